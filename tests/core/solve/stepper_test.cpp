#include "elastin/core/solve/stepper.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "core/solve/energies.h"
#include "core/solve/stable_step.h"
#include "core/solve/steppers.h"
#include "elastin/core/base/error.h"
#include "elastin/core/parallel/threads.h"
#include "elastin/core/simulation/catalog.h"
#include "support/bodies.h"

using namespace elastin;
using namespace elastin::testing;
using Catch::Matchers::Contains;

namespace {

const std::vector<StepperMethod> kSteppers{built_in_steppers().begin(), built_in_steppers().end()};

/// One molecule of 0.5 kg on a spring of 50 N/m and 1 m along x: ω = 10 rad/s.
struct Oscillator {
  Oscillator() {
    body = listed_body({{0, 0, 0}, {1, 0, 0}}, {{0, 1}});
    body.mass = VectorX::Constant(2, 0.5);
    body.radius = VectorX::Constant(2, 0.1);
    model = std::make_unique<Model>(body);
    model->add(make_springs(body, VectorX::Constant(1, 50)));
    model->supports.push_back({0, Matrix3::Zero()});
    state = state_at_rest(body);
  }
  Body body;
  std::unique_ptr<Model> model;
  State state;
};
constexpr double kOmega = 10;

void run(Model& model, State& state, const StepperOptions& options, double dt, int steps) {
  const auto stepper = make_stepper(options);
  for (int step = 0; step < steps; ++step) {
    const StepResult result = stepper->advance(model, state, dt);
    INFO("step " << step << ": " << result.cause);
    REQUIRE(result.outcome == Outcome::converged);
  }
}

/// Orders of the error after `time` as the step is halved, smallest of three.
template <class Make, class Error>
double measured_order(const StepperOptions& options, double time, int steps, Make make, Error error) {
  double last = 0, least = 99;
  for (int refinement = 0; refinement < 4; ++refinement, steps *= 2) {
    auto problem = make();
    run(*problem.model, problem.state, options, time / steps, steps);
    const double now = error(problem.state);
    if (refinement > 0) least = std::min(least, std::log2(last / now));
    last = now;
  }
  return least;
}

/// A free block of tetrahedra, bent, turning and flying.
struct Block {
  explicit Block(const std::string& law = "neo_hookean") : body(jittered_block()), model(body) {
    model.add(built_in_catalog().find(law).make(body, Material{.youngs_modulus = 2e4, .poissons_ratio = 0.3}, {}));
    state = state_at_rest(body);
    const Vector3 spin(3, -20, 5);
    for (int i = 0; i < body.size(); ++i) {
      const Vector3 position = body.rest.col(i);
      state.velocities.col(i) =
          Vector3(1, 0.5, -2) + spin.cross(position) + Vector3(0, 0, 400 * position.x() * position.x());
    }
  }
  Body body;
  Model model;
  State state;
};

}  // namespace

TEST_CASE("every stepper has the order that it declares", "[stepper]") {
  for (const StepperMethod& method : kSteppers) {
    // x(t) = 1 + 0.2 cos ω t, velocity too; after 1.3 s, no whole number of periods.
    const double time = 1.3;
    const double order = measured_order(
        {.method = method}, time, 400,
        [] {
          Oscillator oscillator;
          oscillator.state.positions(0, 1) = 1.2;
          return oscillator;
        },
        [&](const State& state) {
          return std::hypot(state.positions(0, 1) - 1 - 0.2 * std::cos(kOmega * time),
                            state.velocities(0, 1) / kOmega + 0.2 * std::sin(kOmega * time));
        });
    INFO(method->name << ": " << order);
    CHECK(order >= method->order - 0.1);
  }
}

TEST_CASE("damping does not cost order", "[stepper]") {
  for (const StepperMethod& method : kSteppers) {
    // b = 3 N s/m: δ = b/2m = 3 /s, ω_d = √(100 − 9).
    const double time = 0.7, delta = 3, omega = std::sqrt(91.);
    const double order = measured_order(
        {.method = method}, time, 200,
        [] {
          Oscillator oscillator;
          oscillator.model->add(make_damping(3));
          oscillator.state.positions(0, 1) = 1.2;
          return oscillator;
        },
        [&](const State& state) {
          const double decayed = 0.2 * std::exp(-delta * time);
          return std::abs(state.positions(0, 1) - 1 -
                          decayed * (std::cos(omega * time) + delta / omega * std::sin(omega * time)));
        });
    INFO(method->name << ": " << order);
    CHECK(order >= method->order - 0.1);
  }
}

