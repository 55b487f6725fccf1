#include "core/shapes/surfaces.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <numbers>

#include "elastin/core/base/error.h"
#include "elastin/core/shapes/shapes.h"

using namespace elastin;
using std::numbers::pi;

namespace {

double area_of(const Body& body) {
  double area = 0;
  for (const auto& triangle : body.triangles) area += area_vector(body.rest, triangle).norm();
  return area;
}

/// Sides that one triangle alone has; fails where two triangles on a side are not turned the same way.
int rim_sides(const Body& body) {
  std::map<std::pair<int, int>, int> directed;
  for (const auto& triangle : body.triangles)
    for (std::size_t i = 0; i < 3; ++i) ++directed[{triangle[i], triangle[(i + 1) % 3]}];
  int rim = 0;
  for (const auto& [side, count] : directed) {
    REQUIRE(count == 1);
    rim += directed.count({side.second, side.first}) == 0;
  }
  return rim;
}

int euler_characteristic(const Body& body) {
  return body.size() - body.connections.size() + static_cast<int>(body.triangles.size());
}

bool outwards(const Body& body) {
  for (const auto& triangle : body.triangles)
    if (!(area_vector(body.rest, triangle).dot(body.rest.col(triangle[0])) > 0)) return false;
  return true;
}

int triangles_at(const Body& body, const Vector3& position) {
  int count = 0;
  for (const auto& triangle : body.triangles)
    for (const int molecule : triangle) count += (body.rest.col(molecule) - position).norm() < 1e-12;
  return count;
}

}  // namespace

TEST_CASE("spheres are closed, look outwards and gain their area at order 2", "[surfaces]") {
  for (const SphereMesh mesh : {SphereMesh::icosahedron, SphereMesh::type_1, SphereMesh::type_2}) {
    std::array<double, 3> missing{};
    for (int level = 0; level < 3; ++level) {
      const int n = 8 << level;
      const Body body = sphere(0.5, mesh, n);
      CHECK(body.triangles.size() == static_cast<std::size_t>((mesh == SphereMesh::icosahedron ? 20 : 8) * n * n));
      CHECK(euler_characteristic(body) == 2);
      CHECK(rim_sides(body) == 0);
      CHECK(outwards(body));
      CHECK((body.rest.colwise().norm().array() - 0.5).abs().maxCoeff() < 1e-15);
      missing[level] = pi - area_of(body);
    }
    CHECK(std::log2(missing[0] / missing[1]) == Approx(2).margin(0.05));
    CHECK(std::log2(missing[1] / missing[2]) == Approx(2).margin(0.02));
  }
}

TEST_CASE("an octant has its rim in the planes, and one or two triangles at a corner", "[surfaces]") {
  for (const auto& [mesh, at_corner] : {std::pair{SphereMesh::type_1, 1}, {SphereMesh::type_2, 2}}) {
    const Body octant = sphere_octant(2, mesh, 5);
    CHECK(octant.triangles.size() == 25);
    CHECK(octant.size() == 21);
    CHECK(euler_characteristic(octant) == 1);
    CHECK(rim_sides(octant) == 15);
    CHECK(outwards(octant));
    CHECK((octant.rest.array() == 0).count() == 3 * 6);
    CHECK(octant.rest.minCoeff() == 0);
    for (int axis = 0; axis < 3; ++axis) CHECK(triangles_at(octant, 2 * Vector3::Unit(axis)) == at_corner);
    CHECK(8 * area_of(octant) == Approx(area_of(sphere(2, mesh, 5))).epsilon(1e-13));
  }
  CHECK_THROWS_WITH(sphere(1, SphereMesh::type_2, 2), "divisions 2: this mesh needs at least 3");
  CHECK_THROWS_AS(sphere_octant(1, SphereMesh::icosahedron, 4), InputError);
}

TEST_CASE("flat bodies of triangles cover their shape and look along +z", "[surfaces]") {
  const Body round = disc(0.0375, 6), finer = disc(0.0375, 12);
  CHECK(round.triangles.size() == 6 * 36);
  CHECK(rim_sides(round) == 36);
  const double whole = pi * 0.0375 * 0.0375;
  CHECK((whole - area_of(round)) / (whole - area_of(finer)) == Approx(4).epsilon(0.01));
  const Body sheet = rectangular_sheet({0.2, 0.1}, {4, 2}, SheetPattern::alternating);
  CHECK(sheet.size() == 15);
  CHECK(area_of(sheet) == Approx(0.02).epsilon(1e-14));
  const Body crossed = rectangular_sheet({0.2, 0.1}, {4, 2}, SheetPattern::crossed);
  CHECK(crossed.triangles.size() == 32);
  CHECK(area_of(crossed) == Approx(0.02).epsilon(1e-14));
  const Body canopy = cross_canopy(1, 3, 4);
  CHECK(area_of(canopy) == Approx(5).epsilon(1e-14));
  CHECK(canopy.triangles.size() == 2 * 5 * 16);
  CHECK(rim_sides(canopy) == 12 * 4);
  for (const Body* body : {&round, &finer, &sheet, &crossed, &canopy}) {
    CHECK(euler_characteristic(*body) == 1);
    bool upwards = true;
    for (const auto& triangle : body->triangles) upwards &= area_vector(body->rest, triangle).z() > 0;
    CHECK(upwards);
  }
  CHECK_THROWS_WITH(cross_canopy(1, 1, 3), "the span of a cross must be more than its width");
}

TEST_CASE("flat triangles are found, slivers are not", "[surfaces]") {
  Body body = listed_body({{0, 0, 0}, {1, 0, 0}, {0.5, 1e-9, 0}, {2, 0, 0}, {0, 0, 0}}, {});
  body.triangles = {{0, 1, 2}, {0, 1, 3}, {0, 4, 2}};
  CHECK(flat_triangles(body, body.rest) == std::vector<int>{1, 2});
}
