// Relaxing springs and cells against closed forms of the generalised Maxwell model.

#include "elastin/core/forces/prony.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/solve/stable_step.h"
#include "elastin/core/base/error.h"
#include "elastin/core/forces/tangent.h"
#include "elastin/core/shapes/shapes.h"
#include "elastin/core/simulation/simulation.h"
#include "support/bodies.h"
#include "support/slopes.h"

using namespace elastin;
using namespace elastin::testing;

namespace {

const Relaxation kTwoTerms{{{0.5, 0.2}, {0.3, 3}}};

/// G of a relaxation at a time, and its integral: the answer to a ramp of slope 1 that ends at `end`.
double answer_to_ramp(const Relaxation& relaxation, double time, double end) {
  double sum = relaxation.long_term() * std::min(time, end);
  for (const auto& [g, tau] : relaxation.terms)
    sum += g * tau * (std::exp(-std::max(time - end, 0.) / tau) - std::exp(-time / tau));
  return sum;
}

/// Two molecules and a spring; positions are prescribed, and steps committed as steppers do.
struct Pair {
  Body body;
  std::unique_ptr<Model> model;
  State state;

  explicit Pair(const Relaxation& relaxation) : body(cubic_lattice({1, 1, 2}, 1, {true, false, false})) {
    set_matter(body, 0.1, 1000, 0, 0);
    model = std::make_unique<Model>(body);
    model->add(make_prony(body, make_springs(body, VectorX::Constant(1, 100)), relaxation));
    state = state_at_rest(body);
    model->declare_history(state);
    model->commit_step(state);
  }
  void step(double time, double length) {
    model->begin_step(state, time);
    state.positions(2, 1) = state.positions(2, 0) + length;
    state.time = time;
    model->commit_step(state);
  }
  /// q = k (1 − L/l) relaxed [N/m].
  double force_density() const { return model->force_densities(state.positions)[0]; }
};

}  // namespace

TEST_CASE("a relaxing spring in a ramp of its force density and after it", "[prony]") {
  // qᵉ = 100 (1 − 1/l) = 10 t up to t = 1: linear over each step, of any length.
  for (const bool instantaneous : {false, true}) {
    Relaxation relaxation = kTwoTerms;
    relaxation.instantaneous = instantaneous;
    Pair pair(relaxation);
    const auto length = [](double time) { return 1 / (1 - 0.1 * std::min(time, 1.)); };
    for (const double time : {0.05, 0.3, 0.31, 0.9, 1., 1.02, 1.5, 4., 20.}) {
      pair.step(time, length(time));
      CHECK(pair.force_density() == Approx(10 * answer_to_ramp(relaxation, time, 1)).epsilon(1e-12));
    }
  }
}

TEST_CASE("what a relaxing spring has stored, and what it has taken", "[prony][energy]") {
  Pair pair(kTwoTerms);
  double work = 0, density = 0, square = 1, dissipated = 0;
  const auto go = [&](double until, int steps, const auto& length) {
    for (double from = pair.state.time, i = 1; i <= steps; ++i) {
      const double time = from + (until - from) * i / steps, l = length(time);
      pair.step(time, l);
      work += (density + pair.force_density()) / 2 * (l * l - square) / 2;
      density = pair.force_density(), square = l * l;
      const double now = work - pair.model->stored_energy(pair.state.positions);
      CHECK(now > dissipated - 1e-3 * work);
      dissipated = now;
    }
  };
  const double elastic = 100 * 0.05 * 0.05 / 2;
  go(0.001, 500, [](double t) { return 1 + 50 * t; });  // at once
  CHECK(pair.model->stored_energy(pair.state.positions) == Approx(1.8 * elastic).epsilon(5e-3));
  CHECK(work == Approx(1.8 * elastic).epsilon(5e-3));
  go(60, 3000, [](double) { return 1.05; });  // and held
  CHECK(pair.model->stored_energy(pair.state.positions) == Approx(elastic).epsilon(1e-6));
  CHECK(dissipated == Approx(0.8 * elastic).epsilon(0.01));
  go(64, 2000, [](double t) { return 1 + 0.05 * std::cos(3 * (t - 60)); });
  CHECK(dissipated > 2 * elastic);
}

