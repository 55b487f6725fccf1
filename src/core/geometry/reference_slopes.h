#pragma once
#include <array>
#include <vector>

#include "elastin/core/geometry/cell_kind.h"

namespace elastin {

inline constexpr int kMostNodes = 27, kMostPoints = 27;

/// A vector of each node of one cell, a column each.
using NodeVectors = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::ColMajor, 3, kMostNodes>;
/// Of one cell, at each point of its quadrature.
template <int d>
using PointGradients = std::array<Eigen::Matrix<double, 3, d>, kMostPoints>;

/// Slopes by the reference coordinates ξ at all points of a cell at once. By hand: matrices of unknown size have no
/// fast product so small, and take seconds to compile.
template <int d>
class ReferenceSlopes {
 public:
  /// @param kind must outlive this.
  explicit ReferenceSlopes(const CellKind& kind);

  /// Σ_a v_a ⊗ ∂N_a/∂ξ at each point.
  void gradients(const NodeVectors& values, PointGradients<d>& at_points) const;
  /// own_a += Σ_g P_g ∂N_a/∂ξ.
  void spread(const PointGradients<d>& at_points, NodeVectors& own) const;

 private:
  void gradients_by_products(const NodeVectors& values, PointGradients<d>& at_points) const;
  void spread_by_products(const PointGradients<d>& at_points, NodeVectors& own) const;

  const CellKind& kind_;
  int points_;
  // Of a hexahedron27, whose functions are products of three of one coordinate each: with these, 8 passes of 3 × 27
  // products take the place of 27 × 27 [Orszag 1980].
  std::vector<int> nodes_;  ///< its nodes by their places, x first; empty where functions are no products
  std::array<std::array<double, 3>, 3> values_{}, slopes_{};  ///< [at a point][of a node]
};

}  // namespace elastin
