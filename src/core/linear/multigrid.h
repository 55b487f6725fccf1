#pragma once
#include <functional>
#include <memory>
#include <vector>

#include "core/linear/box_assembly.h"
#include "elastin/core/linear/linear_solver.h"

namespace elastin {

/// A grid hierarchy of a body in ever larger boxes, for what conjugate gradients with the blocks of single molecules
/// are slow at: motions that are smooth over many of them. One W-cycle, symmetric, in single precision; the last grid
/// is factorised in double. Or a K-cycle, for flexible conjugate gradients.              [Notay & Vassilevski 2008]
class Multigrid {
 public:
  Multigrid(const Tangent& tangent, const std::vector<Support>& supports);
  ~Multigrid();

  /// Whether the last grid's stiffness is positive, as it has to be for conjugate gradients. To be asked before the
  /// first add, for it factorises that grid.
  bool positive();
  /// motion += P A⁻¹ Pᵀ forces, nearly. `size` of the forces [N], so that they fit into single precision.
  void add(const Positions& forces, double size, Positions& motion);
  /// From now on coarse grids are searched, not only cycled through: better on porous bodies, and not linear.
  void search();
  /// At most as many steps of smoothing on each grid.
  void limit_steps(int most) {
    for (const auto& level : levels_) level->limit_steps(most);
  }
  int levels() const { return static_cast<int>(levels_.size()); }
  /// Whether the body is so thin that even a fine grid's factor has little fill: the body's own may have little, too.
  bool thin() const { return thin_; }

 private:
  struct LevelWorkspace {
    BoxLevel::Vectors b, x, other, step, of_boxes, found, along, resisted;
  };
  class CoarsestSolver;
  void drop_levels_below_cheap_factor();
  void cycle(std::size_t level);
  void search_on(std::size_t level);

  BoxMembers members_;
  std::vector<std::unique_ptr<BoxLevel>> levels_;
  std::vector<LevelWorkspace> workspaces_;
  BoxLevel::Vectors of_boxes_;                ///< of the finest grid, from the molecules
  std::unique_ptr<CoarsestSolver> coarsest_;  ///< once it was asked whether it is positive
  bool thin_ = false, searches_ = false;
};

/// Whether a search with this number of iterations to come, at its pace, is given up for another solver.
using GivesUp = std::function<bool(double to_come)>;

/// As make_multigrid, but asks where many iterations are to come, early and at twice as many each time; of what is
/// given up the result is limit_reached.
std::unique_ptr<LinearSolver> make_multigrid(GivesUp gives_up);

/// Conjugate gradients without a hierarchy that end with limit_reached after `most_iterations`.
std::unique_ptr<LinearSolver> make_pcg(int most_iterations);

}  // namespace elastin
