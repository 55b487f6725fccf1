#pragma once
#include <array>

#include "core/geometry/reference_slopes.h"
#include "elastin/core/laws/law.h"

/// What the driver of a block's cells (block_cells.cpp) consists of.
namespace elastin::blocks {

/// F, δF, F S at a point.
template <int d>
using Gradient = Eigen::Matrix<double, 3, d>;
template <int d>
using Direction = Eigen::Matrix<double, d, 1>;
template <class T>
using AtPoints = std::array<T, kMostPoints>;
/// A symmetric tensor's components in the order of TangentModuli: 11 22 33 12 13 23, or 11 22 12.
template <int d>
using Components = Eigen::Matrix<double, d*(d + 1) / 2, 1>;

template <int d>
constexpr auto order_of_components() {
  if constexpr (d == 3)
    return std::array<std::array<int, 2>, 6>{{{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}}};
  else
    return std::array<std::array<int, 2>, 3>{{{0, 0}, {1, 1}, {0, 1}}};
}
/// Where ij is among the components.
template <int d>
constexpr int component(int i, int j) {
  return i == j ? i : i + j + d - 1;
}

template <int d>
inline Components<d> components_of(const Tensor<d>& tensor) {
  Components<d> own;
  constexpr auto order = order_of_components<d>();
  for (int k = 0; k < own.size(); ++k) {
    const auto [i, j] = order[k];
    own[k] = tensor(i, j);
  }
  return own;
}
/// Those off the diagonal twice: both of their places in a product.
template <int d>
inline Components<d> doubled_components(const Tensor<d>& tensor) {
  Components<d> own;
  constexpr auto order = order_of_components<d>();
  for (int k = 0; k < own.size(); ++k) {
    const auto [i, j] = order[k];
    own[k] = tensor(i, j) * (i == j ? 1 : 2);
  }
  return own;
}
template <int d>
inline Tensor<d> tensor_of(const Components<d>& own) {
  Tensor<d> tensor;
  constexpr auto order = order_of_components<d>();
  for (int k = 0; k < own.size(); ++k) {
    const auto [i, j] = order[k];
    tensor(i, j) = tensor(j, i) = own[k];
  }
  return tensor;
}

/// The cofactors of F: ∂ det F/∂F. Membranes have no volume: zero.
template <int d>
inline Gradient<d> cofactors(const Gradient<d>& F) {
  Gradient<d> result;
  if constexpr (d == 3)
    result << F.col(1).cross(F.col(2)), F.col(2).cross(F.col(0)), F.col(0).cross(F.col(1));
  else
    result.setZero();
  return result;
}

/// What a point's stiffness is made of.
template <int d>
struct PointStiffness {
  Gradient<d> F;
  Tensor<d> S;  ///< times the weight, pressure included
  TangentModuli<d> D;
};

/// What a motion e_i ⊗ B of a point meets, a column for each i: the change of C's components, those off the diagonal
/// twice, its stress, and S B.
template <int d>
struct Acting {
  using Changes = Eigen::Matrix<double, d*(d + 1) / 2, 3>;
  Direction<d> B, SB;
  Changes V, DV;
};
template <int d>
inline Acting<d> acting(const PointStiffness<d>& now, const Direction<d>& B) {
  typename Acting<d>::Changes V;
  constexpr auto order = order_of_components<d>();
  for (int k = 0; k < V.rows(); ++k) {
    const auto [p, q] = order[k];
    for (int i = 0; i < 3; ++i) V(k, i) = (now.F(i, p) * B[q] + now.F(i, q) * B[p]) * (p == q ? 1 : 2);
  }
  return {B, now.S * B, V, now.D * V};
}
/// Adds the stiffness between the motions a and b.
template <int d>
inline void add_pair(const Acting<d>& a, const Acting<d>& b, Matrix3& block) {
  block.noalias() += 0.5 * (a.V.transpose() * b.DV);
  block.diagonal().array() += a.B.dot(b.SB);
}

}  // namespace elastin::blocks
