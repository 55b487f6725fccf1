#pragma once
#include "elastin/core/laws/law.h"

namespace elastin {

/// The components of a symmetric tensor in the order of TangentModuli<3>: 11 22 33 12 13 23, each once.
using Components = Eigen::Matrix<double, 6, 1>;

inline constexpr int kComponents[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};

inline Components components(const Matrix3& symmetric) {
  Components result;
  for (int row = 0; row < 6; ++row) result[row] = symmetric(kComponents[row][0], kComponents[row][1]);
  return result;
}

inline Matrix3 tensor(const Components& c) {
  Matrix3 result;
  result << c[0], c[3], c[4], c[3], c[1], c[5], c[4], c[5], c[2];
  return result;
}

/// a b of symmetric tensors that have the same axes, so that it is symmetric too.
inline Components commuting_product(const Matrix3& a, const Matrix3& b) {
  const auto entry = [&](int i, int j) { return a(i, 0) * b(0, j) + a(i, 1) * b(1, j) + a(i, 2) * b(2, j); };
  Components result;
  result << entry(0, 0), entry(1, 1), entry(2, 2), entry(0, 1), entry(0, 2), entry(1, 2);
  return result;
}

/// a : b of symmetric tensors.
inline double double_product(const Components& a, const Matrix3& b) {
  return a[0] * b(0, 0) + a[1] * b(1, 1) + a[2] * b(2, 2) + 2 * (a[3] * b(0, 1) + a[4] * b(0, 2) + a[5] * b(1, 2));
}

inline double symmetric_determinant(const Matrix3& a) {
  return a(0, 0) * (a(1, 1) * a(2, 2) - a(2, 1) * a(2, 1)) + a(1, 0) * (2 * a(2, 0) * a(2, 1) - a(1, 0) * a(2, 2)) -
         a(2, 0) * a(2, 0) * a(1, 1);
}

/// Of ½ (a bᵀ + b aᵀ).
inline Components symmetric_product(const Vector3& a, const Vector3& b) {
  Components result;
  result << a[0] * b[0], a[1] * b[1], a[2] * b[2], (a[0] * b[1] + a[1] * b[0]) / 2, (a[0] * b[2] + a[2] * b[0]) / 2,
      (a[1] * b[2] + a[2] * b[1]) / 2;
  return result;
}

/// G ⊙ G, ½ (G_ik G_jl + G_il G_jk): −∂C⁻¹/∂C of G = C⁻¹, and of G = I what leaves a symmetric tensor as it is.
inline TangentModuli<3> symmetric_square(const Matrix3& G) {
  TangentModuli<3> result = TangentModuli<3>::Zero();
  add_symmetric_squares(G, 0, 1, result);
  return result;
}

/// a bᵀ + b aᵀ.
inline TangentModuli<3> both_ways(const Components& a, const Components& b) {
  const TangentModuli<3> product = a * b.transpose();
  return product + product.transpose();
}

}  // namespace elastin
