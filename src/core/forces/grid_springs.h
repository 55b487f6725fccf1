#pragma once
#include <array>
#include <optional>
#include <vector>

#include "core/forces/spring_kernel.h"
#include "elastin/core/forces/elasticity.h"

namespace elastin {

/// The forces of springs between neighbours on a grid (Body::grid), without index arrays: a direction's springs from
/// one row of molecules all lead to the same other row, so whole rows are worked on at once. Any neighbours: axes, face
/// and space diagonals, all of them or some.
///
/// On several threads each takes a run of rows and computes the springs that reach into it from before once more: every
/// molecule adds up the same forces in the same order. The bits are not those of a pass over the list of connections.
class GridSprings {
 public:
  /// None where the body is no grid, or a connection with a constant is not between neighbours on it, or there twice.
  /// @param rest_lengths [m], one a connection
  static std::optional<GridSprings> make(const Body& body, const VectorX& constants, const double* rest_lengths);

  void add_forces(const Positions& positions, Positions& forces, Workspace& workspace) const;

 private:
  class Builder;
  struct Direction {
    int x;                        ///< how far a spring's other end is along the row
    int rows;                     ///< how many rows on
    std::vector<int> numbers_at;  ///< of each row: where its constants begin in numbers_, −1 = no springs
  };
  struct Window;

  GridSprings(int length, int rows) : length_(length), rows_(rows) {}
  void add_rows(int begin, int end, const Positions& positions, Positions& forces, Eigen::Map<VectorX> buffer) const;
  void add_row(int row, int begin, const Window& window) const;

  int length_, rows_;  ///< molecules in a row; rows
  int reach_ = 0;      ///< most rows between the ends of a spring
  std::vector<Direction> directions_;
  /// k of each molecule of a row, then L of each. Rows that are alike share them: then they stay in the cache.
  std::vector<double> numbers_;
};

}  // namespace elastin
