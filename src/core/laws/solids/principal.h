#pragma once
#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/dense.h"
#include "core/laws/solids/components.h"

namespace elastin {

/// The eigenvalues of a symmetric A in ascending order, for principal_function: where two are nearly equal each may be
/// off by 1e-8 of their distance to the third, their mean not; nearer than that they are not said to be, for the slopes
/// between them would be of rounding alone. With A = m I + p D, D:D = 6,
/// they are those of 8t³ − 6t = det D, and the one that is alone is found by Halley's method.
inline Vector3 principal_values(const Matrix3& A) {
  const double mean = A.trace() / 3;
  Matrix3 D = A;
  D.diagonal().array() -= mean;
  const double square = D.squaredNorm() / 6;
  if (!(square > 1e-200)) return Vector3::Constant(mean);
  const double p = std::sqrt(square),
               cosine = std::clamp(symmetric_determinant(components(D)) / (2 * p * square), -1., 1.);
  const double r = std::abs(cosine);
  // 4t³ − 3t = r on [cos 30°, 1]: this polynomial is within 5e-6 of t, one of Halley's steps cubes that.
  double t = 0.866030432 + r * (0.1664117218 + r * (-0.0459219331 + r * (0.0175121886 - r * 0.0040353987)));
  const double f = t * (4 * t * t - 3) - r, slope = 12 * t * t - 3;
  t = std::min(1., t - f * slope / (slope * slope - f * 12 * t));
  const double apart = std::max(1e-8, std::sqrt(3 * (1 - t) * (1 + t)));
  if (cosine < 0) return {mean - 2 * p * t, mean + p * (t - apart), mean + p * (t + apart)};
  return {mean - p * (t + apart), mean - p * (t - apart), mean + 2 * p * t};
}

/// The symmetric tensor with the axes of A whose eigenvalues are f where those of A are x, ascending: Newton's
/// polynomial through the three. What an eigenvalue of a close pair is off by enters squared.
inline Matrix3 principal_function(const Matrix3& A, const Vector3& x, const Vector3& f) {
  const double apart = x[2] - x[0], below = x[1] - x[0], above = x[2] - x[1];
  const double first = apart > 0 ? (f[2] - f[0]) / apart : 0;
  const double second = below * above > 0 ? (f[0] + first * below - f[1]) / (below * above) : 0;
  const Components own = components(A), from_low = on_diagonal(own, -x[0]), from_high = on_diagonal(own, -x[2]);
  const Components square = commuting_product(from_low, from_high);
  return tensor(
      on_diagonal(each_component([&](int row) { return first * from_low[row] + second * square[row]; }), f[0]));
}

/// ∂S/∂C of an isotropic law out of what it is in the axes of C: a column of `axes` each.
struct PrincipalAxes {
  Matrix3 axes;

  /// @param direct  ∂S_i/∂C_j of the principal values
  /// @param turning (S_i − S_j)/(C_i − C_j) of the pairs 12 13 23: how S_ij changes with C_ij
  TangentModuli<3> tangent(const Matrix3& direct, const std::array<double, 3>& turning) const {
    Eigen::Matrix<double, 6, 3> along;
    for (int i = 0; i < 3; ++i) along.col(i) = symmetric_product(axes.col(i), axes.col(i));
    TangentModuli<3> result = along * direct * along.transpose();
    for (int pair = 0; pair < 3; ++pair) {
      const auto [i, j] = kComponents[3 + pair];
      const Components across = symmetric_product(axes.col(i), axes.col(j));
      result += 2 * turning[pair] * across * across.transpose();
    }
    return result;
  }
};

}  // namespace elastin
