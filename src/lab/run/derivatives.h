#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "elastin/lab/run/experiment.h"
#include "lab/run/run.h"
#include "lab/run/specimen.h"

namespace elastin::lab {

/// The problem of a run with another value of one number of its scene.
struct VariedProblem {
  std::shared_ptr<const void> owner;  ///< of what follows
  const Specimen* specimen = nullptr;
  const Experiment* experiment = nullptr;
  StrategyChoice choice;
  std::optional<TimeOptions> time = {};  ///< of a run in time
};

/// A number of a scene by which measures are differentiated.
struct SceneNumber {
  std::string key;  ///< "material.youngs_modulus"
  double value;     ///< SI
  double step;      ///< [the same] a difference that is small, and far above rounding
  /// Whether the model's constants follow from solves of their own, so that forces have some 8 digits, not 13.
  bool calibrated;
  std::function<VariedProblem(double value)> at;
};

/// Derivatives of all that an experiment at rest measures by numbers of its scene, whatever those change: the law, a
/// rule's constants, shape, supports, loads, the measure itself. One linear solve a number at each equilibrium x:
///   K dx/dp = ∂f/∂p,  dm/dp = ∂m/∂p + ∂m/∂x dx/dp + ∂m/∂R dR/dp
/// with ∂f/∂p and ∂m/∂p from two problems p ± h at the same displacements x and reactions R, and the rest from measures
/// a little along the motion. No equilibrium is sought again.
/// Of a run in time, with a history or under a load that is sought they are differences of four whole runs a number.
class Derivatives {
 public:
  explicit Derivatives(std::vector<SceneNumber> numbers);
  ~Derivatives();

  /// Throws InputError where derivatives would not be those of the run.
  void check(const Specimen& specimen, const Experiment& experiment, const StrategyChoice& choice,
             const RunOptions& options) const;
  /// Whether they are differences of whole runs.
  static bool by_whole_runs(const Experiment& experiment, Rig& rig, const StrategyChoice& choice, const Model& model,
                            const RunOptions& options);
  /// Adds them to such a run. A measure that jumps, or of which too few digits are known, is a warning instead.
  void of_whole_runs(const RunOptions& options, Run& run) const;
  /// Adds a warning to the run for each of these numbers by whose deviation, up and down, a measure changes unevenly:
  /// what derivatives say of deviations then no longer holds. Two whole runs a number.
  void check_deviations(const std::vector<std::pair<std::string, double>>& deviations, const RunOptions& options,
                        Run& run) const;
  /// Takes the state at which measuring starts.
  void start(Model& model, const StaticRig& rig, const Start& start, const RunOptions& options);
  /// At the equilibrium under a part of the load; `last`: with what is measured once, at the last of several load
  /// steps; `left`: what the solve left, which this takes. Throws InputError where a number cannot be changed, or its
  /// equilibrium has no derivative.
  Gradients at(Model& model, const StaticExperiment& experiment, const StaticRig& rig, const Start& start,
               const State& state, const StaticResult& solved, double load_factor, bool last, const RunOptions& options,
               LastSolve& left);
  /// Adds those of `curve_error`, from those of the load steps; none where it is rounding alone.
  void add_curve_error(const MeasureList& list, Run& run) const;
  /// What at() has left out since the last call, a sentence each: where contact begins, ends or slides, or a
  /// measure jumps.
  std::vector<std::string> take_doubts() { return std::exchange(doubts_, {}); }

 private:
  struct Side;
  struct Number;
  static Run run_at(const SceneNumber& number, double value, const RunOptions& options, const Run& run);
  std::vector<Number> numbers_;
  std::vector<std::string> doubts_;
};

/// Makes it a run that was stopped: without derivatives, which would be of what was solved so far.
void interrupt(Run& run);

/// Adds to the gradients of the last load step those of the mean over all steps of one of their measures.
void add_mean_gradient(const std::vector<CurvePoint>& curve, const std::string& measure, const std::string& mean,
                       Gradients& gradients);

}  // namespace elastin::lab
