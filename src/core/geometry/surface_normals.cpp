#include "core/geometry/surface_normals.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace elastin {
namespace {

/// (x1 − x0) × (x2 − x0), twice the area.
Vector3 cross_of(const Positions& positions, const std::array<int, 3>& triangle) {
  const Vector3 a = positions.col(triangle[0]), b = positions.col(triangle[1]), c = positions.col(triangle[2]);
  return (b - a).cross(c - a);
}

Vector3 unit_or_zero(const Vector3& vector) {
  const double length = vector.norm();
  return length > 0 ? Vector3(vector / length) : Vector3::Zero();
}

double angle_at(const Positions& positions, const std::array<int, 3>& triangle, int point) {
  const int k = triangle[0] == point ? 0 : triangle[1] == point ? 1 : 2;
  const Vector3 from = positions.col(point);
  const Vector3 one = positions.col(triangle[(k + 1) % 3]) - from, other = positions.col(triangle[(k + 2) % 3]) - from;
  return std::atan2(one.cross(other).norm(), one.dot(other));
}

bool has(const std::array<int, 3>& triangle, int point) {
  return std::find(triangle.begin(), triangle.end(), point) != triangle.end();
}

}  // namespace

SurfaceNormals::SurfaceNormals(int points, const Cells<3>& triangles) : triangles_(triangles) {
  std::vector<int> corners;
  for (const auto& triangle : triangles) corners.insert(corners.end(), triangle.begin(), triangle.end());
  around_ = rows_by_target(points, corners);
  for (int& slot : around_.entries) slot /= 3;
}

Vector3 SurfaceNormals::at(const Positions& positions, int triangle, const std::array<double, 3>& weights) const {
  const auto& corners = triangles_[triangle];
  const auto zeros = std::count(weights.begin(), weights.end(), 0);
  const Vector3 face = unit_or_zero(cross_of(positions, corners));
  Vector3 sum = face;
  if (zeros == 1) {
    const int out = weights[0] == 0 ? 0 : weights[1] == 0 ? 1 : 2;
    const int from = corners[(out + 1) % 3], to = corners[(out + 2) % 3];
    sum.setZero();
    for (const int other : around_[from])
      if (const auto& its = triangles_[other]; has(its, to)) sum += unit_or_zero(cross_of(positions, its));
  } else if (zeros == 2) {
    const int corner = corners[weights[0] != 0 ? 0 : weights[1] != 0 ? 1 : 2];
    sum.setZero();
    for (const int other : around_[corner]) {
      const auto& its = triangles_[other];
      sum += angle_at(positions, its, corner) * unit_or_zero(cross_of(positions, its));
    }
  }
  const double length = sum.norm();
  if (length > 1e-9) return sum / length;
  return face.squaredNorm() > 0.5 ? face : Vector3(Vector3::UnitZ());
}

}  // namespace elastin
