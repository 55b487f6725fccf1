#pragma once
#include "elastin/core/forces/model.h"

namespace elastin {

/// The longest step that an explicit stepper can take, and what sets it.
struct StableStep {
  double step = 0;          ///< dt_crit [s]; infinite if nothing resists
  double frequency = 0;     ///< ω_max [rad/s]: the fastest vibration about the state
  double damping_rate = 0;  ///< largest rate of M⁻¹ C [1/s]; 0 without damping and drag
  double bound = 0;         ///< [rad/s], ≥ ω_max: from the row sums of M⁻¹ K by molecule. [Gershgorin 1931]
  int molecule = -1;        ///< that sets the bound
  int connection = -1;      ///< with the largest part of the fastest vibration's energy
  int cell = -1;            ///< the same, if cells carry more of it than connections do
};

/// ω_max by power iteration on M⁻¹ K about the state (from a fixed start: bitwise identical every time), the damping
/// rate in the same way; dt_crit = 2 / (√(ω² + c²) + c), c the damping rate: exact for velocity Verlet on one
/// oscillator without damping, and on one without stiffness. Laws with a history have it begun at the state, and are
/// left there: a caller in the middle of steps calls Model::begin_step with its own state afterwards. Supports are
/// taken into account. `bound`, `molecule`, `connection` and `cell` are left out.
StableStep find_stable_step(Model& model, const State& given);

/// The same with all of them, for half as long again. Of a model of a share (Model::complete_rows), whose processes
/// call this together, neither connection nor cell is named.
StableStep explained_stable_step(Model& model, const State& given);

/// The same from bounds alone, without the connection and the cell: a step that is never too long, and on meshes some
/// 0.5 to 0.9 of the longest. Two passes instead of some hundreds: for a body that changes while somebody waits.
StableStep bounded_stable_step(Model& model, const State& given);

/// The bound alone: one pass, for a watch on bodies that stiffen as they move [rad/s].
double frequency_bound(Model& model, const State& state);

}  // namespace elastin
