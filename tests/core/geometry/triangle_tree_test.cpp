#include "core/geometry/triangle_tree.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "core/base/random.h"
#include "core/geometry/boundary.h"
#include "core/shapes/surfaces.h"
#include "elastin/core/shapes/shapes.h"
#include "support/allocations.h"

using namespace elastin;

namespace {

/// Its corner is the origin.
TriangleTree box(const Vector3& size) {
  const Body block = tetrahedral_block(BlockKind::kuhn, {4, 2, 2}, {size.x(), size.y(), size.z()});
  return {block.rest, boundary_of(block.tetrahedra)};
}

}  // namespace

TEST_CASE("the distance to a surface has the sign of inside and outside, exactly", "[triangle tree]") {
  const TriangleTree tree = box({4, 2, 2});
  CHECK(tree.signed_distance({2, 1, 1}) == Approx(-1));
  CHECK(tree.signed_distance({2, 1, 2.5}) == Approx(0.5));
  CHECK(tree.signed_distance({5, 3, 3}) == Approx(std::sqrt(3)));      // off a corner
  CHECK(tree.signed_distance({-1, -1, 1.3}) == Approx(std::sqrt(2)));  // off a side
  CHECK(tree.signed_distance({0.1, 0.1, 0.2}) == Approx(-0.1));
  const auto found = tree.nearest({1.25, 0.75, -3});
  CHECK((found.on.position - Vector3(1.25, 0.75, 0)).norm() < 1e-12);
  CHECK(found.distance == Approx(3));
}

TEST_CASE("a sphere of triangles knows inside from outside everywhere", "[triangle tree]") {
  const Body ball = sphere(1, SphereMesh::icosahedron, 6);
  const TriangleTree tree(ball.rest, ball.triangles);
  std::mt19937_64 generator(3);
  for (int trial = 0; trial < 500; ++trial) {
    const Vector3 point =
        Vector3(unit_random(generator), unit_random(generator), unit_random(generator)) * 2.4 - Vector3::Constant(1.2);
    // A flat triangle of 20 · 6² lies up to 1 − cos(half its angle) below the sphere: 0.02.
    CHECK(tree.signed_distance(point) == Approx(point.norm() - 1).margin(0.02));
    double least = 1e9;
    for (const auto& [a, b, c] : ball.triangles)
      least = std::min(
          least,
          (nearest_point(point, {ball.rest.col(a), ball.rest.col(b), ball.rest.col(c)}).position - point).norm());
    CHECK(tree.nearest(point).distance == least);
  }
}

TEST_CASE("at a corner the normals around it are weighted with their angles", "[triangle tree]") {
  const TriangleTree tree = box({4, 2, 2});
  for (const Vector3& inwards : {Vector3(1, 1, 1), Vector3(1, -1, 1), Vector3(-1, -1, -1)}) {
    const Vector3 corner((inwards.x() < 0) * 4., (inwards.y() < 0) * 2., (inwards.z() < 0) * 2.);
    const auto nearest = tree.nearest(corner - inwards);
    const Vector3 normal = tree.normals().at(tree.points(), nearest.triangle, nearest.on.weights);
    CHECK((normal + inwards / std::sqrt(3)).norm() < 1e-12);  // however the faces are cut into triangles
  }
}

TEST_CASE("a question to the tree allocates nothing", "[triangle tree]") {
  const TriangleTree tree = box({4, 2, 2});
  const long before = testing::allocations();
  const double distance = tree.signed_distance({1, 2, 3});
  CHECK(testing::allocations() == before);
  CHECK(distance == Approx(1));
}
