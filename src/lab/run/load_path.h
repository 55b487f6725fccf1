#pragma once
#include "elastin/lab/run/experiment.h"

namespace elastin::lab {

/// Brings rig and obstacles to a part of the load (0 … 1).
void set_load(Model& model, StaticRig& rig, double factor);

/// Solves again, from the equilibrium that was found, as long as the rig seeks its load.
void adjust_load(Model& model, StaticRig& rig, const StaticOptions& options, State& state, StaticResult& solved);

/// Load continuation: one equilibrium after the other, each solve starts from the extrapolated path.
class LoadPath {
 public:
  /// From `start`, an equilibrium of the load 0. All references must outlive the path.
  LoadPath(Model& model, StaticRig& rig, const StaticOptions& options, State start);

  /// Brings the load to `factor` (0 … 1; less than before: the body is unloaded). Where that would invert a cell, or
  /// finds no equilibrium, the step is bisected, repeatedly, down to 1/64 of it. An obstacle goes no further in one
  /// part than an eighth of its thickness, or what it meets would leave it by its back. The state stays at the last
  /// equilibrium if that fails. The result is that of the last part, with the iterations of all.
  StaticResult advance(double factor);

  const State& state() const { return state_; }
  int halvings() const { return halvings_; }  ///< parts of the load that had to be halved, so far

 private:
  StaticResult advance(double factor, double smallest);
  int parts_for_obstacles(double factor);
  State start_of(double factor) const;

  Model& model_;
  StaticRig& rig_;
  StaticOptions options_;
  State state_;
  Positions displacement_;             // from the equilibrium before
  double factor_ = 0, last_step_ = 0;  // of the load: now, and how much the last part added
  int halvings_ = 0;
};

}  // namespace elastin::lab
