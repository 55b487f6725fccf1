#include "mesh/fill.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <set>

#include "core/geometry/boundary.h"
#include "core/geometry/triangle_tree.h"
#include "core/shapes/surfaces.h"
#include "elastin/core/base/error.h"
#include "elastin/core/parallel/threads.h"
#include "elastin/core/shapes/shapes.h"

using namespace elastin;
using namespace elastin::mesh;

namespace {

/// A closed surface, as a body of triangles.
Body ball() { return sphere(0.01, SphereMesh::icosahedron, 14); }

/// A torus about z.
Body ring(double radius, double tube) {
  constexpr int n = 48, m = 16;
  Body body;
  body.rest.resize(3, n * m);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < m; ++j) {
      const double a = 2 * std::numbers::pi * i / n, b = 2 * std::numbers::pi * j / m,
                   out = radius + tube * std::cos(b);
      body.rest.col(i * m + j) << out * std::cos(a), out * std::sin(a), tube * std::sin(b);
      const int here = i * m + j, up = i * m + (j + 1) % m, on = (i + 1) % n * m + j,
                both = (i + 1) % n * m + (j + 1) % m;
      body.triangles.push_back({here, on, both});
      body.triangles.push_back({here, both, up});
    }
  return body;
}

/// The outside of those cubes of a block of unit cubes that `wanted` takes, by their middles.
template <class Wanted>
Body carved(const std::array<int, 3>& cubes, Wanted wanted) {
  Body block = tetrahedral_block(BlockKind::kuhn, cubes, {1. * cubes[0], 1. * cubes[1], 1. * cubes[2]});
  std::erase_if(block.tetrahedra, [&](const auto& cell) {
    Vector3 middle = Vector3::Zero();
    for (const int corner : cell) middle += block.rest.col(corner) / 4;
    return !wanted(Vector3(middle.array().floor() + 0.5));
  });
  Body body;
  body.rest = block.rest;
  body.triangles = boundary_of(block.tetrahedra);
  return body;
}

Body box() {
  return carved({4, 2, 2}, [](const Vector3&) { return true; });
}

/// V − E + F of a closed surface: 2 of a ball, 0 of a ring.
int euler_characteristic(const Cells<3>& triangles) {
  std::set<int> corners;
  std::set<std::array<int, 2>> sides;
  for (const auto& t : triangles)
    for (std::size_t i = 0; i < 3; ++i) {
      corners.insert(t[i]);
      sides.insert({std::min(t[i], t[(i + 1) % 3]), std::max(t[i], t[(i + 1) % 3])});
    }
  return static_cast<int>(corners.size()) - static_cast<int>(sides.size()) + static_cast<int>(triangles.size());
}

Filling fill(const Body& surface, const FillOptions& options) {
  return FillRegion(surface.rest, surface.triangles).fill(options);
}

/// What must be true of every filling that follows its surface.
void check_filling(const Body& surface, const Filling& filling, const FillOptions& options) {
  const TriangleTree tree(surface.rest, surface.triangles);
  double volume = 0;
  for (const auto& cell : filling.tetrahedra) {
    REQUIRE(signed_volume(filling.positions, cell) > 0);
    volume += signed_volume(filling.positions, cell);
  }
  CHECK(volume == Approx(filling.volume).epsilon(1e-12));
  CHECK(filling.share.sum() == Approx(1).epsilon(1e-12));
  CHECK(filling.share.minCoeff() > 0);  // every molecule is a corner of a tetrahedron
  CHECK(filling.left_out == 0);
  CHECK(filling.slivers == 0);
  const Connections near = connections_within(filling.positions, 0.5 * options.spacing);
  CHECK(near.size() == 0);
  for (int m = 0; m < filling.positions.cols(); ++m) {
    const double distance = tree.signed_distance(filling.positions.col(m));
    if (m < filling.on_surface)
      REQUIRE(std::abs(distance) < 1e-9 * options.spacing);
    else
      REQUIRE(distance < -0.5 * options.spacing);
  }
}

}  // namespace

TEST_CASE("a point in the hole of a ring is outside", "[fill]") {
  const Body hollow = ring(3, 1);
  const TriangleTree round(hollow.rest, hollow.triangles);
  CHECK(round.signed_distance({0, 0, 0}) == Approx(2).epsilon(0.01));
  CHECK(round.signed_distance({3, 0, 0}) == Approx(-1).epsilon(0.03));
}

