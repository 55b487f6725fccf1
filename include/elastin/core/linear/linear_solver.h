#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "elastin/core/base/table.h"
#include "elastin/core/forces/tangent.h"

namespace elastin {

enum class LinearStatus {
  solved,
  limit_reached,  ///< the iteration limit, or no further progress in this precision
  zero_mode,      ///< the right-hand side works on a direction without stiffness
  negative_mode,  ///< a direction of negative stiffness was met
};

struct LinearResult {
  LinearStatus status = LinearStatus::solved;
  int iterations = 0;
  double residual = 0;                ///< ‖b − K x‖ / ‖b‖
  int negative_modes = -1;            ///< eigenvalues of K below zero, −1 where the solver cannot count them
  Positions negative_direction = {};  ///< on negative_mode, from iterations: one along which K is negative
};

/// Solves K x = b for the free directions of a supported body. Zero-energy modes are no failure as long as b has no
/// part in them: x then has none of them either, up to rounding.
class LinearSolver {
 public:
  virtual ~LinearSolver() = default;
  virtual const char* name() const = 0;
  /// `rhs` must lie in the free directions; `solution` is overwritten. On negative_mode or zero_mode it holds a descent
  /// direction of ½ xᵀKx − bᵀx, to be used with a line search.
  virtual LinearResult solve(const Tangent& tangent, const std::vector<Support>& supports, const Positions& rhs,
                             double tolerance, Positions& solution) = 0;
};

/// A row of the table of linear solvers: what scenes name under solver.linear_solver.
struct LinearSolverKind : Descriptor {
  bool needs_symmetry = true;  ///< where the stiffness is not symmetric, bicgstab replaces it
  bool factorises = false;     ///< whether it sees the whole matrix, and counts its negative modes
  /// Null: the row is a rule that chooses another row for each problem.
  std::function<std::unique_ptr<LinearSolver>()> make = {};
};

/// automatic, pcg, multigrid, mixed, direct, bicgstab.
const Table<LinearSolverKind>& built_in_linear_solvers();
using LinearMethod = Choice<LinearSolverKind, built_in_linear_solvers>;

/// Conjugate gradients without a matrix, preconditioned by the 3×3 blocks of each molecule. Its second solve of as many
/// molecules, and those after it, allocate nothing.
std::unique_ptr<LinearSolver> make_pcg();

/// The same with a hierarchy of coarser grids over the body (core/linear/multigrid.h): for large and slender bodies.
std::unique_ptr<LinearSolver> make_multigrid();

/// Stabilised bi-conjugate gradients with the same preconditioner, for a stiffness that is not symmetric; as to memory,
/// as the first. [van der Vorst 1992]
std::unique_ptr<LinearSolver> make_bicgstab();

/// A sparse LDLᵀ factorisation with iterative refinement: for small bodies, indefinite stiffness and mode counts.
std::unique_ptr<LinearSolver> make_direct();

/// Motions of all molecules in all directions, of size 1 and without a pattern that a body could have; always the same.
Positions scattered_directions(int molecules);
/// That of one molecule.
Vector3 scattered_direction(std::int64_t molecule);

/// Removes the fixed components of each supported molecule's column.
void keep_free(const std::vector<Support>& supports, Positions& vectors);

/// Σ a·b, and ‖v‖, bitwise identical on any number of threads.
double ordered_dot(const Positions& a, const Positions& b);
double ordered_norm(const Positions& vectors);

}  // namespace elastin
