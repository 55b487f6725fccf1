#pragma once
#include <memory>
#include <vector>

#include "core/simulation/budget.h"
#include "elastin/core/solve/integrator.h"
#include "lab/run/time_options.h"

namespace elastin::lab {

/// Steps of a scheme that takes a number of sweeps or iterations: as many as the pace of the steps before leaves time
/// for. What so few of them leave is measured at each `look`.
class PacedSteps {
 public:
  /// Throws InputError where the scheme takes no number of them.
  PacedSteps(Integrator& integrator, const Scheme& scheme, const TimeOptions& options, const StaticOptions& newton);

  StepResult advance(Model& model, State& state, double dt);
  /// Tries a step by dt by both methods, by the last step's sweeps and by backward Euler to the end, and takes it back.
  void look(Model& model, const State& state, double dt);
  BudgetReport report() const;

 private:
  void set_effort(int effort);

  Integrator& integrator_;
  std::unique_ptr<Integrator> converged_;
  int parts_;  ///< of a converged step, where the stepper's own goes in substeps
  double seconds_;
  std::string name_;  ///< of what a step takes some of
  int effort_;
  Budget budget_;
  std::vector<int> efforts_;
  std::vector<double> times_;  ///< [s]
  double error_ = 0, motion_ = 0;
};

}  // namespace elastin::lab
