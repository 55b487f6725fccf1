#include "contact/surface_distance.h"

#include <algorithm>

namespace elastin::contact {

Distance distance_to_surface(const SurfaceNormals& normals, const Positions& positions, int triangle,
                             const NearestPoint& nearest, const Vector3& point) {
  const Vector3 outward = normals.at(positions, triangle, nearest.weights), away = point - nearest.position;
  const auto zeros = std::count(nearest.weights.begin(), nearest.weights.end(), 0);
  if (zeros == 0) return {away.dot(outward), outward, Matrix3::Zero()};
  const auto& [a, b, c] = normals.triangles()[triangle];
  const std::array<Vector3, 3> corners{positions.col(a), positions.col(b), positions.col(c)};
  const double length = away.norm(), sign = away.dot(outward) < 0 ? -1 : 1;
  // Rounding has a say in the direction of what is short; there it comes from the surface.
  const double size = std::max((corners[1] - corners[0]).norm(), (corners[2] - corners[0]).norm());
  if (!(length > 1e-9 * size)) return {sign * length, outward, Matrix3::Zero()};
  const Vector3 normal = sign / length * away;
  Matrix3 free = Matrix3::Identity() - normal * normal.transpose();
  if (zeros == 1) {
    const int out = nearest.weights[0] == 0 ? 0 : nearest.weights[1] == 0 ? 1 : 2;
    const Vector3 side = corners[(out + 2) % 3] - corners[(out + 1) % 3];
    const double side_length = side.norm();
    if (side_length > 0) free -= (side / side_length) * (side / side_length).transpose();
  }
  return {sign * length, normal, sign / length * free};
}

}  // namespace elastin::contact
