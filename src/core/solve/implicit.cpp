#include "core/solve/implicit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>

#include "core/parallel/parallel.h"
#include "core/solve/steppers.h"
#include "elastin/core/base/error.h"
#include "elastin/core/model/share.h"
#include "elastin/core/solve/engine.h"

namespace elastin {
namespace {

/// A step that fails is bisected, and its halves again, down to this part of it.
constexpr double kSmallestSubstep = 1. / 1024;

/// Of a transposed step: residual of its linear solves, and how many there are where damping turns with the body.
constexpr double kTransposedTolerance = 1e-13;
constexpr int kTransposedRounds = 30;

constexpr const char* kOpened = "a contact that pushed has opened within a step, which has no derivative there";

template <class Vectors>
double largest_square(const Vectors& vectors) {
  return vectors.colwise().squaredNorm().maxCoeff();
}

bool may_push(const std::unique_ptr<Load>& load) { return load->changes() && load->acts_at_rest(); }

/// Forces in the free directions; their energy.
void set_push(const Model& model, const State& state, Push& push) {
  const int n = model.body().size();
  push.forces.setZero(3, n), push.elastic.setZero(3, n);
  push.energy = 0;
  for (const auto& load : model.loads()) {
    if (!may_push(load)) continue;
    load->add_forces(state, push.forces);
    load->add_resistance(state, push.elastic);
    push.energy += load->energy(state);
  }
  push.elastic = push.forces - push.elastic;
  keep_free(model.supports, push.forces);
}

/// A load that a balance within a step takes as it is at the step's end, times a factor. That end lies beyond what the
/// balance seeks: x₀ + (x − x₀)/share.
class AtEnd final : public LoadOf {
 public:
  AtEnd(std::unique_ptr<Load> load, const State& start, double share, double factor)
      : LoadOf(std::move(load)), start_(start), share_(share), factor_(factor) {}
  void add_forces(const State& state, Positions& forces) const override {
    sum_.setZero(3, forces.cols());
    load_->add_forces(end_of(state), sum_);
    forces += factor_ * sum_;
  }
  double energy(const State& state) const override { return factor_ * share_ * load_->energy(end_of(state)); }
  void add_change(const State& state, const Positions& motion, const Positions& sped,
                  Positions& forces) const override {
    sum_.setZero(3, forces.cols());
    load_->add_change(end_of(state), motion, sped, sum_);
    forces += factor_ / share_ * sum_;
  }
  void visit_blocks(const State& state, double velocity_weight, const BlockVisitor& visit) const override {
    const auto scaled = [&](int a, int b, const Matrix3& block) { visit(a, b, factor_ / share_ * block); };
    load_->visit_blocks(end_of(state), velocity_weight, std::ref(scaled));
  }
  std::vector<WideTerm> wide_terms(const State& state) const override {
    std::vector<WideTerm> terms = load_->wide_terms(end_of(state));
    for (WideTerm& term : terms) term.factor *= factor_ / share_;
    return terms;
  }
  bool update_multipliers(State& state) const override {
    if (share_ == 1) return load_->update_multipliers(state);
    State end = end_of(state);
    if (!load_->update_multipliers(end)) return false;
    state.carry_over(end);
    return true;
  }

  /// The load itself; nothing is left here.
  std::unique_ptr<Load> extract() { return std::move(load_); }

