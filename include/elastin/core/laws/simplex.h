#pragma once
#include <array>
#include <cmath>
#include <string>

#include "elastin/core/base/error.h"
#include "elastin/core/laws/law.h"
#include "elastin/core/model/material.h"

namespace elastin {

/// The two corners of each connection of a cell, order 01 02 12 or 01 02 03 12 13 23.
template <int corners>
constexpr auto corner_pairs() {
  std::array<std::array<int, 2>, connections_of_cell(corners)> pairs{};
  for (int a = 0, connection = 0; a < corners; ++a)
    for (int b = a + 1; b < corners; ++b) pairs[connection++] = {a, b};
  return pairs;
}

/// One number a connection of a cell, and one a pair of connections.
template <int corners>
using CellVector = Eigen::Matrix<double, connections_of_cell(corners), 1>;
template <int corners>
using CellMatrix = Eigen::Matrix<double, connections_of_cell(corners), connections_of_cell(corners)>;

/// A triangle or a tetrahedron at rest. A triangle lies in a plane frame of its own: first axis along side 01, second
/// towards corner 2. Orientation does not matter; a flat cell (see BodyFindings) gives no finite gradients.
template <int corners>
struct Simplex {
  static constexpr int dimensions = corners - 1;

  Eigen::Matrix<double, dimensions, corners>
      gradients;                        ///< b_a of the barycentric coordinates [1/m], a column a corner
  double measure;                       ///< volume [m³] or area [m²], > 0
  CellVector<corners> squared_lengths;  ///< s⁰ [m²]

  /// @param rest places of the corners [m], a column a corner.
  explicit Simplex(const Eigen::Matrix<double, 3, corners>& rest) {
    static constexpr auto pairs = corner_pairs<corners>();
    for (int c = 0; c < squared_lengths.size(); ++c)
      squared_lengths[c] = (rest.col(pairs[c][1]) - rest.col(pairs[c][0])).squaredNorm();
    Eigen::Matrix<double, dimensions, dimensions> edges;  // from corner 0
    const Vector3 first = rest.col(1) - rest.col(0), second = rest.col(2) - rest.col(0);
    if constexpr (corners == 4) {
      edges << first, second, rest.col(3) - rest.col(0);
    } else {
      const double length = first.norm();
      edges << length, first.dot(second) / length, 0, first.cross(second).norm() / length;
    }
    measure = std::abs(edges.determinant()) / (corners == 4 ? 6 : 2);
    gradients.template rightCols<dimensions>() = edges.inverse().transpose();
    gradients.col(0) = -gradients.template rightCols<dimensions>().rowwise().sum();
  }

  /// B_c = −½ (b_a b_bᵀ + b_b b_aᵀ) [1/m²] of connection c = ab. The right Cauchy–Green tensor is C = Σ_c s_c B_c,
  /// hence q_c = 2 ∂W/∂s_c = V S : B_c for any energy W = V w(C), S = 2 ∂w/∂C.
  Eigen::Matrix<double, dimensions, dimensions> basis(int connection) const {
    const auto [a, b] = corner_pairs<corners>()[connection];
    return -0.5 * (gradients.col(a) * gradients.col(b).transpose() + gradients.col(b) * gradients.col(a).transpose());
  }
};

/// λ and μ [Pa].
struct Lame {
  double lambda, mu;
};

/// λ = E ν/((1+ν)(1−2ν)), μ = E/(2(1+ν)) of the solid, for tetrahedra; in plane stress λ = E ν/(1−ν²), for triangles.
/// Throws InputError unless −1 < ν < ½; in plane stress ν = ½ is a material like others.
template <int corners>
Lame lame(const Material& material) {
  const double E = material.youngs_modulus, nu = material.poissons_ratio;
  if (!(nu > -1 && (corners == 3 ? nu <= 0.5 : nu < 0.5)))
    throw InputError("poissons_ratio " + std::to_string(nu) + ": a cell law needs more than -1 and " +
                     (corners == 3 ? "at most 0.5" : "less than 0.5"));
  return {corners == 4 ? E * nu / ((1 + nu) * (1 - 2 * nu)) : E * nu / (1 - nu * nu), E / (2 * (1 + nu))};
}

}  // namespace elastin
