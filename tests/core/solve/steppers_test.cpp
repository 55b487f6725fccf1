// Steppers that go without Newton's method: where their iterations lead, what they keep, what they refuse.

#include <catch2/catch.hpp>
#include <cmath>

#include "core/solve/energies.h"
#include "elastin/core/parallel/threads.h"
#include "elastin/core/simulation/catalog.h"
#include "elastin/core/simulation/simulation.h"
#include "elastin/core/solve/stepper.h"
#include "support/allocations.h"
#include "support/bodies.h"

using namespace elastin;
using namespace elastin::testing;
using Catch::Matchers::Contains;

namespace {

/// A bar of 5 × 5 × 9 molecules, clamped at one end, drawn out by 10 %, bent and moving.
struct Bar {
  explicit Bar(const std::string& strategy)
      : cells(strategy != "lattice"),
        body(cells ? tetrahedral_block(BlockKind::kuhn, {4, 4, 8}, {0.04, 0.04, 0.08})
                   : cubic_lattice({5, 5, 9}, 0.01, {true, true, false})) {
    set_matter(body, 0.005, 1000, 0, cells ? 0 : 0.04 * 0.04 * 0.08);
    model = std::make_unique<Model>(body);
    model->add(built_in_catalog().find(strategy).make(
        body, Material{.youngs_modulus = 2e4, .poissons_ratio = cells ? 0.4 : 0.25}, {}));
    for (int i = 0; i < body.size(); ++i)
      if (body.rest(2, i) < 1e-9) model->supports.push_back({i});
    state = state_at_rest(body);
    for (int i = 0; i < body.size(); ++i) {
      const double height = body.rest(2, i) / 0.08;
      state.positions(0, i) += 0.01 * height * height;
      state.positions(2, i) *= 1.1;
      state.velocities(1, i) = 0.5 * height;
    }
  }
  StepResult step(const StepperOptions& options, double dt) {
    return make_stepper(options)->advance(*model, state, dt);
  }
  bool cells;
  Body body;
  std::unique_ptr<Model> model;
  State state;
};

StepperOptions options_of(const StepperKind& method, double iterations) {
  StepperOptions options{method.name, {{method.effort, iterations}}};
  if (method.name == "xpbd") options.parameters["substeps"] = 1;
  return options;
}

const std::vector<std::string> kIterative{"block_descent", "xpbd", "projective"};

}  // namespace

TEST_CASE("iterations of every stepper lead to backward Euler's step", "[steppers][slow]") {
  for (const std::string strategy : {"lattice", "neo_hookean"})
    for (const double dt : {1e-3, 4e-3}) {
      Bar exact(strategy);
      const State start = exact.state;
      REQUIRE(exact.step({"backward_euler"}, dt).outcome == Outcome::converged);
      const double moved = (exact.state.positions - start.positions).norm();
      for (const std::string& name : kIterative) {
        const StepperKind& method = *built_in_steppers().find(name);
        double last = 1;
        for (const int iterations : {2, 8, 32, 512}) {
          Bar bar(strategy);
          const StepResult result = bar.step(options_of(method, iterations), dt);
          INFO(name << " on " << strategy << ", " << iterations << " iterations of " << dt << " s: " << result.cause);
          REQUIRE(result.outcome == Outcome::converged);
          if (result.substeps > 1) continue;  // a cell inverted: the step was bisected, and says so
          const double error = (bar.state.positions - exact.state.positions).norm() / moved;
          CHECK(error <= std::max(last, 1e-9));
          last = error;
        }
        INFO(name << " on " << strategy << ", " << dt << " s");
        // Constraints one by one are slow where a step is many times as long as a cell's own period.
        CHECK(last <= (name == "xpbd" && dt > 1e-3 ? 1e-4 : 1e-6));
      }
    }
}

