#include "core/geometry/triangle_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <unsupported/Eigen/BVH>
#include <utility>

namespace elastin {
namespace {

using BoxTree = Eigen::KdBVH<double, 3, int>;

/// Weights of the place of a triangle that is nearest to a point. [Ericson 2005, §5.1.5]
Vector3 nearest_weights(const Vector3& p, const Vector3& a, const Vector3& b, const Vector3& c) {
  const Vector3 ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return {1, 0, 0};
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return {0, 1, 0};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return {1 - d1 / (d1 - d3), d1 / (d1 - d3), 0};
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return {0, 0, 1};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return {1 - d2 / (d2 - d6), 0, d2 / (d2 - d6)};
  const double va = d3 * d6 - d5 * d4, along = d4 - d3, back = d5 - d6;
  if (va <= 0 && along >= 0 && back >= 0) return {0, back / (along + back), along / (along + back)};
  const double sum = va + vb + vc;
  return {va / sum, vb / sum, vc / sum};
}

/// Searches the tree for one point.
struct Search {
  using Scalar = double;
  Vector3 point;
  const Positions& points;
  const Cells<3>& triangles;
  int triangle = -1;
  Vector3 weights = Vector3::Zero();
  double best = std::numeric_limits<double>::infinity();

  Vector3 position_of(int t, const Vector3& w) const {
    const auto& [a, b, c] = triangles[static_cast<std::size_t>(t)];
    return w[0] * points.col(a) + w[1] * points.col(b) + w[2] * points.col(c);
  }
  double minimumOnVolume(const BoxTree::Volume& box) const { return box.squaredExteriorDistance(point); }
  double minimumOnObject(int t) {
    const auto& [a, b, c] = triangles[static_cast<std::size_t>(t)];
    const Vector3 w = nearest_weights(point, points.col(a), points.col(b), points.col(c));
    const double distance = (position_of(t, w) - point).squaredNorm();
    if (distance < best || (distance == best && t < triangle)) best = distance, triangle = t, weights = w;
    return distance;
  }
};

}  // namespace

struct TriangleTree::Impl {
  Positions points;
  Cells<3> triangles;
  BoxTree tree;
  Positions face_normal, corner_normal;  ///< unit; of corners weighted by angle
  std::map<std::array<int, 2>, Vector3> side_normal;

  Vector3 corner(std::size_t t, std::size_t i) const { return points.col(triangles[t][i]); }

  void set_normals() {
    face_normal.resize(3, static_cast<Eigen::Index>(triangles.size()));
    corner_normal = Positions::Zero(3, points.cols());
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      const Vector3 normal = (corner(t, 1) - corner(t, 0)).cross(corner(t, 2) - corner(t, 0)).normalized();
      face_normal.col(static_cast<Eigen::Index>(t)) = normal;
      for (std::size_t i = 0; i < 3; ++i) {
        const Vector3 one = corner(t, (i + 1) % 3) - corner(t, i), other = corner(t, (i + 2) % 3) - corner(t, i);
        corner_normal.col(triangles[t][i]) += std::atan2(one.cross(other).norm(), one.dot(other)) * normal;
        side_normal.try_emplace(side(t, i), Vector3::Zero()).first->second += normal;
      }
    }
  }
  /// From corner i to the next one.
  std::array<int, 2> side(std::size_t t, std::size_t i) const {
    const int a = triangles[t][i], b = triangles[t][(i + 1) % 3];
    return {std::min(a, b), std::max(a, b)};
  }
  Vector3 pseudonormal(const Nearest& at) const {
    const auto t = static_cast<std::size_t>(at.triangle);
    std::array<std::size_t, 3> corners{};
    std::size_t used = 0;
    for (std::size_t i = 0; i < 3; ++i)
      if (at.weights[static_cast<Eigen::Index>(i)] > 0) corners[used++] = i;
    if (used == 1) return corner_normal.col(triangles[t][corners[0]]);
    if (used == 2) return side_normal.at(side(t, corners[1] == corners[0] + 1 ? corners[0] : corners[1]));
    return face_normal.col(at.triangle);
  }
};

TriangleTree::TriangleTree(Positions points, Cells<3> triangles) : impl_(std::make_unique<Impl>()) {
  impl_->points = std::move(points);
  impl_->triangles = std::move(triangles);
  std::vector<int> numbers;
  std::vector<BoxTree::Volume> boxes;
  for (const auto& [a, b, c] : impl_->triangles) {
    numbers.push_back(static_cast<int>(numbers.size()));
    BoxTree::Volume box(impl_->points.col(a));
    boxes.push_back(box.extend(impl_->points.col(b)).extend(impl_->points.col(c)));
  }
  impl_->tree.init(numbers.begin(), numbers.end(), boxes.begin(), boxes.end());
  impl_->set_normals();
}

TriangleTree::~TriangleTree() = default;
TriangleTree::TriangleTree(TriangleTree&&) noexcept = default;

TriangleTree::Nearest TriangleTree::nearest(const Vector3& point) const {
  Search search{point, impl_->points, impl_->triangles};
  Eigen::BVMinimize(impl_->tree, search);
  return {search.triangle, search.position_of(search.triangle, search.weights), search.weights, std::sqrt(search.best)};
}

double TriangleTree::signed_distance(const Vector3& point) const {
  const Nearest found = nearest(point);
  return (point - found.position).dot(impl_->pseudonormal(found)) < 0 ? -found.distance : found.distance;
}

const Positions& TriangleTree::points() const { return impl_->points; }
const Cells<3>& TriangleTree::triangles() const { return impl_->triangles; }

}  // namespace elastin
