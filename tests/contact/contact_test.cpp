#include "elastin/contact/contact.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>

#include "contact/contact_force.h"
#include "core/solve/energies.h"
#include "elastin/core/base/error.h"
#include "elastin/core/parallel/threads.h"
#include "elastin/core/simulation/catalog.h"
#include "elastin/core/solve/stepper.h"
#include "support/bodies.h"
#include "support/forces_of.h"

using namespace elastin;
using namespace elastin::contact;
using namespace elastin::testing;

namespace {

constexpr double kGravity = 9.81;

Obstacle floor_at(double height, double friction = -1) {
  Obstacle floor{"floor", shape::Plane{}, {}, {}, friction};
  floor.pose.position.z() = height;
  return floor;
}

/// A plane through the origin that falls towards +x.
Obstacle incline(double angle) {
  Obstacle plane{"incline", shape::Plane{}, {}};
  plane.pose.turn = Eigen::AngleAxisd(angle, Vector3::UnitY()).toRotationMatrix();
  return plane;
}

Body isolated_molecules(const std::vector<Vector3>& positions, double radius, double mass) {
  Body body = listed_body(positions, {});
  body.radius = VectorX::Constant(body.size(), radius);
  body.mass = VectorX::Constant(body.size(), mass);
  return body;
}

/// A stiff block of 3 × 3 × 2 molecules of 1 cm, lowest spheres on z = 0; 18 g each.
Body block() {
  Body body = cubic_lattice({3, 3, 2}, 0.01, {true, true, true});
  body.rest.row(2).array() += 0.005;
  set_matter(body, 0.005, 1000, 0, 18e-6);
  return body;
}

struct Scene {
  Scene(Body a_body, ContactOptions options, double gravity = kGravity, double modulus = 1e6)
      : body(std::move(a_body)) {
    model = std::make_unique<Model>(body);
    if (body.connections.size() > 0)
      model->add(make_springs(body, VectorX::Constant(body.connections.size(), modulus * 0.004)));
    auto made = make_contact(body, options);
    contact = made.get();
    model->add(std::move(made));
    if (gravity > 0) model->add(make_gravity(body, {0, 0, -gravity}));
    state = state_at_rest(body);
    model->commit_step(state);
  }
  void step(const StepperOptions& options, double dt, int steps) {
    const auto stepper = make_stepper(options);
    for (int step = 0; step < steps; ++step) {
      const StepResult result = stepper->advance(*model, state, dt);
      INFO("step " << step << ": " << result.cause);
      REQUIRE(result.outcome == Outcome::converged);
    }
  }
  Vector3 centre() const { return state.positions * body.mass / body.mass.sum(); }
  Vector3 speed() const { return state.velocities * body.mass / body.mass.sum(); }

  Body body;
  std::unique_ptr<Model> model;
  Contact* contact;
  State state;
};

ContactOptions options_of(double stiffness, double friction, std::vector<Obstacle> obstacles) {
  ContactOptions options;
  options.stiffness = stiffness;
  options.friction = friction;
  options.obstacles = std::move(obstacles);
  return options;
}

/// Largest difference between add_change and central differences of the forces, over the largest change.
double tangent_error(const Body& body, const ContactOptions& options, const State& state, double step) {
  const auto contact = make_contact(body, options);
  double worst = 0;
  for (unsigned seed = 1; seed < 5; ++seed) {
    const Positions motion = random_motion(body, seed), speed = random_motion(body, seed + 10);
    Positions change = Positions::Zero(3, body.size());
    contact->add_change(state, motion, speed, change);
    State ahead = state, behind = state;
    ahead.positions += step * motion, behind.positions -= step * motion;
    ahead.velocities += step * speed, behind.velocities -= step * speed;
    const Positions expected = (forces_of(*contact, ahead) - forces_of(*contact, behind)) / (2 * step);
    REQUIRE(expected.cwiseAbs().maxCoeff() > 0);
    worst = std::max(worst, (change - expected).cwiseAbs().maxCoeff() / expected.cwiseAbs().maxCoeff());

    Positions by_blocks = Positions::Zero(3, body.size()), without_speed = Positions::Zero(3, body.size());
    contact->visit_blocks(state, 0,
                          [&](int a, int b, const Matrix3& part) { by_blocks.col(a) -= part * motion.col(b); });
    contact->add_change(state, motion, Positions::Zero(3, body.size()), without_speed);
    CHECK((by_blocks - without_speed).cwiseAbs().maxCoeff() <= 1e-12 * without_speed.cwiseAbs().maxCoeff());
  }
  return worst;
}

}  // namespace

