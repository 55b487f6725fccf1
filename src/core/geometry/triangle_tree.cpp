#include "core/geometry/triangle_tree.h"

#include <utility>

namespace elastin {

TriangleTree::TriangleTree(Positions points, Cells<3> triangles)
    : points_(std::move(points)), normals_(static_cast<int>(points_.cols()), triangles) {
  std::vector<Box> boxes(triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const auto [a, b, c] = corners(static_cast<int>(t));
    boxes[t] = {a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c)};
  }
  tree_ = BoxTree(boxes);
}

std::array<Vector3, 3> TriangleTree::corners(int triangle) const {
  const auto& [a, b, c] = triangles()[triangle];
  return {points_.col(a), points_.col(b), points_.col(c)};
}

TriangleTree::Nearest TriangleTree::nearest(const Vector3& point) const {
  Nearest found{-1, {Vector3::Zero(), {1, 0, 0}}, std::numeric_limits<double>::infinity()};
  tree_.nearest(point, [&](int triangle) {
    const NearestPoint on = nearest_point(point, corners(triangle));
    const double distance = (point - on.position).norm();
    if (distance < found.distance) found = {triangle, on, distance};
    return distance;
  });
  return found;
}

double TriangleTree::signed_distance(const Vector3& point) const {
  const auto [triangle, on, distance] = nearest(point);
  return (point - on.position).dot(normals_.at(points_, triangle, on.weights)) < 0 ? -distance : distance;
}

}  // namespace elastin
