#include "elastin/core/forces/tension.h"

#include <algorithm>
#include <cmath>

#include "core/model/incidence.h"

namespace elastin {

std::vector<Matrix3> triangle_tensions(const Model& model, const Positions& positions) {
  const Body& body = model.body();
  const auto sides = connections_of_each_cell<3>(body.connections, body.triangles);
  Eigen::Matrix3Xd own = Eigen::Matrix3Xd::Zero(3, static_cast<Eigen::Index>(sides.size()));
  VectorX shared = VectorX::Zero(body.connections.size());
  Workspace workspace;
  model.add_triangle_force_densities(positions, own, shared, workspace);
  std::vector<int> triangles(body.connections.size(), 0);
  for (const auto& cell : sides)
    for (const int c : cell) ++triangles[c];

  std::vector<Matrix3> tensions(sides.size(), Matrix3::Zero());
  for (std::size_t cell = 0; cell < sides.size(); ++cell) {
    const auto& [a, b, c] = body.triangles[cell];
    const Vector3 ab = positions.col(b) - positions.col(a), ac = positions.col(c) - positions.col(a);
    const double area = ab.cross(ac).norm() / 2;
    if (!(area > 0)) continue;
    for (int side = 0; side < 3; ++side) {
      const auto connection = static_cast<std::size_t>(sides[cell][side]);
      const auto& [from, to] = body.connections.ends[connection];
      const Vector3 d = positions.col(to) - positions.col(from);
      const double q = own(side, static_cast<Eigen::Index>(cell)) +
                       shared[static_cast<Eigen::Index>(connection)] / triangles[connection];
      tensions[cell] += q / area * d * d.transpose();
    }
  }
  return tensions;
}

Compression find_compression(const Model& model, const Positions& positions) {
  double largest = 0;
  std::vector<double> least;
  for (const Matrix3& tension : triangle_tensions(model, positions)) {
    // Of the three principal values the one across the triangle is 0.
    const double mean = tension.trace() / 2,
                 half = std::sqrt(std::max(0., (tension.squaredNorm() - 2 * mean * mean) / 2));
    largest = std::max(largest, mean + half);
    least.push_back(mean - half);
  }
  constexpr double rounding = 1e-3;  // about what a mesh misses of a uniaxial tension, across which there is none
  Compression found;
  for (std::size_t cell = 0; cell < least.size(); ++cell) {
    if (!(least[cell] < -rounding * largest)) continue;
    ++found.triangles;
    if (least[cell] < found.tension) found.worst = static_cast<int>(cell), found.tension = least[cell];
  }
  return found;
}

}  // namespace elastin