TEST_CASE("contact: a molecule on a plane is held by its weight exactly", "[contact]") {
  const double mass = 0.3;
  Scene scene(isolated_molecules({{0, 0, 0.01}}, 0.01, mass), options_of(1e6, 0, {floor_at(0)}));
  const StaticResult result = solve_static(*scene.model, scene.state);
  REQUIRE(result.outcome == Outcome::converged);
  const ContactReport report = scene.contact->report(scene.state);
  CHECK(report.pairs == 1);
  CHECK((report.on_obstacles[0] - Vector3(0, 0, -mass * kGravity)).norm() <= 1e-9 * mass * kGravity);
  // Pressure over depth times the molecule's (2r)².
  CHECK(report.largest_penetration == Approx(mass * kGravity / (1e6 * 0.02 * 0.02)).epsilon(1e-9));
}

TEST_CASE("contact: multipliers bound the depth and keep the force", "[contact]") {
  ContactOptions options = options_of(1e6, 0, {floor_at(0)});
  options.penetration = 1e-6;
  Scene scene(isolated_molecules({{0, 0, 0.01}}, 0.01, 0.3), options);
  const StaticResult result = solve_static(*scene.model, scene.state);
  INFO(result.cause);
  REQUIRE(result.outcome == Outcome::converged);
  const ContactReport report = scene.contact->report(scene.state);
  CHECK(report.largest_penetration <= 1e-6);
  CHECK(-report.on_obstacles[0].z() == Approx(0.3 * kGravity).epsilon(1e-9));
}

TEST_CASE("contact: updates of multipliers end on a contact that is far softer than the body", "[contact]") {
  // A molecule on a spring of K = 4000 N/m, pressed by F = 1 N on a plane that it just touches: each update with the
  // contact's own k = 4 N/m would leave K / (K + k) of the depth, of which 10 000 were needed.
  Body body = listed_body({{0, 0, 0.01}, {0, 0, 0.03}}, {{0, 1}});
  body.radius = VectorX::Constant(2, 0.01);
  body.mass = VectorX::Constant(2, 0.1);
  ContactOptions options = options_of(1e4, 0, {floor_at(0)});
  options.penetration = 1e-8;
  Scene scene(body, options, 0);
  Positions forces(3, 1);
  forces << 0, 0, -1;
  scene.model->add(std::make_unique<PointLoads>(scene.body, std::vector<int>{0}, forces));
  scene.model->supports = {{.molecule = 1}, {.molecule = 0, .free = Vector3::UnitZ() * Vector3::UnitZ().transpose()}};
  const StaticResult result = solve_static(*scene.model, scene.state);
  INFO(result.cause);
  REQUIRE(result.outcome == Outcome::converged);
  const ContactReport report = scene.contact->report(scene.state);
  CHECK(report.largest_penetration <= 1e-8);
  CHECK(-report.on_obstacles[0].z() == Approx(1 - 4000 * report.largest_penetration).epsilon(1e-7));
}

TEST_CASE("contact: each implicit stepper bounds the depth by multipliers, explicit ones are refused",
          "[contact][slow]") {
  ContactOptions options = options_of(1e6, 0, {floor_at(0)});
  options.penetration = 1e-6;
  for (const auto& method : built_in_steppers()) {
    INFO(method->name);
    Scene scene(block(), options);  // 9 molecules carry 0.18 kg: 196 um deep by the penalty alone
    scene.model->add(make_mass_damping(scene.body, 300));
    CHECK(unsuited_for(*method, *scene.model).empty() != method->is_explicit);
    if (method->is_explicit) continue;
    scene.step({method->name}, 1e-3, 200);
    for (int step = 0; step < 100; ++step) {
      scene.step({method->name}, 1e-3, 1);
      CHECK(scene.contact->report(scene.state).largest_penetration <= (method->order == 1 ? 1 : 5) * 1e-6);
      CHECK(scene.centre().z() == Approx(0.01).margin(5e-6));  // it lies there
    }
  }
}

