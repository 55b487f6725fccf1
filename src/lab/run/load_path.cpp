#include "lab/run/load_path.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <utility>

#include "contact/distance.h"
#include "core/base/dense.h"
#include "core/linear/rigid_motions.h"
#include "core/model/faces.h"
#include "core/solve/modes.h"
#include "elastin/contact/contact_points.h"
#include "elastin/core/base/stop.h"
#include "elastin/core/base/text.h"
#include "elastin/core/linear/linear_solver.h"
#include "elastin/core/model/rest.h"
#include "elastin/core/model/share.h"
#include "elastin/core/solve/vibrations.h"
#include "lab/run/common_measures.h"
#include "lab/run/compression.h"
#include "lab/run/contact_measures.h"
#include "lab/run/derivatives.h"

namespace elastin::lab {
namespace {

/// Of a load that is found by solving again.
constexpr int kCorrections = 10;

/// Newton iterations after which a load step is halved: most steps take fewer than ten.
constexpr int kPatience = 25;

/// Of an obstacle's half thickness: no further in one part.
constexpr double kObstaclePart = 0.25;
constexpr double kMostObstacleParts = 1000;

void add_cost(StaticResult& result, const StaticResult& cost) {
  result.newton_iterations += cost.newton_iterations;
  result.linear_iterations += cost.linear_iterations;
  result.cut_steps += cost.cut_steps;
  result.left_saddle |= cost.left_saddle;
}

bool bodies_may_pass(const Model& model, const State& from, const State& to) {
  const contact::Contact* contact = contact_of(model);
  return contact && contact::bodies_may_pass(*contact, from, to);
}

}  // namespace

bool stays_in_plane(const Specimen& specimen, const Experiment& experiment, double duration) {
  constexpr double rounding = 1e-6;  // that of directions in a sheet whose places are in single precision
  constexpr int moments = 64;
  const Vector3 normal = plane_normal(specimen.body);
  const StaticExperiment* held = experiment.at_rest() ? experiment.at_rest() : experiment.calibration();
  if (!held || normal.isZero(0) || specimen.start || specimen.contact) return false;
  Model model(specimen.body);
  for (const SpecimenLoad& load : specimen.loads) load.add(model);
  const auto rig = held->static_rig(model);
  if (contact_of(model)) return false;
  rig->set_load(1);
  bool acts = false;
  const auto within = [&](const Positions& vectors) {
    acts |= !vectors.isZero(0);
    return (normal.transpose() * vectors).norm() <= rounding * vectors.norm();
  };
  State state = state_at_rest(model.body());
  for (int moment = 0; moment <= (duration > 0 ? moments : 0); ++moment) {  // any periods differ from these
    state.time = duration * std::fmod(0.6180339887 * moment, 1.);
    if (!within(model.load_forces(state))) return false;
  }
  Positions moved = Positions::Zero(3, static_cast<Eigen::Index>(model.supports.size()));
  for (Eigen::Index i = 0; i < moved.cols(); ++i)
    moved.col(i) = model.supports[i].displacement - model.supports[i].free * model.supports[i].displacement;
  return within(moved) && acts;
}

void set_load(Model& model, StaticRig& rig, double factor) {
  if (contact::Contact* contact = contact_of(model)) contact->set_moment(factor);
  if (const auto& rest = model.body().unstressed; rest && !model.rest_in_time)
    model.set_rest(rest->part ? rest->part(factor) : factor);
  rig.set_load(factor);
}

void adjust_load(Model& model, StaticRig& rig, const StaticOptions& options, State& state, StaticResult& solved) {
  for (int correction = 0; correction < kCorrections; ++correction) {
    if (solved.outcome != Outcome::converged || !rig.adjust(state)) return;
    StaticResult again = solve_static(model, state, options);
    add_cost(again, solved);
    solved = std::move(again);
  }
  if (solved.outcome != Outcome::converged || !rig.adjust(state)) return;
  solved.outcome = Outcome::limit_reached;
  solved.cause = "what is prescribed is not reached after " + std::to_string(kCorrections) + " corrections of the load";
}

LoadPath::LoadPath(Model& model, StaticRig& rig, const StaticOptions& options, State start, LastSolve* last)
    : model_(model), rig_(rig), options_(options), state_(std::move(start)), last_(last) {
  options_.probe = rig.leaves_saddles();
  rig.approach(state_.positions);
  model_.commit_step(state_);
}

/// Of the energy that the last step has added, in as much of the path: what more an extrapolation adds is its own.
constexpr double kOwnEnergy = 4;

/// Extrapolation of the path: near the next equilibrium, unless a cell inverts or the energy is too high: under loads,
/// higher than where the body stands (a bar that turns far would be torn); else, much higher than the path goes on to
/// (one that is twisted, nearly incompressible, would be blown up).
State LoadPath::start_of(double factor) const {
  if (options_.linear) return state_;
  State next = state_;
  if (last_step_ == 0) {
    rig_.shape_start(next.positions);
    return next;
  }
  next.positions += (factor - factor_) / last_step_ * displacement_;
  if (model_.body().share)
    return any_over(model_.body(), !std::isfinite(model_.elastic_energy(next.positions))) ? state_ : next;
  const double gain = model_.elastic_energy(next.positions) + model_.load_energy(next) -
                      model_.elastic_energy(state_.positions) - model_.load_energy(state_);
  const bool loaded = model_.conservative() && !model_.load_forces(state_).isZero(0);
  const double usual = loaded ? 0 : kOwnEnergy * std::abs((factor - factor_) / last_step_) * std::abs(last_gain_);
  return std::isfinite(gain) && gain <= usual ? next : state_;
}

/// In how many parts obstacles go to the load `factor`.
int LoadPath::parts_for_obstacles(double factor) {
  contact::Contact* contact = contact_of(model_);
  if (!contact) return 1;
  const auto poses_at = [&](double at) {
    contact->set_moment(at);
    rig_.set_load(at);
    return contact->poses(state_.time);
  };
  const std::vector<contact::Pose> after = poses_at(factor), before = poses_at(factor_);
  double most = 1;
  for (std::size_t o = 0; o < before.size(); ++o) {
    double displacement = (after[o].position - before[o].position).norm();
    if (const double turned = (after[o].turn - before[o].turn).norm(); turned > 0)
      displacement += turned * (state_.positions.colwise() - before[o].position).colwise().norm().maxCoeff();
    most = std::max(most, displacement / (kObstaclePart * contact::half_thickness(contact->obstacles()[o].shape)));
  }
  return static_cast<int>(std::ceil(std::min(most, kMostObstacleParts) - 1e-9));
}

/// Takes an equilibrium as the path's next.
void LoadPath::keep(State found, double factor) {
  model_.commit_step(found);
  displacement_ = found.positions - state_.positions;
  last_gain_ = model_.elastic_energy(found.positions) - model_.elastic_energy(state_.positions);
  last_step_ = factor - factor_;
  if (steepest_)
    if (const double slope = displacement_.colwise().norm().maxCoeff() / std::abs(last_step_);
        std::isfinite(slope) && slope > steepest_->slope)
      *steepest_ = {factor_, factor, std::move(state_), found, slope};
  state_ = std::move(found);
  factor_ = factor;
}

StaticResult LoadPath::advance(double factor, LoadPart* steepest) {
  steepest_ = steepest;
  const double change = factor - factor_;
  const int parts = options_.linear
                        ? 1
                        : std::max(static_cast<int>(std::ceil(std::abs(change) / rig_.longest_step() - 1e-9)),
                                   parts_for_obstacles(factor));
  StaticResult solved;
  for (int part = parts; part > 0 && solved.outcome == Outcome::converged; --part) {
    const StaticResult before = solved;
    solved = advance(part == 1 ? factor : factor_ + (factor - factor_) / part, std::abs(change) / parts / 64);
    add_cost(solved, before);
  }
  return solved;
}

StaticResult LoadPath::solve(State& state, const StaticOptions& options) {
  return last_ ? solve_static(model_, state, options, *last_) : solve_static(model_, state, options);
}

StaticResult LoadPath::advance(double factor, double smallest) {
  set_load(model_, rig_, factor);
  State next = start_of(factor);
  // A step that can be halved is not worth many iterations.
  StaticOptions options = options_;
  const bool can_be_halved = !options_.linear && std::abs(factor - factor_) / 2 >= smallest;
  if (can_be_halved) options.newton_limit = std::min(options.newton_limit, kPatience);
  const bool went_on = any_over(model_.body(), next.positions != state_.positions);
  StaticResult solved = solve(next, options);
  if (solved.outcome == Outcome::diverged &&
      went_on) {  // where the path bends sharply, its extrapolation may lead nowhere
    next = state_;
    const StaticResult before = std::exchange(solved, solve(next, options));
    add_cost(solved, before);
  }
  const bool balanced = solved.outcome == Outcome::converged;
  adjust_load(model_, rig_, options, next, solved);
  const bool found = solved.outcome == Outcome::converged,
             may_pass = found && !options_.linear && bodies_may_pass(model_, state_, next);
  if (found && !(may_pass && can_be_halved)) {
    may_have_passed_ |= may_pass;
    keep(std::move(next), factor);
    return solved;
  }
  if (found) solved.left_saddle = false;  // on its way to a state that is dropped
  const bool shorter_helps =
      found || (balanced && solved.outcome == Outcome::limit_reached) || solved.outcome == Outcome::inverted ||
      solved.outcome == Outcome::diverged ||
      (solved.outcome == Outcome::limit_reached && solved.newton_iterations >= options.newton_limit);
  if (!shorter_helps || !can_be_halved) return solved;
  ++halvings_;
  StaticResult first = advance((factor_ + factor) / 2, smallest);
  add_cost(first, solved);
  if (first.outcome != Outcome::converged) return first;
  StaticResult second = advance(factor, smallest);
  add_cost(second, first);
  return second;
}

bool RepeatedCurve::solve(Model& model, StaticRig& rig, const Visit& visit) {
  const bool found = from_last(model, rig, visit) || from_start(model, rig, visit);
  expected_.clear();
  return found;
}

void RepeatedCurve::expect(std::size_t step, Positions motion) {
  if (step >= states_.size()) return;
  expected_.resize(states_.size());
  expected_[step] = std::move(motion);
}

bool RepeatedCurve::from_last(Model& model, StaticRig& rig, const Visit& visit) {
  for (std::size_t step = 0; step < states_.size(); ++step) {
    set_load(model, rig, factors_[step]);
    State state = states_[step];
    if (step < expected_.size() && expected_[step].size() > 0) {
      state.positions += expected_[step];
      if (!std::isfinite(model.elastic_energy(state.positions))) state = states_[step];
    }
    StaticResult solved = solve_static(model, state, options_);
    adjust_load(model, rig, options_, state, solved);
    if (solved.outcome != Outcome::converged || !visit(step, state, solved)) return false;
    states_[step] = std::move(state);
  }
  return !states_.empty();
}

bool RepeatedCurve::from_start(Model& model, StaticRig& rig, const Visit& visit) {
  std::vector<State> states;
  LoadPath path(model, rig, options_, state_at_rest(model.body()));
  for (std::size_t step = 0; step < factors_.size(); ++step) {
    StaticResult solved = path.advance(factors_[step]);
    cause_ = solved.cause;
    if (solved.outcome != Outcome::converged || !visit(step, path.state(), solved)) return false;
    states.push_back(path.state());
  }
  states_ = std::move(states);
  return true;
}

namespace {

/// Of the load: what may be left of it unbalanced.
constexpr double kBalanced = 1e-3;
/// Of the load: what others than the grips may bear of it without a word.
constexpr double kBorne = 5e-3;

/// Of the forces that hold the displaced molecules, before others give way: a resistance below that is rounding.
constexpr double kResists = 1e-9;

/// Newton iterations of a load step that may have led a body out of its straight shape.
constexpr int kStraying = 8;

constexpr const char* kBuckled = "left an equilibrium that was no minimum for one of less energy (buckling, snapping)";

void warn_once(const std::string& warning, Run& run) {
  if (std::find(run.warnings.begin(), run.warnings.end(), warning) == run.warnings.end())
    run.warnings.push_back(warning);
}

/// Adds what one solve cost and said to the run; returns whether it converged.
bool note_solve(const StaticResult& solved, const std::string& where, Run& run) {
  run.solver = solved.solver;
  run.solver_reason = solved.reason;
  run.newton_iterations += solved.newton_iterations;
  run.linear_iterations += solved.linear_iterations;
  run.cut_steps += solved.cut_steps;
  run.residual = solved.residual;
  const std::string unstable = "the equilibrium is not stable: directions of negative stiffness";
  run.unstable |= solved.unstable;
  if (solved.unstable) warn_once(unstable, run);
  if (solved.left_saddle) warn_once(kBuckled, run);
  if (solved.outcome == Outcome::converged) return true;
  run.outcome = solved.outcome;
  run.cause = solved.cause + where;
  if (solved.outcome == Outcome::limit_reached && solved.left_saddle)
    run.cause +=
        "; it buckles on the way: `solver.method: implicit` finds where it comes to rest, `solver.displacements: "
        "small` "
        "leaves it straight, and `material.bending` keeps a sheet flat";
  return false;
}

/// Whether the stiffness of a material's curve jumps where there is no strain: what lies next to its neutral plane then
/// has now the one, now the other.
bool jumps_at_rest(const Material& material) {
  constexpr double next_to = 1e-3, most = 1.2;
  if (!material.curve) return false;
  const double tension = material.curve->modulus(next_to), compression = material.curve->modulus(-next_to);
  return std::max(tension, compression) > most * std::min(tension, compression);
}

/// Whether supports have moved a body that has no other reason for forces.
bool is_displaced(const Model& model, const State& state) {
  const Positions& rest = model.body().rest;
  const bool moved = std::any_of(model.supports.begin(), model.supports.end(), [&](const Support& support) {
    const Vector3 motion = state.positions.col(support.molecule) - rest.col(support.molecule);
    return !(motion - support.free * motion).isZero(0);
  });
  return !model.body().unstressed && any_over(model.body(), moved);
}

/// Whether loads, moved supports or a rest of its own give the body forces to balance.
bool has_forces(const Model& model, const State& state) {
  return model.body().unstressed || is_displaced(model, state) ||
         any_over(model.body(), !model.load_forces(state).isZero(0));
}

/// Whether the body would buckle under the load: whether its stiffness is negative in some direction where the load
/// strains it as its small displacements say, by a tenth at most. Of a body that does, the way there is another one.
bool buckles(Model& model, StaticRig& rig, const StaticOptions& options, double factor, const State& reached) {
  constexpr double most = 0.1;
  if (model.body().share || !model.has_energy() || rig.seeks_load()) return false;
  State straight = state_at_rest(model.body());
  const Positions& rest = model.body().rest;
  StaticOptions small = options;
  small.linear = true;
  set_load(model, rig, factor);
  bool found = false;
  if (solve_static(model, straight, small).outcome == Outcome::converged) {
    const Connections& connections = model.body().connections;
    double strain = 0;
    for (int c = 0; c < connections.proper(); ++c) {
      const auto& [a, b] = connections.ends[c];
      const Vector3 along = (rest.col(b) - rest.col(a)).normalized();
      const double longer =
          along.dot(straight.positions.col(b) - straight.positions.col(a)) - connections.rest_length[c];
      if (connections.rest_length[c] > 0) strain = std::max(strain, std::abs(longer) / connections.rest_length[c]);
    }
    const double part = std::min(1., most / strain);
    straight.positions = rest + part * (straight.positions - rest);
    set_load(model, rig, part * factor);
    found = find_vibrations(model, straight, 1, 1e-3, options.stop).frequencies.hasNaN();
  }
  set_load(model, rig, factor);
  model.begin_step(reached, reached.time);
  return found;
}

/// Of a load step's motion: as much within a thousandth of its load is a jump, not a path that bends.
constexpr double kJump = 0.3;
constexpr int kJumpBisections = 10;

/// Of the forces along the straight line between two states, under the present load and supports, times the motion [J].
struct Pull {
  double first = 0, least = 0, most = 0;
  double size = 0;  ///< of the elastic forces, times the motion
  /// More than at the beginning: the stiffness is negative on the way. Of a body that turns far this may be said
  /// without reason, and it `resists` first.
  bool grows(double times) const { return most > times * std::abs(first) && most > 0.01 * size; }
  bool resists() const { return least < -0.01 * most; }
};

Pull pull_along(const Model& model, const State& from, const State& to) {
  constexpr int points = 8;
  const Positions way = to.positions - from.positions;
  State at = from;
  Pull pull;
  for (int point = 0; point < points; ++point) {
    at.positions = from.positions + static_cast<double>(point) / points * way;
    Positions forces = model.elastic_forces(at.positions);
    pull.size = std::max(pull.size, forces.norm() * way.norm());
    forces += model.load_forces(at);
    keep_free(model.supports, forces);
    const double own = forces.cwiseProduct(way).sum();
    if (!std::isfinite(own)) return {0, -std::numeric_limits<double>::infinity(), 1, 0};
    if (point == 0) pull.first = pull.least = pull.most = own;
    pull.least = std::min(pull.least, own), pull.most = std::max(pull.most, own);
  }
  return pull;
}

/// Where in a part of the load the body jumps, as a warning; or "". Found by bisection: the half with more motion, down
/// to where a path would move next to nothing. Leaves the model at the load `factor`, where `reached` was found.
std::string jump_within(Model& model, StaticRig& rig, StaticOptions options, LoadPart part, double factor,
                        const State& reached, bool strays) {
  options.probe = rig.leaves_saddles();
  const auto distance = [](const State& a, const State& b) {
    return (b.positions - a.positions).colwise().norm().maxCoeff();
  };
  double low = part.before, high = part.after;
  State from = std::move(part.from), to = std::move(part.to);
  const double whole = distance(from, to);
  double least = 1;
  set_load(model, rig, high);
  const Pull pull = pull_along(model, from, to);
  bool jumps = pull.grows(1.01) && (strays || !pull.resists());
  for (int bisection = 0; jumps && bisection < kJumpBisections; ++bisection) {
    const double middle = (low + high) / 2;
    set_load(model, rig, middle);
    State between = from;
    jumps = solve_static(model, between, options).outcome == Outcome::converged;
    if (!jumps) {  // from where the path ends the way beyond may lead through inverted cells: not from the other side
      between = to;
      jumps = solve_static(model, between, options).outcome == Outcome::converged;
    }
    if (!jumps) break;
    if (distance(from, between) < distance(between, to))
      from = std::move(between), low = middle;
    else
      to = std::move(between), high = middle;
    least = std::max(kJump, 0.75 * least);
    jumps = distance(from, to) > least * whole;
  }
  set_load(model, rig, high);
  jumps = jumps && pull_along(model, from, to).grows(10);
  set_load(model, rig, factor);
  model.begin_step(reached, reached.time);
  // Slack bodies come taut with the first load, and who is stopped has solved nothing.
  if (!jumps || low == 0 || stop_requested() || (options.stop && options.stop())) return "";
  return "the body snaps through at " + number(50 * (low + high), 3) +
         " % of the load: there its path of equilibria turns back, and the one found beyond lies " +
         number(1e3 * distance(from, to), 3) + " mm away, on another; " +
         (is_displaced(model, reached) ? "" : "prescribe the displacement to follow the path, or ") +
         "run the load in time (`kind: motion`) to see where the body comes to rest";
}

/// Converged means balanced: what loads and reactions leave over is no part of them worth naming, under the `whole`
/// load at least.
void check_balance(const StaticResult& solved, const Measures& measures, double force, double tolerance, bool whole,
                   bool displaced, const std::string& where, Run& run) {
  const double balance = measures.get("reaction_balance");
  const bool known = std::isfinite(force) && solved.scale > 0;
  const double left = known ? balance * std::abs(force) / solved.scale : balance;
  if (whole && displaced && known && std::abs(force) < kResists * solved.scale && balance > kBalanced) {
    run.outcome = Outcome::mechanism;
    run.cause =
        "the body does not resist this displacement: its force is at the rounding level, for it turns or comes apart "
        "freely (are its pieces joined, and its ends held by more than a point?)";
  } else if (whole && solved.residual > kBalanced && run.zero_energy_modes > 0) {
    run.outcome = Outcome::mechanism;
    run.cause = "the body does not resist this load: its resistance is at the rounding level";
  } else if (whole && solved.residual > kBalanced) {
    run.outcome = Outcome::limit_reached;
    run.cause = "the unbalanced force is " + number(solved.residual, 2) +
                " of the load, and rounding of the positions allows no less: the body hardly resists the load, the "
                "stiffness contrast is too large, or the body lies too far from the origin for its size";
  } else if (left > kBalanced) {
    run.outcome = Outcome::limit_reached;
    run.cause = "the reactions do not balance the loads: they leave " + number(left, 2) + " of them" + where;
  } else if (left > 1e-6) {
    warn_once("the reactions balance the loads to " + number(left, 2) + " only", run);
  }
  if (run.outcome == Outcome::converged && solved.residual > std::max(1e-8, 10 * tolerance))
    warn_once("the unbalanced force is " + number(solved.residual, 2) + " of the load, above the tolerance of " +
                  number(tolerance, 2) + ": rounding allows no less",
              run);
}

double total_energy(const Model& model, const State& state) {
  return model.elastic_energy(state.positions) + model.load_energy(state);
}

/// From a scene's own start a body may find no equilibrium, or one of more energy than the one reached from rest. Then
/// that one is measured, and a warning says so. [J] `before`: energy of the start.
StaticResult restart_from_rest(Model& model, const RunOptions& options, double before, StaticResult solved,
                               State& state, Run& run) {
  State other = state_at_rest(model.body());
  StaticResult from_rest = solve_static(model, other, options.statics);
  if (from_rest.outcome != Outcome::converged) return solved;
  const bool found = solved.outcome == Outcome::converged;
  if (found && !model.has_energy()) return solved;
  const double least = total_energy(model, other), above = total_energy(model, state) - least;
  const double noise = std::isfinite(before) ? 1e-9 * std::abs(before - least) : 0;
  if (found && above <= noise) return solved;
  run.restarted_from_rest = true;
  run.warnings.push_back(std::string("from the scene's start the body ") +
                         (found ? "settles in a higher-energy equilibrium than the one reached from rest"
                                : "finds no equilibrium (" + solved.cause + ")") +
                         "; the equilibrium reached from rest is measured");
  state = std::move(other);
  return from_rest;
}

/// What pushes the body as a whole where nothing holds it, however far it goes, as the cause of a failure; or "". Then
/// there is no equilibrium, and the search for one would take its time.
std::string pushed_away(const Model& model, const State& state) {
  constexpr double part = 1e-4, far = 10;
  const auto remembers = [](const auto& load) { return !load->history().empty(); };  // contact, or inertia
  if (model.body().share || std::any_of(model.loads().begin(), model.loads().end(), remembers)) return "";
  Matrix3 held = Matrix3::Zero();
  for (const Support& support : model.supports) held += Matrix3::Identity() - support.free;
  const SymmetricEigen3 directions = symmetric_eigen3(held);
  Matrix3 free = Matrix3::Zero();
  for (int k = 0; k < 3; ++k)
    if (directions.values[k] <= 1e-9 * std::max(1., directions.values.maxCoeff()))
      free += directions.vectors.col(k) * directions.vectors.col(k).transpose();
  const Positions &rest = state.positions, loads = model.load_forces(state);
  const Vector3 force = free * loads.rowwise().sum(), along = force.normalized();
  if (!(force.norm() > part * loads.colwise().norm().sum())) return "";
  State away = state;
  away.positions.colwise() += far * (rest.rowwise().maxCoeff() - rest.rowwise().minCoeff()).norm() * along;
  const Positions change = model.load_forces(away) - loads + model.elastic_forces(away.positions) -
                           model.elastic_forces(rest);  // of what holds it, as springs to the ground
  if (!((free * change.rowwise().sum()).norm() <= part * force.norm())) return "";
  const auto component = [&](int k) { return number(std::abs(along[k]) < 1e-9 ? 0 : along[k], 3); };
  return "nothing holds the " + std::string(model.body().parts.empty() ? "body" : "bodies") + " against " +
         number(force.norm(), 3) + " N of its loads along (" + component(0) + ", " + component(1) + ", " +
         component(2) + ")";
}

/// Ends a run whose body is pushed away; returns whether it is not.
bool is_held(const Model& model, const State& state, const std::string& where, Run& run) {
  const std::string away = pushed_away(model, state);
  if (away.empty()) return true;
  run.outcome = Outcome::mechanism;
  run.cause = away + where;
  return false;
}

/// Without what the rig brings to the body's surface.
bool find_start_alone(Model& model, StaticRig& rig, const RunOptions& options, bool at_rest, State& state, Start& start,
                      Run& run) {
  start = {state.positions, Positions::Zero(3, static_cast<Eigen::Index>(model.supports.size()))};
  set_load(model, rig, 0);
  model.measure_rest_force();
  if (at_rest && model.rest_force() == 0 && !any_over(model.body(), !model.load_forces(state).isZero(0))) return true;
  if (options.progress) options.progress(at_rest ? "the scene's own loads" : "the scene's start");
  constexpr const char* own = " (under what acts without the experiment's load)";
  if (at_rest && !is_held(model, state, own, run)) return false;
  const double before = total_energy(model, state);
  StaticResult solved = solve_static(model, state, options.statics);
  if (!at_rest) solved = restart_from_rest(model, options, before, std::move(solved), state, run);
  start = {state.positions, solved.reactions, state.contact_history};
  return note_solve(solved, at_rest ? own : " (from the scene's start)", run);
}

/// The body before the experiment's load: at rest, or in equilibrium with the scene's other loads, or where it comes to
/// rest from the scene's own start. False if that fails.
bool find_start(Model& model, StaticRig& rig, const RunOptions& options, bool at_rest, State& state, Start& start,
                Run& run) {
  rig.withdraw();
  const bool found = find_start_alone(model, rig, options, at_rest, state, start, run);
  rig.meet(state.positions);
  set_load(model, rig, 0);
  return found;
}

/// Whether an experiment reads a modulus off a load, which others may bear.
bool bears_load(const Body& body, const StaticExperiment& experiment) {
  bool any = false;
  for (int molecule = 0; molecule < body.size() && !any; ++molecule)
    any = !experiment.against_load(body.rest.col(molecule)).isZero(0);
  return any_over(body, any);
}

/// The part of its load that the experiment's grips do not bear: the scene's supports, contact and loads do.
/// @param before forces of these loads [N] at the start
double borne_by_others(const Model& model, const StaticExperiment& experiment, StaticRig& rig, double factor,
                       const Start& start, const Positions& before, const State& state, const StaticResult& solved) {
  const Body& body = model.body();
  const int owned = owned_molecules(body);
  std::array<double, 6> sums{};  // sizes: of grips that are moved, of those that stay, of the own load; of others
  auto& [moved, fixed, own, x, y, z] = sums;
  const auto add_other = [&, &x = x, &y = y, &z = z](const Vector3& part) {
    x += part.x(), y += part.y(), z += part.z();
  };
  for (std::size_t i = 0; i < model.supports.size(); ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    const int molecule = model.supports[i].molecule;
    if (molecule >= owned) continue;
    const Vector3 part = experiment.against_load(state.positions.col(molecule)) *
                         (solved.reactions.col(column) - start.reactions.col(column));
    if (i >= rig.own_supports)
      add_other(part);
    else
      (model.supports[i].displacement.isZero(0) ? fixed : moved) += part.norm();
  }
  const Positions all = model.load_forces(state);
  rig.set_load(0);
  const Positions without = model.load_forces(state);
  rig.set_load(factor);
  for (int molecule = 0; molecule < owned; ++molecule) {
    const Matrix3 against = experiment.against_load(state.positions.col(molecule));
    own += (against * (all.col(molecule) - without.col(molecule))).norm();
    if (!solved.linear)  // there loads that follow the body stay as they were
      add_other(against * (without.col(molecule) - before.col(molecule)));
  }
  sum_over(body, sums);
  const double others = Vector3(x, y, z).norm(), load = std::max({moved, fixed, own, others});
  return load > 0 ? others / load : 0;
}

/// Supports of the scene that hold what the experiment moves, as a warning; or "".
std::string held_and_moved(const Model& model, const StaticExperiment& experiment, const StaticRig& rig) {
  std::map<int, Vector3> moved;
  double most = 0;
  for (std::size_t i = 0; i < rig.own_supports; ++i) {
    const Support& own = model.supports[i];
    moved[own.molecule] = own.displacement;
    most = std::max(most, own.displacement.norm());
  }
  int count = 0, first = 0;
  bool beside = false;  // whether they hold more, so that the body is torn between them and the motion
  for (const Support& support : experiment.further_supports()) {
    const auto own = moved.find(support.molecule);
    beside |= own == moved.end();
    if (own == moved.end()) continue;
    const Vector3 held = own->second - support.free * own->second;
    if (held.norm() > 1e-9 * most && count++ == 0) first = support.molecule;
  }
  if (count == 0 || !beside) return "";
  const Vector3 at = 1e3 * model.body().rest.col(first);
  return "`supports` hold " + counted(count, "molecule") + " that the experiment moves, " +
         (count > 1 ? "the first " : "") + "at (" + number(at.x(), 3) + ", " + number(at.y(), 3) + ", " +
         number(at.z(), 3) +
         ") mm: there the displacement counts, and next to it the body is torn between both; take "
         "the moved end out of the `supports`";
}

/// Where the material says what stress belongs to a strain: that, and the largest difference to it, over the largest
/// such stress. False where it does not.
bool note_curve_error(const Experiment& experiment, const MeasureList& list, const Material& material, Run& run) {
  const auto axis = experiment.axis();
  const std::string strain = list.named(MeasureRole::strain), stress = list.named(MeasureRole::stress);
  double difference = 0, largest = 0;
  for (CurvePoint& point : run.curve) {
    const auto of_law = axis ? uniaxial_stress(material, *axis, point.measures.get(strain)) : std::nullopt;
    if (!of_law) return false;
    const double given = material.relaxation ? material.relaxation->long_term() * *of_law : *of_law;
    point.measures.set("material_stress", given);
    difference = std::max(difference, std::abs(point.measures.get(stress) - given));
    largest = std::max(largest, std::abs(given));
  }
  run.measures.set("curve_error", difference / largest);
  return true;
}

}  // namespace

std::string compression_text(const Model& model, const Positions& positions, const Compression& found,
                             const Material& material) {
  const int all = static_cast<int>(model.body().triangles.size());
  const auto& [a, b, c] = model.body().triangles[found.worst];
  const Vector3 at = (positions.col(a) + positions.col(b) + positions.col(c)) / 3;
  char text[240];
  std::snprintf(
      text, sizeof text,
      "%d of %d triangles in compression (most: triangle %d at %.4g, %.4g, %.4g m, %.3g Pa): a membrane would "
      "wrinkle there; `wrinkling: drop` leaves compression out",
      found.triangles, all, found.worst, at.x(), at.y(), at.z(),
      found.tension / thicknesses(model.body(), material.thickness)[static_cast<std::size_t>(found.worst)]);
  return text;
}

namespace {

/// Under preload: forces, displacements and energy as what the experiment adds, and as what there is in all.
void note_preload(const Model& model, const MeasureList& list, const StaticRig& rig, const Start& start,
                  const State& state, const RunOptions& options, StaticResult solved, double copies,
                  Measures& measures) {
  constexpr double rounding = 1e-12;  // of what there is under the load
  const Positions& rest = model.body().rest;
  const bool displaced =
      (start.positions - rest).norm() > rounding * std::max((state.positions - rest).norm(), rounding * rest.norm());
  if (!any_over(model.body(), displaced || start.reactions.norm() > rounding * solved.reactions.norm())) return;
  measures.set("preload_strain", largest_strain(model, start.positions));
  if (std::isfinite(measures.get("energy"))) {
    const double part = model.rest_part();  // the start is without what of the rest comes with the load
    if (const auto& own = model.body().unstressed) model.set_rest(own->part ? own->part(0) : 0);
    const double before = sum_over(model.body(), model.stored_energy(start.positions));
    model.set_rest(part);
    measures.set("energy_increase", measures.get("energy") - copies * before);
  }
  const Measures whole =
      rig.measure({rest, Positions::Zero(3, start.reactions.cols())}, state, options.statics, solved);
  for (const MeasureRole role : {MeasureRole::force, MeasureRole::torque, MeasureRole::displacement})
    if (const std::string name = list.named(role); common_measures().find("total_" + name))
      measures.set("total_" + name, whole.get(name));
}

/// Of the body's size, as far as a mode is shown to move it.
constexpr double kModeShown = 0.1;

/// The modes about the state that was kept last, to be looked at: shapes alone, without forces.
void keep_modes(const Vibrations& found, Run& run) {
  if (run.snapshots.empty()) return;
  Snapshot& state = run.modes.emplace_back(run.snapshots.back());
  state.at = state.number = 0;
  const Positions& about = run.snapshots.back().positions;
  const double size = (about.rowwise().maxCoeff() - about.rowwise().minCoeff()).norm();
  Snapshot mode = state;
  for (VectorX* force : {&mode.force_densities, &mode.other_force_densities, &mode.contact_pressure}) force->setZero();
  for (Positions* forces : {&mode.contact_forces, &mode.elastic_forces}) forces->setZero();
  mode.states_of_laws.clear(), mode.kept_states.clear();
  for (const Positions& shape : found.shapes) {
    mode.frequency = found.frequencies[mode.number];
    mode.at = ++mode.number;
    mode.positions = about + kModeShown * size / shape.colwise().norm().maxCoeff() * shape;
    run.modes.push_back(mode);
  }
}

}  // namespace

Measures measure_step(const Model& model, const StaticExperiment& experiment, const StaticRig& rig, const Start& start,
                      const State& state, const RunOptions& options, StaticResult& solved,
                      std::optional<contact::ContactReport>& contact) {
  Measures measures = rig.measure(start, state, options.statics, solved);
  note_preload(model, experiment.measures(), rig, start, state, options, solved, experiment.copies(), measures);
  if (const contact::Contact* touching = contact_of(model)) {
    contact = touching->report(state);
    note_contact(*contact, experiment.copies(), measures);
  }
  return measures;
}

namespace {

/// "the supports leave 3 rigid motions of the body free", or "": those that forces at this state do not resist, either.
/// Asked where displacements in space are measured.
std::string free_motions_text(const Model& model, const StaticExperiment& experiment, const State& state) {
  if (experiment.calibration() || experiment.leaves_out_rigid_motions() || model.body().share) return "";
  Positions motions, forces;
  const int free = RigidMotions(Tangent(model, state), model.supports, motions, forces).count();
  return free == 0 ? ""
                   : std::string("the supports") + (contact_of(model) ? " and what touches leave " : " leave ") +
                         counted(free, "rigid motion") + " of the " + (model.body().parts.empty() ? "body" : "bodies") +
                         " free";
}

/// The last equilibrium of a load curve, and the load there.
struct Reached {
  State state;
  double factor = 0;
};

/// What may be the reason that there is no equilibrium beyond the last one, for the end of the cause; or "".
std::string unheld_text(Model& model, const StaticExperiment& experiment, StaticRig& rig, const StaticOptions& options,
                        const Reached& reached, const Run& run) {
  if (run.zero_energy_modes > 0 && !options.linear && options.static_method == StaticMethod::newton)
    return "; `solver.method: implicit` finds where a mechanism comes to rest";
  set_load(model, rig, reached.factor);
  const std::string free = free_motions_text(model, experiment, reached.state);
  return free.empty() ? "" : "; " + free + ": hold more of " + (model.body().parts.empty() ? "it" : "them");
}

/// Takes back that the body is a mechanism where the stress that its rest gives it before the load resists every motion
/// that the laws do not, as the tension of a drum's skin does: there a load in all directions has a response.
void count_stress_against_modes(Model& model, const State& start, const RunOptions& options, Run& run) {
  if (run.zero_energy_modes == 0 || !model.body().unstressed || model.rest_part() == 0 || model.body().share) return;
  StaticOptions response = options.statics;
  response.method = "pcg";
  response.tolerance = 1e-5;
  const Positions load = scattered_directions(model.body().size());
  const StaticResult found =
      static_response(model, start.positions, load, Positions::Zero(3, load.cols()), response).result;
  model.begin_step(start, start.time);
  if (found.outcome != Outcome::converged || found.unstable) return;
  run.zero_energy_modes = 0;
  std::erase_if(run.warnings, [](const std::string& warning) { return warning.starts_with("mechanism: "); });
}

void follow_load_curve(Model& model, const StaticExperiment& experiment, StaticRig& rig, const Material& material,
                       const RunOptions& options, Run& run, const std::function<void(State&)>& begin,
                       Reached& reached) {
  State at_start = state_at_rest(model.body());
  if (begin) begin(at_start);
  Start start;
  if (!find_start(model, rig, options, !begin, at_start, start, run)) return;
  count_stress_against_modes(model, at_start, options, run);
  if (options.derivatives) options.derivatives->start(model, rig, start, options);
  const auto last = options.derivatives ? make_last_solve() : nullptr;
  const Positions before = model.load_forces(at_start);
  LoadPath path(model, rig, options.statics, std::move(at_start), last.get());
  const auto keep = [&](double load_factor, int step) {
    keep_snapshot(model, path.state(), load_factor, step, options, run);
  };
  keep(0, 0);
  const MeasureList list = experiment.measures();
  const auto taken = [&](const Measures& measures, MeasureRole role) { return measures.get(list.named(role)); };
  const int steps = experiment.load_steps();
  // What touches may do so with a jump.
  const bool may_jump =
      !options.statics.linear && !model.body().share && model.has_energy() && !contact_of(model) && !rig.seeks_load();
  bool jumped = false;
  for (int step = 1; step <= steps; ++step) {
    const std::string which = steps > 1 ? "load step " + std::to_string(step) + " of " + std::to_string(steps) : "",
                      where = which.empty() ? "" : " (" + which + ")";
    if (step > 1 && options.stop && options.stop()) {
      run.outcome = Outcome::interrupted;
      run.cause = "stopped before " + which;
      return;
    }
    if (options.progress) options.progress(which.empty() ? "solving" : which);
    const double load_factor = experiment.load_factor(step);
    if (step == 1 && !rig.seeks_load()) {
      set_load(model, rig, load_factor);
      if (!is_held(model, path.state(), where, run)) return;
    }
    LoadPart steepest;
    StaticResult solved = path.advance(load_factor, may_jump ? &steepest : nullptr);
    // Without a load there is nothing to balance, and rounding decides about motions that nothing resists.
    bool loaded = load_factor != 0;
    if (!loaded) solved.unstable = false;
    const bool acts = has_forces(model, path.state());
    if (!acts) solved.residual = 0;  // else rounding over rounding
    Measures measures;
    if (solved.outcome == Outcome::converged) {
      measures = measure_step(model, experiment, rig, start, path.state(), options, solved, run.contact);
      if (!acts && std::isfinite(measures.get("reaction_balance"))) measures.set("reaction_balance", 0);
      if (run.contact && run.contact->pairs == 0 && solved.residual > kBalanced) loaded = false;  // nothing is touched
    }
    run.bisected_load_steps = path.halvings();
    if (solved.outcome != Outcome::converged) reached = {path.state(), path.factor()};
    if (path.may_have_passed())
      warn_once(
          "something may have passed through what it touches within a load step, which was halved as far as can be: "
          "more `load_steps` help",
          run);
    if (!note_solve(solved, where, run)) {
      if (run.outcome != Outcome::interrupted && !options.statics.linear && jumps_at_rest(material))
        run.cause +=
            "; the curve's modulus jumps between compression and tension: a larger `curve.smoothing`, such as 1e-3, "
            "or more `load_steps` help";
      return;
    }
    if (loaded && acts)
      check_balance(solved, measures, taken(measures, MeasureRole::force), options.statics.tolerance, step == steps,
                    is_displaced(model, path.state()), where, run);
    if (run.outcome != Outcome::converged) return;
    if (const std::string both = held_and_moved(model, experiment, rig); !both.empty()) warn_once(both, run);
    if (experiment.of_small_strains() && any_over(model.body(), model.supports.size() > rig.own_supports))
      warn_once(
          "supports of the scene, or rigid bodies, hold what lies within the surface: the moduli are not of the "
          "body alone",
          run);
    if (loaded && acts && step == steps && bears_load(model.body(), experiment))
      if (const double part = borne_by_others(model, experiment, rig, load_factor, start, before, path.state(), solved);
          part > kBorne)
        warn_once("supports, contact or loads of the scene bear " + number(100 * part, 3) +
                      " % of the load: the modulus is not of the body alone",
                  run);
    const double strain = taken(measures, MeasureRole::strain);
    const bool pressed = taken(measures, MeasureRole::displacement) < 0 || strain < 0,
               through = pressed && strain <= -1;
    // A step that ends on another branch takes many iterations.
    const bool strays = path.halvings() > 0 || solved.newton_iterations >= kStraying;
    const bool known = std::find(run.warnings.begin(), run.warnings.end(), kBuckled) != run.warnings.end();
    const bool buckled = pressed && !options.statics.linear && (through || (strays && !known)) &&
                         buckles(model, rig, options.statics, load_factor, path.state());
    if (through) {
      run.outcome = Outcome::inverted;
      run.cause = (buckled ? "the body buckles under this load and folds over: "
                           : "the load presses the body through itself: ") +
                  std::string("strain below −100 %") + where;
      return;
    }
    if (buckled) warn_once(kBuckled, run);
    if (steepest.slope >= 0 && !known && !buckled && !jumped && !solved.unstable) {
      const std::string text =
          jump_within(model, rig, options.statics, std::move(steepest), load_factor, path.state(), strays);
      jumped = !text.empty();
      if (jumped) run.warnings.push_back(text);
    }
    run.curve.push_back({load_factor, measures, solved.newton_iterations, solved.linear_iterations, solved.residual});
    if (options.derivatives) {
      run.curve.back().gradients = options.derivatives->at(model, experiment, rig, start, path.state(), solved,
                                                           load_factor, steps > 1 && step == steps, options, *last);
      for (const std::string& doubt : options.derivatives->take_doubts()) warn_once(doubt, run);
    }
    keep(load_factor, step);
    reached = {path.state(), load_factor};
  }
  run.end = path.state().positions;
  if (const Vibrations* found = rig.vibrations()) keep_modes(*found, run);
  run.measures = run.curve.back().measures;
  run.gradients = run.curve.back().gradients;
  run.remark = experiment.remark(run.measures);
  if (const contact::Contact* contact = contact_of(model); contact && run.contact && run.contact->pairs == 0)
    if (const std::string gap = gap_text(*contact, model.body(), path.state()); !gap.empty())
      run.remark = (run.remark.empty() ? "nothing touches" : run.remark) + ": " + gap;
  // What touches at the end of a load holds as long as it is pressed.
  if (const std::string free =
          contact_of(model) ? ""
                            : free_motions_text(model, experiment,
                                                options.statics.linear ? state_at_rest(model.body()) : path.state());
      !free.empty())
    run.warnings.push_back(free + ", any of which may be in its displacements: hold more of " +
                           (model.body().parts.empty() ? "it" : "them"));
  // What resists bending may bear compression.
  if (!model.body().share && !model.body().triangles.empty() && !options.statics.linear &&
      !(material.bending_rigidity > 0)) {
    const Positions& at_end = path.state().positions;
    if (const Compression found = find_compression(model, at_end); found.triangles > 0)
      run.warnings.push_back(compression_text(model, at_end, found, material));
  }
  const bool grows = std::is_sorted(run.curve.begin(), run.curve.end(), [](const CurvePoint& a, const CurvePoint& b) {
    return a.load_factor < b.load_factor;
  });
  if (grows && note_curve_error(experiment, list, material, run) && options.derivatives)
    options.derivatives->add_curve_error(list, run);
  if (steps > 1 && model.has_full_tangent()) {
    rig.measure_end(path.state(), options.statics, run.measures, run.linear_iterations);
    double sum = 0;
    for (const CurvePoint& point : run.curve) sum += taken(point.measures, MeasureRole::youngs_modulus);
    if (std::isfinite(sum)) run.measures.set("average_modulus", sum / steps);
    add_mean_gradient(run.curve, list.named(MeasureRole::youngs_modulus), "average_modulus", run.gradients);
  }
}

}  // namespace

void solve_load_curve(Model& model, const StaticExperiment& experiment, StaticRig& rig, const Material& material,
                      const RunOptions& options, Run& run, const std::function<void(State&)>& begin) {
  Reached reached{state_at_rest(model.body())};
  follow_load_curve(model, experiment, rig, material, options, run, begin, reached);
  if (run.outcome == Outcome::limit_reached || run.outcome == Outcome::diverged || run.outcome == Outcome::mechanism)
    run.cause += unheld_text(model, experiment, rig, options.statics, reached, run);
}

}  // namespace elastin::lab
