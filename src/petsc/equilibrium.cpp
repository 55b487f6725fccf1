#include "petsc/equilibrium.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "core/linear/linear_choice.h"
#include "core/solve/newton.h"
#include "core/solve/steppers.h"
#include "elastin/core/base/text.h"
#include "petsc/linear.h"

namespace elastin::petsc {
namespace {

/// The grids of boxes where the options, or a rule, choose them.
const BoxHierarchy* chosen_boxes(const Model& model, const Tangent& local, SharedSetting& setting,
                                 const StaticOptions& options, double tolerance, std::string& reason) {
  bool wanted = options.method->name == "multigrid";
  if (!options.method->make) std::tie(wanted, reason) = multigrid_is_worth_it(model, tolerance);
  if (!wanted) return nullptr;
  if (!setting.boxes) setting.boxes = std::make_unique<BoxHierarchy>(local, setting.body);
  return setting.boxes.get();
}

std::string solver_name(const char* method, const std::string& preconditioner, const SharedBody& body) {
  return std::string(method) + " petsc " + preconditioner + " on " + counted(body.processes(), "process", "processes");
}

/// Forces of loads that stay as they are, and what all loads are as sizes.
struct DeadLoads {
  Positions owned;   ///< [N]
  double scale = 0;  ///< sum of their norms
};
DeadLoads dead_loads(const Model& model, const SharedBody& body) {
  const State rest = state_at_rest(model.body());
  DeadLoads loads{Positions::Zero(3, body.owned())};
  for (const auto& load : model.loads()) {
    Positions one = Positions::Zero(3, model.body().size()), local;
    load->add_forces(rest, one);
    body.take(one, local);
    loads.scale +=
        body.of_share() ? std::sqrt(body.sum(local.leftCols(body.owned()).squaredNorm())) : ordered_norm(one);
    loads.owned += local.leftCols(body.owned());
  }
  return loads;
}

/// Saddles that one solve goes down from.
constexpr int kSaddles = 3;

/// Size of the fixed components of owned molecules' vectors, of all.
double fixed_norm(const SharedModel& model, const Positions& owned) {
  double sum = 0;
  for (const Support& support : model.supports()) {
    const Vector3 v = owned.col(support.molecule);
    sum += (v - support.free * v).squaredNorm();
  }
  return std::sqrt(model.body().sum(sum));
}

/// Where Newton's method stands.
struct Point {
  State state;  ///< of the subdomain; of an equilibrium positions alone
  Vector unbalanced;
  double energy = 0, norm = 0, scale = 0, noise = 0;
};

class Newton {
 public:
  Newton(Model& model, SharedSetting& setting, const StaticOptions& options, const Kinematics* kinematics)
      : given_(model),
        setting_(setting),
        body_(setting.body),
        options_(options),
        kinematics_(kinematics),
        model_(model, setting.body, kinematics ? SharedModel::Use::step : SharedModel::Use::equilibrium),
        with_energy_(Problem(model, kinematics).with_energy),
        motion_(setting.body.make_vector()) {
    if (!kinematics) loads_ = dead_loads(model, setting.body);
  }

