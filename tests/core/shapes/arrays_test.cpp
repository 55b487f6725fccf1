#include "elastin/core/shapes/arrays.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "elastin/core/base/error.h"

using namespace elastin;

namespace {

/// Three edges of a unit cube from one corner, and one connection across.
BodyArrays corner() {
  BodyArrays arrays;
  arrays.positions = Positions::Zero(3, 4);
  arrays.positions.rightCols(3).setIdentity();
  arrays.connections = {{0, 1}, {0, 2}, {0, 3}, {1, 2}};
  return arrays;
}

std::string refusal(const BodyArrays& arrays) {
  try {
    make_body(arrays);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("a rope weighs what its molecules do, straight or not", "[arrays]") {
  for (const double off : {0., 1e-6, 1e-3, 3e-3}) {
    BodyArrays rope;
    rope.positions.setZero(3, 9);
    for (int i = 0; i < 9; ++i) {
      rope.positions.col(i) = Vector3(0.0125 * i, off * (i % 2), off * (i % 3 == 1));
      if (i > 0) rope.connections.push_back({i - 1, i});
    }
    rope.radii = VectorX::Constant(9, 0.005);
    CHECK(make_body(rope).mass.isApprox(VectorX::Constant(9, 1000 * 1e-6), 1e-12));
  }
}

TEST_CASE("A body from arrays", "[arrays]") {
  BodyArrays arrays = corner();
  const Body body = make_body(arrays);
  CHECK(body.rest == arrays.positions);
  CHECK(body.connections.ends == arrays.connections);
  CHECK(body.connections.rest_length == std::vector{1., 1., 1., std::sqrt(2.)});
  CHECK(body.radius == VectorX::Constant(4, 0.5));
  CHECK(body.mass.isApprox(VectorX::Constant(4, 1000. / 6 / 4),
                           1e-12));  // of their hull, a sixth of the box  // 1000 kg/m3 in the bounding box of 1 m3
  arrays.masses = VectorX::LinSpaced(4, 1, 4);
  arrays.radii = VectorX::Constant(4, 0.1);
  arrays.rest_lengths = VectorX::Constant(4, 0.9);
  const Body given = make_body(arrays);
  CHECK(given.mass == arrays.masses);
  CHECK(given.radius == arrays.radii);
  CHECK(given.connections.rest_length == std::vector(4, 0.9));
}

TEST_CASE("Cells of arrays are turned, lumped and joined", "[arrays]") {
  BodyArrays arrays = corner();
  arrays.tetrahedra = {{0, 2, 1, 3}};
  const Body body = make_body(arrays);
  CHECK(signed_volume(body.rest, body.tetrahedra.front()) == Approx(1. / 6));
  CHECK(body.connections.proper() == 4);
  CHECK(body.connections.cell_sides == 2);
  CHECK(body.mass.sum() == Approx(1000. / 6));
  arrays.connections.clear();
  CHECK(make_body(arrays).connections.proper() == 6);

  BodyArrays sheet = corner();
  sheet.connections.clear();
  sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
  sheet.thickness = 1e-3;
  CHECK(make_body(sheet).mass.sum() == Approx(1));  // two triangles of 0.5 m2, 1 mm thick
  sheet.thickness = 0;
  CHECK_THAT(refusal(sheet), Catch::Matchers::StartsWith("masses[0]: is 0; allowed: finite numbers above 0 kg"));
}

TEST_CASE("Wrong arrays are refused by name, row and value", "[arrays]") {
  const auto changed = [](auto change) {
    BodyArrays arrays = corner();
    change(arrays);
    return refusal(arrays);
  };
  CHECK(changed([](auto&) {}) == "");
  CHECK(changed([](auto& a) { a.positions.resize(3, 0); }) == "positions: a body needs at least one molecule");
  CHECK(changed([](auto& a) { a.positions(1, 2) = NAN; }) == "positions[2]: is not finite");
  CHECK(changed([](auto& a) {
          a.connections[1] = {0, 4};
        }) == "connections[1]: there is no molecule 4; allowed: 0 to 3");
  CHECK(changed([](auto& a) {
          a.connections[3] = {-1, 2};
        }) == "connections[3]: there is no molecule -1; allowed: 0 to 3");
  CHECK(changed([](auto& a) { a.connections[2] = {3, 3}; }) == "connections[2]: names molecule 3 twice");
  CHECK(changed([](auto& a) { a.triangles = {{0, 1, 0}}; }) == "triangles[0]: names molecule 0 twice");
  CHECK(changed([](auto& a) { a.positions.col(1) = a.positions.col(0); }) ==
        "connections[0]: has no length: its molecules lie at one position");
  CHECK(changed([](auto& a) { a.masses = VectorX::Ones(3); }) == "masses: has 3 numbers; allowed: 4, one a molecule");
  CHECK(changed([](auto& a) { a.radii = VectorX::Constant(4, INFINITY); }) ==
        "radii[0]: is inf; allowed: finite numbers above 0 m");
  CHECK(changed([](auto& a) { a.rest_lengths = VectorX::Zero(4); }) ==
        "rest_lengths[0]: is 0; allowed: finite numbers above 0 m");
  CHECK(changed([](auto& a) {
          a.positions(2, 3) = 0, a.positions(0, 3) = 1;
          a.tetrahedra = {{0, 1, 2, 3}};
        }) == "tetrahedra[0]: is flat");
  CHECK(changed([](auto& a) { a.connections.clear(); }) ==
        "radii: are needed, because there is no connection of which to take half the length");
}
