#include "elastin/core/forces/air.h"

#include <catch2/catch.hpp>

#include "elastin/core/forces/model.h"
#include "support/bodies.h"
#include "support/forces_of.h"

using namespace elastin;
using namespace elastin::testing;

namespace {

/// A flat square of 1 m² in the plane z = 0, of two triangles.
Body plate() {
  Body body = listed_body({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {});
  body.triangles = {{0, 1, 2}, {0, 2, 3}};
  body.connections = connections_of_cells(body.rest, body.triangles, {});
  set_matter(body, 0.1, 1000, 0.001, 0);
  return body;
}

}  // namespace

TEST_CASE("a plate in the wind feels the drag of the textbooks", "[air]") {
  const Body body = plate();
  const Air air{.density = 1.2, .drag_coefficient = 1.17, .skin_coefficient = 0.01, .wind = {0, 0, 7}};
  const State still = state_at_rest(body);
  // ½ ρ C A w² across, and turned by 60° only the normal part, along the normal.
  CHECK(forces_of(*make_air(body, air), still).rowwise().sum().z() == Approx(0.5 * 1.2 * 1.17 * 49));
  Air slanting = air;
  slanting.wind = {7 * std::sin(1.), 0, 7 * std::cos(1.)};
  const Vector3 sum = forces_of(*make_air(body, slanting), still).rowwise().sum();
  CHECK(sum.z() == Approx(0.5 * 1.2 * 1.17 * 49 * std::pow(std::cos(1.), 2)));
  CHECK(sum.x() == Approx(0.5 * 1.2 * 0.01 * 49 * std::pow(std::sin(1.), 2)));
  // A caught pressure pushes along the normals, from whichever side the wind comes.
  for (const double side : {1., -1.}) {
    Air caught = air;
    caught.wind *= side;
    caught.pressure_coefficient = 0.8;
    CHECK(forces_of(*make_air(body, caught), still).rowwise().sum().z() == Approx(side * 0.5 * 1.2 * 1.97 * 49));
  }
  // Only the relative wind counts.
  State moving = still;
  moving.velocities = slanting.wind.replicate(1, 4);
  CHECK(forces_of(*make_air(body, slanting), moving).norm() < 1e-14);
  moving.velocities = -air.wind.replicate(1, 4);
  CHECK(forces_of(*make_air(body, {.density = 1.2, .drag_coefficient = 1.17}), moving).rowwise().sum().z() ==
        Approx(0.5 * 1.2 * 1.17 * 49));
}

TEST_CASE("the air's tangent is the change of its forces with the velocities", "[air]") {
  const Body body = sheet(0.001);
  State state = state_at_rest(body);
  state.positions = deformed(body, 1e-3);
  state.velocities = random_motion(body, 3);
  const auto air = make_air(body, {.skin_coefficient = 0.2, .wind = {1, 2, 3}});
  const Positions dv = random_motion(body, 4), none = Positions::Zero(3, body.size());
  State plus = state, minus = state;
  plus.velocities += 1e-6 * dv, minus.velocities -= 1e-6 * dv;
  const Positions measured = (forces_of(*air, plus) - forces_of(*air, minus)) / 2e-6;
  Positions predicted = none, blocks = none;
  air->add_change(state, none, dv, predicted);
  CHECK((predicted - measured).norm() <= 1e-7 * measured.norm());
  air->visit_blocks(state, 2, [&](int a, int b, const Matrix3& part) { blocks.col(a) -= part * dv.col(b); });
  CHECK((blocks - 2 * predicted).norm() <= 1e-12 * blocks.norm());
  // A triangle without an area feels nothing, and nothing is divided by it.
  State flat = state;
  flat.positions.setZero();
  CHECK(forces_of(*air, flat).isZero(0));
}