TEST_CASE("contact: a stack of ten carries each molecule's own load", "[contact]") {
  const double radius = 0.01, mass = 0.05, stiffness = 1e7;
  std::vector<Vector3> positions;
  for (int i = 0; i < 10; ++i) positions.emplace_back(0, 0, radius * (2 * i + 1));
  Scene scene(isolated_molecules(positions, radius, mass), options_of(stiffness, 0.5, {floor_at(0)}));
  const StaticResult result = solve_static(*scene.model, scene.state);
  INFO(result.cause);
  REQUIRE(result.outcome == Outcome::converged);
  const ContactReport report = scene.contact->report(scene.state);
  CHECK(report.pairs == 10);
  CHECK(-report.on_obstacles[0].z() == Approx(10 * mass * kGravity).epsilon(1e-9));
  const double k = stiffness * 4 * radius * radius;
  double below = 0;
  for (int i = 0; i < 10; ++i) {
    const double depth = radius * (2 * i + 1) - scene.state.positions(2, i);
    CHECK(depth - below == Approx((10 - i) * mass * kGravity / k).epsilon(1e-7));
    below = depth;
  }
}

TEST_CASE("contact: a head-on collision keeps momentum to rounding, and energy", "[contact]") {
  Body body = cubic_lattice({2, 2, 2}, 0.01, {true, true, true});
  Body two = body;
  const int n = body.size();
  two.rest.conservativeResize(3, 2 * n);
  two.rest.rightCols(n) = body.rest.colwise() + Vector3(0.03, 0.002, 0.001);
  for (auto ends : body.connections.ends) two.connections.ends.push_back({ends[0] + n, ends[1] + n});
  two.connections.rest_length.insert(two.connections.rest_length.end(), body.connections.rest_length.begin(),
                                     body.connections.rest_length.end());
  two.cubes.clear();
  two.grid.reset();
  set_matter(two, 0.005, 1000, 0, 16e-6);
  Scene scene(two, options_of(1e9, 0, {}), 0);
  scene.state.velocities.leftCols(n).row(0).setConstant(1.5);
  scene.state.velocities.rightCols(n).row(0).setConstant(-0.5);
  const Ledger ledger(*scene.model, scene.state);
  const Energies before = ledger.energies(*scene.model, scene.state);
  double deepest = 0;
  const auto stepper = make_stepper({"velocity_verlet"});
  for (int step = 0; step < 4000; ++step) {
    REQUIRE(stepper->advance(*scene.model, scene.state, 5e-6).outcome == Outcome::converged);
    deepest = std::max(deepest, scene.contact->report(scene.state).largest_penetration);
  }
  CHECK(deepest > 0);
  CHECK(scene.contact->report(scene.state).pairs == 0);
  const Energies after = ledger.energies(*scene.model, scene.state);
  CHECK((after.momentum - before.momentum).norm() <= 1e-13 * before.momentum.norm() * 1000);
  CHECK((after.angular_momentum - before.angular_momentum).norm() <= 1e-12 * 0.016 * 2 * 0.03);
  CHECK(after.balance() == Approx(before.balance()).epsilon(2e-3));
  CHECK(scene.state.velocities.leftCols(n).row(0).mean() < 0.5);  // it has given momentum away
}

TEST_CASE("contact: implicit steps of order 2 keep the momentum of surfaces that meet; Newmark's make no energy",
          "[contact][slow]") {
  const Body one = tetrahedral_block(BlockKind::kuhn, {2, 2, 2}, {0.02, 0.02, 0.02});
  const int n = one.size();
  Body two = one;
  two.rest.conservativeResize(3, 2 * n);
  two.rest.rightCols(n) = one.rest.colwise() + Vector3(0.021, 0.003, 0.002);
  for (auto cell : one.tetrahedra) two.tetrahedra.push_back({cell[0] + n, cell[1] + n, cell[2] + n, cell[3] + n});
  two.connections = connections_of_cells(two.rest, {}, two.tetrahedra);
  set_matter(two, 0.003, 1000, 0, 0);
  two.mass.head(n) *= 3;
  ContactOptions options = options_of(5e7, 0, {});
  options.surface = ContactSurface::triangles;
  for (const std::string stepper : {"newmark", "generalized_alpha"})
    for (const double dt : {8e-4, 4e-4, 1e-4}) {
      INFO(stepper << ", dt " << dt);
      Scene scene(two, options, 0, 1e5);
      scene.state.velocities.leftCols(n).row(0).setConstant(0.3);
      scene.state.velocities.rightCols(n).row(1).setConstant(-0.05);
      const Ledger ledger(*scene.model, scene.state);
      const Energies before = ledger.energies(*scene.model, scene.state);
      scene.step({stepper}, dt, static_cast<int>(0.06 / dt + 0.5));
      CHECK(scene.contact->report(scene.state).pairs == 0);
      const Energies after = ledger.energies(*scene.model, scene.state);
      CHECK((after.momentum - before.momentum).norm() <= 1e-12 * before.momentum.norm());
      if (stepper == "newmark") CHECK(after.balance() <= (1 + 1e-6) * before.balance());
    }
}