TEST_CASE("where the strain is not linear in time relaxation is of order 2", "[prony]") {
  // qᵉ = 10 sin t; exactly: the integral of G(t − s) 10 cos s.
  const double end = 2;
  double exact = 10 * std::sin(end);
  for (const auto& [g, tau] : kTwoTerms.terms)
    exact += 10 * g * tau / (1 + tau * tau) * (std::cos(end) + tau * std::sin(end) - std::exp(-end / tau));
  std::vector<double> errors;
  for (const int steps : {20, 40, 80}) {
    Pair pair(kTwoTerms);
    for (int i = 1; i <= steps; ++i) pair.step(end * i / steps, 1 / (1 - 0.1 * std::sin(end * i / steps)));
    errors.push_back(std::abs(pair.force_density() - exact));
  }
  CHECK(errors[0] / errors[1] == Approx(4).epsilon(0.05));
  CHECK(errors[1] / errors[2] == Approx(4).epsilon(0.05));
}

TEST_CASE("cyclic strain: storage and loss modulus of the generalised Maxwell model", "[prony]") {
  for (const double omega : {0.3, 2., 20.}) {
    double storage = 1, loss = 0;
    for (const auto& [g, tau] : kTwoTerms.terms) {
      const double x = omega * tau;
      storage += g * x * x / (1 + x * x), loss += g * x / (1 + x * x);
    }
    Pair pair(kTwoTerms);
    const int per_cycle = 400;
    const int cycles = 2 + static_cast<int>(8 * 3 * omega / 6.28);  // until the start is forgotten
    double in_phase = 0, out_of_phase = 0;
    for (int i = 1; i <= per_cycle * cycles; ++i) {
      const double phase = 6.283185307179586 * i / per_cycle;
      pair.step(phase / omega, 1 / (1 - 0.1 * std::sin(phase)));
      if (i <= per_cycle * (cycles - 1)) continue;
      in_phase += pair.force_density() * std::sin(phase) * 2 / per_cycle / 10;
      out_of_phase += pair.force_density() * std::cos(phase) * 2 / per_cycle / 10;
    }
    INFO("omega " << omega);
    CHECK(in_phase == Approx(storage).epsilon(1e-3));
    CHECK(out_of_phase == Approx(loss).epsilon(1e-3));
  }
}

TEST_CASE("a relaxing body: forces are those of its energy within a step, and so is the tangent", "[prony]") {
  const Material material{.youngs_modulus = 2e4, .poissons_ratio = 0.3, .thickness = 0.001, .relaxation = kTwoTerms};
  const Catalog catalog = built_in_catalog();
  for (const char* name : {"prony:lattice", "prony:neo_hookean", "prony:st_venant_kirchhoff"}) {
    INFO(name);
    const Body body = std::string(name) == "prony:lattice" ? jittered_lattice() : jittered_block();
    const Strategy strategy = catalog.find(name);
    Model model(body);
    model.add(strategy.make(body, material, {}));
    State state = state_at_rest(body);
    model.declare_history(state);
    model.commit_step(state);
    model.begin_step(state, 0.4);
    state.positions = deformed(body, 1e-4), state.time = 0.4;
    model.commit_step(state);
    model.begin_step(state, 0.5);
    check_slopes(model, deformed(body, 2e-4), random_motion(body, 21));
  }
}

TEST_CASE("springs and a solid relax alike, and statics sees what is left in the end", "[prony]") {
  // Both bodies held at a strain: force over the elastic one is G(t), whatever the law.
  Material material{.youngs_modulus = 2e4, .poissons_ratio = 0.25, .relaxation = kTwoTerms};
  const Catalog catalog = built_in_catalog();
  for (const char* name : {"lattice", "neo_hookean"}) {
    INFO(name);
    const Body body = std::string(name) == "lattice" ? jittered_lattice() : jittered_block();
    Model relaxing(body), elastic(body);
    relaxing.add(catalog.find("prony:" + std::string(name)).make(body, material, {}));
    elastic.add(catalog.find(name).make(body, material, {}));
    State state = state_at_rest(body);
    relaxing.declare_history(state);
    relaxing.commit_step(state);
    const Positions held = deformed(body, 2e-4), full = elastic.elastic_forces(held);
    state.positions = held;
    for (const double time : {1e-12, 0.1, 0.5, 2., 30.}) {
      relaxing.begin_step(state, time);
      state.time = time;
      double G = 1;
      for (const auto& [g, tau] : kTwoTerms.terms) G += g * std::exp(-time / tau);
      CHECK((relaxing.elastic_forces(held) - G * full).norm() <= 1e-9 * full.norm());
      relaxing.commit_step(state);
      CHECK((relaxing.elastic_forces(held) - G * full).norm() <= 1e-9 * full.norm());
    }
    relaxing.begin_step(state, std::numeric_limits<double>::infinity());
    CHECK((relaxing.elastic_forces(held) - full).norm() <= 1e-13 * full.norm());
  }
}

