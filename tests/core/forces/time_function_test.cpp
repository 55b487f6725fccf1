#include "elastin/core/forces/time_function.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <vector>

#include "core/forces/floor.h"
#include "core/forces/pressure.h"
#include "core/shapes/surfaces.h"
#include "elastin/core/base/error.h"
#include "elastin/core/forces/loads.h"
#include "support/bodies.h"

using namespace elastin;
using namespace elastin::testing;

TEST_CASE("functions of time have their values and rates", "[time][loads]") {
  const TimeFunction ramp = TimeFunction::ramp(2), step = TimeFunction::step(1), sine = TimeFunction::sine(0.5, 0.3, 2),
                     one;
  CHECK(ramp.value(-1) == 0);
  CHECK(ramp.value(0.5) == Approx(0.25));
  CHECK(ramp.value(3) == 1);
  CHECK(ramp.rate(1) == Approx(0.5));
  CHECK(ramp.rate(2) == Approx(0.5));  // at a kink: that of the step that ends there, whatever its time is rounded to
  CHECK(ramp.rate(2 * (1 + 1e-15)) == Approx(0.5));
  CHECK(ramp.rate(2 * (1 + 1e-9)) == 0);
  CHECK(ramp.rate(0) == Approx(0.5));
  CHECK(step.value(0.999) == 0);
  CHECK(step.value(1) == 1);
  CHECK(step.rate(1) == 0);
  CHECK(sine.value(0.7) == Approx(2 + std::sin(M_PI * 0.7 + 0.3)));
  for (const double t : {0.1, 0.9, 1.7})
    CHECK(sine.rate(t) == Approx((sine.value(t + 1e-6) - sine.value(t - 1e-6)) / 2e-6).epsilon(1e-6));
  CHECK(one.value(17) == 1);
  CHECK(one.constant());
  CHECK_FALSE(ramp.constant());
  CHECK_FALSE(sine.constant());
  CHECK(TimeFunction({{-1, 3}, {0, 2}}).constant());  // it changes before time 0 only
  CHECK_THROWS_AS(TimeFunction({{1, 0}, {0.5, 1}}), InputError);
  CHECK_THROWS_AS(TimeFunction(std::vector<std::pair<double, double>>{}), InputError);
}

TEST_CASE("functions of time say where they turn and how short steps see it", "[time][loads]") {
  const TimeFunction pulse({{0, 0}, {0.501, 0}, {0.5011, 1}, {0.504, 1}, {0.508, 1}, {0.5081, 0}, {2, 0}});
  std::vector<double> corners;
  for (double time = 0; std::isfinite(time = pulse.next_corner(time));) corners.push_back(time);
  CHECK(corners == std::vector{0.501, 0.5011, 0.508, 0.5081});  // none where it goes straight on
  CHECK(pulse.next_corner(0.501 * (1 - 1e-14)) == 0.5011);      // a time next to a corner but for rounding is at it
  CHECK(TimeFunction::ramp(2).next_corner(-1) == 0);
  CHECK(TimeFunction::ramp(2).next_corner(0) == 2);
  CHECK(TimeFunction::step(3).next_corner(0) == 3);
  const double never = std::numeric_limits<double>::infinity();
  CHECK(TimeFunction::step(3).next_corner(3) == never);
  const TimeFunction sine = TimeFunction::sine(50);
  CHECK(sine.next_corner(0) == never);
  CHECK(sine.longest_step() == Approx(0.02 / 40));
  CHECK(pulse.longest_step() == never);

  CHECK(sine.shortest_swing() == Approx(0.01));
  CHECK(pulse.shortest_swing() == Approx(0.50801 - 0.501));  // up, and down by a tenth
  CHECK(TimeFunction::ramp(2).shortest_swing() == never);
  CHECK(TimeFunction({{0, 0}, {1, 1}, {1.1, 0.95}, {1.2, 1}, {2, 2}}).shortest_swing() == never);  // scatter
  CHECK(TimeFunction({{0, 5}, {1, 5}, {2, 4}, {4, 6}, {5, 6}}).shortest_swing() == Approx(1.2));
}

