#include "core/solve/implicit.h"

#include <cmath>
#include <utility>

#include "core/parallel/parallel.h"
#include "core/solve/explicit.h"
#include "core/solve/newton.h"
#include "elastin/core/base/error.h"

namespace elastin {
namespace {

/// A step that fails goes in halves, and those in halves, down to this part of it.
constexpr double kSmallestSubstep = 1. / 1024;

class Implicit final : public Integrator {
 public:
  explicit Implicit(const IntegratorOptions& options) : options_(options) {
    kinematics_.cut_short = options.newton_iterations > 0;
    if (kinematics_.cut_short) options_.newton.newton_limit = options.newton_iterations;
  }
  Scheme scheme() const override { return options_.scheme; }

  StepResult advance(Model& model, State& state, double dt) override {
    if (state.accelerations.cols() != state.positions.cols()) set_accelerations(model, state);
    before_ = state;
    StepResult result;
    result.substeps = 0;
    advance(model, state, dt, dt * kSmallestSubstep, result);
    if (result.outcome != Outcome::converged) {
      state = before_;
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

  void set_kinematics(const State& state, double dt) {
    const Positions &v = state.velocities, &a = state.accelerations;
    kinematics_.start = state.positions;
    if (options_.scheme == Scheme::backward_euler) {
      kinematics_.weights = {1 / dt, 1 / (dt * dt)};
      kinematics_.velocities.setZero(3, v.cols());
      kinematics_.accelerations = -v / dt;
      return;
    }
    const double beta = options_.beta, gamma = options_.gamma;
    kinematics_.weights = {gamma / (beta * dt), 1 / (beta * dt * dt)};
    kinematics_.velocities = v * (1 - gamma / beta) + a * (dt * (1 - gamma / (2 * beta)));
    kinematics_.accelerations = -v / (beta * dt) - a * (1 / (2 * beta) - 1);
  }

  /// Where Newton starts: as if nothing changed, if that turns no cell over; else from where the body is.
  void set_first_guess(const Model& model, const State& state, double dt, bool newmark) {
    next_.positions = state.positions + dt * state.velocities;
    next_.velocities = state.velocities;
    next_.time = state.time + dt;
    next_.contact_history = state.contact_history;
    if (newmark) {
      next_.positions += dt * dt / 2 * state.accelerations;
    } else {
      next_.accelerations.setZero(3, model.body().size());
      balance_as_one(model);
    }
    apply_supports(model, next_.positions);
    if (model.admissible(next_.positions)) return;
    next_.positions = state.positions;
    apply_supports(model, next_.positions);
  }

  /// The state stays if it fails; the result then says why.
  void try_step(Model& model, State& state, double dt, StepResult& result) {
    const bool newmark = options_.scheme == Scheme::newmark;
    if (model.drive) model.drive(state.time + dt, model.supports);
    set_kinematics(state, dt);
    set_first_guess(model, state, dt, newmark);
    const StaticResult solved = solve_newton(model, next_, options_.newton, &kinematics_, workspace_);
    result.newton_iterations += solved.newton_iterations;
    result.linear_iterations += solved.linear_iterations;
    const bool cut_short = kinematics_.cut_short && solved.outcome == Outcome::limit_reached;
    if ((solved.outcome != Outcome::converged && !cut_short) || !next_.positions.allFinite()) {
      result.outcome = solved.outcome == Outcome::converged ? Outcome::diverged : solved.outcome;
      result.cause = solved.cause;
      return;
    }
    balance_as_one(model);
    if (model.max_step_fraction(state, next_) < 1) {
      result.outcome = Outcome::limit_reached;
      result.cause = "something would be passed through within a step";
      return;
    }
    model.commit_step(next_);
    ++result.substeps;
    result.cause.clear();
    const double change = newmark ? largest_square(next_.accelerations - state.accelerations)  //
                                  : largest_square(next_.accelerations);
    // Newmark: [Zienkiewicz & Xie 1991]; Euler: half of dt² times the acceleration.
    const double factor = newmark ? std::max(std::abs(options_.beta - 1. / 6), 1. / 12) : 0.5;
    result.error = factor * dt * dt * std::sqrt(change);
    std::swap(state, next_);
  }

  template <class Vectors>
  static double largest_square(const Vectors& vectors) {
    return vectors.colwise().squaredNorm().maxCoeff();
  }

  /// What Newton leaves unbalanced of a free body's whole force would add up over the steps: the body moves as one to
  /// where it is not, which changes no length, so that momentum is kept to rounding.
  void balance_as_one(const Model& model) {
    if (!model.supports.empty()) return;
    model.set_forces(next_, forces_, workspace_.trials.force_pass);
    const double mass = model.body().mass.sum();
    const Vector3 needed = next_.accelerations * model.body().mass;
    const Vector3 missing = (forces_.rowwise().sum() - needed) / mass;
    const Weights& weights = kinematics_.weights;
    next_.accelerations.colwise() += missing;
    next_.velocities.colwise() += missing * (weights.velocity / weights.acceleration);
    next_.positions.colwise() += missing / weights.acceleration;
  }

  IntegratorOptions options_;
  // Kept from one step to the next, so that steps ask for no memory.
  State next_, before_;
  Kinematics kinematics_;
  Positions forces_;
  NewtonWorkspace workspace_;
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