TEST_CASE("contact: two molecules meet with the prescribed restitution", "[contact]") {
  for (const double restitution : {1., 0.8, 0.5, 0.1}) {
    ContactOptions options = options_of(1e8, 0, {});
    options.restitution = restitution;
    Scene scene(isolated_molecules({{0, 0, 0}, {0.03, 0, 0}}, 0.01, 0.01), options, 0);
    scene.state.velocities(0, 0) = 2;
    scene.step({"velocity_verlet"}, 2e-6, 10000);
    CHECK(scene.contact->report(scene.state).pairs == 0);
    // The damping sets in over the first thousandth of a diameter.
    CHECK(scene.state.velocities(0, 1) - scene.state.velocities(0, 0) == Approx(2 * restitution).epsilon(0.04));
  }
  // However slowly they come: what falls to rest loses energy to the end.
  for (const double restitution : {0.5, 0.2})
    for (const double speed : {0.1, 1e-2, 1e-3, 1e-5}) {
      CAPTURE(restitution, speed);
      ContactOptions options = options_of(1e8, 0, {});
      options.restitution = restitution;
      Scene scene(isolated_molecules({{0, 0, 0}, {0.02 + 1e-4 * speed, 0, 0}}, 0.01, 0.01), options, 0);
      scene.state.velocities(0, 0) = speed;
      scene.step({"velocity_verlet"}, 2e-6, 1000);
      CHECK(scene.contact->report(scene.state).pairs == 0);
      CHECK(scene.state.velocities(0, 1) - scene.state.velocities(0, 0) == Approx(speed * restitution).epsilon(0.05));
    }
  CHECK(damping_ratio_of(1) == 0);
  // Where the force falls to zero of x'' + 2ζx' + x = 0 from x' = 1: ζ = 1 leaves with e⁻².
  CHECK(damping_ratio_of(std::exp(-2)) == Approx(1).epsilon(1e-4));
}

TEST_CASE("contact: Newmark's steps give back no more than came, however long they are", "[contact]") {
  // A molecule on a plane, 1 m/s, a contact of 2 π √(m/k) = 5 ms: steps from two of these to a fiftieth.
  const double mass = 0.5e-3, k = 0.79;
  double error = 1, coarser = 1;
  for (const double dt : {0.01, 0.007, 0.003, 0.001, 0.8e-3, 0.2e-3, 0.1e-3}) {
    CAPTURE(dt);
    Scene scene(isolated_molecules({{0, 0, 0.015}}, 0.005, mass), options_of(k / 1e-4, 0, {floor_at(0)}), 0);
    scene.state.velocities(2, 0) = -1;
    scene.step({"newmark"}, dt, static_cast<int>(0.2 / dt));
    const double rebound = scene.state.velocities(2, 0);
    CHECK(scene.contact->report(scene.state).pairs == 0);
    CHECK(rebound > 0);
    CHECK(rebound < 1 + 1e-9);
    coarser = error, error = 1 - rebound;
  }
  CHECK(error < 0.01);
  CHECK(coarser < 0.05);
}

TEST_CASE("contact: Newmark's steps make no energy of a block that bounces and slides", "[contact]") {
  for (const double friction : {0., 0.5})
    for (const double dt : {0.002, 0.5e-3}) {
      CAPTURE(friction, dt);
      Scene scene(block(), options_of(1e8, friction, {floor_at(0)}));
      scene.state.positions.row(2).array() += 0.01;
      scene.state.velocities.row(0).setConstant(0.5);
      Ledger ledger(*scene.model, scene.state);
      const Energies before = ledger.energies(*scene.model, scene.state);
      const auto stepper = make_stepper({"newmark"});
      // The springs are stretched by large turns, of which the trapezoidal rule keeps the energy to some per cent
      // alone.
      const double floor = 18e-6 * 1000 * kGravity * 0.01;
      double most = 0, highest = 0;
      for (int step = 0; step < static_cast<int>(0.3 / dt); ++step) {
        REQUIRE(stepper->advance(*scene.model, scene.state, dt).outcome == Outcome::converged);
        ledger.record(*scene.model, scene.state);
        most = std::max(most, ledger.energies(*scene.model, scene.state).balance() - before.balance());
        highest = std::max(highest, scene.state.positions.row(2).minCoeff());
      }
      CHECK(most < 0.02 * (before.kinetic + floor));
      CHECK(highest < 0.0155);  // no higher than it came from: its lowest molecules' centres began at 15 mm
    }
}

