#pragma once
#include <optional>

#include "elastin/core/base/types.h"

namespace elastin::lab {

/// Values over time [s], in ascending order.
struct Series {
  VectorX times, values;
};

/// value = end + (start − end) exp(−t/τ), t from the first time on, by least squares.
struct ExponentialFit {
  double time = 0;  ///< τ [s]
  double start = 0, end = 0;
  double misfit = 0;  ///< root mean square of what is left over that of the values about their mean
};
/// None of fewer than 4 values, of values that change by less than a millionth, or where τ is shorter than the shortest
/// interval or longer than ten times them all: these values do not show it.
std::optional<ExponentialFit> fit_exponential(const Series& series);

/// value = mean + exp(−δ t) (a cos ω t + b sin ω t) by least squares.
struct VibrationFit {
  double circular_frequency = 0;  ///< ω [rad/s]
  double decay_rate = 0;          ///< δ [1/s]
  double mean = 0, cosine = 0, sine = 0;
  double misfit = 0;  ///< root mean square of what is left over that of the values about their mean
};
/// None unless the values cross their mean at least three times.
std::optional<VibrationFit> fit_vibration(const Series& series);

/// The same with ω given and without decay.
VibrationFit fit_sine(const Series& series, double circular_frequency);

/// Mean time between crossings of a level in one direction; none of fewer than two.
std::optional<double> period_of(const Series& series, double level);

/// The turning points, where the values stop rising or falling: times and values of the parabolas through three.
Series turning_points(const Series& series);

}  // namespace elastin::lab
