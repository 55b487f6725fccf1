#include "elastin/core/model/embedded_surface.h"

#include <catch2/catch.hpp>
#include <limits>
#include <random>
#include <vector>

#include "elastin/core/base/error.h"
#include "elastin/core/shapes/arrays.h"
#include "elastin/core/shapes/shapes.h"

using namespace elastin;
using Catch::Contains;

namespace {

Matrix3 turned_and_stretched() {
  Matrix3 F;
  F << 1.2, 0.3, -0.1, -0.2, 0.9, 0.4, 0.1, -0.3, 1.1;
  return F;
}

Body one_cell(const CellKind& kind) {
  BodyArrays arrays;
  arrays.positions = 0.01 * turned_and_stretched() * kind.reference;
  CellBlock block{&kind, {}, {}};
  for (int node = 0; node < kind.nodes; ++node) block.nodes.push_back(node);
  arrays.blocks.push_back(block);
  arrays.density = 1000;
  return make_body(arrays);
}

/// Where the surface draws its points.
Positions drawn(const EmbeddedSurface& surface, const Positions& positions) {
  std::vector<float> points(3 * static_cast<std::size_t>(surface.size()));
  surface.draw(positions, points, {});
  return Eigen::Map<Eigen::Matrix3Xf>(points.data(), 3, surface.size()).cast<double>();
}

Positions random_points(const Body& body, int count, double beyond) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> part(-beyond, 1 + beyond);
  const Vector3 low = body.rest.rowwise().minCoeff(), size = body.rest.rowwise().maxCoeff() - low;
  Positions points(3, count);
  for (int p = 0; p < count; ++p)
    for (int axis = 0; axis < 3; ++axis) points(axis, p) = low[axis] + part(random) * size[axis];
  return points;
}

}  // namespace

TEST_CASE("embedded surface: points of every shape of cell move with a homogeneous deformation") {
  std::vector<Body> bodies{cubic_lattice({4, 5, 3}, 2e-3, {true, true, false}),
                           tetrahedral_block(BlockKind::kuhn, {2, 3, 2}, {6e-3, 9e-3, 6e-3})};
  for (const CellKind& kind : cell_kinds())
    if (kind.dimensions == 3) bodies.push_back(one_cell(kind));
  const Matrix3 F = turned_and_stretched();
  const Vector3 shift(0.02, -0.01, 0.03);
  for (const Body& body : bodies) {
    CAPTURE(body.size(), body.blocks.empty() ? "" : body.blocks[0].kind->name);
    const Positions points = random_points(body, 200, 0.02);
    const EmbeddedSurface surface(body, points, {});
    const Positions expected = (F * points).colwise() + shift;
    CHECK((drawn(surface, (F * body.rest).colwise() + shift) - expected).cwiseAbs().maxCoeff() < 2e-8);
  }
}

TEST_CASE("embedded surface: a cell of second order bends what it carries") {
  const Body body = one_cell(cell_kind("hexahedron27"));
  const Positions points = random_points(body, 50, -0.4);
  const auto bent = [](Positions at) {
    for (Eigen::Index p = 0; p < at.cols(); ++p) at(2, p) += 8 * at(0, p) * at(0, p) - 5 * at(0, p) * at(1, p);
    return at;
  };
  CHECK((drawn(EmbeddedSurface(body, points, {}), bent(body.rest)) - bent(points)).cwiseAbs().maxCoeff() < 2e-8);
}

TEST_CASE("embedded surface: normals point outward and have length 1") {
  const Body body = cubic_lattice({3, 3, 3}, 1e-2, {true, true, false});
  Positions corners(3, 4);
  corners << 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1;
  corners = 5e-3 * corners.array() + 5e-3;
  const EmbeddedSurface surface(body, corners, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}});
  CHECK(surface.farthest() == 0);
  std::vector<float> points(12), normals(12);
  const Matrix3 F = turned_and_stretched();
  surface.draw(F * body.rest, points, normals);
  const Eigen::Map<Eigen::Matrix3Xf> normal(normals.data(), 3, 4);
  const Vector3 middle = F * corners.rowwise().mean();
  for (int p = 0; p < 4; ++p) {
    CHECK(normal.col(p).norm() == Approx(1).epsilon(1e-6));
    CHECK(normal.col(p).cast<double>().dot(F * corners.col(p) - middle) > 0);
  }
  const Vector3 first = (F.col(1).cross(F.col(0)) + F.col(0).cross(F.col(2)) + F.col(2).cross(F.col(1))).normalized();
  CHECK((normal.col(0).cast<double>() - first).norm() < 1e-6);
}

TEST_CASE("embedded surface: what cannot be carried is refused, and what is outside said") {
  const Body body = tetrahedral_block(BlockKind::kuhn, {1, 1, 1}, Vector3::Constant(1e-2));
  const Positions inside = Positions::Constant(3, 1, 5e-3);
  CHECK(EmbeddedSurface(body, inside, {}).farthest() == 0);
  const double beyond = EmbeddedSurface(body, Vector3(5e-3, 5e-3, 11e-3), {}).farthest();
  CHECK(beyond > 0.5e-3);
  CHECK(beyond < 2e-3);
  CHECK_THROWS_WITH(EmbeddedSurface(body, inside, {{0, 0, 1}}), Contains("the point 1; it has points 0 to 0"));
  CHECK_THROWS_WITH(EmbeddedSurface(body, Positions::Constant(3, 1, std::numeric_limits<double>::quiet_NaN()), {}),
                    Contains("point 0 is not finite"));
  CHECK_THROWS_WITH(drawn(EmbeddedSurface(body, inside, {}), Positions::Zero(3, 5)), Contains("5 positions"));
  Body springs = body;
  springs.tetrahedra.clear(), springs.cubes.clear(), springs.blocks.clear();
  CHECK_THROWS_WITH(EmbeddedSurface(springs, inside, {}), Contains("no solid cells"));
}