TEST_CASE("contact: at Newmark's steps that are long for it, what lies on a plane presses with its weight",
          "[contact]") {
  const double mass = 0.3;
  for (const double dt : {1e-3, 5e-3, 0.02}) {
    CAPTURE(dt);
    Scene scene(isolated_molecules({{0, 0, 0.01}}, 0.01, mass), options_of(1e10, 0, {floor_at(0)}));
    scene.step({"newmark"}, dt, 50);
    double sum = 0;  // of many steps: the trapezoidal rule swings about it
    constexpr int steps = 400;
    for (int step = 0; step < steps; ++step) {
      scene.step({"newmark"}, dt, 1);
      sum -= scene.contact->report(scene.state).on_obstacles[0].z();
    }
    CHECK(sum / steps == Approx(mass * kGravity).epsilon(0.01));
  }
}

TEST_CASE("contact: what a moving belt gives a block by friction is work, and no energy is left over", "[contact]") {
  Obstacle belt = floor_at(0);
  belt.motion = [](double) {
    Pose pose;
    pose.velocity = {0.3, 0, 0};
    return pose;
  };
  Scene scene(block(), options_of(1e8, 0.3, {belt}));
  Ledger ledger(*scene.model, scene.state);
  const Energies before = ledger.energies(*scene.model, scene.state);
  const auto stepper = make_stepper({"velocity_verlet"});
  for (int step = 0; step < 2000; ++step) {
    REQUIRE(stepper->advance(*scene.model, scene.state, 1e-5).outcome == Outcome::converged);
    ledger.record(*scene.model, scene.state);
  }
  const Energies after = ledger.energies(*scene.model, scene.state);
  const double speed = 0.3 * kGravity * 0.02;  // mu g t
  CHECK(scene.speed().x() == Approx(speed).epsilon(0.02));
  CHECK(after.work == Approx(18e-3 * speed * speed / 2).epsilon(0.05));
  CHECK(after.dissipated == 0);
  CHECK(std::abs(after.balance() - before.balance()) < 0.01 * after.work);
}

TEST_CASE("contact: forces are those of the obstacle as it moves now, whenever they were read", "[contact]") {
  const Body body = block();
  Vector3 velocity = Vector3::Zero(), shift = Vector3::Zero();
  Obstacle belt = floor_at(0.001);
  belt.motion = [&, at = belt.pose](double) {
    Pose pose = at;
    pose.position += shift, pose.velocity = velocity;
    return pose;
  };
  ContactOptions options = options_of(1e8, 0.3, {belt});
  options.restitution = 0.5;
  const auto read = make_contact(body, options);
  State state = state_at_rest(body);
  for (const Vector3& next : {Vector3(0, 0, 0), Vector3(0, 0, 0.1), Vector3(0.2, 0, 0.1)})
    for (const Vector3& place : {Vector3(0, 0, 0), Vector3(0, 0, 1e-4)}) {
      velocity = next, shift = place;
      Positions forces = Positions::Zero(3, body.size()), expected = forces;
      read->add_forces(state, forces);
      make_contact(body, options)->add_forces(state, expected);
      CHECK(forces == expected);
    }
}

TEST_CASE("contact: an obstacle that is nowhere is refused", "[contact]") {
  const Body body = block();
  Obstacle plane = floor_at(0);
  plane.pose.position.x() = NAN;
  CHECK_THROWS_WITH(make_contact(body, options_of(1e8, 0, {plane})), Catch::Contains("nowhere"));
  plane = floor_at(0);
  plane.motion = [](double time) {
    Pose pose;
    pose.velocity.z() = std::sqrt(-time);
    return pose;
  };
  Scene scene(body, options_of(1e8, 0, {plane}));
  CHECK_THROWS_WITH(scene.step({"velocity_verlet"}, 1e-4, 2), Catch::Contains("nowhere"));
}

