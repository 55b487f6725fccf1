#include "elastin/core/solve/statics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "core/base/dense.h"
#include "core/parallel/parallel.h"
#include "core/solve/modes.h"
#include "core/solve/newton.h"
#include "core/solve/responses.h"
#include "core/solve/stable_step.h"
#include "core/solve/steppers.h"
#include "core/solve/trial.h"
#include "elastin/core/solve/engine.h"
#include "elastin/core/solve/stepper.h"

namespace elastin {
namespace {

State still_at(const Model& model, const Positions& positions) {
  return {positions, model.feels_velocity() ? Positions(Positions::Zero(3, positions.cols())) : Positions()};
}

constexpr double kStretched = 1e-3;
/// Of the reactions, what an answer may leave, and what is required of the next one.
constexpr double kMostLeft = 0.1, kLeft = 0.01;
/// Of what the answer before left, the least that is required: a rigid motion has no reactions.
constexpr double kLeastLeft = 1e-4;
constexpr int kRefined = 3;  ///< times, at most

/// The answer to moved supports. It is sought to a part of what the torn first layer resists, which near ν = ½ is some
/// thousand times the force of the stretched body, with pressures to match: refined until little of that force is left.
StaticResponse stretched(Model& model, const Positions& at, const Positions& displacement,
                         const StaticOptions& options) {
  const Positions none = Positions::Zero(3, displacement.cols());
  StaticOptions rough = options;
  rough.tolerance = kStretched;
  if (options.engine) return static_response(model, at, none, displacement, rough);
  const State state = still_at(model, at);
  Responses responses(model, state, rough);
  StaticResponse response = responses.to(none, displacement, kStretched);
  Positions left(3, displacement.cols());
  for (int round = 0; round < kRefined; ++round) {
    const StaticResult& result = response.result;
    const double part = result.residual * result.scale / result.reactions.norm();
    if (result.outcome != Outcome::converged || result.unstable || !(part > kMostLeft)) break;
    responses.tangent().apply(response.motion, left);
    StaticResponse more = responses.to(-left, none, std::max(kLeft / part, kLeastLeft));
    more.motion += response.motion;
    more.result.linear_iterations += result.linear_iterations;
    response = std::move(more);
  }
  return response;
}

/// Takes out of the answer to supports that move within the plane of a flat body what leads out of it: rounding.
void stay_in_plane(const Model& model, const Positions& at, const Positions& displacement, Positions& motion) {
  constexpr double rounding = 1e-9;
  const Vector3 normal = model.body().share ? Vector3(Vector3::Zero()) : plane_normal(model.body());
  const auto& loads = model.loads();
  if (normal.isZero(0) || std::any_of(loads.begin(), loads.end(), [](const auto& load) { return load->changes(); }))
    return;
  const Positions about = at.colwise() - at.rowwise().mean();
  for (const Positions* vectors : {&about, &displacement})
    if (!((normal.transpose() * *vectors).norm() <= rounding * vectors->norm())) return;
  motion -= normal * (normal.transpose() * motion).eval();
}

/// The body stretched with the mean motion that moved supports impose is a far better start than a torn first layer:
/// one linear solve about the present state, with the supports' displacement as its only load. Returns that state, if
/// there is such a displacement.
std::optional<State> follow_supports(Model& model, State& state, const StaticOptions& options, StaticResult& result,
                                     LastSolve* last) {
  Positions moved = state.positions;
  apply_supports(model, moved);
  const Positions displacement = moved - state.positions;
  if (!any_over(model.body(), displacement.cwiseAbs().maxCoeff() != 0)) return {};
  StaticResponse response = stretched(model, state.positions, displacement, options);
  stay_in_plane(model, state.positions, displacement, response.motion);
  result.linear_iterations += response.result.linear_iterations;
  if (last) last->note(response.motion, model.supports);
  const Positions positions = state.positions + response.motion;
  const bool usable =
      !any_over(model.body(), !response.motion.allFinite() || !std::isfinite(model.elastic_energy(positions)));
  std::optional<State> before = state;
  state.positions = usable ? positions : moved;
  if (!usable) before.reset();
  return before;
}

constexpr int kExplicitSteps = 50000, kImplicitSteps = 400;
constexpr int kBetweenChecks = 50;  ///< explicit steps
constexpr double kStrictest = 1e-8;
constexpr double kLeastSolved = 0.5;  ///< of what a first answer leaves, to find out whether it can be

double kinetic_energy(const Body& body, const Positions& velocities) {
  return ordered_sum(body.size(), [&](int i) { return 0.5 * body.mass[i] * velocities.col(i).squaredNorm(); });
}

/// Sets residual and reactions; returns whether the body rests.
bool note_balance(Model& model, const State& state, double tolerance, StaticResult& result) {
  Positions forces = model.elastic_forces(state.positions);
  const Positions loads = model.load_forces(state);
  forces += loads;
  result.reactions = -fixed_components(model.supports, forces);
  VectorX force_densities;
  Workspace workspace;
  const double root = std::sqrt(static_cast<double>(model.body().size()));
  const double scale = scale_of(ordered_norm(loads) + result.reactions.norm() + model.rest_force(),
                                internal_force(model, state.positions, force_densities, workspace) / root);
  keep_free(model.supports, forces);
  const double left = ordered_norm(forces);
  result.residual = scale > 0 ? left / scale : 0;
  result.scale = scale;
  return left <= std::max(tolerance * scale, 2 * rounding_floor(Tangent(model, state), state.positions));
}

void stop(const StepResult& step, StaticResult& result) {
  result.outcome = step.outcome;
  result.cause = step.cause;
}

void relax_explicitly(Model& model, State& state, const StaticOptions& options, double tolerance,
                      StaticResult& result) {
  const auto stepper = make_stepper({.method = "velocity_verlet"});
  double dt = 0, before = 0;
  for (int step = 0; step < kExplicitSteps; ++step) {
    if (step % kBetweenChecks == 0) {
      if (note_balance(model, state, tolerance, result) || is_interrupted(options, result)) return;
      dt = 1.8 / frequency_bound(model, state);  // 0.9 of 2/ω
      if (!std::isfinite(dt)) break;
    }
    const StepResult taken = stepper->advance(model, state, dt);
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
  StepperOptions steps{.method = "backward_euler"};
  steps.newton.newton_limit = 20;
  const auto stepper = make_stepper(steps);
  double dt = 100 / frequency_bound(model, state);
  StepResult taken;
  const auto [low, high] = outline_of_whole(model.body());
  const double far = 10 * (high - low).norm();
  const Positions start = state.positions;
  for (int step = 0; step < kImplicitSteps; ++step) {
    if (note_balance(model, state, tolerance, result) || is_interrupted(options, result)) return;
    if (!(std::isfinite(dt) && dt > 0)) break;
    if (any_over(model.body(), !((state.positions - start).cwiseAbs().maxCoeff() <= far))) {
      result.outcome = Outcome::limit_reached;
      result.cause = "not at rest after it has moved by ten times its size";
      return;
    }
    taken = stepper->advance(model, state, dt);
    result.newton_iterations += taken.newton_iterations;
    result.linear_iterations += taken.linear_iterations;
    dt *= taken.outcome == Outcome::converged ? 2 : 0.25;
    state.velocities.setZero();
  }
  result.outcome = taken.outcome == Outcome::converged ? Outcome::limit_reached : taken.outcome;
  result.cause = "not at rest after " + std::to_string(kImplicitSteps) + " implicit steps";
  if (!taken.cause.empty()) result.cause += ": " + taken.cause;
}

/// The equilibrium found by stepping through time until the body rests; it never needs a stiffness matrix to be
/// regular, nor a start near the answer.
///   * explicit: velocity Verlet at 0.9 of the step that the row sums of M⁻¹ K allow; all velocities are set to zero
///     where the kinetic energy peaks. [Day 1965, Cundall 1976]
///   * implicit: backward Euler from rest every time, the step doubled where it succeeds and quartered where it fails:
///     Newton's way, held back by inertia. [Kelley & Keyes 1998]
/// Ends at the unbalanced force of the options, or at 1e-8 of the loads if that is less strict; `limit_reached` if
/// that takes too many steps. The state stays where it got to. Never throws on numerical trouble.
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

/// static_response, which leaves its solver and its motion to `last`, unless null.
StaticResponse respond(Model& model, const Positions& at, const Positions& load_change, const Positions& displacement,
                       const StaticOptions& options, LastSolve* last) {
  if (options.engine) return options.engine->respond(model, at, load_change, displacement, options);
  const State state = still_at(model, at);
  Responses responses(model, state, options);
  StaticResponse response = responses.to(load_change, displacement, options.tolerance);
  if (last) {
    last->solver = responses.take_solver();
    last->note(response.motion, model.supports);
  }
  return response;
}

StaticResult solve_linear_statics(Model& model, State& state, const StaticOptions& options, LastSolve* last) {
  const State rest = state_at_rest(model.body());
  Positions displacement = rest.positions;
  apply_supports(model, displacement);
  displacement -= rest.positions;
  Positions elastic = model.elastic_forces(rest.positions);
  if (model.body().share) options.engine->complete(model, elastic);
  StaticResponse response =
      respond(model, rest.positions, model.load_forces(rest) + elastic, displacement, options, last);
  if (response.result.outcome == Outcome::converged) state.positions = rest.positions + response.motion;
  return response.result;
}

}  // namespace

const char* name_of(Outcome outcome) {
  switch (outcome) {
    case Outcome::converged:
      return "converged";
    case Outcome::limit_reached:
      return "limit_reached";
    case Outcome::inverted:
      return "inverted";
    case Outcome::diverged:
      return "diverged";
    case Outcome::mechanism:
      return "mechanism";
    case Outcome::interrupted:
      return "interrupted";
  }
  return "";
}

namespace {

/// Newton's method; and where a load works on a motion that nothing resists until it has gone on, as across a flat
/// membrane, so that no step is right, from where the body comes to rest as inertia holds it back.
StaticResult newton_or_relaxation(Model& model, State& state, const StaticOptions& options, NewtonWorkspace& workspace,
                                  LastSolve* last) {
  const State start = state;
  StaticResult result = solve_newton(model, state, options, nullptr, workspace, last);
  if (!workspace.adrift || result.outcome == Outcome::converged || result.outcome == Outcome::interrupted)
    return result;
  State resting = start;
  StaticOptions held_back = options;
  held_back.static_method = StaticMethod::implicit_steps;
  const StaticResult relaxed = relax(model, resting, held_back);
  const int newton = result.newton_iterations + relaxed.newton_iterations,
            linear = result.linear_iterations + relaxed.linear_iterations;
  if (relaxed.outcome == Outcome::converged) {
    state = std::move(resting);
    workspace.before.reset();
    result = solve_newton(model, state, options, nullptr, workspace, last);
    result.solver = relaxed.solver + ", then " + result.solver;
    result.newton_iterations += newton, result.linear_iterations += linear;
  }
  return result;
}

StaticResult find_equilibrium(Model& model, State& state, const StaticOptions& options, LastSolve* last) {
  for (Support& support : model.supports) support.free = without_rounding(support.free);
  model.declare_history(state);
  if (state.contact_history.empty())  // what touches at the start sticks where it is
    for (const auto& load : model.loads())
      if (load->history().empty()) load->commit_step(state);
  model.begin_step(state, std::numeric_limits<double>::infinity());
  if (last) last->begin(model);
  if (options.linear) return solve_linear_statics(model, state, options, last);
  if (options.static_method != StaticMethod::newton) return relax(model, state, options);
  StaticResult moved;
  NewtonWorkspace workspace;
  workspace.before = follow_supports(model, state, options, moved, last);
  StaticResult result = options.engine ? options.engine->balance(model, state, options)
                                       : newton_or_relaxation(model, state, options, workspace, last);
  result.linear_iterations += moved.linear_iterations;
  if (last) last->solver = std::move(workspace.solver);
  return result;
}

}  // namespace

StaticResult solve_static(Model& model, State& state, const StaticOptions& options) {
  return find_equilibrium(model, state, options, nullptr);
}

StaticResult solve_static(Model& model, State& state, const StaticOptions& options, LastSolve& last) {
  return find_equilibrium(model, state, options, &last);
}

StaticResponse static_response(Model& model, const Positions& at, const Positions& load_change,
                               const Positions& displacement, const StaticOptions& options) {
  return respond(model, at, load_change, displacement, options, nullptr);
}

namespace {

/// The model as equilibria see it: what relaxes has relaxed.
Model& at_rest(Model& model, const State& state) {
  model.begin_step(state, std::numeric_limits<double>::infinity());
  return model;
}

/// Rotations as a whole that supports leave to the body at rest.
int free_turns(const Model& model) {
  Matrix3 fixed = Matrix3::Zero();
  for (const Support& support : model.supports) fixed += Matrix3::Identity() - support.free;
  const Vector3 held = symmetric_eigenvalues3(fixed);
  const auto translations = (held.array() <= 1e-12 * held.cwiseAbs().maxCoeff()).count();
  return free_rigid_motions(model.body().rest, model.supports) - static_cast<int>(translations);
}

}  // namespace

Responses::Responses(Model& model, const State& state, const StaticOptions& options, LastSolve* last)
    : model_(model),
      options_(options),
      last_(last ? last->taken_for(model) : LastSolve()),
      tangent_(at_rest(model, state), state, {}, options.linear) {}

StaticResponse Responses::to(const Positions& load_change, const Positions& displacement, double tolerance) {
  if (options_.engine) {
    StaticOptions options = options_;
    options.tolerance = tolerance;
    return options.engine->respond(model_, tangent_.positions(), load_change, displacement, options);
  }
  StaticResponse response;
  StaticResult& result = response.result;
  if (is_interrupted(options_, result)) {
    response.motion = Positions::Zero(3, displacement.cols());
    result.reactions = Positions::Zero(3, static_cast<Eigen::Index>(model_.supports.size()));
    return response;
  }
  const auto add_prescribed_displacement = [&](Positions& motion) {
    for (const Support& support : model_.supports) {
      const Vector3 w = displacement.col(support.molecule);
      motion.col(support.molecule) += w - support.free * w;
    }
  };
  Positions rhs(3, displacement.cols()), motion = Positions::Zero(3, displacement.cols());
  add_prescribed_displacement(motion);
  tangent_.apply(motion, rhs);
  rhs = load_change - rhs;
  const double supported = fixed_components(model_.supports, rhs).norm();
  keep_free(model_.supports, rhs);
  double size = ordered_norm(rhs);
  // Of what supports bear alone, rounding is left in the directions that are free: no load.
  if (size < 1e-9 * supported && size <= 2 * rounding_floor(tangent_, tangent_.positions())) rhs.setZero(), size = 0;
  const Positions start = last_.nearest(tangent_, model_.supports, rhs);
  const double left = ordered_norm(rhs), rough = left > 0 ? std::min(kLeastSolved, tolerance * size / left) : tolerance;
  UsedSolver used;
  LinearResult linear = solve_linear(tangent_, model_.supports, rhs, rough, options_, true, motion, used, last_.solver);
  motion += start;
  if (size > 0) linear.residual *= left / size;
  result.solver = "linear " + used.name;
  result.reason = used.reason;
  result.linear = true;
  result.newton_iterations = 1;
  result.linear_iterations = linear.iterations;
  result.scale = size + supported;
  result.residual = size > 0 ? linear.residual * size / (size + supported) : 0;
  // About a shape that is not the body's rest, a turn that supports leave free has the stiffness of stresses which are
  // not yet in balance: of the equilibrium that says nothing.
  const int turns = linear.negative_modes > 0 && model_.body().unstressed ? free_turns(model_) : 0;
  result.unstable =
      linear.negative_modes > turns || (linear.negative_modes <= 0 && linear.status == LinearStatus::negative_mode);
  // An indefinite stiffness still has its one answer, which a factorisation finds and iterations do not; and of stiff
  // parts that move with soft ones rounding leaves a residual, which the result says.
  const double floor = linear.status == LinearStatus::limit_reached ? 2 * rounding_floor(tangent_, motion) : 0;
  if (linear.status != LinearStatus::solved && linear.residual > std::max(tolerance, 1e-8) &&
      !(linear.residual * size <= floor)) {
    const bool mode = linear.status == LinearStatus::zero_mode, negative = linear.status == LinearStatus::negative_mode;
    result.outcome = mode ? Outcome::mechanism : negative ? Outcome::diverged : Outcome::limit_reached;
    result.cause = mode       ? "the loads work on a zero-energy mode"
                   : negative ? "the stiffness has directions of negative stiffness, and iterations end there; the "
                                "solver `direct` finds the equilibrium, which is unstable"
                              : "the linear solver ran out of iterations";
  }
  if (!motion.allFinite()) {
    result.outcome = Outcome::diverged;
    result.cause = "the displacements are too large for numbers";
  }
  add_prescribed_displacement(motion);
  tangent_.apply(motion, rhs);
  rhs -= load_change;
  result.reactions = fixed_components(model_.supports, rhs);
  response.motion = std::move(motion);
  return response;
}

}  // namespace elastin
