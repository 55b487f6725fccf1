#pragma once
#include "elastin/solve/statics.h"
#include "forces/tangent.h"
#include "solve/linear_solver.h"

namespace elastin {

/// What ties velocities and accelerations to the positions sought, at the end of a time step: v = v₀ + w_v (x − x₀),
/// a = a₀ + w_a (x − x₀). A static problem has none of it.
struct Kinematics {
  Weights weights;
  Positions start;          ///< x₀ [m]
  Positions velocities;     ///< v₀ [m/s]
  Positions accelerations;  ///< a₀ [m/s²]
};

/// The one Newton of static and implicit solvers: finds the positions where elastic forces, damping and loads balance
/// inertia, from state.positions, with a line search on the energy where there is one and else on the unbalanced force.
/// state.time is that of the answer; supports must be set for it. Never throws on numerical trouble.
/// @param kinematics nullptr: static.
StaticResult solve_newton(Model& model, State& state, const StaticOptions& options, const Kinematics* kinematics);

/// The unbalanced force [N] that rounding of the positions alone makes: nothing smaller can be asked for.
double rounding_floor(const Tangent& tangent, const Positions& positions);

/// What solved a linear problem, and why that: "multigrid", "103823 molecules, …".
struct UsedSolver {
  std::string name, reason;
};

/// One linear solve, by the method of the options; falls back on the factorisation where iterations met what they
/// cannot handle and the body is small enough for it; on a negative mode only if `through_saddles`.
LinearResult solve_linear(const Tangent& tangent, const std::vector<Support>& supports, const Positions& rhs,
                          double tolerance, const StaticOptions& options, bool through_saddles, Positions& solution,
                          UsedSolver& used);

/// The held part of each supported molecule's column, 3 × supports.
Positions held_parts(const std::vector<Support>& supports, const Positions& vectors);

/// Puts every supported molecule where its support wants it, in the held directions.
void place_supports(const Model& model, Positions& positions);

}  // namespace elastin