TEST_CASE("contact: iterations meet an obstacle that was not there when the step began, and its friction",
          "[contact]") {
  for (const double friction : {0., 0.5}) {
    const auto fall = [&](const StepperOptions& stepper) {
      Scene scene(block(), options_of(5e7, friction, {floor_at(-0.1e-3)}), 0, 1e4);
      scene.state.velocities.row(0).setConstant(0.3);
      scene.state.velocities.row(2).setConstant(-0.2);
      scene.step(stepper, 1e-3, 3);
      return scene;
    };
    const Scene exact = fall({"backward_euler"});
    CHECK(exact.contact->report(exact.state).pairs > 0);
    for (const StepperOptions& stepper : {StepperOptions{"block_descent", {{"sweeps", 1000}}},
                                          StepperOptions{"xpbd", {{"iterations", 1000}, {"substeps", 1}}}}) {
      CAPTURE(friction, stepper.method->name);
      const Scene scene = fall(stepper);
      CHECK((scene.state.positions - exact.state.positions).colwise().norm().maxCoeff() < 1e-9);
    }
  }
}

TEST_CASE("contact: below the angle of friction a block stays where it is for ten seconds", "[contact]") {
  const double mu = 0.5, angle = 0.95 * std::atan(mu);
  Body body = block();
  const Matrix3 turn = incline(angle).pose.turn;
  rotate(body, turn);
  Scene scene(body, options_of(1e9, mu, {incline(angle)}));
  const StaticResult settled = solve_static(*scene.model, scene.state);
  INFO(settled.cause);
  REQUIRE(settled.outcome == Outcome::converged);
  scene.model->commit_step(scene.state);
  const Positions begin = scene.state.positions;
  scene.step({"newmark"}, 0.05, 200);
  CHECK((scene.state.positions - begin).colwise().norm().maxCoeff() < 1e-6);
  CHECK(scene.contact->report(scene.state).sticking == 9);
}

TEST_CASE("contact: a block slides from the angle of friction on, with g (sin − μ cos)", "[contact]") {
  const double mu = 0.5, threshold = std::atan(mu);
  for (const double part : {0.999, 1.001, 1.2}) {
    const double angle = part * threshold;
    Body body = block();
    rotate(body, incline(angle).pose.turn);
    Scene scene(body, options_of(1e9, mu, {incline(angle)}));
    const Vector3 down = incline(angle).pose.turn.col(0);
    // Pressed on by its weight's normal part before it is released, or it bounces.
    scene.step({"backward_euler"}, 0.01, 20);
    const double before = scene.speed().dot(down);
    scene.step({"backward_euler"}, 0.01, 100);
    const double gained = scene.speed().dot(down) - before,
                 expected = kGravity * (std::sin(angle) - mu * std::cos(angle));
    INFO("angle " << part << " of the threshold: gained " << gained << " m/s, expected " << expected);
    if (part < 1)
      CHECK(std::abs(gained) < 1e-9);
    else
      CHECK(gained == Approx(expected).epsilon(1e-3));
  }
}

TEST_CASE("contact: a sled slows down by μ g", "[contact]") {
  const double mu = 0.3;
  Scene scene(block(), options_of(1e9, mu, {floor_at(0)}));
  REQUIRE(solve_static(*scene.model, scene.state).outcome == Outcome::converged);
  scene.state.velocities.row(0).setConstant(1);
  scene.model->commit_step(scene.state);
  scene.step({"velocity_verlet"}, 5e-5, 4000);
  // It rattles, as nothing damps it: friction takes μ times what the floor gives, its weight and its hops alike.
  CHECK(1 - scene.speed().x() == Approx(mu * (kGravity * 0.2 + scene.speed().z())).epsilon(1e-3));
  scene.step({"velocity_verlet"}, 5e-5, 6000);
  CHECK(std::abs(scene.speed().x()) < 1e-3);  // it has stopped, and does not start again
}

