#include "lab/run/load_path.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "contact/thickness.h"
#include "elastin/core/model/share.h"
#include "lab/run/contact_measures.h"

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
}

}  // namespace

void set_load(Model& model, StaticRig& rig, double factor) {
  if (contact::Contact* contact = contact_of(model)) contact->set_moment(factor);
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

LoadPath::LoadPath(Model& model, StaticRig& rig, const StaticOptions& options, State start)
    : model_(model), rig_(rig), options_(options), state_(std::move(start)) {
  options_.probe = rig.leaves_saddles();
  rig.approach(state_.positions);
  model_.commit_step(state_);
}

/// Extrapolation of the path: near the next equilibrium, unless a cell inverts or, under loads, the
/// energy is higher than where the body stands (a bar that turns far would be torn).
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
  return std::isfinite(gain) && !(loaded && gain > 0) ? next : state_;
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

StaticResult LoadPath::advance(double factor) {
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

StaticResult LoadPath::advance(double factor, double smallest) {
  set_load(model_, rig_, factor);
  State next = start_of(factor);
  // A step that can be halved is not worth many iterations.
  StaticOptions options = options_;
  const bool can_be_halved = !options_.linear && std::abs(factor - factor_) / 2 >= smallest;
  if (can_be_halved) options.newton_limit = std::min(options.newton_limit, kPatience);
  const bool went_on = any_over(model_.body(), next.positions != state_.positions);
  StaticResult solved = solve_static(model_, next, options);
  if (solved.outcome == Outcome::diverged &&
      went_on) {  // where the path bends sharply, its extrapolation may lead nowhere
    next = state_;
    const StaticResult before = std::exchange(solved, solve_static(model_, next, options));
    add_cost(solved, before);
  }
  const bool balanced = solved.outcome == Outcome::converged;
  adjust_load(model_, rig_, options, next, solved);
  if (solved.outcome == Outcome::converged) {
    model_.commit_step(next);
    displacement_ = next.positions - state_.positions;
    state_ = std::move(next);
    last_step_ = factor - factor_;
    factor_ = factor;
    return solved;
  }
  const bool shorter_helps =
      (balanced && solved.outcome == Outcome::limit_reached) || solved.outcome == Outcome::inverted ||
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

}  // namespace elastin::lab
