#pragma once
#include <utility>

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

/// Adds entry(row, column), symmetric, to every entry: the loops unrolled, so that the components' places are known
/// to the compiler.
template <class Entry>
void add_symmetric(TangentModuli<3>& result, const Entry& entry) {
  const auto add_one = [&]<int row, int column>() {
    const double value = entry.template operator()<row, column>();
    result(row, column) += value;
    if constexpr (row != column) result(column, row) += value;
  };
  const auto add_row = [&]<int row, int... columns>(std::integer_sequence<int, columns...>) {
    (add_one.template operator()<row, columns>(), ...);
  };
  [&]<int... rows>(std::integer_sequence<int, rows...>) {
    (add_row.template operator()<rows>(std::make_integer_sequence<int, rows + 1>()), ...);
  }
  (std::make_integer_sequence<int, 6>());
}

/// An entry of G ⊙ G, ½ (G_ik G_jl + G_il G_jk).
template <int row, int column>
double symmetric_square_entry(const Matrix3& G) {
  constexpr int i = kComponents[row][0], j = kComponents[row][1], k = kComponents[column][0],
                l = kComponents[column][1];
  return (G(i, k) * G(j, l) + G(i, l) * G(j, k)) / 2;
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
  add_symmetric(result, [&]<int row, int column>() { return symmetric_square_entry<row, column>(G); });
  return result;
}

/// a bᵀ + b aᵀ.
inline TangentModuli<3> both_ways(const Components& a, const Components& b) {
  const TangentModuli<3> product = a * b.transpose();
  return product + product.transpose();
}

}  // namespace elastin