TEST_CASE("contact: tangents are the derivatives of the forces", "[contact]") {
  const Body single = isolated_molecules({{0, 0, 0.0099}, {0.021, 0, 0.0095}, {0.003, 0.01, 0.0268}}, 0.01, 0.1);
  const Body apart = isolated_molecules({{0, 0, 0.0099}, {0.021, 0, 0.0095}}, 0.01, 0.1);
  State state = state_at_rest(single);
  SECTION("plane, no friction") { CHECK(tangent_error(single, options_of(1e6, 0, {floor_at(0)}), state, 1e-8) < 1e-6); }
  SECTION("spheres and a sphere obstacle") {
    Obstacle ball{"ball", shape::Sphere{0.05}, {}};
    ball.pose.position = {0.01, 0.002, -0.0495};
    CHECK(tangent_error(single, options_of(1e6, 0, {ball}), state, 1e-8) < 1e-6);
  }
  SECTION("sticking and sliding") {
    const ContactOptions options = options_of(1e6, 0.4, {floor_at(0)});
    state = state_at_rest(apart);
    make_contact(apart, options)->commit_step(state);
    state.positions(0, 0) += 1e-6;  // within the cone
    state.positions(1, 1) += 3e-3;  // far outside
    CHECK(tangent_error(apart, options, state, 1e-9) < 1e-5);
  }
  SECTION("damping") {
    ContactOptions options = options_of(1e6, 0.4, {floor_at(0)});
    options.restitution = 0.5;
    state = state_at_rest(apart);
    make_contact(apart, options)->commit_step(state);
    state.velocities = 1e-3 * random_motion(apart, 3);
    CHECK(tangent_error(apart, options, state, 1e-9) < 1e-5);
  }
}

TEST_CASE("contact: tangents of two surfaces of triangles pressed into each other", "[contact]") {
  const Body one = jittered_block();
  Body two = one;
  const int n = one.size();
  two.rest.conservativeResize(3, 2 * n);
  two.rest.rightCols(n) =
      (Eigen::AngleAxisd(0.2, Vector3(1, 2, 3).normalized()).toRotationMatrix() * one.rest).colwise() +
      Vector3(0.004, 0.003, 0.0195);
  for (auto cell : one.tetrahedra) two.tetrahedra.push_back({cell[0] + n, cell[1] + n, cell[2] + n, cell[3] + n});
  two.connections = connections_of_cells(two.rest, {}, two.tetrahedra);
  set_matter(two, 0.003, 1000, 0, 0);
  ContactOptions options = options_of(1e8, 0, {});
  options.surface = ContactSurface::triangles;
  const State state = state_at_rest(two);
  const auto contact = make_contact(two, options);
  REQUIRE(contact->report(state).pairs > 3);
  const Positions forces = forces_of(*contact, state);
  const double size = forces.cwiseAbs().maxCoeff();
  CHECK(forces.rowwise().sum().norm() < 1e-12 * size);
  Vector3 torque = Vector3::Zero();
  for (int i = 0; i < two.size(); ++i) torque += Vector3(two.rest.col(i)).cross(Vector3(forces.col(i)));
  CHECK(torque.norm() < 1e-12 * size);
  CHECK(tangent_error(two, options, state, 1e-9) < 1e-4);
  // The forces are the energy's slope whatever the depth.
  const Positions motion = random_motion(two, 4);
  State ahead = state, behind = state;
  ahead.positions += 1e-8 * motion, behind.positions -= 1e-8 * motion;
  CHECK((contact->energy(ahead) - contact->energy(behind)) / 2e-8 ==
        Approx(-forces.cwiseProduct(motion).sum()).epsilon(1e-5));
}

namespace {

/// Two pieces of jittered hexahedra, pressed into each other and onto a floor; molecule a of the one has the number
/// `number[a]` in the other.
Body hexahedra(const std::vector<int>& number) {
  const Body one = cell_box(cell_kind("hexahedron8"), {3, 3, 2}, {0.03, 0.03, 0.02}, 0.2);
  const int n = one.size();
  BodyArrays arrays;
  arrays.positions.resize(3, 2 * n);
  const Matrix3 turn = Eigen::AngleAxisd(0.2, Vector3(1, 2, 3).normalized()).toRotationMatrix();
  CellBlock cells{one.blocks[0].kind, {}, {}};
  for (int a = 0; a < n; ++a) {
    arrays.positions.col(number[a]) = one.rest.col(a);
    arrays.positions.col(number[n + a]) = turn * one.rest.col(a) + Vector3(0.004, 0.003, 0.0195);
  }
  for (int piece = 0; piece < 2; ++piece)
    for (const int node : one.blocks[0].nodes) cells.nodes.push_back(number[piece * n + node]);
  arrays.blocks = {cells};
  return make_body(arrays);
}

}  // namespace

