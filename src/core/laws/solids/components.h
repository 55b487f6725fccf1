#pragma once
#include "elastin/core/laws/law.h"

namespace elastin {

/// The components of a symmetric tensor in the order of TangentModuli<3>: 11 22 33 12 13 23, each once.
using Components = Eigen::Matrix<double, 6, 1>;

inline constexpr int kComponents[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};

/// Each from its own number alone. Eigen's expressions read two at a time what was written one at a time just before,
/// for which processors wait: a quarter of a law's force.
template <class Number>
Components each_component(const Number& number) {
  Components result;
  for (int row = 0; row < 6; ++row) result[row] = number(row);
  return result;
}

inline Components components(const Matrix3& symmetric) {
  return each_component([&](int row) { return symmetric(kComponents[row][0], kComponents[row][1]); });
}

inline Matrix3 tensor(const Components& c) {
  Matrix3 result;
  result << c[0], c[3], c[4], c[3], c[1], c[5], c[4], c[5], c[2];
  return result;
}

/// a b of symmetric tensors that have the same axes, so that it is symmetric too.
inline Components commuting_product(const Components& a, const Components& b) {
  static constexpr int at[3][3] = {{0, 3, 4}, {3, 1, 5}, {4, 5, 2}};
  return each_component([&](int row) {
    const auto [i, j] = kComponents[row];
    return a[at[i][0]] * b[at[0][j]] + a[at[i][1]] * b[at[1][j]] + a[at[i][2]] * b[at[2][j]];
  });
}

/// a : b of symmetric tensors.
inline double double_product(const Components& a, const Components& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + 2 * (a[3] * b[3] + a[4] * b[4] + a[5] * b[5]);
}
inline double double_product(const Components& a, const Matrix3& b) { return double_product(a, components(b)); }

inline double symmetric_determinant(const Components& a) {
  return a[0] * (a[1] * a[2] - a[5] * a[5]) + a[3] * (2 * a[4] * a[5] - a[3] * a[2]) - a[4] * a[4] * a[1];
}
/// With `number` more in each entry of the diagonal.
inline Components on_diagonal(const Components& a, double number) {
  return each_component([&](int row) { return row < 3 ? a[row] + number : a[row]; });
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

/// Adds factor (a bᵀ + b aᵀ).
inline void add_both_ways(double factor, const Components& a, const Components& b, TangentModuli<3>& tangent) {
  add_symmetric(tangent, [&](int row, int column) { return factor * (a[row] * b[column] + b[row] * a[column]); });
}
/// Adds factor a aᵀ.
inline void add_square(double factor, const Components& a, TangentModuli<3>& tangent) {
  add_symmetric(tangent, [&](int row, int column) { return factor * a[row] * a[column]; });
}

/// a bᵀ + b aᵀ.
inline TangentModuli<3> both_ways(const Components& a, const Components& b) {
  const TangentModuli<3> product = a * b.transpose();
  return product + product.transpose();
}

}  // namespace elastin
