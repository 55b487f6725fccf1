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

TEST_CASE("simulation: with a tool that rubs, steps are the same bits in a fresh simulation, and if forces are read") {
  using Case = std::pair<StepperMethod, std::string>;
  for (const auto& [method, strategy] :
       {Case("symplectic_euler", "lattice"), Case("velocity_verlet", "lattice"), Case("newmark", "lattice"),
        Case("projective", "lattice"), Case("projective", "neo_hookean")}) {
    CAPTURE(method->name, strategy);
    const auto place = [](int step) { return Vector3(2e-3 + 2e-6 * step, 2e-3, 8.02e-3 - 5e-6 * step); };
    const auto make = [&, &method = method, &strategy = strategy] {
      Simulation tissue = simulation_of(strategy == "neo_hookean" ? tissue_block() : tissue_cube(4), method, strategy);
      for (int i = 0; i < tissue.body().size(); ++i)
        if (tissue.body().rest(2, i) == 0) tissue.fix(i);
      ContactOptions options;
      options.stiffness = default_contact_stiffness(tissue.body(), kTissue.youngs_modulus);
      options.friction = 0.4, options.restitution = 0.5;
      options.obstacles.push_back(
          {"ball", shape::Sphere{1e-3}, {}, tissue.tool_motion(tissue.add_tool({.position = place(0)}))});
      tissue.model().add(make_contact(tissue.body(), options));
      return tissue;
    };
    const auto run = [&](Simulation& tissue, int from, int to, bool reads) {
      for (int step = from; step < to; ++step) {
        tissue.move_tool(1, place(step + 1));
        REQUIRE(tissue.step(1e-3).outcome == Outcome::converged);
        if (reads) forces_on_obstacles(tissue);
      }
    };
    Simulation quiet = make(), read = make(), later = make();
    run(quiet, 0, 60, false), run(read, 0, 60, true);
    CHECK(quiet.positions() == read.positions());
    CHECK(forces_on_obstacles(quiet).front().second.norm() > 0);
    later.restore(quiet.save());
    run(quiet, 60, 90, false), run(later, 60, 90, true);
    CHECK(quiet.positions() == later.positions());
  }
}

TEST_CASE("simulation: any number of sweeps makes no energy where damped contact sets in within a step") {
  using Sweeps = std::pair<double, double>;  // how many, and how many of them are mixed
  for (const auto& [sweeps, mixing] : {Sweeps(5, 0), Sweeps(5, 5), Sweeps(20, 0), Sweeps(20, 5)})
    for (const double restitution : {0.5, 0.1}) {
      CAPTURE(sweeps, mixing, restitution);
      Body body = tetrahedral_block(BlockKind::kuhn, {6, 6, 6}, Vector3::Constant(30e-3));
      set_matter(body, 2.5e-3, 1000, 0, 0);
      SimulationOptions options;
      options.stepper = {"block_descent", {{"sweeps", sweeps}, {"mixing", mixing}}};
      Simulation tissue(body, built_in_catalog().find("neo_hookean"), kTissue, options);
      ContactOptions touch;
      touch.surface = ContactSurface::triangles;
      touch.stiffness = default_contact_stiffness(body, kTissue.youngs_modulus);
      touch.restitution = restitution;
      touch.obstacles.push_back({"floor", shape::Plane{}, {.position = {0, 0, -1e-3}}});
      tissue.add([&](Model& model) {
        model.add(make_gravity(model.body(), {0, 0, -10}));
        model.add(make_contact(model.body(), touch));
      });
      const auto energy = [&] {
        return tissue.velocities().colwise().squaredNorm().dot(body.mass) / 2 +
               tissue.model().elastic_energy(tissue.positions()) + 10 * tissue.positions().row(2).dot(body.mass);
      };
      const double before = energy();
      for (int step = 0; step < 12; ++step) {
        REQUIRE(tissue.step(5e-3).outcome == Outcome::converged);
        CHECK(energy() < before);
      }
    }
}

TEST_CASE("simulation: the halves of a cut, touched as spheres, stay where the cut leaves them") {
  for (const StepperMethod method : {"symplectic_euler", "velocity_verlet", "backward_euler"}) {
    INFO(method->name);
    Simulation tissue = simulation_of(tissue_cube(4), method);
    ContactOptions touch;
    touch.stiffness = default_contact_stiffness(tissue.body(), kTissue.youngs_modulus);
    touch.friction = 0.4, touch.restitution = 0.5;
    tissue.add([&](Model& model) { model.add(make_contact(model.body(), touch)); });
    REQUIRE(tissue.step(1e-4).outcome == Outcome::converged);
    const double middle = tissue.body().rest.row(0).mean();
    REQUIRE(tissue.cut(CutSurface::plane({middle, 0, 0}, {1, 0, 0})).split_molecules > 0);
    for (int step = 0; step < 20; ++step) {
      const StepResult result = tissue.step(1e-4);
      REQUIRE(result.outcome == Outcome::converged);
      CHECK(result.newton_iterations < 5);
    }
    CHECK(tissue.velocities().cwiseAbs().maxCoeff() < 1e-6);
  }
}
