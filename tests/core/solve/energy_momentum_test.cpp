// The stepper that keeps energy and both momenta: against what the exact motion keeps, and a finer one of another kind.

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "core/forces/floor.h"
#include "core/shapes/surfaces.h"
#include "core/solve/energies.h"
#include "elastin/core/simulation/catalog.h"
#include "elastin/core/simulation/simulation.h"
#include "support/bodies.h"

using namespace elastin;
using namespace elastin::testing;
using Catch::Matchers::Contains;

namespace {

/// A block of 10 cm that turns about an axis of its own, its corner drawn out a little.
struct Spinning {
  explicit Spinning(const std::string& strategy, double spin)
      : body(strategy == "lattice" ? cubic_lattice({3, 3, 4}, 0.033, {true, true, false})
                                   : tetrahedral_block(BlockKind::body_centred, {2, 2, 2}, {0.1, 0.08, 0.12})) {
    set_matter(body, 0.005, 1000, 0, strategy == "lattice" ? 0.066 * 0.066 * 0.099 : 0);
    model = std::make_unique<Model>(body);
    model->add(built_in_catalog().find(strategy).make(
        body, Material{.youngs_modulus = 1e5, .poissons_ratio = strategy == "lattice" ? 0.25 : 0.4}, {}));
    state = state_at_rest(body);
    const Vector3 axis = spin * Vector3(0.2, -0.3, 1).normalized();
    const Vector3 centre = state.positions.rowwise().mean();
    for (int i = 0; i < body.size(); ++i)
      state.velocities.col(i) = axis.cross(Vector3(state.positions.col(i) - centre)) + Vector3(0.1, 0, 0);
    state.positions *= 1.02;
  }
  Energies energies() const { return Ledger(*model, state).energies(*model, state); }
  Body body;
  std::unique_ptr<Model> model;
  State state;
};

}  // namespace

TEST_CASE("energy_momentum keeps a spinning block's energy and momenta at ten steps a turn", "[steppers][slow]") {
  const double spin = 20, dt = 2 * std::numbers::pi / spin / 10;
  for (const std::string strategy : {"lattice", "neo_hookean", "neo_hookean+volume", "st_venant_kirchhoff"}) {
    Spinning block(strategy, spin);
    const auto stepper = make_stepper({"energy_momentum"});
    const Energies first = block.energies();
    const int turns = strategy == "st_venant_kirchhoff" ? 20 : 1;
    for (int step = 0; step < 10 * turns; ++step) {
      const StepResult result = stepper->advance(*block.model, block.state, dt);
      INFO(strategy << ", step " << step << ": " << result.cause);
      REQUIRE(result.outcome == Outcome::converged);
    }
    const Energies last = block.energies();
    INFO(strategy);
    CHECK(last.balance() == Approx(first.balance()).epsilon(1e-6));
    CHECK((last.angular_momentum - first.angular_momentum).norm() <= 1e-6 * first.angular_momentum.norm());
    CHECK((last.momentum - first.momentum).norm() <= 1e-9 * first.momentum.norm());
    // Newmark's method does not: its energy is another one after the first turn.
    Spinning other(strategy, spin);
    const auto newmark = make_stepper({"newmark"});
    for (int step = 0; step < 10; ++step) newmark->advance(*other.model, other.state, dt);
    CHECK(std::abs(other.energies().balance() / first.balance() - 1) > 1e-3);
  }
}

TEST_CASE("energy_momentum is of order 2", "[steppers]") {
  const auto place_after = [](const std::string& method, int steps) {
    Spinning block("neo_hookean", 5);
    const auto stepper = make_stepper({method});
    for (int step = 0; step < steps; ++step)
      REQUIRE(stepper->advance(*block.model, block.state, 0.02 / steps).outcome == Outcome::converged);
    return block.state.positions;
  };
  const Positions exact = place_after("velocity_verlet", 4000);
  const double coarse = (place_after("energy_momentum", 100) - exact).norm();
  const double fine = (place_after("energy_momentum", 200) - exact).norm();
  CHECK(coarse / fine == Approx(4).epsilon(0.1));
}

TEST_CASE("energy_momentum under weight, with supports, and with damping", "[steppers][slow]") {
  Spinning block("neo_hookean", 0);
  block.model->supports = {{0}, {1}, {2}};
  block.model->add(make_gravity(block.body, {0, 0, -9.81}));
  const auto stepper = make_stepper({"energy_momentum"});
  block.state.positions = block.body.rest;
  block.state.velocities.setZero();
  const double first = block.energies().balance();
  double most = 0;
  for (int step = 0; step < 100; ++step) {
    REQUIRE(stepper->advance(*block.model, block.state, 5e-3).outcome == Outcome::converged);
    const Energies now = block.energies();
    most = std::max(most, now.kinetic);
    CHECK(std::abs(now.balance() - first) <= 1e-7 * most + 1e-12);
  }
  CHECK(most > 1e-4);
  block.model->add(make_mass_damping(block.body, 20));
  for (int step = 0; step < 400; ++step)
    REQUIRE(stepper->advance(*block.model, block.state, 0.02).outcome == Outcome::converged);
  CHECK(block.energies().kinetic < 1e-6 * most);
}

TEST_CASE("energy_momentum comes to rest under weight on a floor", "[steppers][floor][slow]") {
  Body body = cubic_lattice({4, 3, 3}, 0.01, {true, true, false});
  set_matter(body, 0.005, 1000, 0, 12e-6);
  body.rest.row(2).array() += 0.005;
  Model model(body);
  model.add(built_in_catalog().find("lattice").make(body, Material{.youngs_modulus = 1e5, .poissons_ratio = 0.25}, {}));
  model.add(make_gravity(body, {0, 0, -9.81}));
  model.add(make_mass_damping(body, 40));
  model.add(make_floor(body, {.point = {0, 0, 0}, .normal = {0, 0, 1}, .stiffness = 1e4}));
  State state = state_at_rest(body);
  const auto stepper = make_stepper({"energy_momentum"});
  for (int step = 0; step < 1500; ++step) {
    const StepResult result = stepper->advance(model, state, 5e-4);
    INFO("step " << step << ": " << result.cause);
    REQUIRE(result.outcome == Outcome::converged);
  }
  CHECK(state.velocities.norm() < 1e-4);
}

TEST_CASE("energy_momentum refuses what has no energy to keep", "[steppers]") {
  const auto simulate = [](const std::string& strategy, const Body& body) {
    SimulationOptions options;
    options.stepper.method = "energy_momentum";
    return Simulation(body, built_in_catalog().find(strategy), Material{.youngs_modulus = 1e5}, options);
  };
  Body sheet = rectangular_sheet({0.1, 0.1}, {3, 3}, SheetPattern::alternating);
  set_matter(sheet, 0.001, 1000, 0.001, 0);
  CHECK_THROWS_WITH(simulate("two_parameter", sheet), Contains("an energy to keep"));
  Body block = tetrahedral_block(BlockKind::body_centred, {1, 1, 1}, {0.1, 0.1, 0.1});
  set_matter(block, 0.005, 1000, 0, 0);
  CHECK_NOTHROW(simulate("neo_hookean", block));
}
