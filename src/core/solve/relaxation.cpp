#include "core/solve/relaxation.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "core/parallel/parallel.h"
#include "core/solve/newton.h"
#include "core/solve/steppers.h"
#include "elastin/core/solve/integrator.h"
#include "elastin/core/solve/stable_step.h"

namespace elastin {
namespace {

constexpr int kExplicitSteps = 50000, kImplicitSteps = 400;
constexpr int kBetweenChecks = 50;  ///< explicit steps
constexpr double kStrictest = 1e-8;

double kinetic_energy(const Body& body, const Positions& velocities) {
  return ordered_sum(body.size(), [&](int i) { return 0.5 * body.mass[i] * velocities.col(i).squaredNorm(); });
}

/// Sets residual and reactions; returns whether the body rests.
bool note_balance(Model& model, const State& state, double tolerance, StaticResult& result) {
  Positions forces = model.elastic_forces(state.positions);
  const Positions loads = model.load_forces(state);
  forces += loads;
  result.reactions = -fixed_components(model.supports, forces);
  const double scale = ordered_norm(loads) + result.reactions.norm();
  keep_free(model.supports, forces);
  const double left = ordered_norm(forces);
  result.residual = scale > 0 ? left / scale : 0;
  return left <= std::max(tolerance * scale, 2 * rounding_floor(Tangent(model, state), state.positions));
}

void stop(const StepResult& step, StaticResult& result) {
  result.outcome = step.outcome;
  result.cause = step.cause;
}

void relax_explicitly(Model& model, State& state, const StaticOptions& options, double tolerance,
                      StaticResult& result) {
  const auto integrator = make_integrator({.scheme = "velocity_verlet"});
  double dt = 0, before = 0;
  for (int step = 0; step < kExplicitSteps; ++step) {
    if (step % kBetweenChecks == 0) {
      if (note_balance(model, state, tolerance, result) || is_interrupted(options, result)) return;
      dt = 1.8 / frequency_bound(model, state);  // 0.9 of 2/ω
      if (!std::isfinite(dt)) break;
    }
    const StepResult taken = integrator->advance(model, state, dt);
    ++result.newton_iterations;
    if (taken.outcome != Outcome::converged) return stop(taken, result);
    const double energy = kinetic_energy(model.body(), state.velocities);
    if (energy < before) state.velocities.setZero();
    before = energy < before ? 0 : energy;
  }
  result.outcome = Outcome::limit_reached;
  result.cause = "not at rest after " + std::to_string(kExplicitSteps) + " explicit steps";
}

void relax_implicitly(Model& model, State& state, const StaticOptions& options, double tolerance,
                      StaticResult& result) {
  IntegratorOptions steps{.scheme = "backward_euler"};
  steps.newton.newton_limit = 20;
  const auto integrator = make_integrator(steps);
  double dt = 100 / frequency_bound(model, state);
  StepResult taken;
  for (int step = 0; step < kImplicitSteps; ++step) {
    if (note_balance(model, state, tolerance, result) || is_interrupted(options, result)) return;
    if (!(std::isfinite(dt) && dt > 0)) break;
    taken = integrator->advance(model, state, dt);
    result.newton_iterations += taken.newton_iterations;
    result.linear_iterations += taken.linear_iterations;
    dt *= taken.outcome == Outcome::converged ? 2 : 0.25;
    state.velocities.setZero();
  }
  result.outcome = taken.outcome == Outcome::converged ? Outcome::limit_reached : taken.outcome;
  result.cause = "not at rest after " + std::to_string(kImplicitSteps) + " implicit steps";
  if (!taken.cause.empty()) result.cause += ": " + taken.cause;
}

}  // namespace

StaticResult relax(Model& model, State& state, const StaticOptions& options) {
  StaticResult result;
  const bool by_explicit = options.static_method == StaticMethod::explicit_steps;
  result.solver = by_explicit ? "explicit relaxation" : "implicit relaxation";
  state.velocities.setZero(3, state.positions.cols());
  apply_supports(model, state.positions);
  const double tolerance = std::max(options.tolerance, kStrictest);
  if (!model.admissible(state.positions)) {
    result.outcome = Outcome::inverted;
    result.cause = inverted_text(model.body(), state.positions) + " at the start";
    note_balance(model, state, tolerance, result);
    return result;
  }
  (by_explicit ? relax_explicitly : relax_implicitly)(model, state, options, tolerance, result);
  state.velocities.setZero();
  state.accelerations.resize(3, 0);
  return result;
}

}  // namespace elastin
