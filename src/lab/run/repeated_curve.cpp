#include "lab/run/repeated_curve.h"

#include <cmath>
#include <utility>

#include "lab/run/load_path.h"

namespace elastin::lab {

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
