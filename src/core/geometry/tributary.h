#pragma once
#include <Eigen/Core>
#include <vector>

namespace elastin {

using Points2 = Eigen::Matrix2Xd;  ///< one column a point

/// Corners of the convex hull, counter-clockwise; fewer than 3 where the points lie on a line (to 1e-9 of their
/// spread).
Points2 convex_hull(const Points2& points);

/// Area of a polygon, positive counter-clockwise.
double polygon_area(const Points2& polygon);

/// Second moments of area of a polygon, ∫ (x − x̄) (x − x̄)ᵀ dA [m⁴], x̄ its centroid; positive counter-clockwise.
Eigen::Matrix2d polygon_second_moments(const Points2& polygon);

/// The part of a convex polygon that is nearest to each point (its Voronoi cell clipped by the polygon): the parts sum
/// to the polygon's area. Points must be distinct. Cost O(n log n) for points of even density.
std::vector<double> tributary_areas(const Points2& points, const Points2& polygon);

}  // namespace elastin