TEST_CASE("a filled ball: molecules on the surface, its volume to second order", "[fill]") {
  for (const FillPacking packing : {FillPacking::lattice, FillPacking::blue_noise}) {
    const Body surface = ball();
    double last = 0;
    for (const double spacing : {0.004, 0.002}) {
      const FillOptions options{spacing, packing, 1, true};
      const Filling filling = fill(surface, options);
      check_filling(surface, filling, options);
      CHECK(euler_characteristic(boundary_of(filling.tetrahedra)) == 2);
      // Sagitta of triangles of side 1.1 h on a sphere: about a quarter of (h/R)² of the volume.
      const double lost = 1 - filling.volume / filling.surface_volume;
      CHECK(lost > 0);
      CHECK(lost < 0.7 * std::pow(spacing / 0.01, 2));
      if (last > 0) CHECK(last / lost == Approx(4).margin(1));
      last = lost;
      const double cubes = filling.surface_volume / std::pow(spacing, 3);
      CHECK(filling.positions.cols() - filling.on_surface < cubes);
    }
  }
}

TEST_CASE("a filled box keeps its corners, sides and volume", "[fill]") {
  for (const FillPacking packing : {FillPacking::lattice, FillPacking::blue_noise}) {
    const FillOptions options{0.4, packing, 3, true};
    const Filling filling = fill(box(), options);
    check_filling(box(), filling, options);
    CHECK(filling.surface_volume == Approx(16).epsilon(1e-12));
    CHECK(filling.volume == Approx(16).epsilon(1e-9));
    int corners = 0, on_sides = 0;
    for (int m = 0; m < filling.positions.cols(); ++m) {
      int planes = 0;
      const std::array<double, 3> ends{4, 2, 2};
      for (int axis = 0; axis < 3; ++axis) {
        const double x = filling.positions(axis, m);
        planes += std::abs(x) < 1e-9 || std::abs(x - ends[axis]) < 1e-9;
      }
      corners += planes == 3, on_sides += planes == 2;
    }
    CHECK(corners == 8);
    CHECK(on_sides == 4 * 9 + 8 * 4);  // 4 / 0.4 and 2 / 0.4 parts
  }
}

TEST_CASE("a lattice alone fills a box that it fits", "[fill]") {
  const Filling filling = fill(box(), {0.5, FillPacking::lattice, 1, false});
  CHECK(filling.positions.cols() == 9 * 5 * 5);
  CHECK(filling.volume == Approx(16).epsilon(1e-9));
}

TEST_CASE("nothing crosses the hole of a filled ring", "[fill]") {
  for (const FillPacking packing : {FillPacking::lattice, FillPacking::blue_noise}) {
    const FillOptions options{0.5, packing, 1, true};
    const Body surface = ring(2, 1);
    const FillRegion inside(surface.rest, surface.triangles);
    const Filling filling = inside.fill(options);
    check_filling(surface, filling, options);
    CHECK(euler_characteristic(boundary_of(filling.tetrahedra)) == 0);
    CHECK(filling.volume / filling.surface_volume == Approx(1).margin(0.05));
    const Connections connections = inside.connections_within(filling, 1.6 * options.spacing);
    CHECK(2 * connections.size() > static_cast<int>(sides_of(filling.tetrahedra).size()));
    for (const auto& [a, b] : connections.ends) {  // the middle lies in the tube, but for the sagitta of its round
      const Vector3 middle = (filling.positions.col(a) + filling.positions.col(b)) / 2;
      REQUIRE(std::hypot(std::hypot(middle.x(), middle.y()) - 2, middle.z()) < 1.1);
    }
  }
}

