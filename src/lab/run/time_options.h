#pragma once
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "elastin/core/forces/time_function.h"
#include "elastin/core/solve/stepper.h"
#include "lab/run/config_names.h"

namespace elastin::lab {

/// By what the length of a time step is set.
enum class StepChoice {
  automatic,  ///< explicit steppers: 0.8 of the longest stable step, watched; implicit ones: by their error
  fixed,
  by_error,
  per_frame,  ///< a count of equal length in each frame
};

/// Time-stepping options.
struct TimeOptions {
  double duration = 1;                   ///< [s], > 0
  std::optional<StepperMethod> stepper;  ///< none: see chosen_stepper
  ParameterValues parameters = {};       ///< of the stepper
  StepChoice choice = StepChoice::automatic;
  double step = 0;                      ///< [s], of fixed ones; frames shorten it evenly
  double error = 1e-4;                  ///< of a step in position, as a part of the body's size
  double smallest = 0, largest = 1e30;  ///< [s], of steps by error
  int steps_per_frame = 1;              ///< of StepChoice::per_frame
  int frames = 100;                     ///< states that are kept in addition to the first
  /// [s], the end of the first frame; that of each other one is the one before times the same factor. 0: equal frames.
  double first_frame = 0;
  double frame_rate = 250;                 ///< frames a second at most, where a run is shown live
  int checkpoint = 0;                      ///< frames between two restart files; 0 = none
  double budget = 0;                       ///< [s] by the clock for a step of a stepper that takes sweeps; 0 = any
  std::vector<TimeFunction> follows = {};  ///< at whose corners steps end, but for those of a fixed length
  /// Whether steps by error are short for the motion so far, too; not of what is slow, whose vibrations they damp.
  bool resolves_motion = true;

  /// When a frame ends [s]: frame 0 … frames.
  double time_of(int frame) const {
    if (frame <= 0) return 0;
    if (frame >= frames) return duration;
    if (first_frame == 0) return duration * frame / frames;
    return first_frame * std::pow(duration / first_frame, (frame - 1.) / (frames - 1.));
  }
};

/// How the steps kept their budget.
struct BudgetReport {
  double budget = 0;                               ///< [s] by the clock
  std::string effort;                              ///< the unit of effort of a step: "sweeps", "iterations", "solves"
  int least = 0, median = 0, most = 0;             ///< of them in a step
  double median_seconds = 0, longest_seconds = 0;  ///< of a step
  double late = 0;                                 ///< part of the steps that took longer than the budget
  /// Largest distance, at the frames, between where a step's sweeps and backward Euler's balance bring a molecule, and
  /// the largest displacement of one in such a step [m].
  double iteration_error = 0, motion = 0;
};

/// Time-stepping report.
struct TimeReport {
  std::string stepper, reason;              ///< the stepper, and why it was taken if the scene left that open
  int steps = 0, rejected = 0;              ///< rejected: gone again, shorter, because their error was too large
  double shortest_step = 0, last_step = 0;  ///< [s]
  double critical_step = 0, frequency = 0;  ///< of explicit steppers: longest stable step [s], ω_max [rad/s]
  double simulated = 0, seconds = 0;        ///< simulated and wall-clock time of this run alone [s]
  bool resumed = false;
  std::optional<BudgetReport> budget;
};

/// {ramp: {duration: 1 s}}, {step: {at: 1 s}}, {sine: …} or {table: [[0 s, 0], …]}.
TimeFunction read_time_function(const Reader& reader);

template <class Setup>
Key<Setup> time_function_key(std::string name, std::optional<TimeFunction> Setup::*member, std::string text) {
  return {{std::move(name), "time function", "", "", "none", std::move(text)},
          [member](const Reader& value, Setup& setup, const Frame&) { setup.*member = read_time_function(value); }};
}

/// Its table in the key reference.
KeySection time_function_section();

}  // namespace elastin::lab
