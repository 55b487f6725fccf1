#include "core/geometry/boundary.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>

#include "elastin/core/shapes/shapes.h"

using namespace elastin;

namespace {

/// Enclosed by triangles that look outwards.
double volume_inside(const Positions& points, const Cells<3>& triangles) {
  double volume = 0;
  for (const auto& [a, b, c] : triangles) {
    const Vector3 first = points.col(a), second = points.col(b), third = points.col(c);
    volume += first.dot(second.cross(third)) / 6;
  }
  return volume;
}

Cells<3> sorted_corners(Cells<3> triangles) {
  for (auto& triangle : triangles) std::sort(triangle.begin(), triangle.end());
  return triangles;
}

}  // namespace

TEST_CASE("the boundary of tetrahedra encloses their volume and looks outwards", "[boundary]") {
  for (const BlockKind kind : {BlockKind::kuhn, BlockKind::alternating, BlockKind::body_centred}) {
    const Body block = tetrahedral_block(kind, {3, 2, 4}, {3, 2, 4});
    const Cells<3> boundary = boundary_of(block.tetrahedra);
    CHECK(volume_inside(block.rest, boundary) == Approx(24).epsilon(1e-12));
    const Cells<3> sorted = sorted_corners(boundary);
    CHECK(std::is_sorted(sorted.begin(), sorted.end()));
    CHECK(faces_of(block.tetrahedra).size() == 4 * block.tetrahedra.size());
  }
}

TEST_CASE("the boundary does not depend on the order of the cells", "[boundary]") {
  const Body block = tetrahedral_block(BlockKind::kuhn, {3, 2, 4}, {3, 2, 4});
  Cells<4> turned = block.tetrahedra;
  std::reverse(turned.begin(), turned.end());
  CHECK(boundary_of(turned) == boundary_of(block.tetrahedra));
}

TEST_CASE("two cubes have ten faces outside, and each looks outwards", "[boundary]") {
  const Body lattice = cubic_lattice({3, 2, 2}, 1, {true, false, false});
  REQUIRE(lattice.cubes.size() == 2);
  Cells<3> triangles;
  for (const auto& [a, b, c, d] : boundary_of(lattice.cubes)) {
    triangles.push_back({a, b, c});
    triangles.push_back({a, c, d});
  }
  CHECK(triangles.size() == 20);
  CHECK(volume_inside(lattice.rest, triangles) == Approx(2).epsilon(1e-12));
}