TEST_CASE("connections do not cross a gap that is narrower than they are long", "[fill]") {
  // A horseshoe: a slot of one unit between two arms, spacing 1.5.
  const Body surface = carved({7, 4, 8}, [](const Vector3& cube) { return cube.x() != 3.5 || cube.z() < 2; });
  const FillRegion inside(surface.rest, surface.triangles);
  const Filling filling = inside.fill({1.5, FillPacking::blue_noise, 1, true});
  const auto across = [&](int a, int b) {
    return filling.positions(0, a) <= 3 && filling.positions(0, b) >= 4 && filling.positions(2, a) > 2.7 &&
           filling.positions(2, b) > 2.7;
  };
  int all = 0, kept = 0;
  for (const auto& [a, b] : connections_within(filling.positions, 2.4).ends) all += across(a, b) || across(b, a);
  for (const auto& [a, b] : inside.connections_within(filling, 2.4).ends) kept += across(a, b) || across(b, a);
  CHECK(all > 10);
  CHECK(kept == 0);
  CHECK(filling.volume == Approx(filling.surface_volume).epsilon(0.01));
}

TEST_CASE("the same seed fills alike on any number of threads, another otherwise", "[fill]") {
  const Body surface = ball();
  const FillOptions options{0.0025, FillPacking::blue_noise, 7, true};
  const Filling filling = fill(surface, options);
  set_threads(2);
  const Filling again = fill(surface, options);
  set_threads(0);
  CHECK(again.positions == filling.positions);
  CHECK(again.tetrahedra == filling.tetrahedra);
  const Filling other = fill(surface, {0.0025, FillPacking::blue_noise, 8, true});
  CHECK((other.positions.cols() != filling.positions.cols() || other.positions != filling.positions));
}

TEST_CASE("a spacing that fits no tetrahedron, or too many molecules, is refused", "[fill]") {
  CHECK_THROWS_WITH(fill(ball(), {0.1, FillPacking::lattice, 1, false}), Catch::Contains("too wide"));
  CHECK_THROWS_WITH(fill(ball(), {1e-5, FillPacking::lattice, 1, true}), Catch::Contains("at most 5e+06"));
}

TEST_CASE("shells that are not in each other are filled apart, however narrow the gap", "[fill][slow]") {
  const auto with_another = [](double scale, const Vector3& at) {
    Body both = box();
    const auto count = static_cast<int>(both.rest.cols());
    const Cells<3> triangles = both.triangles;
    both.rest.conservativeResize(3, 2 * count);
    both.rest.rightCols(count) = (scale * both.rest.leftCols(count)).colwise() + at;
    for (const auto& [a, b, c] : triangles) both.triangles.push_back({a + count, b + count, c + count});
    return both;
  };
  const Body two = with_another(1, {4.1, 0, 0});
  for (const bool by_winding_number : {false, true})
    for (const FillPacking packing : {FillPacking::lattice, FillPacking::blue_noise}) {
      const FillRegion inside(two.rest, two.triangles, by_winding_number);
      CHECK(inside.shells() == 2);
      CHECK(inside.filled_as_one() == 1);
      const Filling filling = inside.fill({0.5, packing, 1, true});
      CHECK(filling.empty_shells == 0);
      CHECK(filling.volume == Approx(32).epsilon(1e-9));
      CHECK(filling.share.sum() == Approx(1).epsilon(1e-12));
      const auto is_first = [&](int m) { return filling.positions(0, m) < 4.05; };
      for (const auto& cell : filling.tetrahedra)
        for (const int corner : cell) REQUIRE(is_first(corner) == is_first(cell[0]));
      for (const auto& [a, b] : inside.connections_within(filling, 1).ends) REQUIRE(is_first(a) == is_first(b));
    }
  // A body in a cavity is one of its own, the shell of the cavity is not.
  const Body nested = carved({7, 7, 7}, [](const Vector3& cube) {
    const double out = (cube - Vector3::Constant(3.5)).cwiseAbs().maxCoeff();
    return out > 2.5 || out < 1.5;
  });
  const FillRegion inside(nested.rest, nested.triangles);
  CHECK(inside.shells() == 2);
  const Filling filling = inside.fill({0.9, FillPacking::blue_noise, 1, true});
  CHECK(filling.surface_volume == Approx(343 - 125 + 27).epsilon(1e-12));
  CHECK(filling.volume == Approx(filling.surface_volume).epsilon(0.02));
  // What no tetrahedron fits into is left out and counted.
  const Body speck = with_another(0.01, {5, 0, 0});
  const Filling without = fill(speck, {0.5, FillPacking::lattice, 1, false});
  CHECK(without.empty_shells == 1);
  CHECK(without.surface_volume == Approx(16).epsilon(1e-12));
  CHECK(without.share.sum() == Approx(1).epsilon(1e-12));
}
