#pragma once
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace elastin::hull {

/// A facet of a convex hull: n · x + offset ≤ 0 inside, and the points at its corners.
struct HullFacet {
  const double* normal;  ///< unit length, as many numbers as the space has dimensions
  double offset;
  std::vector<int> corners;
};

/// Calls visit for each facet of the hull of points in a space of `dimension`, their coordinates one point behind the
/// other. `triangulated`: facets with more corners than a simplex are cut into simplices; else those in one plane, to
/// rounding, are one. Returns "", or what Qhull says is wrong with the points. [Barber 1996]
std::string visit_hull(int dimension, const std::vector<double>& points, bool triangulated,
                       const std::function<void(const HullFacet&)>& visit);

}  // namespace elastin::hull
