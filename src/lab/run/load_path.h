#pragma once
#include <functional>
#include <optional>
#include <vector>

#include "elastin/lab/run/experiment.h"
#include "lab/run/run.h"

namespace elastin::lab {

/// Whether all that acts on a flat body lies in its plane: loads, within the `duration` [s] of a run in time, and
/// supports that are moved. Of one on which nothing acts (vibrations), or that meets contact, or that a start of its
/// own moves, or an experiment in time without a fixture, this is not said.
bool stays_in_plane(const Specimen& specimen, const Experiment& experiment, double duration);

/// Brings rig and obstacles to a part of the load (0 … 1).
void set_load(Model& model, StaticRig& rig, double factor);

/// Solves again, from the equilibrium that was found, as long as the rig seeks its load.
void adjust_load(Model& model, StaticRig& rig, const StaticOptions& options, State& state, StaticResult& solved);

/// One solve's part of the load, between two equilibria.
struct LoadPart {
  double before = 0, after = 0;  ///< the load
  State from, to;
  double slope = -1;  ///< the largest displacement of a molecule over the part of the load [m]; < 0: none yet
};

/// Load continuation: one equilibrium after the other, each solve starts from the extrapolated path.
class LoadPath {
 public:
  /// From `start`, an equilibrium of the load 0. All references must outlive the path.
  /// @param last gets what each equilibrium leaves; null: that is dropped
  LoadPath(Model& model, StaticRig& rig, const StaticOptions& options, State start, LastSolve* last = nullptr);

  /// Brings the load to `factor` (0 … 1; less than before: the body is unloaded). Where that would invert a cell, or
  /// finds no equilibrium, the step is bisected, repeatedly, down to 1/64 of it. An obstacle goes no further in one
  /// part than an eighth of its thickness, or what it meets would leave it by its back; an equilibrium on the way to
  /// which bodies may have passed through each other is sought in halves, too. The state stays at the last equilibrium
  /// if that fails. The result is that of the last part, with the iterations of all.
  /// @param steepest gets the part in which the body moved most for its load; null: none is kept
  StaticResult advance(double factor, LoadPart* steepest = nullptr);

  const State& state() const { return state_; }
  double factor() const { return factor_; }   ///< of the load, there
  int halvings() const { return halvings_; }  ///< parts of the load that had to be halved, so far
  /// Whether what touches may have passed through something in a part of the load that was not halved any more.
  bool may_have_passed() const { return may_have_passed_; }

 private:
  StaticResult advance(double factor, double smallest);
  StaticResult solve(State& state, const StaticOptions& options);
  int parts_for_obstacles(double factor);
  State start_of(double factor) const;
  void keep(State found, double factor);

  Model& model_;
  StaticRig& rig_;
  StaticOptions options_;
  State state_;
  LastSolve* last_;
  Positions displacement_;             // from the equilibrium before
  double factor_ = 0, last_step_ = 0;  // of the load: now, and how much the last part added
  double last_gain_ = 0;               // of the elastic energy [J], by that part
  int halvings_ = 0;
  LoadPart* steepest_ = nullptr;
  bool may_have_passed_ = false;
};

/// The load curve of one body with one material after the other: each equilibrium is sought from the one that the
/// material before had under the same load, and along the whole load path where that fails.
class RepeatedCurve {
 public:
  /// @param factors of the load, ascending, > 0 and at most 1
  RepeatedCurve(std::vector<double> factors, const StaticOptions& options)
      : factors_(std::move(factors)), options_(options) {}

  /// What is done at an equilibrium; false ends the curve.
  using Visit = std::function<bool(std::size_t step, const State&, StaticResult&)>;

  /// False where an equilibrium was not found or a visit ended the curve.
  bool solve(Model& model, StaticRig& rig, const Visit& visit);
  double factor(std::size_t step) const { return factors_[step]; }
  /// Where the next curve is sought: at an equilibrium of the last one moved so. Used once.
  void expect(std::size_t step, Positions motion);
  /// The unbalanced force that equilibria may have, over the size of loads and reactions.
  void set_tolerance(double tolerance) { options_.tolerance = tolerance; }
  /// The next curve begins at rest, as where the load path counts.
  void forget() { states_.clear(); }
  /// Why the last curve ended early; "" where a visit ended it.
  const std::string& cause() const { return cause_; }

 private:
  bool from_last(Model& model, StaticRig& rig, const Visit& visit);
  bool from_start(Model& model, StaticRig& rig, const Visit& visit);

  std::vector<double> factors_;
  StaticOptions options_;
  std::vector<State> states_;        ///< of the last curve that was found, one a factor
  std::vector<Positions> expected_;  ///< motions from there, as far as they are known
  std::string cause_;
};

/// What the rig measures of an equilibrium, with what every run adds: under preload, of contact, whose report is set.
Measures measure_step(const Model& model, const StaticExperiment& experiment, const StaticRig& rig, const Start& start,
                      const State& state, const RunOptions& options, StaticResult& solved,
                      std::optional<contact::ContactReport>& contact);

/// Solves load step after load step of a model that the experiment holds, each started where the last two lead, and
/// adds curve, measures, cost and outcome to the run. A step that fails ends it; what was measured before stays.
/// @param begin changes the state in which the search for the first equilibrium starts; may be empty.
void solve_load_curve(Model& model, const StaticExperiment& experiment, StaticRig& rig, const Material& material,
                      const RunOptions& options, Run& run, const std::function<void(State&)>& begin = {});

/// Takes a held model through time, frame after frame, and adds rows, measures, cost and outcome to the run. A step
/// that fails ends it: the frames before stay. Throws InputError where options or a restart text do not fit.
void run_in_time(Model& model, const TimedExperiment& experiment, TimedRig& rig, const Specimen& specimen,
                 const RunOptions& options, Run& run);

/// The stepper that a run takes, and why if the scene leaves it open.
std::pair<StepperMethod, std::string> chosen_stepper(const TimeOptions& options, const TimedExperiment& experiment,
                                                     const Specimen& specimen, bool uses_cells);

}  // namespace elastin::lab