  StaticResult solve(State& state) {
    StaticResult result;
    Point now;
    if (kinematics_)
      now.state = state;
    else
      body_.take(state.positions, now.state.positions);
    evaluate(now);
    if (!std::isfinite(now.energy)) {
      result.outcome = Outcome::inverted;
      const bool here = !std::isfinite(model_.local().elastic_energy(now.state.positions)) || !body_.of_share();
      result.cause = first_over(given_.body(), here ? inverted_text(given_.body(), state.positions) : "") +
                     " at the start of the step";
      return result;
    }
    std::string preconditioner = "pcg";
    bool stable_start = false;
    int saddles = 0;
    double forcing = 1e-3, last = now.norm;
    while (true) {
      if (!std::isfinite(now.norm + now.scale)) {
        stop(Outcome::diverged, "the forces are too large for numbers", result);
        break;
      }
      const SharedTangent tangent(model_, now.state, kinematics_ ? kinematics_->weights : Weights{});
      result.scale = now.scale;
      result.residual = now.scale > 0 ? now.norm / now.scale : 0;
      const double goal = std::max(options_.tolerance * now.scale, 2 * tangent.rounding_floor());
      if (now.norm <= goal) {
        if (!options_.probe || kinematics_ || saddles == kSaddles || !may_buckle(now.state.positions)) break;
        result.unstable = find_negative_direction(tangent, motion_, result.linear_iterations);
        if (!result.unstable || !stable_start || !leave_saddle(now)) break;
        ++saddles;
        result.left_saddle = true;
        continue;
      }
      if (result.newton_iterations == options_.newton_limit) {
        const bool cut_short = kinematics_ && kinematics_->cut_short;
        stop(Outcome::limit_reached,
             cut_short ? "" : "no equilibrium within " + counted(options_.newton_limit, "Newton iteration"), result);
        break;
      }
      // Solve each step no further than the next unbalanced force can use. [Eisenstat & Walker 1996, choice 2]
      if (result.newton_iterations > 0) forcing = std::min(1e-2, 0.5 * std::pow(now.norm / last, 2));
      forcing = std::max(forcing, 0.1 * goal / now.norm);
      last = now.norm;
      const BoxHierarchy* boxes =  // inertia keeps iterations few
          kinematics_ ? nullptr : chosen_boxes(given_, tangent.local(), setting_, options_, forcing, result.reason);
      const SharedLinearResult linear = solve_linear(tangent, boxes, now.unbalanced, forcing, motion_);
      preconditioner = linear.preconditioner;
      result.linear_iterations += linear.iterations;
      ++result.newton_iterations;
      result.unstable = linear.status == LinearStatus::negative_mode;
      if (result.newton_iterations == 1) stable_start = !result.unstable;
      if (linear.status != LinearStatus::solved && linear.residual > 0.9) limit_motion();
      bool inverted = false;
      const bool found = line_search(now, inverted);
      result.cut_steps += inverted;
      if (found) continue;
      const bool adrift = linear.status == LinearStatus::zero_mode;
      stop(adrift     ? Outcome::mechanism
           : inverted ? Outcome::inverted
                      : Outcome::diverged,
           adrift     ? "the loads work on a zero-energy mode that does not stiffen"
           : inverted ? "any further step would invert a cell"
                      : "no step lowers the unbalanced force",
           result);
      break;
    }
    result.solver = solver_name("newton", preconditioner, body_);
    if (kinematics_) {
      state = std::move(now.state);
      return result;  // a step's reactions are not needed
    }
    body_.gather(now.state.positions.leftCols(body_.owned()), state.positions);
    result.reactions = reactions(state, now);
    return result;
  }

 private:
  static void stop(Outcome outcome, std::string cause, StaticResult& result) {
    result.outcome = outcome;
    result.cause = std::move(cause);
  }

  /// On the supports of what was given; none on those of ghosts.
  Positions reactions(const State& state, const Point& now) {
    Positions forces;
    if (!body_.of_share()) {
      given_.set_forces(state, forces);
    } else {
      forces_.setZero(3, body_.size());
      model_.local().add_elastic_forces(now.state.positions, forces_, workspace_);
      const Vector sums = body_.make_vector();
      body_.add_up(forces_, sums);
      body_.read(sums, owned_);
      forces = Positions::Zero(3, body_.size());
      forces.leftCols(body_.owned()) = owned_ + loads_.owned;
    }
    return -fixed_components(given_.supports, forces);
  }

  /// Sets all of a point that follows from its positions.
  void evaluate(Point& point) {
    const Positions& x = point.state.positions;
    point.norm = point.scale = point.noise = 0;
    if (kinematics_) {
      set_velocities(given_, *kinematics_, point.state);
      const Weights& weights = kinematics_->weights;
      point.state.accelerations = kinematics_->accelerations + weights.acceleration * (x - kinematics_->start);
    }
    double own = own_energy(point.state);
    if (!model_.local().admissible(x)) own = std::numeric_limits<double>::infinity();
    point.energy = body_.sum(own);
    if (!std::isfinite(point.energy)) return;
    forces_.setZero(3, body_.size());
    model_.local().add_elastic_forces(x, forces_, workspace_);
    if (!point.unbalanced) point.unbalanced = body_.make_vector();
    if (kinematics_) {
      given_.add_other_forces(point.state, forces_, workspace_);
      owned_ = forces_.leftCols(body_.owned());
      point.scale = add_inertia(point.state);
    } else {
      body_.add_up(forces_, point.unbalanced);
      body_.read(point.unbalanced, owned_);
      owned_ += loads_.owned;
      point.scale = loads_.scale;
    }
    body_.write(owned_, point.unbalanced);
    point.scale += fixed_norm(model_, owned_);
    model_.keep_free(point.unbalanced);
    check(VecNorm(point.unbalanced, NORM_2, &point.norm));
    if (with_energy_) set_noise(point);
  }