TEST_CASE("accelerated sweeps of block descent lead to the same step sooner", "[steppers]") {
  Bar exact("lattice");
  REQUIRE(exact.step({"backward_euler"}, 0.01).outcome == Outcome::converged);
  const auto error_of = [&](const ParameterValues& parameters) {
    Bar bar("lattice");
    ParameterValues all = parameters;
    all["sweeps"] = 50;
    REQUIRE(bar.step({"block_descent", all}, 0.01).outcome == Outcome::converged);
    return (bar.state.positions - exact.state.positions).norm();
  };
  const double plain = error_of({{"mixing", 0}});
  CHECK(error_of({{"chebyshev", 0.95}}) < 0.1 * plain);
  CHECK(error_of({{"mixing", 5}}) < 0.1 * plain);
}

TEST_CASE("few sweeps of block descent at a long step do not make energy from nothing", "[steppers]") {
  for (const std::string strategy : {"lattice", "neo_hookean"})
    for (const int sweeps : {1, 2, 5}) {
      Bar bar(strategy);
      const Ledger ledger(*bar.model, bar.state);
      const double first = ledger.energies(*bar.model, bar.state).balance();
      const auto stepper = make_stepper({"block_descent", {{"sweeps", sweeps}}});
      for (int step = 0; step < 50; ++step) {
        const StepResult result = stepper->advance(*bar.model, bar.state, 0.02);
        INFO(strategy << ", " << sweeps << " sweeps, step " << step << ": " << result.cause);
        REQUIRE(result.outcome == Outcome::converged);
        // What sweeps leave undone may swing; it never exceeds what the body began with.
        CHECK(ledger.energies(*bar.model, bar.state).balance() <= first * (1 + 1e-9));
      }
    }
}

TEST_CASE("a crushed body comes back by every stepper, or the outcome says why not", "[steppers][slow]") {
  for (const std::string& name : kIterative)
    for (const double flat : {0.3, 0.02}) {
      Bar bar("neo_hookean");
      bar.state = state_at_rest(bar.body);
      bar.state.positions.row(2) *= flat;
      const double before = bar.model->elastic_energy(bar.state.positions);
      bar.model->add(make_mass_damping(bar.body, 30));
      const auto stepper = make_stepper({name});
      bool stopped = false;
      for (int step = 0; step < 100 && !stopped; ++step) {
        const StepResult result = stepper->advance(*bar.model, bar.state, 2e-3);
        stopped = result.outcome != Outcome::converged;
        if (stopped) CHECK(!result.cause.empty());
      }
      INFO(name << ", flattened to " << flat << (stopped ? ", stopped" : ""));
      REQUIRE(bar.state.positions.allFinite());
      CHECK(bar.model->admissible(bar.state.positions));
      CHECK(bar.model->elastic_energy(bar.state.positions) <= before);
      if (!stopped) CHECK(bar.model->elastic_energy(bar.state.positions) < 0.1 * before);
    }
}

TEST_CASE("steps of every stepper allocate nothing after the first", "[steppers]") {
  if (allocations() == 0) return;  // they cannot be counted here
  for (const std::string& name : kIterative) {
    Bar bar("lattice");
    bar.model->add(make_gravity(bar.body, {0, 0, -9.81}));
    bar.model->add(make_mass_damping(bar.body, 3));
    const auto stepper = make_stepper({name});
    for (int step = 0; step < 3; ++step) stepper->advance(*bar.model, bar.state, 1e-3);
    const long before = allocations();
    for (int step = 0; step < 5; ++step) stepper->advance(*bar.model, bar.state, 1e-3);
    const long after = allocations();
    INFO(name);
    CHECK(after == before);
  }
}

TEST_CASE("a law that a stepper has no form for is refused by what it takes", "[steppers]") {
  const auto simulate = [](const std::string& strategy, const char* method) {
    SimulationOptions options;
    options.stepper.method = method;
    return Simulation(Bar(strategy).body, built_in_catalog().find(strategy),
                      Material{.youngs_modulus = 2e4, .poissons_ratio = 0.3}, options);
  };
  CHECK_THROWS_WITH(simulate("st_venant_kirchhoff", "xpbd"), Contains("xpbd") && Contains("neo_hookean"));
  CHECK_THROWS_WITH(simulate("van_gelder+volume", "block_descent"), Contains("block_descent") && Contains("+volume"));
  CHECK_NOTHROW(simulate("st_venant_kirchhoff", "block_descent"));
  CHECK_NOTHROW(simulate("van_gelder+volume", "projective"));
}
