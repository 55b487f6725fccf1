#include "hull/delaunay.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <map>

#include "elastin/core/base/error.h"
#include "support/bodies.h"

using namespace elastin;
using namespace elastin::hull;
using namespace elastin::testing;

namespace {

/// How many cells each face bounds.
std::map<std::array<int, 3>, int> faces(const Cells<4>& tetrahedra) {
  std::map<std::array<int, 3>, int> count;
  for (const auto& cell : tetrahedra)
    for (std::size_t left_out = 0; left_out < 4; ++left_out) {
      std::array<int, 3> face{cell[(left_out + 1) % 4], cell[(left_out + 2) % 4], cell[(left_out + 3) % 4]};
      std::sort(face.begin(), face.end());
      ++count[face];
    }
  return count;
}

Body turned(Body body) {
  rotate(body, Eigen::AngleAxisd(0.7, Vector3(1, 2, 3).normalized()).toRotationMatrix());
  return body;
}

}  // namespace

TEST_CASE("Delaunay tetrahedra fill the hull, face to face, whatever lies on one sphere", "[delaunay]") {
  struct Case {
    Body body;
    double volume;
  };
  const std::vector<Case> cases{{cubic_lattice({4, 5, 6}, 0.01, {}), 3 * 4 * 5 * 1e-6},
                                {turned(cubic_lattice({4, 5, 6}, 0.01, {})), 3 * 4 * 5 * 1e-6},
                                {body_centred_lattice({3, 3, 3}, 2, false), 216},
                                {face_centred_lattice({3, 3, 3}, 2, false), 216},
                                {turned(face_centred_lattice({3, 3, 3}, 2, false)), 216},
                                {listed_body({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {}), 1. / 6}};
  for (const auto& [body, volume] : cases) {
    const Cells<4> cells = delaunay_tetrahedra(body.rest);
    double filled = 0;
    std::vector<char> used(static_cast<std::size_t>(body.size()), 0);
    for (const auto& cell : cells) {
      const double own = signed_volume(body.rest, cell);
      REQUIRE(own > 0);
      filled += own;
      for (const int molecule : cell) used[molecule] = 1;
    }
    CHECK(filled == Approx(volume).epsilon(1e-9));
    CHECK(count_slivers(body.rest, cells) == 0);
    CHECK(std::count(used.begin(), used.end(), 0) == 0);
    // Face to face: none bounds more than two cells, and those that bound one are a closed surface: every side of such
    // a face belongs to two of them.
    std::map<std::array<int, 2>, int> sides;
    for (const auto& [face, count] : faces(cells)) {
      REQUIRE(count <= 2);
      if (count == 2) continue;
      ++sides[{face[0], face[1]}], ++sides[{face[0], face[2]}], ++sides[{face[1], face[2]}];
    }
    CHECK(std::all_of(sides.begin(), sides.end(), [](const auto& side) { return side.second == 2; }));
  }
}

TEST_CASE("almost no other molecule lies in the sphere around a Delaunay tetrahedron", "[delaunay]") {
  const Body body = random_packing({1, 1, 1}, 0.2, 0.3, 3);
  for (const auto& cell : delaunay_tetrahedra(body.rest)) {
    Matrix3 edges;
    Vector3 right;
    for (int i = 0; i < 3; ++i) {
      edges.row(i) = 2 * (body.rest.col(cell[static_cast<std::size_t>(i) + 1]) - body.rest.col(cell[0])).transpose();
      right[i] = edges.row(i).squaredNorm() / 4;
    }
    const Vector3 centre = edges.inverse() * right;  // from corner 0
    const double radius2 = centre.squaredNorm();
    for (int molecule = 0; molecule < body.size(); ++molecule) {
      const double power = (body.rest.col(molecule) - body.rest.col(cell[0]) - centre).squaredNorm() - radius2;
      // Weights of 1 % of the squared mean spacing move powers by no more than a few times that, in flat cells more.
      REQUIRE(power > -0.05 * radius2);
    }
  }
}

TEST_CASE("Delaunay says what it cannot do", "[delaunay]") {
  CHECK_THROWS_AS(delaunay_tetrahedra(cubic_lattice({3, 1, 1}, 1, {}).rest), InputError);
  CHECK_THROWS_AS(delaunay_tetrahedra(cubic_lattice({3, 3, 1}, 1, {}).rest), InputError);
  CHECK_THROWS_AS(delaunay_tetrahedra(Positions::Zero(3, 6)), InputError);
}
