#pragma once
#include <string>
#include <vector>

#include "elastin/core/solve/statics.h"
#include "elastin/lab/run/measures.h"

namespace elastin::lab {

/// One stepper with one number of iterations and one time step. NaN where something was not measured.
struct StepperRow {
  std::string stepper;
  int iterations = 0;  ///< of each step; 0 = as many as it takes, or none to choose
  double step = 0;     ///< [s]
  Outcome outcome = Outcome::converged;
  std::string cause;            ///< why it did not get through, or does not suit the model
  bool suited = true;           ///< false: it cannot step this model
  bool settled = true;          ///< whether the loaded body came to rest in time
  std::vector<double> at_rest;  ///< the measures of StepperComparison of the body that came to rest under its load
  double rest_error;            ///< of the first, to the equilibrium of the same model
  /// Of the motion after release, root mean square over time and mass, over the size of the displacement it starts
  /// from.
  double iteration_error;  ///< to the same step, converged: backward Euler's, or the stepper's own of second order
  double time_error;       ///< to the limit of short steps
  double energy;           ///< change of the body's energy over one period, over what it starts with
  double seconds;          ///< of one step, median
  int substeps = 0;        ///< that an explicit stepper parts a step into; 0 of an implicit one
};

/// Steppers side by side on one model.
struct StepperComparison {
  std::string scene, title, strategy, machine;
  int molecules = 0, connections = 0, cells = 0, threads = 1;
  double period = 0;                  ///< of the loaded shape, by Rayleigh's quotient [s]
  std::vector<MeasureInfo> measures;  ///< of the fixture, the most telling first
  std::vector<double> equilibrium;    ///< the same, of the static solution
  std::vector<StepperRow> rows;
  std::vector<std::string> warnings;
};

/// A table, and which rows are within 1 % of the modulus and 5 % of the motion in the least time.
std::string stepper_text(const StepperComparison& comparison, bool colours);
std::string stepper_json(const std::vector<StepperComparison>& comparisons);
/// One HTML page: error against time, the error at rest against time, the table.
std::string stepper_page(const std::vector<StepperComparison>& comparisons, const std::string& command);

}  // namespace elastin::lab
