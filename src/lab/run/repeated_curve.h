#pragma once
#include <functional>
#include <vector>

#include "elastin/lab/run/experiment.h"

namespace elastin::lab {

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

}  // namespace elastin::lab