TEST_CASE("cells of every shape in a ramp of their stress and after it", "[prony][cells]") {
  // neo_hookean_log with nu = 0, pulled along z: S = mu (1 - 1/l^2), made to grow linearly; the force is S l A.
  const double mu = 1e4, slope = 0.5;
  const Vector3 size(0.01, 0.01, 0.02);
  Material material{.youngs_modulus = 2 * mu, .poissons_ratio = 0, .relaxation = kTwoTerms};
  material.law = LawConstants{.law = "neo_hookean_log"};
  const auto stretch = [&](double time) { return 1 / std::sqrt(1 - slope * std::min(time, 1.)); };
  for (const CellKind& kind : cell_kinds()) {
    if (kind.dimensions != 3) continue;
    for (const char* name : {"prony:neo_hookean_log", "prony:neo_hookean+volume"}) {
      const bool log = std::string(name) == "prony:neo_hookean_log";
      INFO(kind.name << ' ' << name);
      const Body body = cell_box(kind, {1, 1, 2}, size, 0);
      if (!built_in_catalog().find(name).unsuited(body).empty()) continue;
      Model relaxing(body), elastic(body);
      relaxing.add(built_in_catalog().find(name).make(body, material, {}));
      elastic.add(built_in_catalog().find(name + 6).make(body, material, {}));
      State state = state_at_rest(body);
      relaxing.declare_history(state);
      relaxing.commit_step(state);
      for (const double time : {0.05, 0.3, 0.31, 0.9, 1., 1.02, 1.5, 4., 20.}) {
        relaxing.begin_step(state, time);
        state.positions = body.rest;
        if (log)
          state.positions.row(2) *= stretch(time);
        else
          state.positions = (1 + 1e-9 * std::min(time, 1.)) * body.rest;  // linear
        state.time = time;
        const Positions before = relaxing.elastic_forces(state.positions);
        relaxing.commit_step(state);
        const Positions forces = relaxing.elastic_forces(state.positions),
                        whole = elastic.elastic_forces(state.positions);
        const double ratio = answer_to_ramp(kTwoTerms, time, 1) / std::min(time, 1.);
        CHECK((forces - before).norm() <= 1e-12 * whole.norm());
        CHECK((forces - ratio * whole).norm() <= (log ? 1e-10 : 1e-6) * whole.norm());
        if (!log) continue;
        double end = 0;
        for (int a = 0; a < body.size(); ++a)
          if (body.rest(2, a) < 1e-9) end += forces(2, a);
        const double S = mu * slope * answer_to_ramp(kTwoTerms, time, 1);
        CHECK(end == Approx(S * stretch(time) * size[0] * size[1]).epsilon(1e-10));
      }
    }
  }
}

TEST_CASE("a dashpot parallel to the law: Kelvin and Voigt", "[prony]") {
  Relaxation dashpot;
  dashpot.retardation = 0.3;
  Pair pair(dashpot);
  for (const double time : {0.05, 0.3, 0.9, 1.}) {  // q = 10 t and its slope 10 at all times of the ramp
    pair.step(time, 1 / (1 - 0.1 * time));
    CHECK(pair.force_density() == Approx(10 * time + 3).epsilon(1e-12));
  }
  pair.step(1.5, 1 / 0.9);
  CHECK(pair.force_density() == Approx(10).epsilon(1e-12));
  pair.model->begin_step(pair.state, std::numeric_limits<double>::infinity());
  CHECK(pair.force_density() == Approx(10).epsilon(1e-12));
}

TEST_CASE("a relaxing oscillator steps alike with every stepper", "[prony]") {
  // A mass on a standard linear solid: m x‴ + … = 0; here the steppers against each other and a fine one.
  const auto after = [](const char* method, double dt) {
    Body body = cubic_lattice({1, 1, 2}, 1, {true, false, false});
    set_matter(body, 0.1, 1000, 0, 0);
    body.mass.setConstant(1);
    SimulationOptions options;
    options.stepper.method = method;
    const Catalog catalog = built_in_catalog();
    const Material material{.youngs_modulus = 100, .relaxation = Relaxation{{{0.8, 0.1}}}};
    Simulation simulation(std::move(body), catalog.find("prony:uniform"), material, options);
    simulation.fix(0);
    simulation.add_load(*built_in_loads().find("gravity"), {.vectors = {{"acceleration", Vector3(0, 0, 3)}}});
    for (int i = 0; i < static_cast<int>(std::lround(0.5 / dt)); ++i)
      REQUIRE(simulation.step(dt).outcome == Outcome::converged);
    return simulation.positions()(2, 1) - 1;
  };
  const double fine = after("newmark", 1e-4);
  CHECK(std::abs(fine) > 1e-4);
  CHECK(after("velocity_verlet", 1e-4) == Approx(fine).epsilon(1e-3));
  CHECK(after("symplectic_euler", 1e-4) == Approx(fine).epsilon(1e-2));
  CHECK(after("backward_euler", 1e-4) == Approx(fine).epsilon(1e-2));
}

