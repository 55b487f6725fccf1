#pragma once
#include "elastin/core/shapes/cell_shape.h"

namespace elastin {

/// Linear simplices: N_0 = 1 − Σ ξ_i, N_i = ξ_i; one quadrature point is exact.
template <int dimensions_>
struct LinearSimplex {
  static constexpr int dimensions = dimensions_, nodes = dimensions + 1;
  using Position = std::array<double, dimensions>;

  static Eigen::Matrix<double, nodes, 1> shape_functions(const Position& at) {
    Eigen::Matrix<double, nodes, 1> values;
    for (int i = 0; i < dimensions; ++i) values[i + 1] = at[i];
    values[0] = 1 - values.template tail<dimensions>().sum();
    return values;
  }
  static Eigen::Matrix<double, dimensions, nodes> shape_slopes(const Position&) {
    Eigen::Matrix<double, dimensions, nodes> slopes;
    slopes.template rightCols<dimensions>().setIdentity();
    slopes.col(0).setConstant(-1);
    return slopes;
  }
};

struct Triangle3 : LinearSimplex<2> {
  static constexpr std::string_view name = "triangle3", plural = "triangles";
  static constexpr std::array<Position, 3> reference_nodes{{{0, 0}, {1, 0}, {0, 1}}};
  static constexpr std::array<QuadraturePoint<2>, 1> points{{{{1. / 3, 1. / 3}, 0.5}}};
  static constexpr std::array<std::array<int, 2>, 3> faces{{{0, 1}, {1, 2}, {2, 0}}};
  static const Cells<3>& in(const Body& body) { return body.triangles; }
};

struct Tetrahedron4 : LinearSimplex<3> {
  static constexpr std::string_view name = "tetrahedron4", plural = "tetrahedra";
  static constexpr std::array<Position, 4> reference_nodes{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  static constexpr std::array<QuadraturePoint<3>, 1> points{{{{0.25, 0.25, 0.25}, 1. / 6}}};
  static constexpr std::array<std::array<int, 3>, 4> faces{{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}};
  static const Cells<4>& in(const Body& body) { return body.tetrahedra; }
};

}  // namespace elastin