TEST_CASE("contact: hexahedra touch alike however they are numbered", "[contact]") {
  std::vector<int> given(2 * 48), shuffled(2 * 48);
  std::iota(given.begin(), given.end(), 0);
  shuffled = given;
  std::shuffle(shuffled.begin(), shuffled.end(), std::mt19937_64(3));
  ContactOptions options = options_of(1e8, 0, {floor_at(2e-4)});
  options.surface = ContactSurface::triangles;
  const Body one = hexahedra(given), other = hexahedra(shuffled);
  const Positions forces = forces_of(*make_contact(one, options), state_at_rest(one)),
                  renumbered = forces_of(*make_contact(other, options), state_at_rest(other));
  REQUIRE(forces.norm() > 0);
  for (int a = 0; a < one.size(); ++a)
    CHECK((forces.col(a) - renumbered.col(shuffled[a])).norm() < 1e-11 * forces.cwiseAbs().maxCoeff());
  CHECK(tangent_error(one, options, state_at_rest(one), 1e-9) < 1e-4);
  CHECK(make_contact(one, options)->report(state_at_rest(one)).pairs > 5);
  // Without the floor nothing comes from outside.
  options.obstacles.clear();
  Vector3 torque = Vector3::Zero();
  const Positions inner = forces_of(*make_contact(one, options), state_at_rest(one));
  for (int a = 0; a < one.size(); ++a) torque += Vector3(one.rest.col(a)).cross(Vector3(inner.col(a)));
  CHECK(inner.rowwise().sum().norm() < 1e-12 * inner.cwiseAbs().maxCoeff());
  CHECK(torque.norm() < 1e-12 * inner.cwiseAbs().maxCoeff());
}

TEST_CASE("contact: what slid into its place does not stick", "[contact]") {
  // The elastic slip at which the cone is reached is μ N / k: moved by less it sticks, by more it has slid.
  for (const double part : {0.9, 1.1}) {
    const double mu = 0.5;
    Scene scene(isolated_molecules({{0, 0, 0.01}}, 0.01, 0.3), options_of(1e6, mu, {floor_at(0)}));
    REQUIRE(solve_static(*scene.model, scene.state).outcome == Outcome::converged);
    scene.model->commit_step(scene.state);
    scene.state.positions(0, 0) += part * mu * scene.contact->report(scene.state).largest_penetration;
    for (int step = 0; step < 2; ++step) {
      scene.model->commit_step(scene.state);
      CHECK(scene.contact->report(scene.state).sticking == (part < 1 ? 1 : 0));
    }
  }
}

TEST_CASE("contact: nothing passes through a thin plate however fast it comes", "[contact]") {
  for (const StepperMethod method : {"velocity_verlet", "symplectic_euler", "backward_euler", "newmark"}) {
    Obstacle plate{"plate", shape::Box{{0.2, 0.2, 1e-3}}, {}};
    Scene scene(isolated_molecules({{0, 0, 0.1}}, 0.005, 0.001), options_of(1e10, 0, {plate}),
                0);  // stiff enough to stop it within its radius
    scene.state.velocities(2, 0) = -100;
    const auto stepper = make_stepper({method});
    for (int step = 0; step < 50 && scene.state.velocities(2, 0) < 0; ++step) {
      const StepResult result = stepper->advance(*scene.model, scene.state, 1e-4);  // 1 cm a step
      INFO(method->name << ": " << result.cause);
      REQUIRE(result.outcome == Outcome::converged);
      REQUIRE(scene.state.positions(2, 0) > 0);
    }
    CHECK(scene.state.positions(2, 0) > 0);
  }
}

TEST_CASE("contact: wrong options are refused", "[contact]") {
  const Body body = block();
  CHECK_THROWS_AS(make_contact(body, options_of(0, 0, {floor_at(0)})), InputError);
  CHECK_THROWS_AS(make_contact(body, options_of(1, -1, {floor_at(0)})), InputError);
  ContactOptions options = options_of(1, 0, {});
  options.restitution = 0;
  CHECK_THROWS_AS(make_contact(body, options), InputError);
  options = options_of(1, 0, {});
  options.surface = ContactSurface::triangles;
  CHECK_THROWS_WITH(make_contact(isolated_molecules({{0, 0, 0}}, 1, 1), options),
                    Catch::Contains("no surface of triangles"));
}