TEST_CASE("energy stays bounded over 100 000 steps", "[stepper]") {
  const double start = 0.5 * 50 * 0.04;
  for (const StepperMethod method : {"symplectic_euler", "velocity_verlet", "newmark"}) {
    Oscillator oscillator;
    oscillator.state.positions(0, 1) = 1.2;
    const Ledger ledger(*oscillator.model, oscillator.state);
    const auto stepper = make_stepper({.method = method});
    double low = start, high = start, late = start;
    for (int step = 0; step < 100000; ++step) {
      REQUIRE(stepper->advance(*oscillator.model, oscillator.state, 0.02).outcome == Outcome::converged);
      const double energy = ledger.energies(*oscillator.model, oscillator.state).balance();
      low = std::min(low, energy), high = std::max(high, energy);
      if (step >= 90000) late = std::max(late, energy);
    }
    // ω dt = 0.2: the energy of Verlet swings by (ω dt)²/4, that of Euler by q/(1 − q), q = ω dt/2; Newmark's of a
    // linear spring not.
    const double swing = method == "symplectic_euler" ? 0.1 / 0.9 + 1e-6 : method == "velocity_verlet" ? 0.0102 : 1e-6;
    INFO(method->name << ": " << low / start - 1 << " … " << high / start - 1);
    CHECK(high <= start * (1 + swing));
    CHECK(low >= start * (1 - swing));
    CHECK(late <= start * (1 + swing));
  }
}

TEST_CASE("generalised alpha leaves of motions too fast for its steps what its spectral radius says", "[stepper]") {
  for (const double radius : {0., 0.6, 0.8, 0.95, 1.}) {
    Oscillator oscillator;
    oscillator.state.positions(0, 1) = 1.0001;
    const auto stepper = make_stepper({.method = "generalized_alpha", .parameters = {{"spectral_radius", radius}}});
    std::vector<double> left;  // √(x² + v²/ω²), over the first
    for (int step = 1; step <= 40; ++step) {
      REQUIRE(stepper->advance(*oscillator.model, oscillator.state, 100 / kOmega).outcome == Outcome::converged);
      left.push_back(std::hypot(oscillator.state.positions(0, 1) - 1, oscillator.state.velocities(0, 1) / kOmega) /
                     1e-4);
    }
    // At ω dt = 100 the roots of a step are nearly alike, so that some n radius^n is left after n steps.
    const double a_step = std::pow(left[39] / left[19], 1. / 20);
    INFO(radius << ": " << left[2] << ", " << left[19] << ", " << left[39] << ", " << a_step << " a step");
    if (radius == 0)
      CHECK(left[2] < 0.02);
    else if (radius == 1)
      CHECK(left[39] == Approx(1).epsilon(1e-6));
    else
      CHECK(a_step == Approx(radius).epsilon(0.08));
  }
}

TEST_CASE("generalised alpha meets prescribed motions at the end of its steps", "[stepper]") {
  for (const double radius : {0., 0.5, 1.}) {
    Oscillator oscillator;
    oscillator.model->drive = [](double time, std::vector<Support>& supports) {
      supports[0].displacement.x() = 0.1 * time * time;
      supports[0].velocity.x() = 0.2 * time;
    };
    const auto stepper = make_stepper({.method = "generalized_alpha", .parameters = {{"spectral_radius", radius}}});
    for (int step = 1; step <= 20; ++step) {
      REQUIRE(stepper->advance(*oscillator.model, oscillator.state, 0.05).outcome == Outcome::converged);
      const double time = 0.05 * step;
      CHECK(oscillator.state.positions(0, 0) == Approx(0.1 * time * time).margin(1e-14));
      CHECK(oscillator.state.velocities(0, 0) == Approx(0.2 * time));
      CHECK(oscillator.state.time == Approx(time));
    }
  }
}

