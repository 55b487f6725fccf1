#include "solve/implicit.h"

#include <cmath>
#include <utility>

#include "base/parallel.h"
#include "elastin/base/error.h"
#include "solve/explicit.h"
#include "solve/newton.h"

namespace elastin {
namespace {

/// A step that fails goes in halves, and those in halves, down to this part of it.
constexpr double kSmallestPart = 1. / 1024;

class Implicit final : public Integrator {
 public:
  explicit Implicit(const IntegratorOptions& options) : options_(options) {
    if (options.newton_iterations > 0) options_.newton.newton_limit = options.newton_iterations;
  }
  Scheme scheme() const override { return options_.scheme; }

  StepResult advance(Model& model, State& state, double dt) override {
    const State before = state;
    StepResult result;
    result.parts = 0;
    advance(model, state, dt, dt * kSmallestPart, result);
    if (result.outcome != Outcome::converged) {
      state = before;
      if (model.drive) model.drive(state.time, model.supports);
    }
    return result;
  }

 private:
  void advance(Model& model, State& state, double dt, double smallest, StepResult& result) {
    try_step(model, state, dt, result);
    if (result.outcome == Outcome::converged || dt / 2 < smallest) return;
    result.outcome = Outcome::converged;
    for (int half = 0; half < 2 && result.outcome == Outcome::converged; ++half)
      advance(model, state, dt / 2, smallest, result);
  }

  Kinematics kinematics_of(const State& state, double dt) const {
    const Positions& v = state.velocities;
    if (options_.scheme == Scheme::backward_euler)
      return {{1 / dt, 1 / (dt * dt)}, state.positions, Positions::Zero(3, v.cols()), -v / dt};
    const Positions& a = state.accelerations;
    const double beta = options_.beta, gamma = options_.gamma;
    return {{gamma / (beta * dt), 1 / (beta * dt * dt)},
            state.positions,
            v * (1 - gamma / beta) + a * (dt * (1 - gamma / (2 * beta))),
            -v / (beta * dt) - a * (1 / (2 * beta) - 1)};
  }

  /// Where Newton starts: as if nothing changed, if that turns no cell over; else from where the body is.
  static State first_guess(const Model& model, const Kinematics& kinematics, const State& state, double dt,
                           bool newmark) {
    State guess{state.positions + dt * state.velocities, state.velocities, state.time + dt, {}, state.touches};
    if (newmark) {
      guess.positions += dt * dt / 2 * state.accelerations;
    } else {
      guess.accelerations = Positions::Zero(3, model.body().size());
      balance_as_one(model, kinematics, guess);
    }
    place_supports(model, guess.positions);
    if (model.admissible(guess.positions)) return guess;
    guess.positions = state.positions;
    place_supports(model, guess.positions);
    return guess;
  }

  /// The state stays if it fails; the result then says why.
  void try_step(Model& model, State& state, double dt, StepResult& result) {
    const bool newmark = options_.scheme == Scheme::newmark;
    if (newmark && state.accelerations.cols() != state.positions.cols()) set_accelerations(model, state);
    if (model.drive) model.drive(state.time + dt, model.supports);
    const Kinematics kinematics = kinematics_of(state, dt);
    State next = first_guess(model, kinematics, state, dt, newmark);
    const StaticResult solved = solve_newton(model, next, options_.newton, &kinematics);
    result.newton_iterations += solved.newton_iterations;
    result.linear_iterations += solved.linear_iterations;
    const bool cut_short = options_.newton_iterations > 0 && solved.outcome == Outcome::limit_reached;
    if ((solved.outcome != Outcome::converged && !cut_short) || !next.positions.allFinite()) {
      result.outcome = solved.outcome == Outcome::converged ? Outcome::diverged : solved.outcome;
      result.cause = solved.cause;
      return;
    }
    balance_as_one(model, kinematics, next);
    if (model.free_way(state, next) < 1) {
      result.outcome = Outcome::limit_reached;
      result.cause = "something would be passed through within a step";
      return;
    }
    model.remember(next);
    ++result.parts;
    result.cause.clear();
    const Positions change =
        newmark ? Positions(next.accelerations - state.accelerations) : Positions(next.accelerations);
    // Newmark: [Zienkiewicz & Xie 1991]; Euler: half of dt² times the acceleration.
    const double factor = newmark ? std::max(std::abs(options_.beta - 1. / 6), 1. / 12) : 0.5;
    result.error = factor * dt * dt * std::sqrt(change.colwise().squaredNorm().maxCoeff());
    state = std::move(next);
  }

  /// What Newton leaves unbalanced of a free body's whole force would add up over the steps: the body moves as one to
  /// where it is not, which changes no length, so that momentum is kept to rounding.
  static void balance_as_one(const Model& model, const Kinematics& kinematics, State& state) {
    if (!model.supports.empty()) return;
    Positions forces;
    model.set_forces(state, forces);
    const double mass = model.body().mass.sum();
    const Vector3 needed = state.accelerations * model.body().mass;
    const Vector3 missing = (forces.rowwise().sum() - needed) / mass;
    state.accelerations.colwise() += missing;
    state.velocities.colwise() += missing * (kinematics.weights.velocity / kinematics.weights.acceleration);
    state.positions.colwise() += missing / kinematics.weights.acceleration;
  }

  IntegratorOptions options_;
};

}  // namespace

std::unique_ptr<Integrator> make_implicit(const IntegratorOptions& options) {
  return std::make_unique<Implicit>(options);
}

const char* name_of(Scheme scheme) {
  switch (scheme) {
    case Scheme::symplectic_euler:
      return "symplectic_euler";
    case Scheme::velocity_verlet:
      return "velocity_verlet";
    case Scheme::backward_euler:
      return "backward_euler";
    case Scheme::newmark:
      return "newmark";
  }
  return "";
}

bool is_explicit(Scheme scheme) { return scheme == Scheme::symplectic_euler || scheme == Scheme::velocity_verlet; }

std::unique_ptr<Integrator> make_integrator(const IntegratorOptions& options) {
  if (is_explicit(options.scheme)) return make_explicit(options.scheme);
  if (!(options.beta > 0 && options.beta <= 1)) throw InputError("newmark's beta must be above 0 and at most 1");
  if (!(options.gamma >= 0.5 && options.gamma <= 1)) throw InputError("newmark's gamma must be from 0.5 to 1");
  if (options.newton_iterations < 0) throw InputError("newton_iterations must not be negative");
  return make_implicit(options);
}

}  // namespace elastin