  /// Of what this process counts; of a step with that of the inertia, see elastin::evaluate.
  double own_energy(const State& state) {
    const Positions& x = state.positions;
    if (!kinematics_) {
      const auto moved = (x - model_.local().body().rest).leftCols(body_.owned());
      return model_.local().elastic_energy(x) - (loads_.owned.array() * moved.array()).sum();
    }
    return given_.elastic_energy(x) + given_.load_energy(state) + step_energy(given_, *kinematics_, x);
  }

  /// Takes the inertia of owned molecules from their forces. The size of loads and inertia [N].
  double add_inertia(const State& state) {
    const int owned = body_.owned();
    double scale = 0;
    for (const auto& load : given_.loads()) {
      forces_.setZero();
      load->add_forces(state, forces_);
      scale += std::sqrt(body_.sum(forces_.leftCols(owned).squaredNorm()));
    }
    const Positions inertia = state.accelerations.leftCols(owned) * given_.body().mass.head(owned).asDiagonal();
    owned_ -= inertia;
    return scale + std::sqrt(body_.sum(inertia.squaredNorm()));
  }

  /// What rounding of the positions does to the energy [J].
  void set_noise(Point& point) {
    const Positions& x = point.state.positions;
    const Connections& connections = model_.local().body().connections;
    densities_.setZero(connections.size());
    for (const auto* law : model_.local().edge_laws()) law->add_force_densities(x, densities_, workspace_);
    double pull = 0;
    for (int c = 0; c < connections.size(); ++c) {
      const auto& [a, b] = connections.ends[c];
      pull += std::abs(densities_[c]) * (x.col(b) - x.col(a)).norm();
    }
    for (const auto* law : model_.local().nodal_laws()) pull += law->internal_force(x);
    const double reach = body_.largest(x.size() > 0 ? x.cwiseAbs().maxCoeff() : 0);
    const double all = body_.sum(pull) + std::sqrt(static_cast<double>(body_.all_molecules())) * point.scale;
    point.noise = 4 * std::numeric_limits<double>::epsilon() * reach * all;
  }

  /// Halves the step until the energy falls or, where rounding hides that, the unbalanced force does.
  bool line_search(Point& now, bool& inverted) {
    Positions motion;
    body_.spread(motion_, motion);
    if (!body_.all(motion.allFinite())) return false;
    double slope = 0;
    check(VecDot(now.unbalanced, motion_, &slope));
    slope = -slope;
    Point trial;
    if (kinematics_) trial.state = now.state;
    for (double step = 1; step > 1e-9; step /= 2) {
      trial.state.positions = now.state.positions + step * motion;
      evaluate(trial);
      inverted |= std::isinf(trial.energy);
      if (!std::isfinite(trial.energy) || !std::isfinite(trial.norm)) continue;
      bool falls = with_energy_ && slope < 0 && trial.energy <= now.energy + 1e-4 * step * slope;
      if (!with_energy_) {  // of a step: its forces' work along it gives the same criterion
        double work = 0;
        check(VecDot(trial.unbalanced, motion_, &work));
        falls = slope < 0 && (work - slope) / 2 >= -1e-4 * slope;
      }
      const bool calmer = trial.norm < (1 - 1e-4 * step) * now.norm;
      if (falls || (calmer && (!with_energy_ || trial.energy - now.energy <= trial.noise))) {
        std::swap(now, trial);
        return true;
      }
    }
    return false;
  }

  /// Whether the body may be strained enough to buckle; as solve_newton.
  bool may_buckle(const Positions& x) const {
    const auto [low, high] = outline_of_whole(given_.body());
    const Vector3 size = high - low;
    const double thin = size.minCoeff() / size.maxCoeff(), limit = std::min(1e-4, 0.1 * thin * thin);
    const Connections& connections = body_.local().connections;
    bool strained = false;
    for (int c = 0; c < connections.size() && !strained; ++c) {
      const auto& [a, b] = connections.ends[c];
      const double length = connections.rest_length[c];
      strained = !(std::abs((x.col(b) - x.col(a)).norm() - length) < limit * length);
    }
    return !body_.all(!strained);
  }

