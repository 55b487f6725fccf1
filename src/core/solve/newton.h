#pragma once
#include <memory>
#include <optional>
#include <string>

#include "core/solve/trial.h"
#include "elastin/core/forces/tangent.h"
#include "elastin/core/linear/linear_solver.h"
#include "elastin/core/solve/statics.h"

namespace elastin {

class LastSolve;

/// A linear solver kept from one solve to the next, for its memory and its grid hierarchy of the stiffness.
struct CachedSolver {
  std::unique_ptr<LinearSolver> solver;
  LinearMethod method = "automatic";
  /// Where an equilibrium or a step begins, whose answer must not hang on those before.
  void forget();
};

/// Workspace of Newton's method; it only grows. Time steps of one model with conjugate gradients allocate
/// nothing after the first.
struct NewtonWorkspace {
  Trial now;
  TrialWorkspace trials;
  std::unique_ptr<Tangent> tangent;  // of the model
  CachedSolver solver;
  Positions motion;
  std::optional<State> before;  ///< where a linear step began that led to the state of an equilibrium's start
  bool adrift = false;          ///< whether a load worked on a motion that nothing resisted where the body was
};

/// The one Newton of static and implicit solvers: finds the positions where elastic forces, damping and loads balance
/// inertia, from state.positions, with a line search on the energy where there is one and else on the unbalanced force.
/// state.time is that of the answer; supports must be set for it. Never throws on numerical trouble.
/// @param kinematics nullptr: static. Else reactions are not computed.
/// @param workspace of this model alone.
/// @param last where the motions are noted; may be null
/// @param shared of several processes: `model` has what this one computes; reactions are not computed either.
StaticResult solve_newton(Model& model, State& state, const StaticOptions& options, const Kinematics* kinematics,
                          NewtonWorkspace& workspace, LastSolve* last = nullptr, SharedProblem* shared = nullptr);

/// Updates of the loads' multipliers, each followed by a balance, at most.
inline constexpr int kMultiplierUpdates = 50;

/// Calls balance(), which sets the result's outcome and brings `state` there, until no load changes its multipliers at
/// that state any more. Every implicit balance, of steps and at rest, goes through this.
/// @param cut_short whether one that ends at its limit of iterations counts, too; see Kinematics
template <class Result, class Balance>
void balance_with_multipliers(const Model& model, State& state, bool cut_short, Result& result,
                              const Balance& balance) {
  const auto usable = [&] {
    return result.outcome == Outcome::converged || (cut_short && result.outcome == Outcome::limit_reached);
  };
  balance();
  for (int round = 0; usable() && model.update_multipliers(state); ++round) {
    if (round == kMultiplierUpdates) {
      result.outcome = Outcome::limit_reached;
      result.cause = "contact penetration still exceeds the limit after " + std::to_string(kMultiplierUpdates) +
                     " multiplier updates: each takes the more off it the stiffer the contact is; take ten times its "
                     "stiffness";
      return;
    }
    balance();
  }
}

/// Whether the options' `stop` ends the solve; if so, the result says it.
bool is_interrupted(const StaticOptions& options, StaticResult& result);

/// The unbalanced force [N] that rounding of the positions alone makes: no smaller tolerance can be reached.
double rounding_floor(const Tangent& tangent, const Positions& positions);

/// One linear solve, by the method of the options; falls back on the factorisation where iterations met what they
/// cannot handle and the body is small enough for it; on a negative mode only if `through_saddles`.
LinearResult solve_linear(const Tangent& tangent, const std::vector<Support>& supports, const Positions& rhs,
                          double tolerance, const StaticOptions& options, bool through_saddles, Positions& solution,
                          UsedSolver& used, CachedSolver& cached);

/// The fixed component of each supported molecule's column, 3 × supports.
void set_fixed_components(const std::vector<Support>& supports, const Positions& vectors, Positions& parts);
Positions fixed_components(const std::vector<Support>& supports, const Positions& vectors);

/// Puts every supported molecule where its support wants it, in the fixed directions.
void apply_supports(const Model& model, Positions& positions);

}  // namespace elastin
