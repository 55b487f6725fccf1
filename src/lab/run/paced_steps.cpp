#include "lab/run/paced_steps.h"

#include <algorithm>
#include <chrono>
#include <limits>

#include "core/solve/steppers.h"
#include "elastin/core/base/error.h"

namespace elastin::lab {
namespace {

ParameterValues values_of(const Scheme& scheme, const TimeOptions& options) {
  if (scheme->effort.empty())
    throw InputError("a budget chooses a number of sweeps or iterations, and '" + std::string(scheme->name) +
                     "' takes none");
  return complete_values(scheme->name, scheme->parameters, options.parameters);
}

int parts_of(const ParameterValues& values) {
  const auto own = values.find("substeps");
  return own == values.end() ? 1 : static_cast<int>(own->second);
}

}  // namespace

PacedSteps::PacedSteps(Integrator& integrator, const Scheme& scheme, const TimeOptions& options,
                       const StaticOptions& newton)
    : integrator_(integrator),
      converged_(make_integrator({"backward_euler", {}, newton})),
      parts_(parts_of(values_of(scheme, options))),
      seconds_(options.budget),
      name_(scheme->effort) {
  set_effort(std::max(1, static_cast<int>(values_of(scheme, options).at(scheme->effort))));
}

void PacedSteps::set_effort(int effort) {
  effort_ = effort;
  dynamic_cast<HasEffort&>(integrator_).set_effort(effort);
}

StepResult PacedSteps::advance(Model& model, State& state, double dt) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point begun = Clock::now();
  set_effort(budget_.next(seconds_, effort_));
  const StepResult result = integrator_.advance(model, state, dt);
  const double took = std::chrono::duration<double>(Clock::now() - begun).count();
  budget_.took(took, effort_);
  efforts_.push_back(effort_);
  times_.push_back(took);
  return result;
}

void PacedSteps::look(Model& model, const State& state, double dt) {
  const auto reached = [&](Integrator& integrator, int parts) {
    State tried = state;
    bool went = true;
    for (int part = 0; part < parts && went; ++part)
      went = integrator.advance(model, tried, dt / parts).outcome == Outcome::converged;
    model.begin_step(state, state.time);
    if (model.drive) model.drive(state.time, model.supports);
    return went ? tried.positions : Positions();
  };
  const Positions own = reached(integrator_, 1), balance = reached(*converged_, parts_);
  if (own.size() == 0 || balance.size() == 0) return;
  error_ = std::max(error_, (own - balance).colwise().norm().maxCoeff());
  motion_ = std::max(motion_, (balance - state.positions).colwise().norm().maxCoeff());
}

BudgetReport PacedSteps::report() const {
  BudgetReport report;
  report.budget = seconds_;
  report.effort = name_;
  if (efforts_.empty()) return report;
  std::vector<int> efforts = efforts_;
  std::vector<double> times = times_;
  std::sort(efforts.begin(), efforts.end());
  std::sort(times.begin(), times.end());
  report.least = efforts.front(), report.median = efforts[efforts.size() / 2], report.most = efforts.back();
  report.median_seconds = times[times.size() / 2], report.longest_seconds = times.back();
  const auto late = times.end() - std::upper_bound(times.begin(), times.end(), seconds_);
  report.late = static_cast<double>(late) / static_cast<double>(times.size());
  report.iteration_error = error_, report.motion = motion_;
  return report;
}

}  // namespace elastin::lab
