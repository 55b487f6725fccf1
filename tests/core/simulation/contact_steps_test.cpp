#include <catch2/catch.hpp>

#include "core/simulation/tissues.h"
#include "elastin/contact/contact.h"
#include "support/allocations.h"

using namespace elastin;
using namespace elastin::contact;
using namespace elastin::testing;

TEST_CASE("simulation: a body on a rough floor goes on bitwise identically after restore, and allocates no memory") {
  for (const StepperMethod method : {"symplectic_euler", "velocity_verlet", "backward_euler"}) {
    Simulation tissue = simulation_of(tissue_cube(4), method);
    const Body& body = tissue.body();
    tissue.model().add(make_gravity(body, {2, 0, -10}));
    tissue.model().add(make_mass_damping(body, 10));
    ContactOptions options;
    options.stiffness = default_contact_stiffness(body, kTissue.youngs_modulus);
    options.friction = 0.4;
    options.obstacles.push_back({"floor", shape::Plane{}, {.position = {0, 0, -1.01e-3}}});
    tissue.model().add(make_contact(body, options));
    const auto run = [&](int steps) {
      int good = 0;
      for (int step = 0; step < steps; ++step) good += tissue.step(1e-3).outcome == Outcome::converged;
      return good == steps;
    };
    REQUIRE(run(60));
    const SimulationState saved = tissue.save();
    CHECK(saved.state.contact_history.size() > 4);  // it sticks
    const long before = allocations();
    const bool went = run(40);
    CHECK(allocations() == before);
    REQUIRE(went);
    const Positions reached = tissue.positions();
    CHECK(reached != saved.state.positions);
    tissue.restore(saved);
    REQUIRE(run(40));
    CHECK(tissue.positions() == reached);
  }
}
