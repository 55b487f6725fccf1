#include "experiment/faces.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "elastin/base/error.h"

namespace elastin {
namespace {

/// A third of the area, seen along `direction`, of each boundary triangle whose three corners are in the face.
VectorX triangle_thirds(const Body& body, const std::vector<int>& molecules, const Vector3& direction) {
  std::vector<int> slot(static_cast<std::size_t>(body.size()), -1);
  for (std::size_t i = 0; i < molecules.size(); ++i) slot[static_cast<std::size_t>(molecules[i])] = static_cast<int>(i);
  std::vector<std::array<int, 3>> triangles;
  for (const auto& cell : body.tetrahedra)
    for (std::size_t left_out = 0; left_out < 4; ++left_out) {
      std::array<int, 3> corners{cell[(left_out + 1) % 4], cell[(left_out + 2) % 4], cell[(left_out + 3) % 4]};
      std::sort(corners.begin(), corners.end());
      if (std::all_of(corners.begin(), corners.end(), [&](int m) { return slot[static_cast<std::size_t>(m)] >= 0; }))
        triangles.push_back(corners);
    }
  std::sort(triangles.begin(), triangles.end());
  VectorX areas = VectorX::Zero(static_cast<Eigen::Index>(molecules.size()));
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    if (i + 1 < triangles.size() && triangles[i] == triangles[i + 1]) {
      ++i;  // between two cells: not on the boundary
      continue;
    }
    const auto& [a, b, c] = triangles[i];
    const Vector3 ab = body.rest.col(b) - body.rest.col(a), ac = body.rest.col(c) - body.rest.col(a);
    for (const int corner : triangles[i])
      areas[slot[static_cast<std::size_t>(corner)]] += std::abs(ab.cross(ac).dot(direction)) / 6;
  }
  return areas;
}

}  // namespace

Eigen::Matrix<double, 3, 2> across(const Vector3& axis) {
  int least = 0;
  axis.cwiseAbs().minCoeff(&least);
  const Vector3 first = axis.cross(Vector3::Unit(least)).normalized();
  Eigen::Matrix<double, 3, 2> plane;
  plane << first, axis.cross(first);
  return plane;
}

Face end_face(const Body& body, const Vector3& direction, double depth) {
  const VectorX height = body.rest.transpose() * direction;
  const double low = height.minCoeff(), high = height.maxCoeff();
  depth = std::max(depth, 1e-6 * (high - low));
  if (!(high - low > 2 * depth)) throw InputError("the body has no length along the axis beyond its grips");
  Face face;
  for (int molecule = 0; molecule < body.size(); ++molecule)
    if (height[molecule] >= high - depth) face.molecules.push_back(molecule);
  const auto count = static_cast<Eigen::Index>(face.molecules.size());
  Points2 layer(2, count);
  const auto plane = across(direction);
  for (Eigen::Index i = 0; i < count; ++i)
    layer.col(i) = plane.transpose() * body.rest.col(face.molecules[static_cast<std::size_t>(i)]);
  const Points2 outline = convex_hull(layer);
  face.area = polygon_area(outline);
  face.share = VectorX::Constant(count, 1. / static_cast<double>(count));
  if (!(face.area > 0)) return face;
  if (!body.tetrahedra.empty()) {
    const VectorX thirds = triangle_thirds(body, face.molecules, direction);
    if (thirds.sum() > 0) {
      face.area = thirds.sum();
      face.share = thirds / face.area;
      return face;
    }
  }
  const std::vector<double> areas = tributary_areas(layer, outline);
  for (Eigen::Index i = 0; i < count; ++i) face.share[i] = areas[static_cast<std::size_t>(i)] / face.area;
  return face;
}

}  // namespace elastin
