#include "solve/newton.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.h"
#include "solve/explicit.h"
#include "solve/linear_choice.h"

namespace elastin {
namespace {

/// Above this many molecules a factorisation is never tried where iterations got stuck.
constexpr int kDirectLimit = 2500;

/// Newton iterations in which a body that was stable at the start is followed down past negative modes before saddles
/// are tried: nearly incompressible ones pass through pressures that are not there at the end.
constexpr int kDownhillSteps = 25;

/// Saddles that one solve goes down from.
constexpr int kSaddles = 3;

const std::string kAdrift = "the loads work on a zero-energy mode that does not stiffen";

std::unique_ptr<LinearSolver> make_solver(LinearMethod method) {
  if (method == LinearMethod::direct) return make_direct();
  return method == LinearMethod::multigrid ? make_multigrid() : make_pcg();
}

struct Balance {
  Positions unbalanced;  ///< all forces less inertia, in the free directions [N]
  double norm = 0;       ///< its size
  double scale = 0;      ///< size of loads, inertia and reactions
};

Positions inertia(const Model& model, const State& state) {
  return state.accelerations * model.body().mass.asDiagonal();
}

Balance balance(const Model& model, const State& state, bool moving) {
  Balance result;
  // Each load by itself: together they may cancel, as a weight and the floor that it rests on.
  Positions loads = Positions::Zero(3, model.body().size()), one(3, model.body().size());
  for (const auto& load : model.loads()) {
    one.setZero();
    load->add_forces(state, one);
    result.scale += ordered_norm(one);
    loads += one;
  }
  if (moving) {
    model.set_forces(state, result.unbalanced);
    const Positions needed = inertia(model, state);
    result.unbalanced -= needed;
    result.scale += ordered_norm(needed);
  } else {
    result.unbalanced = model.elastic_forces(state.positions);
    result.unbalanced += loads;
  }
  result.scale += held_parts(model.supports, result.unbalanced).norm();
  keep_free(model.supports, result.unbalanced);
  result.norm = ordered_norm(result.unbalanced);
  return result;
}

/// Velocities and accelerations that go with the positions; supports move as they say.
void follow(const Model& model, const Kinematics& kinematics, State& state) {
  const auto& [weights, start, velocities, accelerations] = kinematics;
  state.velocities = velocities + weights.velocity * (state.positions - start);
  state.accelerations = accelerations + weights.acceleration * (state.positions - start);
  move_with_supports(model.supports, state.velocities);
}

/// What the step's kinetic energy adds to the energy that its end minimises: ½ w_a |Δx|² + a₀·Δx, by mass.
double step_energy(const Model& model, const Kinematics& kinematics, const Positions& positions) {
  const VectorX& mass = model.body().mass;
  return ordered_sum(model.body().size(), [&](int i) {
    const Vector3 way = positions.col(i) - kinematics.start.col(i);
    return mass[i] *
           (kinematics.weights.acceleration / 2 * way.squaredNorm() + kinematics.accelerations.col(i).dot(way));
  });
}

/// What stays the same through the iterations.
struct Problem {
  Model& model;
  const Kinematics* kinematics;  ///< null: static
  bool with_energy;              ///< whether the answer minimises an energy

