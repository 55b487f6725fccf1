#include <catch2/catch.hpp>
#include <thread>

#include "core/simulation/pool.h"
#include "core/simulation/tissues.h"
#include "elastin/core/forces/viscosity.h"
#include "support/allocations.h"

using namespace elastin;
using namespace elastin::testing;

namespace {

/// Gravity, a push that grows in time, drag of every kind, a tool, an own force, a moved base.
void load(Simulation& tissue) {
  const Body& body = tissue.body();
  const int top = body.size() - 1;
  Model& model = tissue.model();
  model.add(make_gravity(body, {0, 0, -9.81}));
  model.add(make_varying(std::make_unique<PointLoads>(body, std::vector<int>{top}, Positions::Constant(3, 1, 1e-4)),
                         TimeFunction({{0, 0}, {1, 1}})));
  model.add(make_mass_damping(body, 5));
  model.add(make_stokes_drag(body, 1e-3));
  model.add(make_quadratic_drag(body, 1, 0.5));
  tissue.couple(top, body.rest.col(top) + Vector3(0, 1e-4, 0), 5, 1e-3);
  tissue.host_forces()(0, top / 2) = 1e-4;
  for (int molecule = 0; molecule < body.size(); ++molecule)
    if (body.rest(2, molecule) < 1e-9) tissue.fix(molecule);
}

bool step(Simulation& tissue, int number) {
  tissue.move_to(0, tissue.body().rest.col(0) + Vector3(1e-6 * number, 0, 0));
  tissue.host_forces()(1, 1) = 1e-5 * number;
  tissue.move_coupling(1, tissue.body().rest.col(tissue.body().size() - 1) + Vector3(1e-5 * number, 0, 0));
  return tissue.step(1e-3).outcome == Outcome::converged;
}

/// Of a number of steps, after the first.
long allocations_in_steps(Simulation& tissue, int steps) {
  double read = 0;
  tissue.observe(2, [&read](const Simulation& seen) { read += seen.positions()(0, 0); });
  const long at_first = allocations();
  REQUIRE(step(tissue, 0));
  if (at_first > 0) CHECK(allocations() > at_first);  // they are counted
  read += tissue.forces()(0, 0) + tissue.tensions()[0];
  const long before = allocations();
  for (int number = 1; number <= steps; ++number) {
    if (!step(tissue, number)) FAIL();
    read += tissue.forces()(0, 0) + tissue.tensions()[0] + tissue.reaction(0).x() + tissue.coupling_force(1).x();
  }
  const long after = allocations();
  CHECK(std::isfinite(read));
  return after - before;
}

Positions after_steps(Simulation& tissue, int steps) {
  for (int number = 0; number < steps; ++number)
    if (!step(tissue, number)) return {};
  return tissue.positions();
}

}  // namespace

TEST_CASE("simulation: steps, views, grips, moved supports and observers allocate no memory", "[slow]") {
  for (const StepperMethod& method : kSteppers)
    for (const char* strategy : {"lattice", "lattice+volume", "neo_hookean"})
      for (const int newton : {0, 1}) {
        if (newton == 1 && method->effort != "newton_iterations") continue;
        if (!suits(method, strategy)) continue;
        INFO(method->name << " " << strategy << " " << newton);
        // More molecules than one block of an ordered sum, where that is quick.
        Body body = strategy[0] == 'n' ? tissue_block() : tissue_cube(std::string(strategy) == "lattice" ? 11 : 5);
        SimulationOptions options;
        if (newton > 0) options.stepper.parameters["newton_iterations"] = newton;
        Simulation tissue = simulation_of(std::move(body), method, strategy, options);
        load(tissue);
        CHECK(allocations_in_steps(tissue, 4) == 0);
      }
}

TEST_CASE("simulation: damping of connections, of the stiffness and of cells allocates no memory") {
  for (const StepperMethod method : {"velocity_verlet", "backward_euler"}) {
    Simulation tissue = simulation_of(tissue_block(), method, "neo_hookean");
    load(tissue);
    tissue.model().add(make_damping(1e-4));
    tissue.model().add(make_stiffness_damping(tissue.body(), *tissue.model().elasticity().front(), 1e-4));
    tissue.model().add(make_cell_damping(tissue.body(), 0.1, 0.1));
    CHECK(allocations_in_steps(tissue, 4) == 0);
  }
}

TEST_CASE("simulation: the host's threads give bitwise identical results, and allocate no memory either") {
  const auto with = [](TaskRunner* runner, int threads) {
    SimulationOptions options{.runner = runner, .threads = threads};
    options.stepper.parameters["newton_iterations"] = 1;
    // Large enough to be shared out.
    Simulation tissue = simulation_of(tissue_cube(20), "backward_euler", "lattice", options);
    load(tissue);
    REQUIRE(step(tissue, 0));
    const long before = allocations();
    if (!step(tissue, 1)) FAIL();
    if (runner) CHECK(allocations() == before);
    return tissue.positions();
  };
  Pool pool(2);
  const Positions alone = with(nullptr, 1);
  REQUIRE(alone.cols() == 8000);
  CHECK(with(&pool, 0) == alone);
  CHECK(pool.loops > 0);
  CHECK(with(nullptr, 2) == alone);
}

TEST_CASE("simulation: several in several threads move as each does alone") {
  constexpr int count = 4;
  const auto run = [](int number) {
    Simulation tissue = simulation_of(tissue_cube(3 + number), kSteppers[number]);
    load(tissue);
    return after_steps(tissue, 40);
  };
  std::vector<Positions> alone, together(count);
  for (int number = 0; number < count; ++number) alone.push_back(run(number));
  std::vector<std::thread> threads;
  for (int number = 0; number < count; ++number) threads.emplace_back([&, number] { together[number] = run(number); });
  for (std::thread& thread : threads) thread.join();
  REQUIRE(alone.front().cols() == 27);
  CHECK(together == alone);
}
