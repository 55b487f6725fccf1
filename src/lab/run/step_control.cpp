#include "lab/run/step_control.h"

#include <algorithm>
#include <cmath>

#include "elastin/core/base/error.h"
#include "elastin/core/model/share.h"
#include "elastin/core/solve/stable_step.h"

namespace elastin::lab {
namespace {

constexpr double kSafety = 0.8;   ///< of the longest stable step: room for a body that stiffens between two looks
constexpr int kWatchEvery = 100;  ///< steps

double size_of(const Body& body) {
  const auto [low, high] = outline_of_whole(body);
  return (high - low).norm();
}

}  // namespace

StepControl::StepControl(Model& model, const State& start, const TimeOptions& options, const Scheme& scheme,
                         const StaticOptions& newton)
    : options_(options), size_(size_of(model.body())) {
  integrator_ = make_integrator({scheme, options.parameters, newton});
  order_ = scheme->order;
  if (options.budget > 0) paced_.emplace(*integrator_, scheme, options, newton);
  const bool automatic = options.choice == StepChoice::automatic;
  by_error_ = options.choice == StepChoice::by_error || (automatic && !scheme->is_explicit);
  watched_ = scheme->is_explicit && options.choice != StepChoice::fixed;
  memory.wanted = options.choice == StepChoice::fixed ? options.step : options.time_of(1);
  memory.stable = std::numeric_limits<double>::infinity();
  if (scheme->is_explicit) {
    const StableStep found = find_stable_step(model, start);
    memory.critical = found.step;
    memory.frequency = found.frequency;
    if (watched_) {
      memory.stable = kSafety * found.step;
      memory.first_bound = found.bound;
    }
  }
  if (by_error_) memory.wanted = std::min(options.largest, memory.wanted / 8);
}

/// A body that stiffens as it moves takes shorter steps; the row sums say by how much, in one pass.
void StepControl::watch(Model& model, const State& state) {
  if (!watched_ || memory.steps % kWatchEvery != 0 || memory.steps == 0) return;
  const double bound = frequency_bound(model, state);
  if (std::isfinite(memory.critical) && bound > 0)
    memory.stable = std::min(memory.stable, kSafety * memory.critical * std::min(1., memory.first_bound / bound));
}

StepResult StepControl::one_step(Model& model, State& state, double until) {
  watch(model, state);
  while (true) {
    const double left = until - state.time;
    double step = std::min(memory.wanted, memory.stable);
    if (by_error_) step = std::max(step, options_.smallest);
    // The rest of the frame's time in equal steps; a step that rounding alone makes is left out.
    const double count = std::max(1., std::ceil(left / step * (1 - 1e-9)));
    const double dt = left / count;
    if (!(state.time + dt > state.time))
      return {Outcome::diverged, "the step has become too short for the clock", 0, 0, 1, 0};
    const State before = by_error_ ? state : State{};
    StepResult result = paced_ ? paced_->advance(model, state, dt) : integrator_->advance(model, state, dt);
    if (result.outcome != Outcome::converged) return result;
    if (by_error_) {
      const double ratio = result.error / (options_.error * size_);
      const double change = ratio > 0 ? 0.9 * std::pow(ratio, -1 / (order_ + 1)) : 2;
      const bool can_shorten = dt > options_.smallest * (1 + 1e-9) && result.substeps <= 1;
      memory.wanted = std::min(options_.largest, dt * std::clamp(change, 0.2, 2.));
      if (ratio > 1 && can_shorten) {
        state = before;
        if (model.drive) model.drive(state.time, model.supports);
        ++memory.rejected;
        continue;
      }
    }
    if (count == 1) {
      state.time = until;
      if (model.drive) model.drive(until, model.supports);
    }
    ++memory.steps;
    memory.last = dt;
    memory.shortest = memory.shortest > 0 ? std::min(memory.shortest, dt) : dt;
    return result;
  }
}

}  // namespace elastin::lab
