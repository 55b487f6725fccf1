#pragma once
#include <array>
#include <cmath>
#include <concepts>
#include <string_view>

#include "elastin/core/model/body.h"

namespace elastin {

/// Pairs of the nodes of a cell, which are its connections: 3 of a triangle, 6 of a tetrahedron.
constexpr int pairs_of(int nodes) { return nodes * (nodes - 1) / 2; }

/// The two nodes of each pair, order 01 02 03 … 12 13 ….
template <int nodes>
constexpr auto node_pairs() {
  std::array<std::array<int, 2>, pairs_of(nodes)> pairs{};
  for (int a = 0, pair = 0; a < nodes; ++a)
    for (int b = a + 1; b < nodes; ++b) pairs[pair++] = {a, b};
  return pairs;
}

/// One number a pair of a cell's nodes, and one a pair of pairs.
template <int nodes>
using CellVector = Eigen::Matrix<double, pairs_of(nodes), 1>;
template <int nodes>
using CellMatrix = Eigen::Matrix<double, pairs_of(nodes), pairs_of(nodes)>;

/// Where the nodes of a cell are [m], a column a node.
template <int nodes>
using NodePositions = Eigen::Matrix<double, 3, nodes>;

/// A point ξ of the reference cell and its weight ω in integrals over it.
template <int dimensions>
struct QuadraturePoint {
  std::array<double, static_cast<std::size_t>(dimensions)> position;
  double weight;
};

/// The shape of a cell whose nodes are molecules; it knows no law. `dimensions` 2 (membranes) or 3 (solids), `nodes`,
/// `points` to integrate at, `faces`: the nodes of each face, outward; of a membrane, of each side. N_a are the shape
/// functions, 1 at node a and 0 at the others; their slopes ∂N_a/∂ξ have a column a node. in(body) are the body's cells
/// of this shape.
template <class Shape>
concept CellShape = requires(const std::array<double, Shape::dimensions>& at, const Body& body) {
  { Shape::name } -> std::convertible_to<std::string_view>;
  { Shape::plural } -> std::convertible_to<std::string_view>;
  requires Shape::dimensions == 2 || Shape::dimensions == 3;
  requires Shape::points.size() > 0 && Shape::reference_nodes.size() == Shape::nodes;
  { Shape::faces.front().front() } -> std::convertible_to<int>;
  { Shape::shape_functions(at) } -> std::convertible_to<Eigen::Matrix<double, Shape::nodes, 1>>;
  { Shape::shape_slopes(at) } -> std::convertible_to<Eigen::Matrix<double, Shape::dimensions, Shape::nodes>>;
  { Shape::in(body) } -> std::convertible_to<const Cells<Shape::nodes>&>;
};

/// ∂x/∂ξ at a point of the reference cell, from where its nodes are.
template <CellShape Shape>
Eigen::Matrix<double, 3, Shape::dimensions> jacobian(const NodePositions<Shape::nodes>& positions,
                                                     const std::array<double, Shape::dimensions>& at) {
  return positions * Shape::shape_slopes(at).transpose();
}

/// A cell at rest, as laws need it at its quadrature points g. A membrane's gradients are in a plane frame of the point
/// itself: first axis along ∂x/∂ξ₁, second in the cell. Orientation does not matter; a flat cell (see BodyFindings)
/// gives no finite gradients.
///
/// Because Σ_a B_a = 0, lengths alone give the right Cauchy–Green tensor, C = −½ Σ_ab s_ab (B_a B_bᵀ + B_b B_aᵀ) over
/// pairs, hence q_ab = 2 ∂W/∂s_ab = −Σ_g w_g B_aᵀ S_g B_b for any energy.
template <CellShape Shape>
struct RestCell {
  static constexpr int dimensions = Shape::dimensions, nodes = Shape::nodes;
  static constexpr std::size_t points = Shape::points.size();
  using Gradients = Eigen::Matrix<double, dimensions, nodes>;

  std::array<Gradients, points> gradients;  ///< B_a = ∂N_a/∂X [1/m], a column a node
  std::array<double, points> weights;       ///< w_g [m³], or [m²] of a membrane, > 0
  CellVector<nodes> squared_lengths;        ///< s⁰ [m²]

  /// @param rest the nodes [m], a column a node.
  explicit RestCell(const NodePositions<nodes>& rest) {
    static constexpr auto pairs = node_pairs<nodes>();
    for (int c = 0; c < squared_lengths.size(); ++c)
      squared_lengths[c] = (rest.col(pairs[c][1]) - rest.col(pairs[c][0])).squaredNorm();
    for (std::size_t g = 0; g < points; ++g) {
      const auto& [at, weight] = Shape::points[g];
      const Eigen::Matrix<double, dimensions, dimensions> edges = in_frame(jacobian<Shape>(rest, at));
      weights[g] = weight * std::abs(edges.determinant());
      gradients[g] = edges.inverse().transpose() * Shape::shape_slopes(at);
    }
  }

  /// Volume [m³] or area [m²].
  double measure() const {
    double sum = 0;
    for (const double weight : weights) sum += weight;
    return sum;
  }

 private:
  static Eigen::Matrix<double, dimensions, dimensions> in_frame(const Eigen::Matrix<double, 3, dimensions>& edges) {
    if constexpr (dimensions == 3) {
      return edges;
    } else {
      const Vector3 first = edges.col(0), second = edges.col(1);
      const double length = first.norm();
      Eigen::Matrix2d plane;
      plane << length, first.dot(second) / length, 0, first.cross(second).norm() / length;
      return plane;
    }
  }
};

/// Whether a solid cell is flat or inverted at one of its quadrature points: lengths cannot tell a cell from its mirror
/// image, signed volumes can.
template <CellShape Shape>
requires(Shape::dimensions == 3) bool flat_or_inverted(const NodePositions<Shape::nodes>& positions) {
  for (const auto& point : Shape::points)
    if (!(jacobian<Shape>(positions, point.position).determinant() > 0)) return true;
  return false;
}

}  // namespace elastin
