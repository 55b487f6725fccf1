#include "core/solve/newton.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include <Eigen/Eigenvalues>

#include "core/linear/linear_choice.h"
#include "core/linear/mixed.h"
#include "core/linear/multigrid.h"
#include "core/linear/rigid_motions.h"
#include "core/parallel/parallel.h"
#include "core/solve/divergence.h"
#include "core/solve/last_solve.h"
#include "core/solve/steppers.h"
#include "elastin/core/base/stop.h"
#include "elastin/core/model/share.h"

namespace elastin {
namespace {

/// Above this many molecules a factorisation is never tried where iterations got stuck.
constexpr int kDirectLimit = 2500;

/// Newton iterations in which a body that was stable at the start is followed down past negative modes before saddles
/// are tried: nearly incompressible ones pass through pressures that are not there at the end.
constexpr int kDownhillSteps = 25;

/// Steps of one solve without an energy that may let the unbalanced force grow.
constexpr int kGrowingSteps = 30;

/// Saddles that one solve goes down from.
constexpr int kSaddles = 3;

/// Iterations with predicted stresses, at most.
constexpr int kPredictions = 12;

const std::string kAdrift = "the loads work on a zero-energy mode that does not stiffen";

/// The solver of the last time, if it was of this kind.
LinearSolver& solver_of(const LinearMethod& method, bool chosen, bool symmetric, CachedSolver& cached) {
  static const LinearMethod unsymmetric = "bicgstab";
  const LinearMethod& used = symmetric || !method->needs_symmetry ? method : unsymmetric;
  if (cached.solver && cached.method == used) return *cached.solver;
  cached.solver = chosen && used->name == "multigrid"                ? make_multigrid_or_direct()
                  : used->name != method->name && method->factorises ? make_bicgstab_by_factor()
                                                                     : used->make();
  cached.method = used;
  return *cached.solver;
}

/// A load that has a part in all directions, but for the motions that nothing resists, on which it does no work.
Positions scattered_load(const Tangent& tangent, const std::vector<Support>& supports, Positions& ignored) {
  Positions load = scattered_directions(tangent.model().body().size()), forces;
  keep_free(supports, load);
  RigidMotions(tangent, supports, ignored, forces).remove_from(tangent.positions(), load);
  return load;
}

/// A way out of an equilibrium that is no minimum, which no force leads out of: a direction of negative stiffness, met
/// on the way to the answer for a load that has a part in all of them. Null columns where there is no such motion. By
/// conjugate gradients, which meet it with any preconditioner; a factorisation would only count. The solver of the last
/// time is taken where it is of that kind, for two would need twice the memory; its grid hierarchy is made again. One
/// that may factorise is not one.
Positions way_down(const Tangent& tangent, const std::vector<Support>& supports, const StaticOptions& options,
                   int& iterations, Positions& ignored, CachedSolver& cached) {
  constexpr double tolerance = 1e-5;
  const Positions load = scattered_load(tangent, supports, ignored);
  const LinearMethod method = choose_linear_solver(tangent, options.method, tolerance).method;
  cached.forget();
  if (!options.method->make) cached.solver.reset();
  const bool mixed = method->name == "mixed";
  if (mixed && SoftVolume::ratio(tangent) > 2 * kSoftRatio) {
    // Less stiffness than the body's: where that leads nowhere down, the body's does not.
    const SoftVolume soft(tangent);
    const LinearResult found = make_multigrid()->solve(soft.tangent(), supports, load, tolerance, ignored);
    iterations += found.iterations;
    if (found.negative_direction.size() == 0 && found.status == LinearStatus::solved) return {};
  }
  std::unique_ptr<LinearSolver> other;
  if (method->factorises || !method->needs_symmetry)
    other = make_pcg();
  else if (mixed)
    other = make_multigrid();
  else if (!cached.solver || cached.method != method)
    other = method->make();
  LinearSolver& solver = other ? *other : *cached.solver;
  LinearResult found = solver.solve(tangent, supports, load, tolerance, ignored);
  if (found.negative_direction.size() > 0) cached.forget();
  iterations += found.iterations;
  return std::move(found.negative_direction);
}

/// What the next trials need, and what the linear solve before them needs, is as large as the body: an equilibrium of
/// many molecules has room for one of them at a time. Steps in time keep both, so that they allocate no memory.
void forget_trials(const Kinematics* kinematics, NewtonWorkspace& workspace) {
  if (!kinematics) workspace.trials = {};
}
void forget_tangent(const Kinematics* kinematics, NewtonWorkspace& workspace) {
  if (!kinematics) workspace.tangent.reset();
}

/// A direction without stiffness has no length of its own: no molecule goes further than half its connections' mean.
void limit_motion(const Problem& problem, Positions& motion) {
  const double most = 0.5 * mean_length(problem.whole()), own = furthest(problem, motion);
  if (own > most) motion *= most / own;
}

/// Whether a body may be strained enough to buckle, which is worth another linear solve to find out. A column with one
/// end free buckles at a strain of π²/48 (h/L)², any other later; and where the body is thinner than its outline,
/// struts up to 45 times as long as they are thick do at 1e-4.
bool may_buckle(const Problem& problem, const Positions& positions) {
  if (problem.whole().unstressed) return true;
  const auto [low, high] = outline_of_whole(problem.whole());
  const Vector3 size = high - low;
  const double thin = size.minCoeff() / size.maxCoeff(), limit = std::min(1e-4, 0.1 * thin * thin);
  const Connections& connections = problem.model.body().connections;
  bool strained = false;
  for (int c = 0; c < connections.size() && !strained; ++c) {
    const auto& [a, b] = connections.ends[c];
    const double rest = connections.rest_length[c];
    strained = !(std::abs((positions.col(b) - positions.col(a)).norm() - rest) < limit * rest);
  }
  return problem.any(strained);
}

/// The normal of the plane that all points lie in, but for rounding; or nothing, also for points on a line.
std::optional<Vector3> plane_normal(const Positions& points) {
  const Positions about = points.colwise() - points.rowwise().mean();
  const Eigen::SelfAdjointEigenSolver<Matrix3> spread(about * about.transpose());
  const Vector3 normal = spread.eigenvectors().col(0);
  const double size = std::sqrt(spread.eigenvalues()[2] / static_cast<double>(points.cols()));
  if (!((normal.transpose() * about).cwiseAbs().maxCoeff() < 1e-6 * size)) return {};
  if (!(spread.eigenvalues()[1] > 1e-9 * spread.eigenvalues()[2])) return {};
  return normal;
}

/// Whether an equilibrium is that of a sheet in its plane, which nothing at rest keeps there: springs and membranes
/// without bending stiffness. In the least compression such a sheet folds as finely as its mesh allows, which may have
/// no end.
bool lies_flat(const Problem& problem, const State& state) {
  const Positions& rest = problem.model.body().rest;
  if (problem.shared) return false;
  const auto normal = plane_normal(rest);
  if (!normal || !plane_normal(state.positions)) return false;
  State at_rest = state;
  at_rest.positions = rest;
  const Tangent tangent(problem.model, at_rest);
  for (int i = 0; i < rest.cols(); ++i)
    if (!(std::abs(normal->dot(tangent.diagonal(i) * *normal)) <= 1e-9 * tangent.diagonal(i).norm())) return false;
  return true;
}

/// What holds a flat sheet where it is and in its plane, too: across that plane its forces are rounding, and where
/// slack it has no stiffness that would keep their motion small. Nothing where the forces lead out of the plane, or
/// have no such part at all, as in a plane of two axes.
std::optional<std::vector<Support>> supports_in_plane(const Problem& problem, const Trial& now) {
  constexpr double rounding = 1e-9;
  const Positions& positions = now.state.positions;
  const auto normal = plane_normal(positions);
  if (!normal) return {};
  const Eigen::RowVectorXd off = normal->transpose() * (positions.colwise() - positions.rowwise().mean()),
                           across = normal->transpose() * now.forces.unbalanced;
  if (off.isZero(0) && across.isZero(0)) return {};
  if (!(across.norm() <= rounding * (now.forces.scale + now.forces.norm))) return {};
  const Matrix3 within = Matrix3::Identity() - *normal * normal->transpose();
  std::vector<Support> supports = problem.model.supports;
  std::vector<char> held(static_cast<std::size_t>(positions.cols()), 0);
  for (Support& support : supports) {
    if (!((support.free * within - within * support.free).norm() <= rounding)) return {};
    support.free *= within;
    held[support.molecule] = 1;
  }
  for (int molecule = 0; molecule < positions.cols(); ++molecule)
    if (!held[molecule]) supports.push_back({molecule, within});
  return supports;
}

}  // namespace

void CachedSolver::forget() {
  if (auto* keeps = dynamic_cast<KeepsWay*>(solver.get())) keeps->forget();
}

bool is_interrupted(const StaticOptions& options, StaticResult& result) {
  if (!stop_requested() && !(options.stop && options.stop())) return false;
  result.outcome = Outcome::interrupted;
  result.cause = "stopped";
  if (result.newton_iterations > 0)
    result.cause += " after " + std::to_string(result.newton_iterations) + " Newton iteration" +
                    (result.newton_iterations == 1 ? "" : "s");
  return true;
}

double rounding_floor(const Tangent& tangent, const Positions& positions) {
  const double reach = positions.cwiseAbs().maxCoeff();
  double sum = 0;
  for (int i = 0; i < tangent.model().body().size(); ++i) sum += tangent.diagonal(i).squaredNorm();
  return std::numeric_limits<double>::epsilon() * reach * std::sqrt(sum);
}

LinearResult solve_linear(const Tangent& tangent, const std::vector<Support>& supports, const Positions& rhs,
                          double tolerance, const StaticOptions& options, bool through_saddles, Positions& solution,
                          UsedSolver& used, CachedSolver& cached) {
  const int molecules = tangent.model().body().size();
  const LinearChoice choice = choose_linear_solver(tangent, options.method, tolerance);
  used.reason = choice.reason;
  // Iterations may do on half of a law's stiffness, a factor does not.
  const bool symmetric = tangent.symmetric() && (tangent.model().has_energy() || !choice.method->factorises);
  if (!symmetric && choice.method->needs_symmetry && tangent.weights().acceleration == 0) {  // a step has no memory
    used.reason = "the stiffness is not symmetric";
    if (options.method->make) used.reason += ", as `" + choice.method->name + "` needs it";
  }
  LinearSolver* solver = &solver_of(choice.method, !options.method->make, symmetric, cached);
  LinearResult result = solver->solve(tangent, supports, rhs, tolerance, solution);
  std::unique_ptr<LinearSolver> other_solver;
  if (result.negative_modes > 0 && !through_saddles) {  // a factorisation leads to the saddle, iterations downhill
    other_solver = make_pcg();
    solver = other_solver.get();
    const int before = result.iterations;
    result = solver->solve(tangent, supports, rhs, tolerance, solution);
    result.iterations += before;
  }
  // A factor of half of an unsymmetric stiffness is refined by the whole: of use where iterations got nowhere.
  const bool iterated = std::string(solver->name()) != "direct" && (symmetric || result.residual > 0.1);
  const bool downhill = result.status == LinearStatus::negative_mode && !through_saddles;
  if (result.status != LinearStatus::solved && !downhill && iterated && !options.method->make &&
      molecules <= kDirectLimit) {
    Positions other;
    auto direct = make_direct();
    const LinearResult second = direct->solve(tangent, supports, rhs, tolerance, other);
    if (second.residual <= std::max(result.residual, tolerance)) {
      solution = other;
      other_solver = std::move(direct);
      solver = other_solver.get();
      used.reason = "iterations got stuck, and with " + std::to_string(molecules) + " molecules it is affordable";
      result = {second.status, result.iterations + second.iterations, second.residual, second.negative_modes, {}};
    }
  }
  used.name = solver->name();
  if (!other_solver && used.name == "direct" && choice.method->name == "multigrid")
    used.reason = "iterations would take longer than a factorisation";
  return result;
}

void set_fixed_components(const std::vector<Support>& supports, const Positions& vectors, Positions& parts) {
  parts.resize(3, static_cast<Eigen::Index>(supports.size()));
  for (std::size_t i = 0; i < supports.size(); ++i) {
    const Vector3 v = vectors.col(supports[i].molecule);
    parts.col(static_cast<Eigen::Index>(i)) = v - supports[i].free * v;
  }
}

Positions fixed_components(const std::vector<Support>& supports, const Positions& vectors) {
  Positions parts;
  set_fixed_components(supports, vectors, parts);
  return parts;
}

void apply_supports(const Model& model, Positions& positions) {
  for (const Support& support : model.supports) {
    const Vector3 wanted = model.body().rest.col(support.molecule) + support.displacement;
    const Vector3 off = wanted - positions.col(support.molecule);
    positions.col(support.molecule) += off - support.free * off;
  }
}

namespace {

double goal_of(const StaticOptions& options, const Trial& trial, double floor) {
  return std::max(options.tolerance * trial.forces.scale, 2 * floor);
}

/// Equilibrium of a body that bends far, by iterations with predicted strains (see Tangent::linearise_onward): `now` is
/// then there. On the way energy and force may rise, and cells be inverted, so that only the end is judged: a stiffness
/// without negative modes all along, and less energy than at the start. False, and `now` stays, where it leads
/// elsewhere; or where the first step makes the force smaller, for then other iterations are as good.
/// @param motion of the first iteration: from `now`, where the tangent of the workspace is
/// @param negative whether it met negative stiffness, as the pressures of a linear step near ν = ½ make it: the way
///   then begins with that step, from workspace.before
bool bend(const Problem& problem, const StaticOptions& options, Positions motion, bool negative, Trial& now,
          NewtonWorkspace& workspace, UsedSolver& used, StaticResult& result) {
  const Model& model = problem.model;
  Tangent& tangent = *workspace.tangent;
  if (!tangent.predicts()) return false;
  Trial trials[2];
  const auto move = [&](const Trial& from, Trial& to) {
    set_state(from.state, 1, motion, to.state);
    if (model.max_step_fraction(from.state, to.state) < 1) return false;
    evaluate(problem, true, to, workspace.trials);
    return true;
  };
  Trial* at = &trials[1];
  if (!negative && (!move(now, *at) || (std::isfinite(at->energy) && at->forces.norm <= now.forces.norm))) return false;
  if (workspace.before) {
    tangent.linearise_at(*workspace.before, {});
    at = &now;
  }
  double last = now.forces.norm, forcing = 1e-3;
  for (int iteration = 0; iteration < kPredictions; ++iteration) {
    Positions unbalanced;
    tangent.linearise_onward(at->state, unbalanced);
    unbalanced += model.load_forces(at->state);
    keep_free(model.supports, unbalanced);
    const double goal =
        goal_of(options, std::isfinite(at->energy) ? *at : now, rounding_floor(tangent, at->state.positions));
    if (std::isfinite(at->energy) && at->forces.norm <= goal) {
      if (at->energy > now.energy) return false;
      if (at != &now) std::swap(now, *at);
      return true;
    }
    if (result.newton_iterations >= options.newton_limit || is_interrupted(options, result)) return false;
    const double norm = problem.norm(unbalanced);
    if (!std::isfinite(norm)) return false;
    if (iteration > 0) forcing = std::min(1e-2, 0.5 * std::pow(norm / last, 2));
    forcing = std::max(forcing, std::min(0.1, 0.1 * goal / norm));
    last = norm;
    const LinearResult linear =
        solve_linear(tangent, model.supports, unbalanced, forcing, options, false, motion, used, workspace.solver);
    ++result.newton_iterations;
    result.linear_iterations += linear.iterations;
    if (linear.status != LinearStatus::solved || linear.negative_modes > 0 || !motion.allFinite()) return false;
    Trial& next = trials[iteration % 2];
    if (!move(*at, next)) return false;
    at = &next;
  }
  return false;
}

/// An equilibrium with the memory that the state has.
StaticResult balance_once(Model& model, State& state, const StaticOptions& options, const Kinematics* kinematics,
                          NewtonWorkspace& workspace, LastSolve* last_solve, SharedProblem* shared) {
  StaticResult result;
  const Problem problem(model, kinematics, shared);
  Trial& now = workspace.now;
  now.state = state;
  evaluate(problem, problem.with_energy, now, workspace.trials);
  if (!std::isfinite(now.energy)) {
    result.outcome = Outcome::inverted;
    result.cause = inverted_anywhere(model, now.state.positions) + " at the start of the step";
    return result;
  }
  UsedSolver used{options.method->factorises ? options.method->name : "pcg", ""};
  // What grows or shrinks is at a saddle as soon as its rest says so, before it has moved.
  bool stable_start = problem.with_energy && options.probe && model.body().unstressed, adrift = false;
  const int growing_limit = problem.with_energy || kinematics ? 0 : kGrowingSteps;
  const auto& loads = model.loads();
  const bool flat_sheet = !kinematics && lies_flat(problem, now.state) &&
                          std::none_of(loads.begin(), loads.end(), [](const auto& load) { return load->changes(); });
  const bool lacks_energy = options.probe && !problem.with_energy && !kinematics && !shared && !model.body().share;
  int growing = growing_limit;
  std::optional<Trial> calm;         // where the first of these steps began
  int saddles = 0, last_saddle = 0;  // how many were left, and after how many iterations
  std::optional<State> flat;         // the first of them, if it is that of a slack sheet
  double forcing = 1e-3, last = now.forces.norm;
  while (true) {
    if (!std::isfinite(now.forces.norm + now.forces.scale)) {
      result.outcome = Outcome::diverged;
      result.cause = "the forces are too large for numbers";
      break;
    }
    const Weights weights = kinematics ? kinematics->weights : Weights{};
    forget_trials(kinematics, workspace);
    if (workspace.tangent && &workspace.tangent->model() == &model)
      workspace.tangent->linearise_at(now.state, weights);
    else
      workspace.tangent = std::make_unique<Tangent>(model, now.state, weights);
    const Tangent& tangent = *workspace.tangent;
    auto linearised = shared ? shared->linearise(tangent) : nullptr;
    const double floor = linearised ? linearised->rounding_floor() : rounding_floor(tangent, now.state.positions);
    result.scale = now.forces.scale;
    result.residual = now.forces.scale > 0 ? now.forces.norm / now.forces.scale : 0;
    const double goal = goal_of(options, now, floor);
    if (now.forces.norm <= goal) {
      const bool probe = options.probe && !kinematics && problem.with_energy && saddles < kSaddles;
      // The last step met negative stiffness where it began: here there may be none.
      const bool judge_again = result.unstable && !kinematics && problem.with_energy;
      // An answer has met the stiffness already; a start that needs none has not.
      const bool looks = probe && (result.newton_iterations == 0 || may_buckle(problem, now.state.positions));
      if (lacks_energy && saddles < kSaddles &&
          (result.newton_iterations == 0 || may_buckle(problem, now.state.positions))) {
        const Divergence away = find_divergence(problem, now, scattered_load(tangent, model.supports, workspace.motion),
                                                result.linear_iterations, workspace.trials);
        result.unstable = away.direction.size() > 0;
        if (!result.unstable || lies_flat(problem, now.state) ||
            !follow_divergence(problem, away, options, floor, now, workspace.trials, result))
          break;
        ++saddles;
        result.left_saddle = true;
        result.unstable = false;
        continue;
      }
      if (!judge_again && !looks) break;
      const Positions down = linearised ? linearised->way_down(result.linear_iterations)
                                        : way_down(tangent, model.supports, options, result.linear_iterations,
                                                   workspace.motion, workspace.solver);
      result.unstable = down.size() > 0;
      linearised.reset();
      forget_tangent(kinematics, workspace);
      if (!probe || !result.unstable || !stable_start) break;
      if (saddles == 0 && lies_flat(problem, now.state)) flat = now.state;
      if (!leave_saddle(problem, down, now, workspace.trials)) break;
      ++saddles;
      last_saddle = result.newton_iterations;
      result.left_saddle = true;
      continue;
    }
    if (!shared && is_interrupted(options, result)) break;
    if (result.newton_iterations >= options.newton_limit) {
      result.outcome = adrift ? Outcome::mechanism : Outcome::limit_reached;
      if (!kinematics || !kinematics->cut_short || adrift)
        result.cause = adrift ? kAdrift
                              : "no equilibrium within " + std::to_string(options.newton_limit) + " Newton iteration" +
                                    (options.newton_limit == 1 ? "" : "s");
      break;
    }
    // Solve each step no further than the next unbalanced force can use. [Eisenstat & Walker 1996, choice 2]
    if (result.newton_iterations > 0) forcing = std::min(1e-2, 0.5 * std::pow(now.forces.norm / last, 2));
    forcing = std::max(forcing, 0.1 * goal / now.forces.norm);
    // Conjugate gradients get stuck on a stiffness that is not symmetric: require little, and come again.
    if (!model.has_energy()) forcing = std::max(forcing, 0.03);
    last = now.forces.norm;
    Positions& motion = workspace.motion;
    const auto in_plane = flat_sheet ? supports_in_plane(problem, now) : std::nullopt;
    if (in_plane) keep_free(*in_plane, now.forces.unbalanced);
    const LinearResult linear =
        linearised ? linearised->solve(now.forces.unbalanced, forcing, motion, used)
                   : solve_linear(tangent, in_plane ? *in_plane : model.supports, now.forces.unbalanced, forcing,
                                  options, !stable_start || result.newton_iterations >= last_saddle + kDownhillSteps,
                                  motion, used, workspace.solver);
    const bool negative = linear.status == LinearStatus::negative_mode || linear.negative_modes > 0;
    if (result.newton_iterations == 0) stable_start = stable_start || (problem.with_energy && !negative);
    result.linear_iterations += linear.iterations;
    ++result.newton_iterations;
    result.unstable = negative;
    adrift = linear.status == LinearStatus::zero_mode && linear.residual > 0.9;
    workspace.adrift |= adrift;
    if (linear.status != LinearStatus::solved && linear.residual > 0.9) limit_motion(problem, motion);
    // A full answer of an indefinite stiffness leads to a saddle of the energy: there only the force can be a guide.
    const bool to_saddle = linear.negative_modes > 0;
    const bool from_before = negative && workspace.before;
    if (result.newton_iterations == 1 && problem.with_energy && !kinematics && !shared &&
        (from_before || (!negative && linear.status == LinearStatus::solved)) &&
        bend(problem, options, motion, negative, now, workspace, used, result))
      continue;
    bool inverted = false;
    linearised.reset();
    forget_tangent(kinematics, workspace);
    if (growing_limit > 0 && growing == growing_limit) calm = now;
    const bool found =
        !problem.any(!motion.allFinite()) &&
        line_search(problem, motion, problem.with_energy && !to_saddle, now, inverted, workspace.trials, &growing);
    result.cut_steps += inverted;
    if (found && last_solve) last_solve->note(motion, model.supports);
    if (!found && growing < growing_limit && calm) {  // back, and by the force alone
      now = *std::exchange(calm, std::nullopt), growing = 0;
      continue;
    }
    if (!found) {
      const bool mechanism = adrift;  // else it is a soft direction, which a shorter load step may lead through
      result.outcome = mechanism ? Outcome::mechanism : inverted ? Outcome::inverted : Outcome::diverged;
      result.cause = mechanism  ? kAdrift
                     : inverted ? "any further step would invert a cell"
                                : "no step lowers the unbalanced force";
      break;
    }
  }
  if (flat && result.outcome != Outcome::converged && result.outcome != Outcome::interrupted) {
    now.state = *flat;
    evaluate(problem, true, now, workspace.trials);
    result.outcome = Outcome::converged;
    result.cause.clear();
    result.residual = now.forces.scale > 0 ? now.forces.norm / now.forces.scale : 0;
    result.scale = now.forces.scale;
    result.left_saddle = false;
    result.unstable = true;
  }
  state = now.state;
  result.solver = "newton " + used.name;
  result.reason = used.reason;
  if (kinematics || shared) return result;  // a step needs no reactions; processes find them together
  Positions forces;
  model.set_forces(state, forces);
  result.reactions = -fixed_components(model.supports, forces);
  return result;
}

}  // namespace

StaticResult solve_newton(Model& model, State& state, const StaticOptions& options, const Kinematics* kinematics,
                          NewtonWorkspace& workspace, LastSolve* last, SharedProblem* shared) {
  workspace.solver.forget();
  StaticResult result;
  bool first = true;
  balance_with_multipliers(model, state, kinematics && kinematics->cut_short, result, [&] {
    if (!std::exchange(first, false)) workspace.before.reset();
    StaticResult again = balance_once(model, state, options, kinematics, workspace, last, shared);
    again.newton_iterations += result.newton_iterations;
    again.linear_iterations += result.linear_iterations;
    again.cut_steps += result.cut_steps;
    result = std::move(again);
  });
  return result;
}

}  // namespace elastin
