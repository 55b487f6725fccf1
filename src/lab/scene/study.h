#pragma once
#include <string>
#include <utility>
#include <vector>

#include "elastin/core/simulation/catalog.h"

namespace elastin::lab {

/// Keys of the scene that change together, and the values that they take in turn.
struct StudyAxis {
  /// One a value: the keys with what they become, "body.lattice.molecules" = "[5, 5, 5]".
  std::vector<std::vector<std::pair<std::string, std::string>>> values;
};

/// What a comparison changes beside the strategy. A row for each combination of all axes.
struct Study {
  std::vector<StudyAxis> axes;
  int repeats = 1;           ///< of the whole comparison, one after the other
  std::vector<int> threads;  ///< numbers of threads; empty = the command's
  /// The strategy from whose own values under refinement the reference is extrapolated; empty = the scene's or the
  /// material's value counts.
  std::string own_reference;
  bool any() const { return !axes.empty() || repeats > 1 || !threads.empty(); }
};

/// A scheme with the parameters that a comparison of steppers leaves as they are.
struct StepperChoice {
  Scheme scheme;
  ParameterValues parameters = {};
};

/// What a comparison of steppers runs through: each scheme with each number of iterations and each time step.
struct StepperStudy {
  std::vector<StepperChoice> schemes;
  std::vector<int> iterations{1, 4, 16, 64};
  std::vector<double> steps;  ///< [s]; empty = 1/25 and 1/100 of the loaded shape's period
};

/// "all", or names separated by commas. Throws InputError with the nearest name.
std::vector<StepperChoice> read_steppers(const std::string& names, const Table<Stepper>& steppers);

/// One axis as a command line gives it: "KEY.PATH=[value, …]" or "{KEY.PATH: [value, …], KEY.PATH: …}".
StudyAxis read_axis(const std::string& text);

/// Each combination of the axes' values, the last axis fastest: what becomes of which key. One empty combination
/// without axes. Throws InputError where there are more than 100 000.
std::vector<std::vector<std::pair<std::string, std::string>>> combinations(const std::vector<StudyAxis>& axes);

}  // namespace elastin::lab