TEST_CASE("backward Euler never gains energy, whatever the step", "[stepper][slow]") {
  for (const double dt : {1e-4, 1e-3, 0.01, 0.1, 1.}) {
    Block block;
    const Ledger ledger(block.model, block.state);
    const auto stepper = make_stepper({.method = "backward_euler"});
    double last = ledger.energies(block.model, block.state).balance();
    for (int step = 0; step < 20; ++step) {
      REQUIRE(stepper->advance(block.model, block.state, dt).outcome == Outcome::converged);
      const double now = ledger.energies(block.model, block.state).balance();
      REQUIRE(now <= last * (1 + 1e-9));
      last = now;
    }
  }
}

TEST_CASE("momentum is kept to rounding, angular momentum where the stepper can", "[stepper][slow]") {
  for (const StepperMethod& method : kSteppers) {
    Block block;
    block.model.add(make_cell_damping(block.body, 0.02, 0.01));
    const Ledger ledger(block.model, block.state);
    const Energies before = ledger.energies(block.model, block.state);
    const double dt = method->is_explicit ? 0.5 * find_stable_step(block.model, block.state).step : 1e-3;
    run(block.model, block.state, {.method = method}, dt, 200);
    const Energies after = ledger.energies(block.model, block.state);
    INFO(method->name);
    CHECK((after.momentum - before.momentum).norm() <= 1e-13 * before.momentum.norm());
    CHECK(after.kinetic + after.elastic != Approx(before.kinetic + before.elastic));  // something happened
    if (method == "symplectic_euler")
      CHECK((after.angular_momentum - before.angular_momentum).norm() <= 1e-11 * before.angular_momentum.norm());
  }
  // Without damping Verlet keeps it too.
  Block block;
  const Ledger ledger(block.model, block.state);
  const Vector3 before = ledger.energies(block.model, block.state).angular_momentum;
  run(block.model, block.state, {.method = "velocity_verlet"}, 0.5 * find_stable_step(block.model, block.state).step,
      200);
  CHECK((ledger.energies(block.model, block.state).angular_momentum - before).norm() <= 1e-12 * before.norm());
}

TEST_CASE("free fall strains nothing", "[stepper]") {
  for (const StepperMethod& method : kSteppers) {
    Block block;
    block.state = state_at_rest(block.body);
    block.model.add(make_gravity(block.body, {0, 0, -9.81}));
    const double dt = method->is_explicit ? 1e-4 : 0.01;
    run(block.model, block.state, {.method = method}, dt, 50);
    const Positions fall = block.state.positions - block.body.rest;
    const double apart = (fall.colwise() - Vector3(fall.col(0))).cwiseAbs().maxCoeff();
    INFO(method->name << ", out of shape by " << apart);
    CHECK(apart <= 5 * 50 * 2.2e-16 * std::abs(fall(2, 0)) + 1e-16);  // some roundings a step
    if (method->order == 2)                                           // exact for a constant acceleration
      CHECK(fall(2, 0) == Approx(-0.5 * 9.81 * std::pow(50 * dt, 2)).epsilon(1e-10));
  }
}

TEST_CASE("the account of a run: weight, damping and a moved support add up", "[stepper]") {
  // A shaken, damped oscillator under its weight: what is left of the balance goes down with the step squared.
  double last = 0;
  for (int refinement = 0; refinement < 3; ++refinement) {
    Oscillator oscillator;
    oscillator.model->add(make_damping(3));
    oscillator.model->add(make_stokes_drag(oscillator.body, 0.2));
    oscillator.model->add(make_gravity(oscillator.body, {9.81, 0, 0}));
    oscillator.model->drive = [](double time, std::vector<Support>& supports) {
      supports[0].displacement.x() = 0.05 * std::sin(7 * time);
      supports[0].velocity.x() = 0.35 * std::cos(7 * time);
    };
    const int steps = 200 << refinement;
    oscillator.state.velocities(0, 0) = 0.35;
    Ledger ledger(*oscillator.model, oscillator.state);
    const double before = ledger.energies(*oscillator.model, oscillator.state).balance();
    const auto stepper = make_stepper({.method = "velocity_verlet"});
    for (int step = 0; step < steps; ++step) {
      REQUIRE(stepper->advance(*oscillator.model, oscillator.state, 2. / steps).outcome == Outcome::converged);
      ledger.record(*oscillator.model, oscillator.state);
    }
    const Energies after = ledger.energies(*oscillator.model, oscillator.state);
    CHECK(after.dissipated > 0.01);
    CHECK(std::abs(after.work) > 0.01);
    const double off = std::abs(after.balance() - before);
    INFO("off " << off << " of " << after.dissipated << ", " << after.work);
    if (refinement > 0) CHECK(std::log2(last / off) >= 1.8);
    last = off;
  }
}

