#pragma once
#include <string>

#include "lab/report/plot.h"

namespace elastin::lab {

/// Two columns of a CSV file that Elastin wrote against each other, named with or without their unit. Empty names
/// choose:
///   * rows of benchmarks: error over minimum_s, a series a method;
///   * runs.csv: the first error over the time to solve, a series a strategy (and scene, where there are several);
///   * curves and time histories: what the page draws of them, one series.
/// Benchmarks stand on logarithmic axes, and so do times and errors of runs, errors by their size. Throws InputError:
/// file:line, with the nearest column.
Plot csv_plot(const std::string& path, std::string x, std::string y);

}  // namespace elastin::lab
