#pragma once
#include "elastin/core/solve/statics.h"

namespace elastin {

/// The equilibrium found by stepping through time until the body rests; it never needs a stiffness matrix to be
/// regular, nor a start near the answer.
///   * explicit: velocity Verlet at 0.9 of the step that the row sums of M⁻¹ K allow; all velocities are set to zero
///     where the kinetic energy peaks. [Day 1965, Cundall 1976]
///   * implicit: backward Euler from rest every time, the step doubled where it succeeds and quartered where it fails:
///     Newton's way, held back by inertia. [Kelley & Keyes 1998]
/// Ends at the unbalanced force of the options, or at 1e-8 of the loads if that is less strict; `limit_reached` if
/// that takes too many steps. The state stays where it got to. Never throws on numerical trouble.
StaticResult relax(Model& model, State& state, const StaticOptions& options);

}  // namespace elastin
