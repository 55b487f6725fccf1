#include "core/linear/mixed.h"

namespace elastin {

const Table<LinearSolverKind>& built_in_linear_solvers() {
  static const Table<LinearSolverKind> table = [] {
    Table<LinearSolverKind> rows("linear solver");
    rows.add(
        {{"automatic", "the quickest by a rule: direct for tiny bodies, multigrid for large or slender ones, else pcg",
          "measured on cubes and rods"}});
    rows.add(
        {{"pcg", "conjugate gradients with the blocks of single molecules", "[Hestenes 1952]"}, true, false, make_pcg});
    rows.add({{"multigrid", "the same with a hierarchy of coarser grids over the body", "[Brandt 1977]"},
              true,
              false,
              make_multigrid});
    rows.add(
        {{"mixed",
          "displacements and the pressures of cells together, with a hierarchy of grids: near a Poisson's ratio of ½",
          "[Silvester 1994]"},
         true,
         false,
         make_mixed});
    rows.add({{"direct", "a sparse factorisation with refinement: small bodies, negative modes", "Eigen's LDLT"},
              true,
              true,
              make_direct});
    rows.add(
        {{"bicgstab", "for a stiffness that is not symmetric", "[van der Vorst 1992]"}, false, false, make_bicgstab});
    return rows;
  }();
  return table;
}

}  // namespace elastin
