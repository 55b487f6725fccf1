#include "elastin/core/forces/loads.h"

#include <catch2/catch.hpp>
#include <numbers>

#include "core/forces/surface_load.h"
#include "elastin/core/forces/load_table.h"
#include "elastin/core/forces/model.h"
#include "elastin/core/shapes/shapes.h"
#include "support/bodies.h"
#include "support/forces_of.h"

using namespace elastin;
using namespace elastin::testing;

TEST_CASE("drag balances weight at the terminal velocity of the textbooks", "[loads]") {
  Body body = listed_body({{0, 0, 0}, {1, 0, 0}}, {});
  body.radius = VectorX::Constant(2, 0.002);
  body.mass = VectorX::Constant(2, 3e-5);
  const Vector3 g(0, 0, -9.81);
  const auto gravity = make_gravity(body, g);
  State state = state_at_rest(body);
  // 6π η r v = m g, and ½ ρ C π r² v² = m g
  state.velocities = (g * (3e-5 / (6 * std::numbers::pi * 0.1 * 0.002))).replicate(1, 2);
  CHECK((forces_of(*gravity, state) + forces_of(*make_stokes_drag(body, 0.1), state)).norm() < 1e-16);
  const double speed = std::sqrt(3e-5 * 9.81 / (0.5 * 1000 * 0.47 * std::numbers::pi * 4e-6));
  state.velocities = (g.normalized() * speed).replicate(1, 2);
  CHECK((forces_of(*gravity, state) + forces_of(*make_quadratic_drag(body, 1000, 0.47), state)).norm() < 1e-16);
}

TEST_CASE("a whole body drags as a sphere does, however many molecules it has", "[loads]") {
  for (const int molecules : {2, 3, 5}) {
    Body body = cubic_lattice({molecules, molecules, molecules}, 0.1, {.axis = true});
    body.mass = VectorX::LinSpaced(body.size(), 1, 2);
    body.mass *= 3 / body.mass.sum();
    Model model(body);
    add_load(model, *built_in_loads().find("stokes_drag"), {.numbers = {{"viscosity", 0.1}, {"body_radius", 0.2}}});
    add_load(model, *built_in_loads().find("quadratic_drag"),
             {.numbers = {{"density", 1000}, {"drag_coefficient", 0.47}, {"body_radius", 0.2}}});
    State state = state_at_rest(body);
    state.velocities.row(2).setConstant(0.3);
    const Vector3 viscous = forces_of(*model.loads()[0], state).rowwise().sum();
    CHECK(viscous.z() == Approx(-6 * std::numbers::pi * 0.1 * 0.2 * 0.3).epsilon(1e-12));
    const Positions turbulent = forces_of(*model.loads()[1], state);
    CHECK(turbulent.row(2).sum() == Approx(-0.5 * 1000 * 0.47 * std::numbers::pi * 0.04 * 0.09).epsilon(1e-12));
    // Shared by mass: no molecule is left behind.
    CHECK((turbulent.row(2).transpose().array() / body.mass.array() * 3 / turbulent.row(2).sum() - 1).abs().maxCoeff() <
          1e-12);
  }
}

TEST_CASE("loads: energies and changes agree with differences", "[loads]") {
  const Body body = jittered_block();
  const State state = moving(body);
  const Positions dx = random_motion(body, 32), dv = random_motion(body, 33);
  std::vector<std::unique_ptr<Load>> loads;
  loads.push_back(make_gravity(body, {0, 1, -9.81}));
  loads.push_back(std::make_unique<PointLoads>(body, std::vector<int>{0, 5}, Positions::Ones(3, 2)));
  const std::vector<LoadedFace> faces = outer_faces(body, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11});
  REQUIRE(faces.size() > 4);
  loads.push_back(std::make_unique<SurfaceForces>(body, SurfaceLoad{.faces = faces}, 120));
  loads.push_back(std::make_unique<SurfaceForces>(
      body, SurfaceLoad{.faces = faces, .pressure = false, .traction = Vector3(3, 4, 5)}));
  loads.push_back(std::make_unique<SurfaceForces>(
      body, SurfaceLoad{.faces = faces, .pressure = false, .traction = Vector3(3, 4, 5), .at_rest = true}));
  loads.push_back(make_stokes_drag(body, 0.2));
  loads.push_back(make_quadratic_drag(body, 1000, 0.5));
  loads.push_back(make_mass_damping(body, 3));
  const double h = 1e-7;
  for (const auto& load : loads) {
    State plus = state, minus = state;
    plus.positions += h * dx, minus.positions -= h * dx;
    if (load->acts_at_rest() && load->has_energy())
      CHECK(-(load->energy(plus) - load->energy(minus)) / (2 * h) ==
            Approx(forces_of(*load, state).cwiseProduct(dx).sum()).epsilon(1e-7));
    plus.velocities += h * dv, minus.velocities -= h * dv;
    const Positions measured = (forces_of(*load, plus) - forces_of(*load, minus)) / (2 * h);
    Positions predicted = Positions::Zero(3, body.size());
    load->add_change(state, dx, dv, predicted);
    CHECK((predicted - measured).norm() <= 1e-6 * std::max(1e-3, measured.norm()));
    CHECK(load->changes() == (predicted.norm() > 0));
    // Blocks say the same: with a velocity weight of 2, of a change of positions alone.
    Positions from_blocks = Positions::Zero(3, body.size()), from_change = from_blocks;
    load->visit_blocks(state, 2, [&](int a, int b, const Matrix3& part) { from_blocks.col(a) -= part * dx.col(b); });
    load->add_change(state, dx, 2 * dx, from_change);
    CHECK((from_blocks - from_change).norm() <= 1e-12 * from_change.norm());
  }
}