  Problem(Model& a_model, const Kinematics* some_kinematics) : model(a_model), kinematics(some_kinematics) {
    with_energy = model.conservative();
    if (!kinematics) return;
    with_energy &= model.viscosity().empty();
    for (const auto& load : model.loads()) with_energy &= !load->resists();
  }
};

/// Where a line search stands: total energy (where there is one) and unbalanced force.
struct Trial {
  State state;
  Balance forces;
  double energy;  ///< +infinity where a cell is flat or turned over
  double noise;   ///< what rounding of the positions does to the energy [J]
};

/// @param state its positions count; what follows from them is set here.
Trial evaluate(const Problem& problem, State state, bool with_energy) {
  const auto& [model, kinematics, _] = problem;
  Trial trial{std::move(state), {}, 0, 0};
  const Positions& positions = trial.state.positions;
  if (kinematics) follow(model, *kinematics, trial.state);
  trial.energy = model.elastic_energy(positions) + model.load_energy(trial.state);
  if (!model.admissible(positions)) trial.energy = std::numeric_limits<double>::infinity();
  if (kinematics) trial.energy += step_energy(model, *kinematics, positions);
  if (!std::isfinite(trial.energy)) return trial;
  trial.forces = balance(model, trial.state, kinematics);
  if (with_energy) {
    const VectorX densities = model.force_densities(positions);
    const auto& ends = model.body().connections.ends;
    const double pull = ordered_sum(model.body().connections.size(), [&](int c) {
      return std::abs(densities[c]) * (positions.col(ends[c][1]) - positions.col(ends[c][0])).norm();
    });
    const double all = pull + std::sqrt(static_cast<double>(positions.cols())) * trial.forces.scale;
    trial.noise = 4 * std::numeric_limits<double>::epsilon() * positions.cwiseAbs().maxCoeff() * all;
  }
  return trial;
}

double work(const Balance& forces, const Positions& motion) {
  return ordered_sum(static_cast<int>(motion.cols()),
                     [&](int i) { return forces.unbalanced.col(i).dot(motion.col(i)); });
}

/// Halves the step until the energy falls (Armijo) or, where rounding hides that or there is no energy, the unbalanced
/// force does; and while a cell is turned over, with or without an energy. A time step with damping or drag has no
/// energy, but forces whose work on the way says the same. Returns false if no step helps.
bool line_search(const Problem& problem, const Positions& motion, bool with_energy, Trial& now, bool& inverted) {
  const double slope = -work(now.forces, motion);
  inverted = false;
  State whole = now.state;
  whole.positions += motion;
  for (double step = problem.model.free_way(now.state, whole); step > 1e-9; step /= 2) {
    State state = now.state;
    state.positions += step * motion;
    Trial trial = evaluate(problem, std::move(state), with_energy);
    inverted |= std::isinf(trial.energy);
    if (!std::isfinite(trial.energy) || !std::isfinite(trial.forces.norm)) continue;
    bool falls = with_energy && slope < 0 && trial.energy <= now.energy + 1e-4 * step * slope;
    if (!problem.with_energy && problem.kinematics)
      falls = slope < 0 && (work(trial.forces, motion) - slope) / 2 >= -1e-4 * slope;
    const bool calmer = trial.forces.norm < (1 - 1e-4 * step) * now.forces.norm;
    // Near the answer the energy differs by less than its rounding; far from it, a calmer force alone may be a saddle.
    const bool same_energy = !with_energy || trial.energy - now.energy <= trial.noise;
    if (falls || (calmer && same_energy)) {
      now = std::move(trial);
      return true;
    }
  }
  return false;
}

double mean_length(const Body& body) {
  double mean = 0;
  for (const double length : body.connections.rest_length)
    mean += length / static_cast<double>(body.connections.rest_length.size());
  return mean;
}

/// A way out of an equilibrium that is no minimum, which no force leads out of: a direction of negative stiffness, met
/// on the way to the answer for a load that has a part in all of them. Null columns where there is none.
Positions way_down(const Tangent& tangent, const std::vector<Support>& supports, int& iterations) {
  Positions load = scattered_directions(tangent.model().body().size()), ignored;
  keep_free(supports, load);
  const LinearResult found = make_pcg()->solve(tangent, supports, load, 1e-5, ignored);
  iterations += found.iterations;
  return found.negative_direction;
}

/// Goes along a direction, or against it, as far as the energy falls by more than its rounding. Returns whether it did.
bool leave_saddle(const Problem& problem, const Positions& direction, Trial& now) {
  const double furthest = std::sqrt(direction.colwise().squaredNorm().maxCoeff());
  const double length = 0.1 * mean_length(problem.model.body()) / furthest;
  for (double step = length; step > 1e-6 * length; step /= 4)
    for (const double way : {step, -step}) {
      State state = now.state;
      state.positions += way * direction;
      Trial trial = evaluate(problem, std::move(state), true);
      if (!(now.energy - trial.energy > 10 * std::max(now.noise, trial.noise))) continue;
      now = std::move(trial);
      return true;
    }
  return false;
}

/// A direction without stiffness has no length of its own: no molecule goes further than half its connections' mean.
void limit_motion(const Body& body, Positions& motion) {
  const double mean = mean_length(body);
  const double furthest = std::sqrt(motion.colwise().squaredNorm().maxCoeff());
  if (furthest > 0.5 * mean) motion *= 0.5 * mean / furthest;
}

/// Whether a body may be strained enough to buckle, which is worth another linear solve to find out. A column with one
/// end free buckles at a strain of π²/48 (h/L)², any other later; and where the body is thinner than its outline,
/// struts up to 45 times as long as they are thick do at 1e-4.
bool may_buckle(const Body& body, const Positions& positions) {
  const Vector3 size = body.rest.rowwise().maxCoeff() - body.rest.rowwise().minCoeff();
  const double thin = size.minCoeff() / size.maxCoeff(), limit = std::min(1e-4, 0.1 * thin * thin);
  for (int c = 0; c < body.connections.size(); ++c) {
    const auto& [a, b] = body.connections.ends[static_cast<std::size_t>(c)];
    const double rest = body.connections.rest_length[static_cast<std::size_t>(c)];
    if (!(std::abs((positions.col(b) - positions.col(a)).norm() - rest) < limit * rest)) return true;
  }
  return false;
}

}  // namespace

double rounding_floor(const Tangent& tangent, const Positions& positions) {
  const double reach = positions.cwiseAbs().maxCoeff();
  double sum = 0;
  for (int i = 0; i < tangent.model().body().size(); ++i) sum += tangent.diagonal(i).squaredNorm();
  return std::numeric_limits<double>::epsilon() * reach * std::sqrt(sum);
}

LinearResult solve_linear(const Tangent& tangent, const std::vector<Support>& supports, const Positions& rhs,
                          double tolerance, const StaticOptions& options, bool through_saddles, Positions& solution,
                          UsedSolver& used) {
  const int molecules = tangent.model().body().size();
  const LinearChoice choice = choose_linear_solver(tangent, options.method, tolerance);
  used.reason = choice.reason;
  auto solver = tangent.model().symmetric() ? make_solver(choice.method) : make_bicgstab();
  LinearResult result = solver->solve(tangent, supports, rhs, tolerance, solution);
  if (result.negative_modes > 0 && !through_saddles) {  // a factorisation leads to the saddle, iterations downhill
    solver = make_pcg();
    const int before = result.iterations;
    result = solver->solve(tangent, supports, rhs, tolerance, solution);
    result.iterations += before;
  }
  const bool iterated = choice.method != LinearMethod::direct && tangent.model().symmetric();
  const bool downhill = result.status == LinearStatus::negative_mode && !through_saddles;
  if (result.status != LinearStatus::solved && !downhill && iterated && options.method == LinearMethod::automatic &&
      molecules <= kDirectLimit) {
    Positions other;
    auto direct = make_direct();
    const LinearResult second = direct->solve(tangent, supports, rhs, tolerance, other);
    if (second.residual <= std::max(result.residual, tolerance)) {
      solution = other;
      solver = std::move(direct);
      used.reason = "iterations got stuck, and with " + std::to_string(molecules) + " molecules it is affordable";
      result = {second.status, result.iterations + second.iterations, second.residual, second.negative_modes, {}};
    }
  }
  used.name = solver->name();
  return result;
}

Positions held_parts(const std::vector<Support>& supports, const Positions& vectors) {
  Positions parts(3, static_cast<Eigen::Index>(supports.size()));
  for (std::size_t i = 0; i < supports.size(); ++i) {
    const Vector3 v = vectors.col(supports[i].molecule);
    parts.col(static_cast<Eigen::Index>(i)) = v - supports[i].free * v;
  }
  return parts;
}

void place_supports(const Model& model, Positions& positions) {
  for (const Support& support : model.supports) {
    const Vector3 wanted = model.body().rest.col(support.molecule) + support.displacement;
    const Vector3 off = wanted - positions.col(support.molecule);
    positions.col(support.molecule) += off - support.free * off;
  }
}

namespace {

/// Of a memory that is tightened after each equilibrium, until it says that it is enough.
constexpr int kTightenings = 50;

/// An equilibrium with the memory that the state has.
StaticResult balance_once(Model& model, State& state, const StaticOptions& options, const Kinematics* kinematics) {
  StaticResult result;
  const Problem problem(model, kinematics);
  Trial now = evaluate(problem, state, problem.with_energy);
  if (!std::isfinite(now.energy)) {
    result.outcome = Outcome::inverted;
    result.cause = turned_over_text(model.body(), now.state.positions) + " at the start of the step";
    return result;
  }
  UsedSolver used{options.method == LinearMethod::direct ? "direct" : "pcg", ""};
  bool stable_start = false, adrift = false;
  int saddles = 0, last_saddle = 0;  // how many were left, and after how many iterations
  double forcing = 1e-3, last = now.forces.norm;
  while (true) {
    if (!std::isfinite(now.forces.norm + now.forces.scale)) {
      result.outcome = Outcome::diverged;
      result.cause = "the forces are too large for numbers";
      break;
    }
    const Tangent tangent(model, now.state, kinematics ? kinematics->weights : Weights{});
    const double floor = rounding_floor(tangent, now.state.positions);
    result.residual = now.forces.scale > 0 ? now.forces.norm / now.forces.scale : 0;
    const double goal = std::max(options.tolerance * now.forces.scale, 2 * floor);
    if (now.forces.norm <= goal) {
      const bool probe = options.probe && !kinematics && problem.with_energy && saddles < kSaddles;
      if (!probe || !may_buckle(model.body(), now.state.positions)) break;
      const Positions down = way_down(tangent, model.supports, result.linear_iterations);
      result.unstable = down.size() > 0;
      if (!result.unstable || !stable_start || !leave_saddle(problem, down, now)) break;
      ++saddles;
      last_saddle = result.newton_iterations;
      result.left_saddle = true;
      continue;
    }
    if (result.newton_iterations == options.newton_limit) {
      result.outcome = adrift ? Outcome::mechanism : Outcome::limit_reached;
      result.cause = adrift ? kAdrift
                            : "no equilibrium within " + std::to_string(options.newton_limit) + " Newton iteration" +
                                  (options.newton_limit == 1 ? "" : "s");
      break;
    }
    // Solve each step no further than the next unbalanced force can use. [Eisenstat & Walker 1996, choice 2]
    if (result.newton_iterations > 0) forcing = std::min(1e-2, 0.5 * std::pow(now.forces.norm / last, 2));
    forcing = std::max(forcing, 0.1 * goal / now.forces.norm);
    // Conjugate gradients get stuck on a stiffness that is not symmetric: ask for little, and come again.
    if (!model.has_energy()) forcing = std::max(forcing, 0.03);
    last = now.forces.norm;
    Positions motion;
    const LinearResult linear =
        solve_linear(tangent, model.supports, now.forces.unbalanced, forcing, options,
                     !stable_start || result.newton_iterations >= last_saddle + kDownhillSteps, motion, used);
    const bool negative = linear.status == LinearStatus::negative_mode || linear.negative_modes > 0;
    if (result.newton_iterations == 0) stable_start = problem.with_energy && !negative;
    result.linear_iterations += linear.iterations;
    ++result.newton_iterations;
    result.unstable = negative;
    adrift = linear.status == LinearStatus::zero_mode && linear.residual > 0.9;
    if (linear.status != LinearStatus::solved && linear.residual > 0.9) limit_motion(model.body(), motion);
    // A full answer of an indefinite stiffness leads to a saddle of the energy: there only the force can be a guide.
    const bool to_saddle = linear.negative_modes > 0;
    bool inverted = false;
    const bool found =
        motion.allFinite() && line_search(problem, motion, problem.with_energy && !to_saddle, now, inverted);
    result.cut_steps += inverted;
    if (!found) {
      const bool mechanism = linear.status == LinearStatus::zero_mode;
      result.outcome = mechanism ? Outcome::mechanism : inverted ? Outcome::inverted : Outcome::diverged;
      result.cause = mechanism  ? kAdrift
                     : inverted ? "every further step would turn a cell over"
                                : "no step lowers the unbalanced force";
      break;
    }
  }
  state = std::move(now.state);
  result.solver = "newton " + used.name;
  result.reason = used.reason;
  Positions forces;
  model.set_forces(state, forces);
  if (kinematics) forces -= inertia(model, state);
  result.reactions = -held_parts(model.supports, forces);
  return result;
}

}  // namespace

StaticResult solve_newton(Model& model, State& state, const StaticOptions& options, const Kinematics* kinematics) {
  StaticResult result = balance_once(model, state, options, kinematics);
  for (int round = 0; result.outcome == Outcome::converged && model.tighten(state); ++round) {
    if (round == kTightenings) {
      result.outcome = Outcome::limit_reached;
      result.cause = "contact is pressed in deeper than allowed after " + std::to_string(kTightenings) + " tightenings";
      break;
    }
    StaticResult again = balance_once(model, state, options, kinematics);
    again.newton_iterations += result.newton_iterations;
    again.linear_iterations += result.linear_iterations;
    again.cut_steps += result.cut_steps;
    result = std::move(again);
  }
  return result;
}

}  // namespace elastin
