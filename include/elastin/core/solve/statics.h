#pragma once
#include <functional>
#include <memory>
#include <string>

#include "elastin/core/forces/model.h"
#include "elastin/core/linear/linear_solver.h"

namespace elastin {

/// How a run ended.
enum class Outcome {
  converged,
  limit_reached,
  inverted,
  diverged,
  mechanism,
  interrupted,  ///< the user stopped it
};
const char* name_of(Outcome outcome);

/// How an equilibrium with large displacements is sought; see solve/statics.cpp.
enum class StaticMethod { newton, explicit_steps, implicit_steps };

class LastSolve;
class StaticEngine;

struct StaticOptions {
  bool linear = false;  ///< true: small displacements, one linear solve about rest; false: large displacements
  StaticMethod static_method = StaticMethod::newton;
  LinearMethod method = "automatic";
  double tolerance = 1e-10;  ///< largest unbalanced force over the size of loads and reactions, both as Euclidean norms
  int newton_limit = 200;
  /// Whether one more linear solve tests that an equilibrium is a minimum; if it is not (a straight column
  /// beyond its buckling load), the body leaves it towards lower energy. For loads with an energy; large displacements.
  bool probe = false;
  std::shared_ptr<StaticEngine> engine = {};  ///< see solve/engine.h; null: this process by itself
  /// Asked before each iteration of Newton's method and each linear solve; true ends the solve as `interrupted`. May be
  /// empty.
  std::function<bool()> stop = {};
};

struct StaticResult {
  Outcome outcome = Outcome::converged;
  std::string cause;    ///< why it did not converge; empty if it did
  std::string solver;   ///< "newton pcg", "linear direct" …
  std::string reason;   ///< why this linear solver, in words for a user; empty where there was no choice to make
  bool linear = false;  ///< small displacements were assumed
  int newton_iterations = 0;
  int linear_iterations = 0;
  int cut_steps = 0;  ///< steps that were shortened because they would have inverted a cell
  /// Unbalanced force over the size of loads and reactions; where these are nothing, of the forces within the body.
  double residual = 0;
  double scale = 0;          ///< that size [N], a Euclidean norm
  bool left_saddle = false;  ///< went down from an equilibrium that was no minimum
  bool unstable = false;     ///< the equilibrium found has a direction of negative stiffness: it is not a minimum
  Positions reactions;       ///< force that fixes each support in its fixed directions [N], shape 3 × supports
};

/// Finds the equilibrium of the loads, supports and elastic forces. Starts from `state.positions`, which must be
/// finite, and leaves the equilibrium there; velocities stay. Never throws on numerical trouble: the outcome says it.
/// Zero-energy modes that the loads do not work on are left where they are; one that they do work on is followed with
/// large displacements (it may stiffen) and ends as `mechanism` in the linear mode.
StaticResult solve_static(Model& model, State& state, const StaticOptions& options = {});

/// Room for what a solve leaves to a Sensitivity of its answer: the preconditioner, and the motions that led there,
/// which are most of the adjoint of the loads' work or of the force of a moved support. 100 to 400 B a molecule once
/// filled; answers are the same within their tolerance.
std::shared_ptr<LastSolve> make_last_solve();
StaticResult solve_static(Model& model, State& state, const StaticOptions& options, LastSolve& last);

/// Small motion about the state `at` under changed loads [N] and moved supports (the fixed components of `displacement`
/// [m]), both 3 × n.
struct StaticResponse {
  StaticResult result;  ///< its reactions are the changes of the reactions
  Positions motion;     ///< [m], 3 × n
};
StaticResponse static_response(Model& model, const Positions& at, const Positions& load_change,
                               const Positions& displacement, const StaticOptions& options = {});

}  // namespace elastin