  /// Goes along the motion, or against it, as far as the energy falls by more than its rounding.
  bool leave_saddle(Point& now) {
    Positions direction;
    body_.spread(motion_, direction);
    const double furthest = body_.largest(direction.cols() ? direction.colwise().norm().maxCoeff() : 0);
    const double length = 0.1 * mean_length(given_.body()) / furthest;
    Point trial;
    for (double step = length; step > 1e-6 * length; step /= 4)
      for (const double factor : {step, -step}) {
        trial.state.positions = now.state.positions + factor * direction;
        evaluate(trial);
        if (!(now.energy - trial.energy > 10 * std::max(now.noise, trial.noise))) continue;
        std::swap(now, trial);
        return true;
      }
    return false;
  }

  /// A direction without stiffness has no length of its own: no molecule goes further than half its connections' mean.
  void limit_motion() {
    Positions motion;
    body_.read(motion_, motion);
    const double furthest = body_.largest(motion.cols() ? motion.colwise().norm().maxCoeff() : 0);
    const double most = 0.5 * mean_length(given_.body());
    if (furthest > most) check(VecScale(motion_, most / furthest));
  }

  Model& given_;
  SharedSetting& setting_;
  const SharedBody& body_;
  const StaticOptions& options_;
  const Kinematics* kinematics_;  ///< null: an equilibrium
  SharedModel model_;
  bool with_energy_;  ///< whether what is sought has the least of one
  DeadLoads loads_;
  Vector motion_;
  Positions forces_, owned_;
  VectorX densities_;
  Workspace workspace_;
};

}  // namespace

StaticResult balance(Model& model, SharedSetting& setting, State& state, const StaticOptions& options,
                     const Kinematics* kinematics) {
  return Newton(model, setting, options, kinematics).solve(state);
}

StaticResponse respond(Model& model, SharedSetting& setting, const Positions& at, const Positions& load_change,
                       const Positions& displacement, const StaticOptions& options) {
  const SharedBody& body = setting.body;
  SharedModel shared(model, body);
  Positions prescribed = Positions::Zero(3, at.cols());
  for (const Support& support : model.supports) {
    const Vector3 w = displacement.col(support.molecule);
    prescribed.col(support.molecule) = w - support.free * w;
  }
  Positions local, motion, loads, owned;
  body.take(at, local);
  const SharedTangent tangent(shared, State{std::move(local), Positions()});
  body.take(prescribed, motion);
  body.take(load_change, loads);
  Vector rhs = body.make_vector(), solution = body.make_vector();
  tangent.apply(motion, rhs);
  body.read(rhs, owned);
  owned = (loads.leftCols(body.owned()) - owned).eval();
  body.write(owned, rhs);
  const double supported = fixed_norm(shared, owned);
  shared.keep_free(rhs);
  double size = 0;
  check(VecNorm(rhs, NORM_2, &size));

  StaticResponse response;
  StaticResult& result = response.result;
  const BoxHierarchy* boxes = chosen_boxes(model, tangent.local(), setting, options, options.tolerance, result.reason);
  const SharedLinearResult linear = solve_linear(tangent, boxes, rhs, options.tolerance, solution);
  result.solver = solver_name("linear", linear.preconditioner, body);
  result.linear = true;
  result.newton_iterations = 1;
  result.linear_iterations = linear.iterations;
  result.scale = size + supported;
  result.residual = size > 0 ? linear.residual * size / (size + supported) : 0;
  result.unstable = linear.status == LinearStatus::negative_mode;
  if (linear.status != LinearStatus::solved && linear.residual > std::max(options.tolerance, 1e-8)) {
    const bool mode = linear.status == LinearStatus::zero_mode, negative = linear.status == LinearStatus::negative_mode;
    result.outcome = mode ? Outcome::mechanism : negative ? Outcome::diverged : Outcome::limit_reached;
    result.cause = mode       ? "the loads work on a zero-energy mode"
                   : negative ? "the stiffness has directions of negative stiffness"
                              : "the linear solver ran out of iterations";
  }
  body.spread(solution, motion);
  if (!body.all(motion.allFinite())) {
    result.outcome = Outcome::diverged;
    result.cause = "the displacements are too large for numbers";
  }
  Positions prescribed_here;
  body.take(prescribed, prescribed_here);
  motion += prescribed_here;
  tangent.apply(motion, rhs);
  body.read(rhs, owned);
  owned -= loads.leftCols(body.owned());
  Positions forces = Positions::Zero(3, body.size());
  if (body.of_share())
    forces.leftCols(body.owned()) = owned;
  else
    body.gather(owned, forces);
  result.reactions = fixed_components(model.supports, forces);
  body.gather(motion.leftCols(body.owned()), response.motion);
  return response;
}

}  // namespace elastin::petsc
