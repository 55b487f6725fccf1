// A step with a budget of time: how many sweeps it gets, and what that does to it.

#include <catch2/catch.hpp>

#include "core/simulation/budget.h"
#include "core/simulation/tissues.h"
#include "elastin/core/base/error.h"

using namespace elastin;
using namespace elastin::testing;
using Catch::Contains;

namespace {

constexpr double kStep = 1e-3;  // s

Simulation swinging(const StepperMethod& method, double budget, const ParameterValues& parameters = {}) {
  SimulationOptions options;
  options.stepper = {method, parameters, {}};
  options.budget = budget;
  Simulation tissue(tissue_block(), built_in_catalog().find("neo_hookean"), kTissue, options);
  tissue.add_load(*built_in_loads().find("gravity"), {.vectors = {{"acceleration", Vector3(3, 0, -9.81)}}});
  for (int molecule = 0; molecule < 16; ++molecule) tissue.fix(molecule);
  return tissue;
}

}  // namespace

TEST_CASE("a budget of sweeps follows the pace of the machine", "[budget]") {
  Budget budget;
  CHECK(budget.next(1e-3, 20) == 20);  // nothing is known
  budget.took(1, 20);                  // the first step finds room: it does not count
  CHECK(budget.next(1e-3, 20) == 20);
  budget.took(2e-3, 20);  // 0.1 ms a sweep
  CHECK(budget.next(1e-3, 20) == 8);
  CHECK(budget.next(1e-5, 8) == 1);
  CHECK(budget.next(1, 8) == 16);  // no more than twice as many as before
  budget.took(8e-3, 8);            // slower: at once
  CHECK(budget.next(8e-3, 8) == 6);
  for (int step = 0; step < 100; ++step) budget.took(8e-4, 8);  // faster: in time
  CHECK(budget.next(8e-4, 8) == 6);
}

TEST_CASE("the number of sweeps is recorded, and a replay with it is bitwise the same", "[budget]") {
  for (const StepperMethod method : {"block_descent", "xpbd", "backward_euler"}) {
    INFO(method->name);
    Simulation tissue = swinging(method, 1e-4), replay = swinging(method, 0);
    for (int step = 0; step < 20; ++step) {
      REQUIRE(tissue.step(kStep).outcome == Outcome::converged);
      REQUIRE(tissue.effort() >= 1);
      replay.set_effort(tissue.effort());
      REQUIRE(replay.step(kStep).outcome == Outcome::converged);
    }
    CHECK(tissue.positions() == replay.positions());
  }
}

TEST_CASE("the error of too few sweeps is reported, and reporting changes nothing", "[budget]") {
  double last = std::numeric_limits<double>::infinity();
  for (const double sweeps : {1., 4., 16., 400.}) {
    Simulation tissue = swinging("block_descent", 0, {{"sweeps", sweeps}});
    for (int step = 0; step < 5; ++step) REQUIRE(tissue.step(kStep).outcome == Outcome::converged);
    const Positions before = tissue.positions();
    const auto [off, motion] = tissue.iteration_error(kStep);
    CHECK(tissue.positions() == before);
    CHECK(off < last);
    CHECK(motion > 0);
    if (sweeps == 400) CHECK(off < 1e-5 * motion);
    last = off;
    // As it is by hand: the same step by backward Euler to the end.
    Simulation converged = swinging("backward_euler", 0);
    SimulationState state = tissue.save();
    state.effort = 0;
    converged.restore(state);
    REQUIRE(converged.step(kStep).outcome == Outcome::converged);
    REQUIRE(tissue.step(kStep).outcome == Outcome::converged);
    CHECK(off == Approx((tissue.positions() - converged.positions()).colwise().norm().maxCoeff()).epsilon(1e-9));
  }
}

TEST_CASE("a stepper without sweeps has no budget", "[budget]") {
  CHECK_THROWS_WITH(swinging("symplectic_euler", 1e-3), Contains("takes no number of sweeps"));
  Simulation tissue = swinging("velocity_verlet", 0);
  CHECK(tissue.effort() == 0);
  CHECK_THROWS_WITH(tissue.set_effort(3), Contains("takes no number of sweeps"));
  CHECK_THROWS_WITH(tissue.iteration_error(kStep), Contains("takes no number of sweeps"));
  CHECK_THROWS_WITH(swinging("block_descent", 0).set_effort(0), Contains("0 is out of range"));
  CHECK_THROWS_WITH(swinging("block_descent", -1), Contains("budget -1 s is out of range"));
}