 private:
  const State& end_of(const State& state) const {
    if (share_ == 1) return state;
    end_.carry_over(state);
    end_.positions = start_.positions + (state.positions - start_.positions) / share_;
    end_.velocities = start_.velocities + (state.velocities - start_.velocities) / share_;
    end_.time = start_.time + (state.time - start_.time) / share_;
    return end_;
  }
  const State& start_;
  double share_, factor_;
  mutable State end_;
  mutable Positions sum_;
};

/// Takes the accelerations that a push gives out of those.
void take_out(const Push& push, const VectorX& mass, Positions& accelerations) {
  for (int i = 0; i < mass.size(); ++i)
    if (!push.forces.col(i).isZero(0)) accelerations.col(i) -= push.forces.col(i) / mass[i];
}

}  // namespace

void Implicit::cut_short(int iterations) {
  kinematics_.cut_short = iterations > 0;
  if (kinematics_.cut_short) newton_.newton_limit = iterations;
}

StaticResult Implicit::balance(Model& model, State& next, const Kinematics& kinematics) {
  if (model.has_complete_rows()) return newton_.engine->balance_step(model, next, newton_, kinematics);
  return solve_newton(model, next, newton_, &kinematics, workspace_);
}

StepResult Implicit::advance(Model& model, State& state, double dt) {
  model.declare_history(state);
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

void Implicit::advance(Model& model, State& state, double dt, double smallest, StepResult& result) {
  try_step(model, state, dt, result);
  if (result.outcome == Outcome::converged || dt / 2 < smallest) return;
  result.outcome = Outcome::converged;
  for (int half = 0; half < 2 && result.outcome == Outcome::converged; ++half)
    advance(model, state, dt / 2, smallest, result);
}

void Implicit::set_kinematics(const State& state, const Positions& a, double dt) {
  const Positions& v = state.velocities;
  kinematics_.start = state.positions;
  if (!newmark()) {
    kinematics_.weights = {1 / dt, 1 / (dt * dt)};
    kinematics_.velocities.setZero(3, v.cols());
    kinematics_.accelerations = -v / dt;
    return;
  }
  const double beta = beta_, gamma = gamma_, share = shares_.forces, of_inertia = shares_.inertia;
  kinematics_.weights = {gamma / (beta * dt), of_inertia / (share * beta * dt * dt)};
  kinematics_.velocities = v * (1 - share * gamma / beta) + a * (share * dt * (1 - gamma / (2 * beta)));
  kinematics_.accelerations = v * (-of_inertia / (beta * dt)) + a * (1 - of_inertia / (2 * beta));
}

void Implicit::end_sweeps(const Model& model, const Kinematics& kinematics, State& next, StaticResult& result) {
  follow(model, kinematics, next);
  if (!next.positions.allFinite()) {
    result.outcome = Outcome::diverged;
    result.cause = "the sweeps have no finite end";
  } else if (!model.admissible(next.positions)) {
    result.outcome = Outcome::inverted;
    result.cause = inverted_text(model.body(), next.positions);
  }
}

/// Where the search starts: as if nothing changed, if that inverts no cell; else from where the body is.
void Implicit::set_first_guess(const Model& model, const State& state, double dt) {
  const double share = shares_.forces;
  next_.positions = state.positions + share * dt * state.velocities;
  next_.velocities = state.velocities;
  next_.carry_over(state);
  next_.time = state.time + share * dt;
  if (newmark()) {
    next_.positions += share * dt * dt / 2 * state.accelerations;
  } else {
    next_.accelerations.setZero(3, model.body().size());
    // Contact is stiffer than that: a push would throw what sticks far past where it is in balance.
    if (std::none_of(model.loads().begin(), model.loads().end(), may_push)) balance_as_one(model);
  }
  apply_supports(model, next_.positions);
  if (!any_over(model.body(), !model.admissible(next_.positions))) return;
  next_.positions = state.positions;
  apply_supports(model, next_.positions);
}

PushesAtEnd::PushesAtEnd(Model& model, const State& start, double share, double factor) : model_(model) {
  for (auto& load : model.extract_loads())
    model.add(may_push(load) ? std::make_unique<AtEnd>(std::move(load), start, share, factor) : std::move(load));
}

PushesAtEnd::~PushesAtEnd() {
  for (auto& load : model_.extract_loads()) {
    auto* at_end = dynamic_cast<AtEnd*>(load.get());
    model_.add(at_end ? at_end->extract() : std::move(load));
  }
}

/// Contact that opens within a step would push on through the air by half of the force at a step's beginning, and what
/// is met within one would be pushed back from where it never was held: both give back more than was put in. A step
/// that makes energy so is to be solved again with pushes as they are at its end alone, which takes energy and never
/// gives any [Kane et al. 1999]. Contact that lasts stays of order 2.
std::optional<double> Implicit::made_by_pushes(const Model& model, const State& from, const State& to, double share) {
  if (std::none_of(model.loads().begin(), model.loads().end(), may_push)) return {};
  set_push(model, from, push_);
  set_push(model, to, pushed_);
  const Body& body = model.body();
  if (!any_over(body, !push_.forces.isZero(0) || (share != 1 && !pushed_.forces.isZero(0)))) return {};
  if (share != 1) {
    within_.carry_over(to);
    within_.positions = from.positions + share * (to.positions - from.positions);
    within_.velocities = from.velocities + share * (to.velocities - from.velocities);
    within_.time = from.time + share * (to.time - from.time);
    set_push(model, within_, push_within_);
  }
  std::array<double, 3> energies{0, push_.energy, pushed_.energy};
  bool opens = false;
  for (int i = 0; i < owned_molecules(body); ++i) {
    const Vector3 motion = to.positions.col(i) - from.positions.col(i);
    const double before = push_.forces.col(i).norm(), after = pushed_.forces.col(i).norm();
    if (share == 1) {
      energies[0] += (push_.elastic.col(i) + pushed_.elastic.col(i)).dot(motion) / 2;
      opens |= before > 0 && !(after > before / 2);
    } else {
      energies[0] += push_within_.elastic.col(i).dot(motion);
      opens |= before + after > 0 && !(push_within_.forces.col(i).norm() > 0.4 * std::max(before, after));
    }
  }
  sum_over(body, energies);
  const auto [work, energy_before, energy_after] = energies;
  if (!any_over(body, opens)) return {};
  const double size = std::max(std::abs(energy_before), std::abs(energy_after));
  return work + energy_after - energy_before - 1e-9 * size;
}

StaticResult Implicit::balance_at_end(Model& model, const State& state, double dt) {
  set_kinematics(state, state.accelerations, dt);
  set_first_guess(model, state, dt);
  const StaticResult solved = balance(model, next_, kinematics_);
  if (!newmark() || solved.outcome != Outcome::converged || !(made_by_pushes(model, state, next_, 1) > 0.))
    return solved;
  withheld_ = state.accelerations;
  take_out(push_, model.body().mass, withheld_);
  set_kinematics(state, withheld_, dt);
  set_first_guess(model, state, dt);
  StaticResult again;
  {
    const PushesAtEnd at_end(model, state, 1, 2);  // in full: of the end's force Newmark's method takes half
    again = balance(model, next_, kinematics_);
  }
  set_push(model, next_, pushed_);
  take_out(pushed_, model.body().mass, next_.accelerations);
  again.newton_iterations += solved.newton_iterations;
  again.linear_iterations += solved.linear_iterations;
  return again;
}

/// Brings `next_` from within the step, where it is in balance, to the step's end.
void Implicit::go_on_to_end(const Model& model, const State& state, double dt) {
  const auto [share, of_inertia] = shares_;
  next_.positions = state.positions + (next_.positions - state.positions) / share;
  next_.accelerations = state.accelerations + (next_.accelerations - state.accelerations) / of_inertia;
  next_.velocities = state.velocities + dt * ((1 - gamma_) * state.accelerations + gamma_ * next_.accelerations);
  next_.time = state.time + dt;
  apply_supports(model, next_.positions);
  move_with_supports(model.supports, next_.velocities);
}

/// A step that is balanced within: y = x₀ + α_f (x₁ − x₀) is sought, on which the velocities and accelerations there
/// depend linearly, so that it is one of three weights as well.                              [Chung & Hulbert 1993]
StaticResult Implicit::balance_within(Model& model, const State& state, double dt) {
  const StaticResult solved = balance_once_within(model, state, dt);
  if (solved.outcome != Outcome::converged || !(made_by_pushes(model, state, next_, shares_.forces) > 0.))
    return solved;
  const PushesAtEnd at_end(model, state, shares_.forces, 1);
  StaticResult again = balance_once_within(model, state, dt);
  again.newton_iterations += solved.newton_iterations;
  again.linear_iterations += solved.linear_iterations;
  return again;
}

StaticResult Implicit::balance_once_within(Model& model, const State& state, double dt) {
  const double share = shares_.forces;
  ends_ = model.supports;
  if (model.drive) {  // forces that it sets meet the body where it is balanced; supports go straight to the step's end
    model.drive(state.time + share * dt, model.supports);
    model.supports = ends_;
  }
  for (Support& support : model.supports) {
    const Vector3 begin = state.positions.col(support.molecule) - model.body().rest.col(support.molecule);
    support.displacement = begin + share * (support.displacement - begin);
    const Vector3 velocity = state.velocities.col(support.molecule);
    support.velocity = velocity + share * (support.velocity - velocity);
  }
  model.begin_step(state, state.time + share * dt);
  set_kinematics(state, state.accelerations, dt);
  set_first_guess(model, state, dt);
  StaticResult solved = balance(model, next_, kinematics_);
  const bool usable =
      solved.outcome == Outcome::converged || (kinematics_.cut_short && solved.outcome == Outcome::limit_reached);
  if (usable) balance_as_one(model);
  model.supports = ends_;
  if (model.drive) model.drive(state.time + dt, model.supports);
  model.begin_step(state, state.time + dt);
  go_on_to_end(model, state, dt);
  if (usable && any_over(model.body(), !model.admissible(next_.positions))) {
    solved.outcome = Outcome::inverted;
    solved.cause = inverted_anywhere(model, next_.positions) + " at the end of the step";
  }
  return solved;
}

void Implicit::try_step(Model& model, State& state, double dt, StepResult& result) {
  if (model.drive) model.drive(state.time + dt, model.supports);
  model.begin_step(state, state.time + dt);
  const StaticResult solved = within() ? balance_within(model, state, dt) : balance_at_end(model, state, dt);
  result.newton_iterations += solved.newton_iterations;
  result.linear_iterations += solved.linear_iterations;
  const bool cut_short = kinematics_.cut_short && solved.outcome == Outcome::limit_reached;
  if ((solved.outcome != Outcome::converged && !cut_short) || any_over(model.body(), !next_.positions.allFinite())) {
    result.outcome = solved.outcome == Outcome::converged ? Outcome::diverged : solved.outcome;
    result.cause = solved.cause;
    return;
  }
  if (!within()) balance_as_one(model);
  hold_accelerations(model);
  if (model.max_step_fraction(state, next_) < 1) {
    result.outcome = Outcome::limit_reached;
    result.cause = "something would be passed through within a step";
    return;
  }
  model.commit_step(next_);
  ++result.substeps;
  result.cause.clear();
  const double change = largest_over(model.body(), newmark() ? largest_square(next_.accelerations - state.accelerations)
                                                             : largest_square(next_.accelerations));
  // Newmark: [Zienkiewicz & Xie 1991]; Euler: half of dt² times the acceleration.
  const double factor = newmark() ? std::max(std::abs(beta_ - 1. / 6), 1. / 12) : 0.5;
  result.error = factor * dt * dt * std::sqrt(change);
  std::swap(state, next_);
}

/// What is held keeps no acceleration: Newmark's formula would have it swing for ever about that of the prescribed
/// motion, and hand it to the body when it is let go.
void Implicit::hold_accelerations(const Model& model) {
  for (const Support& support : model.supports)
    next_.accelerations.col(support.molecule) = support.free * next_.accelerations.col(support.molecule);
}

/// What iterations leave unbalanced of a free body's whole force would add up over the steps: the body moves as one to
/// where it is not, which changes no length, so that momentum is kept to rounding.
void Implicit::balance_as_one(const Model& model) {
  const Body& body = model.body();
  if (any_over(body, !model.supports.empty())) return;
  forces_.setZero(3, body.size());  // those within the body cancel
  model.add_other_forces(next_, forces_, workspace_.trials.force_pass);
  const int owned = owned_molecules(body);
  Eigen::Vector4d sums;
  sums << forces_.leftCols(owned).rowwise().sum() - next_.accelerations.leftCols(owned) * body.mass.head(owned),
      body.mass.head(owned).sum();
  sum_over(body, {sums.data(), 4});
  const Vector3 missing = sums.head<3>() / sums[3];
  const Weights& weights = kinematics_.weights;
  next_.accelerations.colwise() += missing;
  next_.velocities.colwise() += missing * (weights.velocity / weights.acceleration);
  next_.positions.colwise() += missing / weights.acceleration;
}

/// λ of Kᵀ λ = rhs, K the workspace's tangent and what of the damping it leaves out.
Positions ImplicitByNewton::transposed_balance(const TransposedForces& forces, const Positions& rhs) {
  const Tangent& tangent = *workspace_.tangent;
  const Model& model = tangent.model();
  Positions lambda = Positions::Zero(3, rhs.cols()), left = rhs, change;
  UsedSolver used;
  workspace_.solver.forget();
  for (int round = 0; round < kTransposedRounds; ++round) {
    const LinearResult solved = solve_linear(tangent, model.supports, left, kTransposedTolerance, newton_, true, change,
                                             used, workspace_.solver);
    if (solved.residual > std::sqrt(kTransposedTolerance) || !change.allFinite()) break;
    lambda += change;
    if (model.viscosity().empty() || change.norm() <= 1e-13 * lambda.norm()) return lambda;
    left = rhs;
    forces.add_turning(lambda, left);
    tangent.apply(lambda, change);
    left -= change;
    keep_free(model.supports, left);
  }
  throw InputError("a step's stiffness is too near to singular for derivatives");
}

/// The balance M a = f at x, v = v₀ + w_v (x − x₀), a = a₀ + w_a (x − x₀), of which m has the slopes x̄, v̄, ā:
///   Kᵀ λ = x̄ + w_v v̄ + w_a ā,  K = w_a M + w_v C − ∂f/∂x,  C = −∂f/∂v
/// and of x₀: w_a M λ + w_v C λ − w_v v̄ − w_a ā, of v₀: v̄ − C λ, of a₀: ā − M λ.
void ImplicitByNewton::transpose(Model& model, const State& from, const State& to, StateSlopes& slopes,
                                 const Visit& visit) {
  const double dt = to.time - from.time;
  const auto [share, of_inertia] = shares_;
  const VectorX& mass = model.body().mass;
  const auto free = [&](Positions vectors) {
    keep_free(model.supports, vectors);
    return vectors;
  };
  transpose_commit(model, from, to, slopes);
  set_kinematics(from, from.accelerations, dt);
  const Weights& weights = kinematics_.weights;
  State at = to;
  Positions of_x = free(slopes.positions), of_v = free(slopes.velocities), of_a = free(slopes.accelerations);
  Positions start_x = Positions::Zero(3, of_x.cols()), start_v = start_x, start_a = start_x;
  if (within()) {
    if (made_by_pushes(model, from, to, share)) throw InputError(kOpened);
    at.positions = from.positions + share * (to.positions - from.positions);
    at.time = from.time + share * dt;
    if (model.drive) model.drive(at.time, model.supports);
    of_a += dt * gamma_ * of_v;
    start_v = of_v, start_a = dt * (1 - gamma_) * of_v + (1 - 1 / of_inertia) * of_a;
    start_x = (1 - 1 / share) * of_x;
    of_x /= share, of_a /= of_inertia, of_v.setZero();
    at.velocities = kinematics_.velocities + weights.velocity * (at.positions - kinematics_.start);
    const Positions between = from.velocities + share * (to.velocities - from.velocities);
    at.velocities += between - at.velocities - free(between - at.velocities);
  }
  at.accelerations = kinematics_.accelerations + weights.acceleration * (at.positions - kinematics_.start);
  const Positions reached = from.accelerations + of_inertia * (to.accelerations - from.accelerations);
  if (free(at.accelerations - reached).norm() > 1e-6 * (reached.norm() + weights.acceleration * at.positions.norm()))
    throw InputError(kOpened);
  TransposedForces forces(model);
  forces.begin(from, at.time, at, dt);
  workspace_.tangent = std::make_unique<Tangent>(model, at, weights);
  const Positions lambda =
      transposed_balance(forces, free(of_x + weights.velocity * of_v + weights.acceleration * of_a));
  const Positions inertia = lambda * mass.asDiagonal(), damped = free(forces.damping(lambda));
  start_x += weights.acceleration * (inertia - of_a) + weights.velocity * (damped - of_v);
  of_v -= damped, of_a -= inertia;
  if (newmark()) {
    start_v += (1 - share * gamma_ / beta_) * of_v - of_inertia / (beta_ * dt) * of_a;
    start_a += share * dt * (1 - gamma_ / (2 * beta_)) * of_v + (1 - of_inertia / (2 * beta_)) * of_a;
  } else {
    start_v -= of_a / dt;
  }
  slopes.positions = std::move(start_x), slopes.velocities = std::move(start_v);
  slopes.accelerations = std::move(start_a);
  forces.add_past(lambda, slopes);
  visit(at, lambda);
  workspace_.tangent.reset();
}

namespace {

ParameterInfo newton_iterations() {
  return {"newton_iterations",
          dimension::none,
          0,
          1000,
          0,
          "Newton iterations in each step; 0: until it converges; 1: the residual is carried into the next step",
          false,
          ValueKind::whole};
}

std::unique_ptr<Stepper> make_implicit(const ParameterValues& values, const StaticOptions& newton, double beta,
                                       double gamma, EndShares shares = {}) {
  auto implicit = std::make_unique<ImplicitByNewton>(newton, beta, gamma, shares);
  implicit->cut_short(static_cast<int>(values.at("newton_iterations")));
  return implicit;
}

}  // namespace

StepperKind backward_euler() {
  return {
      {"backward_euler", "implicit, order 1: never gains energy", "[Baraff 1998]", {newton_iterations()}},
      false,
      1,
      [](const ParameterValues& values, const StaticOptions& newton) { return make_implicit(values, newton, 0, 0); },
      {},
      "newton_iterations",
      false,
      true};
}

StepperKind newmark() {
  return {{"newmark",
           "implicit, order 2 with gamma = 0.5; stable for any step if 2 beta >= gamma",
           "[Newmark 1959]",
           {{"beta", dimension::none, 0, 1, 0.25, "weight of the step's last acceleration in its displacement", true},
            {"gamma", dimension::none, 0.5, 1, 0.5, "weight of the step's last acceleration in its velocity"},
            newton_iterations()}},
          false,
          2,
          [](const ParameterValues& values, const StaticOptions& newton) {
            return make_implicit(values, newton, values.at("beta"), values.at("gamma"));
          },
          {},
          "newton_iterations",
          false,
          true};
}

StepperKind generalized_alpha() {
  return {{"generalized_alpha",
           "implicit, order 2: damps what the steps cannot resolve, as far as its spectral radius says",
           "[Chung & Hulbert 1993]",
           {{"spectral_radius", dimension::none, 0, 1, 0.8,
             "what a step leaves of motions far too fast for it: 0 nothing, 1 all, the midpoint rule"},
            newton_iterations()}},
          false,
          2,
          [](const ParameterValues& values, const StaticOptions& newton) {
            const double radius = values.at("spectral_radius");
            const EndShares shares{1 / (1 + radius), (2 - radius) / (1 + radius)};
            const double more = shares.inertia - shares.forces;
            return make_implicit(values, newton, (1 + more) * (1 + more) / 4, 0.5 + more, shares);
          },
          {},
          "newton_iterations",
          false,
          true};
}

}  // namespace elastin
