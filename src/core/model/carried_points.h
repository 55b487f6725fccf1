#pragma once
#include <vector>

#include "elastin/core/model/body.h"

namespace elastin {

/// Points of a body that are no molecules: each moves with the solid cell that holds it at rest, or that is nearest to
/// it, by this cell's shape functions.
struct CarriedPoints {
  /// @param points 3 × n [m], in the body's shape at rest
  /// Cells are the body's tetrahedra, hexahedra and prisms, or the cubes of a lattice. Throws InputError where it has
  /// none, a point is not finite or so far outside that no cell can be continued to it.
  CarriedPoints(const Body& body, const Positions& points);

  int size() const { return static_cast<int>(beyond.size()); }
  /// Where point p is when the molecules are at `positions`.
  Vector3 at(const Positions& positions, int p) const {
    Vector3 sum = Vector3::Zero();
    for (int i = starts[p]; i < starts[p + 1]; ++i) sum += weights[i] * positions.col(molecules[i]);
    return sum;
  }

  std::vector<int> starts{0}, molecules;  ///< of point p those from starts[p] to starts[p + 1]
  std::vector<double> weights;            ///< how much each counts
  std::vector<double> beyond;  ///< how far outside of all cells each point lies at rest [m], about; 0 = in one
};

}  // namespace elastin