TEST_CASE("relaxation that cannot be is refused", "[prony]") {
  const Body body = jittered_lattice();
  const auto make = [&](const Relaxation& relaxation) {
    return make_prony(body, make_springs(body, VectorX::Ones(body.connections.size())), relaxation);
  };
  CHECK_THROWS_WITH(make({}), Catch::Contains("at least one term"));
  CHECK_THROWS_WITH(make({{}, false, -1}), Catch::Contains("below 0"));
  CHECK_THROWS_WITH(make({{{0.5, 0}}}), Catch::Contains("above 0"));
  CHECK_THROWS_WITH(make({{{-0.5, 1}}}), Catch::Contains("above 0"));
  CHECK_THROWS_WITH(make({{{0.5, 1}, {0.5, 2}}, true}), Catch::Contains("sum to 1"));
  const Catalog catalog = built_in_catalog();
  CHECK_THROWS_WITH(catalog.find("prony:prony:lattice"), Catch::Contains("'prony:' is repeated or misplaced"));
  CHECK_THROWS_WITH(catalog.find("calibrated:prony:lattice"), Catch::Contains("prony:mullins:calibrated:"));
  CHECK_THROWS_WITH(catalog.find("pruny:lattice"), Catch::Contains("did you mean 'prony:'"));
  CHECK_THROWS_WITH(catalog.find("prony"), Catch::Contains("prony:lattice"));
  CHECK(catalog.find("prony:lattice").unsuited_material(Material{}) == "needs `relaxation` in the material");
}

TEST_CASE("explicit steps are as long as the instantaneous stiffness and the dashpot allow", "[prony]") {
  // Two molecules: ω² = 2 k G(0)/m, of the dashpot c = 2 θ k/m.
  for (const double retardation : {0., 0.05}) {
    Relaxation relaxation = kTwoTerms;
    relaxation.retardation = retardation;
    Pair pair(relaxation);
    pair.body.mass.setConstant(0.2);
    const double unit = 2 * 100 / pair.body.mass[0], w = std::sqrt(1.8 * unit), c = retardation * unit;
    for (const auto& find : {find_stable_step, bounded_stable_step})
      for (const State& state : {state_at_rest(pair.body), pair.state}) {
        const StableStep found = find(*pair.model, state);
        CHECK(found.frequency == Approx(w).epsilon(1e-9));
        CHECK(found.damping_rate == Approx(c).epsilon(1e-6).margin(1e-9 * w));
        CHECK(found.step == Approx(2 / (std::sqrt(w * w + c * c) + c)).epsilon(1e-6));
      }
  }
}

TEST_CASE("a relaxing body that was pushed stays whole in explicit steps of any stepper", "[prony][slow]") {
  for (const double retardation : {0., 1e-3})
    for (const char* name : {"prony:lattice", "prony:neo_hookean"})
      for (const char* method : {"symplectic_euler", "velocity_verlet"}) {
        INFO(name << " by " << method << ", " << retardation << " s");
        Body body = std::string(name) == "prony:lattice" ? jittered_lattice() : jittered_block();
        Simulation tissue(
            body, built_in_catalog().find(name),
            {.youngs_modulus = 2e4, .poissons_ratio = 0.3, .relaxation = Relaxation{{{3, 1}}, false, retardation}},
            {.stepper = {std::string(method)}});
        tissue.set_velocities(0.05 * random_motion(body, 7));
        int substeps = 0;
        for (int step = 0; step < 300; ++step) {
          const StepResult result = tissue.step(1e-2);
          INFO(result.cause);
          REQUIRE(result.outcome == Outcome::converged);
          substeps += result.substeps;
        }
        CHECK(substeps > 1000);
        for (int c = 0; c < body.connections.size(); ++c) {
          const auto& [a, b] = body.connections.ends[c];
          const double rest = body.connections.rest_length[c];
          CHECK((tissue.positions().col(b) - tissue.positions().col(a)).norm() == Approx(rest).margin(0.1 * rest));
        }
      }
}
