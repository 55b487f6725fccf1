#include "elastin/core/shapes/cell_shapes.h"

#include <catch2/catch.hpp>

#include "support/cells.h"

using namespace elastin;
using namespace elastin::testing;

namespace {

template <class Shape>
NodePositions<Shape::nodes> reference() {
  NodePositions<Shape::nodes> positions = NodePositions<Shape::nodes>::Zero();
  for (int a = 0; a < Shape::nodes; ++a)
    for (int i = 0; i < Shape::dimensions; ++i) positions(i, a) = Shape::reference_nodes[a][i];
  return positions;
}

}  // namespace

TEMPLATE_TEST_CASE("a cell shape: shape functions, slopes, points and faces belong together", "[cell_shape]", Triangle3,
                   Tetrahedron4) {
  using Shape = TestType;
  constexpr int nodes = Shape::nodes, dimensions = Shape::dimensions;
  for (int a = 0; a < nodes; ++a) {
    const auto values = Shape::shape_functions(Shape::reference_nodes[a]);
    for (int b = 0; b < nodes; ++b) CHECK(values[b] == Approx(a == b).margin(1e-15));
  }
  Random random(1);
  for (int trial = 0; trial < 20; ++trial) {
    std::array<double, dimensions> at;
    for (double& x : at) x = random.number();
    CHECK(Shape::shape_functions(at).sum() == Approx(1));
    const auto slopes = Shape::shape_slopes(at);
    CHECK(slopes.rowwise().sum().norm() <= 1e-14);
    for (int i = 0; i < dimensions; ++i) {
      auto up = at, down = at;
      up[i] += 1e-6, down[i] -= 1e-6;
      const Eigen::Matrix<double, nodes, 1> change = (Shape::shape_functions(up) - Shape::shape_functions(down)) / 2e-6;
      CHECK((change.transpose() - slopes.row(i)).norm() <= 1e-9);
    }
  }
  // The points integrate 1, the faces' outward area vectors close, and each sees the middle on its inner side.
  const NodePositions<nodes> positions = reference<Shape>();
  CHECK(RestCell<Shape>(positions).measure() == Approx(dimensions == 2 ? 0.5 : 1. / 6));
  const Vector3 middle = positions.rowwise().mean();
  Vector3 total = Vector3::Zero();
  for (const auto& face : Shape::faces) {
    const Vector3 along = positions.col(face[1]) - positions.col(face[0]);
    const Vector3 other =
        dimensions == 2 ? Vector3(Vector3::UnitZ()) : Vector3(positions.col(face.back()) - positions.col(face[0]));
    const Vector3 outward = along.cross(other);
    CHECK(outward.dot(positions.col(face[0]) - middle) > 0);
    total += outward;
  }
  CHECK(total.norm() <= 1e-14);
}

TEMPLATE_TEST_CASE("a cell at rest: gradients of linear functions are exact", "[cell_shape]", Triangle3, Tetrahedron4) {
  using Shape = TestType;
  Random random(2);
  for (int trial = 0; trial < 50; ++trial) {
    const auto rest = random_cell<Shape::nodes>(random);
    const RestCell<Shape> cell(rest);
    for (const auto& B : cell.gradients) {
      CHECK(B.rowwise().sum().norm() <= 1e-12 * B.norm());
      const Eigen::Matrix<double, 3, Shape::dimensions> frame = rest * B.transpose();  // of the cell, orthonormal
      CHECK((frame.transpose() * frame - Tensor<Shape::dimensions>::Identity()).norm() <= 1e-11);
    }
  }
}

TEST_CASE("a solid cell is inverted where its volume is not positive, whatever its lengths", "[cell_shape]") {
  NodePositions<4> cell = reference<Tetrahedron4>();
  CHECK_FALSE(flat_or_inverted<Tetrahedron4>(cell));
  cell.row(2) *= -1;
  CHECK(flat_or_inverted<Tetrahedron4>(cell));
  cell.row(2).setZero();
  CHECK(flat_or_inverted<Tetrahedron4>(cell));
}
