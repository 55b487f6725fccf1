#pragma once
#include <string>
#include <vector>

#include "core/geometry/box_tree.h"
#include "elastin/core/geometry/cells.h"

namespace elastin::mesh {

/// A surface that is as closed as it can be made, and what was done for it, in words with its number.
struct RepairedSurface {
  Positions points;
  Cells<3> triangles;
  std::vector<std::string> repairs;
  double widest_hole = 0;  ///< that is still open [m]
};

/// Drops triangles that stand twice, back to back, alone or on a side of two others; turns triangles like their
/// neighbours and shells so that their normals look out of the body, where a shell in another one bounds a cavity;
/// closes holes of at most 2 % of the surface's area, of three sides 10 %. Points and triangles that nothing is
/// wrong with keep their order.
RepairedSurface repair_surface(const Positions& points, const Cells<3>& triangles);

/// Drops triangles without area: of two equal corners, or of three in a line, whose middle one then becomes a corner of
/// the neighbour across the longest side. @return what was done, in words with its number
std::vector<std::string> drop_flat_triangles(const std::vector<Vector3>& points, Cells<3>& triangles);

/// How often a surface goes round a point, 1 inside and 0 outside; between them where it has holes, 2 where two parts
/// overlap. Far triangles count by their sums of area, to about 2 %. Cost O(log n).      [Jacobson 2013, Barill 2018]
class WindingNumber {
 public:
  WindingNumber(const Positions& points, const Cells<3>& triangles);
  double at(const Vector3& point) const { return sum(0, point); }

 private:
  double sum(int node, const Vector3& point) const;

  std::vector<std::array<Vector3, 3>> corners_;
  BoxTree tree_;
  std::vector<Vector3> area_, middle_;  ///< of each node: Σ area vectors [m²], their middle [m]
  std::vector<double> reach_;           ///< from there to its furthest corner [m]
};

}  // namespace elastin::mesh