TEST_CASE("the stable step is that of the textbooks", "[stepper]") {
  // A free chain of n equal molecules: ω_max = 2 √(k/m) cos(π/2n).
  const int n = 12;
  std::vector<Vector3> positions;
  std::vector<std::array<int, 2>> pairs;
  for (int i = 0; i < n; ++i) positions.emplace_back(i, 0, 0);
  for (int i = 0; i + 1 < n; ++i) pairs.push_back({i, i + 1});
  Body body = listed_body(positions, pairs);
  body.mass = VectorX::Constant(n, 0.5);
  body.radius = VectorX::Constant(n, 0.1);
  Model model(body);
  model.add(make_springs(body, VectorX::Constant(n - 1, 200)));
  const State state = state_at_rest(body);
  StableStep stable = explained_stable_step(model, state);
  const double frequency = 2 * std::sqrt(200 / 0.5) * std::cos(std::numbers::pi / (2 * n));
  CHECK(stable.frequency == Approx(frequency).epsilon(1e-4));
  CHECK(stable.step == Approx(2 / frequency).epsilon(1e-4));
  CHECK(stable.bound == Approx(2 * std::sqrt(200 / 0.5)).epsilon(1e-12));  // inner molecules: 4 k/m
  CHECK(stable.bound >= stable.frequency);
  CHECK(stable.cell == -1);
  // One stiff connection sets it, and is named: two molecules on 100 k, ω² ≥ 2 · 100 k/m.
  VectorX constants = VectorX::Constant(n - 1, 200);
  constants[7] *= 100;
  Model uneven(body);
  uneven.add(make_springs(body, constants));
  stable = explained_stable_step(uneven, state);
  CHECK(stable.connection == 7);
  CHECK((stable.molecule == 7 || stable.molecule == 8));
  CHECK(stable.frequency >= std::sqrt(2 * 100 * 200 / 0.5));
  // A sliver among cells.
  Block block;
  block.body.rest.col(5) += 0.6 * (block.body.rest.col(6) - block.body.rest.col(5));
  const auto faults = flat_or_inverted_cells(block.body, block.body.rest);
  REQUIRE(faults.empty());
}

TEST_CASE("just below the stable step a run stays, just above it does not", "[stepper]") {
  for (const StepperMethod method : {"symplectic_euler", "velocity_verlet"})
    for (const double damping : {0., 0.5, 10., 100.})
      for (const double part : {0.98, 1.05, 1.5}) {
        Oscillator oscillator;
        if (damping > 0) oscillator.model->add(make_damping(damping));
        const double step = part * find_stable_step(*oscillator.model, oscillator.state).step;
        oscillator.state.positions(0, 1) = 1 + 1e-9;
        const auto stepper = make_stepper({.method = method});
        bool stays = true;
        for (int i = 0; i < 4000 && stays; ++i)
          stays = stepper->advance(*oscillator.model, oscillator.state, step).outcome == Outcome::converged &&
                  std::abs(oscillator.state.positions(0, 1) - 1) < 1e-6;
        INFO(method->name << ", b = " << damping << ", " << part << " of the stable step");
        if (part < 1) CHECK(stays);
        if (part > 1 && damping == 0) CHECK(!stays);
      }
}

namespace {

/// A spring of 150 N/m and a dashpot of a fifth of the critical damping on the second molecule, of 0.5 kg, that set in.
struct SetsIn final : Load {
  static constexpr double kStiffness = 150, kMass = 0.5, kRatio = 0.2;
  void add_forces(const State& state, Positions& forces) const override {
    const double damping = 2 * kRatio * std::sqrt(kStiffness * kMass);
    forces(0, 1) -= kStiffness * (state.positions(0, 1) - 1) + damping * state.velocities(0, 1);
  }
  bool changes() const override { return true; }
  bool resists() const override { return true; }
  double square_frequency(const State&, double) const override {
    return kStiffness / kMass * std::pow(std::sqrt(1 + kRatio * kRatio) + kRatio, 2);
  }
};

}  // namespace

