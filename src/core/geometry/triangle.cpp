#include "core/geometry/triangle.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace elastin {
namespace {

NearestPoint on_side(const std::array<Vector3, 3>& corners, int from, int to, double part) {
  NearestPoint nearest{corners[from] + part * (corners[to] - corners[from]), {0, 0, 0}};
  nearest.weights[from] = 1 - part;
  nearest.weights[to] = part;
  return nearest;
}

NearestPoint at_corner(const std::array<Vector3, 3>& corners, int corner) {
  NearestPoint nearest{corners[corner], {0, 0, 0}};
  nearest.weights[corner] = 1;
  return nearest;
}

}  // namespace

NearestPoint nearest_point(const Vector3& point, const std::array<Vector3, 3>& corners) {
  const auto& [a, b, c] = corners;
  const Vector3 ab = b - a, ac = c - a, ap = point - a, bp = point - b, cp = point - c;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return at_corner(corners, 0);
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return at_corner(corners, 1);
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0 && d1 > d3) return on_side(corners, 0, 1, d1 / (d1 - d3));
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return at_corner(corners, 2);
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0 && d2 > d6) return on_side(corners, 0, 2, d2 / (d2 - d6));
  const double va = d3 * d6 - d5 * d4;
  const double to_c = d4 - d3, to_b = d5 - d6;
  if (va <= 0 && to_c >= 0 && to_b >= 0 && to_c + to_b > 0) return on_side(corners, 1, 2, to_c / (to_c + to_b));
  const double sum = va + vb + vc;
  if (!(sum > 0)) return at_corner(corners, 0);  // no area, and nothing above held, but for rounding
  const double v = vb / sum, w = vc / sum;
  return {a + v * ab + w * ac, {1 - v - w, v, w}};
}

std::array<Vector3, 3> weight_slopes(const std::array<Vector3, 3>& corners, const std::array<double, 3>& weights) {
  std::array<Vector3, 3> slopes{Vector3::Zero(), Vector3::Zero(), Vector3::Zero()};
  const auto zeros = std::count(weights.begin(), weights.end(), 0);
  if (zeros == 0) {
    const Vector3 normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    for (int j = 0; j < 3; ++j)
      slopes[j] = normal.cross(corners[(j + 2) % 3] - corners[(j + 1) % 3]) / normal.squaredNorm();
  } else if (zeros == 1) {
    const int out = weights[0] == 0 ? 0 : weights[1] == 0 ? 1 : 2, from = (out + 1) % 3, to = (out + 2) % 3;
    const Vector3 side = corners[to] - corners[from];
    slopes[to] = side / side.squaredNorm();
    slopes[from] = -slopes[to];
  }
  return slopes;
}

}  // namespace elastin