TEST_CASE("a load in time is its own times the factor of the moment", "[time][loads]") {
  const Body body = jittered_lattice();
  const auto plain = make_gravity(body, {1, 2, 3});
  const auto varying = make_varying(make_gravity(body, {1, 2, 3}), TimeFunction::ramp(4));
  State state = state_at_rest(body);
  state.positions.array() += 0.1;
  state.time = 1;
  Positions whole = Positions::Zero(3, body.size()), part = whole;
  plain->add_forces(state, whole);
  varying->add_forces(state, part);
  CHECK((part - 0.25 * whole).norm() <= 1e-15 * whole.norm());
  CHECK(varying->energy(state) == Approx(0.25 * plain->energy(state)));
  CHECK_FALSE(varying->steady());
  CHECK(make_varying(make_gravity(body, {1, 2, 3}), {})->steady());
}

TEST_CASE("a load in time says what it is, and its blocks and wide terms are its change", "[time][loads]") {
  const Body ball = sphere(1, SphereMesh::icosahedron, 2), sheet = elastin::testing::sheet(0.001);
  const auto wind = make_varying(std::make_unique<Pressure>(sheet, constant_pressure(70), Vector3::Zero(), false),
                                 TimeFunction::ramp(4));
  CHECK_FALSE(wind->has_energy());
  CHECK(make_varying(make_mass_damping(ball, 3), TimeFunction::ramp(4))->resists());
  const auto gas = make_varying(std::make_unique<Pressure>(ball, enclosed_gas(400, 1, 90), Vector3::Zero(), false),
                                TimeFunction::ramp(4));
  CHECK(gas->has_energy());
  State state = state_at_rest(ball);
  state.positions = deformed(ball, 0.01);
  state.time = 1;
  const Positions motion = random_motion(ball, 6);
  Positions change = Positions::Zero(3, ball.size()), blocks = change;
  gas->add_change(state, motion, motion, change);
  gas->visit_blocks(state, 0, [&](int a, int b, const Matrix3& part) { blocks.col(a) -= part * motion.col(b); });
  for (const WideTerm& wide : gas->wide_terms(state))
    blocks -= wide.factor * wide.direction.cwiseProduct(motion).sum() * wide.direction;
  CHECK((change - blocks).norm() < 1e-12 * change.norm());
}

TEST_CASE("a floor's force is the slope of its energy, and its tangent the slope of its force", "[floor][loads]") {
  const Body body = jittered_lattice();
  const Floor floor{Vector3(0, 0, 0.004), Vector3(0.1, 0.2, 1).normalized(), 50, 3};
  State state{deformed(body, 0.002), random_motion(body, 3)};
  for (const auto& load : {make_floor(body, floor), make_floor_damping(body, floor)}) {
    Positions forces = Positions::Zero(3, body.size());
    load->add_forces(state, forces);
    REQUIRE(forces.norm() > 0);
    const Positions motion = random_motion(body, 4);
    const double h = 1e-7;
    State ahead = state, behind = state;
    if (load->acts_at_rest()) {
      ahead.positions += h * motion, behind.positions -= h * motion;
      CHECK(-forces.cwiseProduct(motion).sum() ==
            Approx((load->energy(ahead) - load->energy(behind)) / (2 * h)).epsilon(1e-6));
    } else {
      ahead.velocities += h * motion, behind.velocities -= h * motion;
      CHECK(forces.cwiseProduct(state.velocities).sum() < 0);
    }
    Positions up = Positions::Zero(3, body.size()), down = up, change = up, by_blocks = up;
    load->add_forces(ahead, up);
    load->add_forces(behind, down);
    const Positions none = Positions::Zero(3, body.size());
    load->add_change(state, load->acts_at_rest() ? motion : none, load->acts_at_rest() ? none : motion, change);
    CHECK((change - (up - down) / (2 * h)).norm() <= 1e-5 * change.norm());
    load->visit_blocks(state, 1, [&](int a, int b, const Matrix3& k) { by_blocks.col(a) -= k * motion.col(b); });
    CHECK((by_blocks - change).norm() <= 1e-12 * change.norm());
  }
}

TEST_CASE("a molecule deep in the floor feels its stiffness", "[floor]") {
  const Body body = listed_body({Vector3(0, 0, 0)}, {});
  Body ball = body;
  set_matter(ball, 0.01, 1000, 0, 1);
  const auto floor = make_floor(ball, {.point = {0, 0, 0}, .normal = {0, 0, 2}, .stiffness = 100});
  State state = state_at_rest(ball);
  Positions force = Positions::Zero(3, 1);
  floor->add_forces(state, force);  // pressed in by its radius: the first tenth counts half
  CHECK(force(2, 0) == Approx(100 * (0.01 - 0.0005)));
  state.positions(2, 0) = 0.0101;
  force.setZero();
  floor->add_forces(state, force);
  CHECK(force.norm() == 0);
}