TEST_CASE("a damped stiffness that sets in has its room next to a body that steps at its own limit", "[stepper]") {
  for (const StepperMethod method : {"symplectic_euler", "velocity_verlet"})
    for (const double damping : {0., 10.}) {
      Oscillator oscillator;
      if (damping > 0) oscillator.model->add(make_damping(damping));
      const StableStep own = find_stable_step(*oscillator.model, oscillator.state);
      oscillator.model->add(std::make_unique<SetsIn>());
      oscillator.state.positions(0, 1) = 1 + 1e-9;
      const auto stepper = make_stepper({.method = method});
      dynamic_cast<SharedStep&>(*stepper).set_own(own.frequency * own.frequency, own.damping_rate);
      INFO(method->name << ", b = " << damping);
      int substeps = 0;
      for (int step = 0; step < 2000; ++step) {
        const StepResult result = stepper->advance(*oscillator.model, oscillator.state, 0.98 * own.step);
        REQUIRE(result.outcome == Outcome::converged);
        REQUIRE(std::abs(oscillator.state.positions(0, 1) - 1) < 1e-8);
        substeps = result.substeps;
      }
      CHECK(substeps <= (damping > 0 ? 2 : 6));
      CHECK(std::abs(oscillator.state.positions(0, 1) - 1) < 1e-12);
    }
}

TEST_CASE("a step that cannot be taken leaves the state as it was, and says why", "[stepper]") {
  for (const StepperMethod& method : kSteppers) {
    Block block;
    block.state.velocities.col(3) = 1e160 * Vector3(1, 2, 3);
    const State before = block.state;
    const StepResult result = make_stepper({.method = method})->advance(block.model, block.state, 0.1);
    INFO(method->name);
    CHECK(result.outcome != Outcome::converged);
    CHECK(!result.cause.empty());
    CHECK((block.state.positions.array() == before.positions.array()).all());
    CHECK((block.state.velocities.array() == before.velocities.array()).all());
    CHECK(block.state.time == before.time);
  }
}

TEST_CASE("steps give bitwise identical results on any number of threads", "[stepper][slow]") {
  // 61 000 connections: enough for several threads.
  Body body = cubic_lattice({20, 20, 20}, 0.01, {true, true, false});
  add_jitter(body, 0.001, 3);
  set_matter(body, 0.005, 1000, 0, std::pow(0.19, 3));
  for (const StepperMethod& method : kSteppers) {
    State first;
    for (const int count : {1, 2, 3, 5}) {
      set_threads(count);
      Model model(body);
      model.add(make_springs(body, VectorX::Constant(body.connections.size(), 100)));
      model.add(make_damping(0.01));
      model.add(make_stokes_drag(body, 0.1));
      for (int i = 0; i < 20; ++i) model.supports.push_back({i, Matrix3::Zero()});
      State state = state_at_rest(body);
      state.positions = deformed(body, 1e-3);
      ParameterValues few;
      if (!method->effort.empty()) few[method->effort] = method->effort == "newton_iterations" ? 1 : 2;
      run(model, state, {.method = method, .parameters = few}, 1e-4, method->is_explicit ? 4 : 1);
      set_threads(0);
      if (count == 1) first = state;
      CHECK((state.positions.array() == first.positions.array()).all());
      CHECK((state.velocities.array() == first.velocities.array()).all());
    }
  }
}

TEST_CASE("steppers refuse parameters that make no stepper", "[stepper]") {
  const auto refusal = [](const StepperMethod& method, const ParameterValues& parameters) -> std::string {
    try {
      make_stepper({method, parameters});
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  CHECK_THAT(refusal("newmark", {{"beta", 0}}), Contains("newmark.beta: 0 is out of range: it must be above 0"));
  CHECK_THAT(refusal("newmark", {{"gamma", 0.4}}), Contains("at least 0.5 and at most 1"));
  CHECK_THAT(refusal("newmark", {{"newton_iterations", -1}}), Contains("whole, at least 0"));
  CHECK_THAT(refusal("backward_euler", {{"newton_iterations", 1.5}}), Contains("whole"));
  CHECK_THAT(refusal("newmark", {{"gama", 0.5}}), Contains("did you mean 'gamma'?"));
  CHECK_THAT(refusal("velocity_verlet", {{"beta", 0.25}}), Contains("takes no parameters"));
  CHECK_THROWS_AS(StepperMethod("newmrk"), InputError);
}
