#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/simulation/budget.h"
#include "elastin/core/model/state.h"
#include "elastin/core/solve/stepper.h"
#include "lab/run/run.h"
#include "lab/run/time_options.h"

namespace elastin::lab {

/// Steps of a stepper that takes a number of sweeps or iterations: as many as the pace of the steps before leaves time
/// for. What so few of them leave is measured at each `look`.
class PacedSteps {
 public:
  /// Throws InputError where the stepper takes no number of them.
  PacedSteps(Stepper& stepper, const StepperMethod& method, const TimeOptions& options, const StaticOptions& newton);

  StepResult advance(Model& model, State& state, double dt);
  /// Tries a step by dt by both methods, by the last step's sweeps and by backward Euler to the end, and takes it back.
  void look(Model& model, const State& state, double dt);
  BudgetReport report() const;

 private:
  void set_effort(int effort);

  Stepper& stepper_;
  std::unique_ptr<Stepper> converged_;
  int parts_;  ///< of a converged step, where the stepper's own goes in substeps
  double seconds_;
  std::string name_;  ///< of what a step takes some of
  int effort_;
  Budget budget_;
  std::vector<int> efforts_;
  std::vector<double> times_;  ///< [s]
  double error_ = 0, motion_ = 0;
};

/// Takes a state from one frame to the next in steps of a length that the options set. What it keeps as history can be
/// written down and read again: the steps that follow are then the same, bit by bit.
class StepControl {
 public:
  /// Throws InputError if nothing says how long a step may be (an explicit stepper on a body that nothing holds
  /// together).
  StepControl(Model& model, const State& start, const TimeOptions& options, const StepperMethod& method,
              const StaticOptions& newton);

  /// Steps to `until` [s] exactly. Ends early if a step fails: the state is then the last good one. `after` is called
  /// with each step's end; false ends it there, as interrupted.
  template <class After>
  StepResult advance(Model& model, State& state, double until, After&& after) {
    StepResult all;
    all.substeps = 0;
    if (options_.choice == StepChoice::per_frame) memory.wanted = (until - state.time) / options_.steps_per_frame;
    while (state.time < until) {
      const StepResult step = one_step(model, state, until);
      all.newton_iterations += step.newton_iterations;
      all.linear_iterations += step.linear_iterations;
      ++all.substeps;
      if (step.outcome != Outcome::converged) {
        all.outcome = step.outcome;
        all.cause = step.cause;
        return all;
      }
      if (!after(state)) {
        all.outcome = Outcome::interrupted;
        return all;
      }
    }
    return all;
  }

  /// What has to be written down.
  struct Memory {
    double wanted = 0;                   ///< length of the next step [s]
    double first_bound = 0;              ///< of frequencies, where the watch began [rad/s]
    double stable = 0;                   ///< longest step that is stable, with safety [s]
    double critical = 0, frequency = 0;  ///< of explicit steppers at the start: longest stable step [s], ω_max [rad/s]
    double shortest = 0;                 ///< step taken [s]
    double last = 0;                     ///< step, taken or tried [s]
    double motion = 0;                   ///< largest displacement so far [m]; of steps by error alone
    int steps = 0, rejected = 0;
  };
  Memory memory;

  /// What its few sweeps would do to the next step, where there is a budget.
  void look(Model& model, const State& state) {
    if (paced_) paced_->look(model, state, memory.wanted);
  }
  std::optional<BudgetReport> budget() const { return paced_ ? std::optional(paced_->report()) : std::nullopt; }

 private:
  StepResult one_step(Model& model, State& state, double until);
  double error_limit(double motion) const;
  void watch(Model& model, const State& state);

  TimeOptions options_;
  std::unique_ptr<Stepper> stepper_;
  std::optional<PacedSteps> paced_;  ///< where steps have a budget
  double size_ = 0;                  // of the body [m]
  double longest_ = 0;               // step that sees the functions of time between their corners [s]
  Positions start_;                  // from where motion counts, of steps by error alone
  double order_ = 2;
  bool by_error_ = false, watched_ = false;
};

/// All that a run in time needs to go on as if it had not stopped.
struct RestartPoint {
  int frame = 0;
  State state;
  double dissipated = 0, work = 0, taken = 0, jumps = 0;  ///< [J], of the ledger
  StepControl::Memory memory;
  int newton_iterations = 0, linear_iterations = 0;
  std::vector<CurvePoint> curve, history;  ///< of the frames; of steps too
};

/// As text, every number with all its bits. `identity` names what must be the same when it is read.
std::string restart_text(const RestartPoint& point, const std::string& identity);
/// Throws InputError, with `path`, line and column if there is a path, where the text is no restart file, one of
/// another version, or that of another run.
RestartPoint parse_restart(const std::string& text, const std::string& identity, const std::string& path = "");

/// What a run must share with the one that it goes on from: body, problem, strategy, stepper and frames.
std::string restart_identity(const Body& body, const std::string& problem, const std::string& strategy,
                             const TimeOptions& options, const std::string& method);

}  // namespace elastin::lab
