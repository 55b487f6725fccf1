#include "core/solve/trial.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/parallel/parallel.h"
#include "core/solve/newton.h"
#include "core/solve/steppers.h"
#include "elastin/core/model/share.h"

namespace elastin {
namespace {

void set_balance(const Problem& problem, const State& state, Balance& result, TrialWorkspace& workspace) {
  const Model& model = problem.model;
  const int n = model.body().size();
  result.scale = model.rest_force();
  // Each load by itself: together they may cancel, as a weight and the floor that it rests on.
  workspace.loads.setZero(3, n);
  Positions& one = result.unbalanced;  // until all loads are known
  for (const auto& load : model.loads()) {
    one.setZero(3, n);
    load->add_forces(state, one);
    result.scale += problem.norm(one);
    workspace.loads += one;
  }
  if (problem.kinematics) {
    model.set_forces(state, result.unbalanced, workspace.force_pass);
    workspace.inertia = state.accelerations * model.body().mass.asDiagonal();
    result.unbalanced -= workspace.inertia;
    result.scale += problem.norm(workspace.inertia);
  } else {
    result.unbalanced.setZero(3, n);
    model.add_elastic_forces(state.positions, result.unbalanced, workspace.force_pass);
    if (problem.shared) problem.shared->add_up(result.unbalanced);
    result.unbalanced += workspace.loads;
  }
  set_fixed_components(model.supports, result.unbalanced, workspace.supported);
  for (std::size_t i = 0; problem.shared && i < model.supports.size(); ++i)  // those of ghosts count elsewhere
    if (model.supports[i].molecule >= problem.shared->owned())
      workspace.supported.col(static_cast<Eigen::Index>(i)).setZero();
  result.scale += std::sqrt(problem.sum(workspace.supported.squaredNorm()));
  keep_free(model.supports, result.unbalanced);
  result.norm = problem.norm(result.unbalanced);
}

/// Sets what rounding of the positions does to the energy [J]; and, of an equilibrium without loads and reactions, the
/// scale of its forces by those within the body.
void set_noise(const Problem& problem, Trial& trial, TrialWorkspace& workspace) {
  const Positions& positions = trial.state.positions;
  const double root = std::sqrt(static_cast<double>(molecules_of_whole(problem.whole())));
  const double within =
      problem.sum(internal_force(problem.model, positions, workspace.force_densities, workspace.force_pass));
  const double all = within + root * trial.forces.scale;
  trial.noise = 4 * std::numeric_limits<double>::epsilon() * problem.largest(positions.cwiseAbs().maxCoeff()) * all;
  if (!problem.kinematics) trial.forces.scale = scale_of(trial.forces.scale, within / root);
}

}  // namespace

double internal_force(const Model& model, const Positions& positions, VectorX& force_densities, Workspace& workspace) {
  const auto& ends = model.body().connections.ends;
  const int connections = model.body().connections.size();
  double within = 0;
  for (const auto* law : model.edge_laws()) {
    force_densities.resize(connections);
    law->set_part_sizes(positions, force_densities, workspace);
    within += ordered_sum(connections, [&](int c) {
      return force_densities[c] * (positions.col(ends[c][1]) - positions.col(ends[c][0])).norm();
    });
  }
  for (const auto* law : model.nodal_laws()) within += law->internal_force(positions);
  return within;
}

double scale_of(double outer, double within) {
  constexpr double nothing = 1e-10;
  return outer < nothing * within ? within : outer;
}

void set_state(const State& from, double factor, const Positions& motion, State& state) {
  state.positions = from.positions + factor * motion;
  state.velocities = from.velocities;
  state.accelerations = from.accelerations;
  state.carry_over(from);
}

void set_velocities(const Model& model, const Kinematics& kinematics, State& state) {
  state.velocities = kinematics.velocities + kinematics.weights.velocity * (state.positions - kinematics.start);
  move_with_supports(model.supports, state.velocities);
}

void follow(const Model& model, const Kinematics& kinematics, State& state) {
  set_velocities(model, kinematics, state);
  state.accelerations =
      kinematics.accelerations + kinematics.weights.acceleration * (state.positions - kinematics.start);
}

double step_energy(const Model& model, const Kinematics& kinematics, const Positions& positions) {
  const VectorX& mass = model.body().mass;
  return ordered_sum(owned_molecules(model.body()), [&](int i) {
    const Vector3 displacement = positions.col(i) - kinematics.start.col(i);
    return mass[i] * (kinematics.weights.acceleration / 2 * displacement.squaredNorm() +
                      kinematics.accelerations.col(i).dot(displacement));
  });
}

Problem::Problem(Model& a_model, const Kinematics* some_kinematics, SharedProblem* some_shared)
    : model(a_model), kinematics(some_kinematics), shared(some_shared) {
  with_energy = model.conservative();
  if (!kinematics) return;
  with_energy &= model.viscosity().empty();
  for (const auto& load : model.loads()) with_energy &= !load->resists();
}

double Problem::dot(const Positions& a, const Positions& b) const {
  return sum(ordered_sum(shared ? shared->owned() : static_cast<int>(a.cols()),
                         [&](int i) { return a.col(i).dot(b.col(i)); }));
}

double Problem::norm(const Positions& vectors) const {
  if (!shared) return ordered_norm(vectors);
  return std::sqrt(dot(vectors, vectors));
}

double furthest(const Problem& problem, const Positions& motion) {
  return std::sqrt(problem.largest(motion.colwise().squaredNorm().maxCoeff()));
}

void evaluate(const Problem& problem, bool with_energy, Trial& trial, TrialWorkspace& workspace) {
  const Model& model = problem.model;
  const Positions& positions = trial.state.positions;
  trial.noise = 0;
  trial.forces.norm = trial.forces.scale = 0;
  if (problem.kinematics) follow(model, *problem.kinematics, trial.state);
  trial.energy = model.elastic_energy(positions) + model.load_energy(trial.state);
  if (!model.admissible(positions)) trial.energy = std::numeric_limits<double>::infinity();
  if (problem.kinematics) trial.energy += step_energy(model, *problem.kinematics, positions);
  trial.energy = problem.sum(trial.energy);
  if (!std::isfinite(trial.energy)) return;
  set_balance(problem, trial.state, trial.forces, workspace);
  if (with_energy) set_noise(problem, trial, workspace);
}

bool line_search(const Problem& problem, const Positions& motion, bool with_energy, Trial& now, bool& inverted,
                 TrialWorkspace& workspace, int* growing) {
  const double slope = -problem.dot(now.forces.unbalanced, motion);
  inverted = false;
  Trial& trial = workspace.next;
  set_state(now.state, 1, motion, trial.state);
  for (double step = problem.model.max_step_fraction(now.state, trial.state); step > 1e-9; step /= 2) {
    set_state(now.state, step, motion, trial.state);
    evaluate(problem, with_energy, trial, workspace);
    inverted |= std::isinf(trial.energy);
    if (!std::isfinite(trial.energy) || !std::isfinite(trial.forces.norm)) continue;
    bool falls = with_energy && slope < 0 && trial.energy <= now.energy + 1e-4 * step * slope;
    if (!problem.with_energy && problem.kinematics)
      falls = slope < 0 && (problem.dot(trial.forces.unbalanced, motion) - slope) / 2 >= -1e-4 * slope;
    const bool calmer = trial.forces.norm < (1 - 1e-4 * step) * now.forces.norm;
    // A step along a nearly incompressible body's stiff valley leaves it by its square: the force grows at first, and
    // works little along the step.                                                          [Matthies & Strang 1979]
    if (!calmer && growing && *growing > 0 &&
        std::abs(problem.dot(trial.forces.unbalanced, motion)) < 0.5 * std::abs(slope))
      falls = true, --*growing;
    // Near the answer the energy differs by less than its rounding; far from it, a calmer force alone may be a saddle.
    const bool same_energy = !with_energy || trial.energy - now.energy <= trial.noise;
    if (falls || (calmer && same_energy)) {
      std::swap(now, trial);
      return true;
    }
  }
  return false;
}

bool leave_saddle(const Problem& problem, const Positions& direction, Trial& now, TrialWorkspace& workspace) {
  const double length = 0.1 * mean_length(problem.whole()) / furthest(problem, direction);
  Trial& trial = workspace.next;
  for (double step = length; step > 1e-6 * length; step /= 4)
    for (const double factor : {step, -step}) {
      set_state(now.state, factor, direction, trial.state);
      evaluate(problem, true, trial, workspace);
      if (!(now.energy - trial.energy > 10 * std::max(now.noise, trial.noise))) continue;
      std::swap(now, trial);
      return true;
    }
  return false;
}

double mean_length(const Body& body) {
  double mean = 0;
  if (body.share) {
    const auto [sum, count] = lengths_of_whole(body);
    return count > 0 ? sum / count : 0;
  }
  for (const double length : body.connections.rest_length)
    mean += length / static_cast<double>(body.connections.rest_length.size());
  return mean;
}

}  // namespace elastin
