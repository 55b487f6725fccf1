#include "lab/run/time_history_fits.h"

#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "core/base/dense.h"

namespace elastin::lab {
namespace {

/// The least value of a function on an interval where it has one valley. [Kiefer 1953]
double golden_section(const std::function<double(double)>& f, double low, double high) {
  const double ratio = (std::sqrt(5.) - 1) / 2;
  double a = high - ratio * (high - low), b = low + ratio * (high - low), fa = f(a), fb = f(b);
  for (int i = 0; i < 80 && high - low > 1e-10 * (std::abs(low) + std::abs(high)); ++i) {
    if (fa < fb) {
      high = b, b = a, fb = fa;
      a = high - ratio * (high - low), fa = f(a);
    } else {
      low = a, a = b, fa = fb;
      b = low + ratio * (high - low), fb = f(b);
    }
  }
  return (low + high) / 2;
}

/// The best of a coarse search, then its valley: of a function that may have several.
double least_of(const std::function<double(double)>& f, double low, double high, int intervals) {
  int best = 0;
  double least = f(low);
  for (int i = 1; i <= intervals; ++i)
    if (const double value = f(low + (high - low) * i / intervals); value < least) best = i, least = value;
  const double step = (high - low) / intervals;
  return golden_section(f, low + step * std::max(0, best - 1), low + step * std::min(intervals, best + 1));
}

/// Coefficients of the columns that come nearest to the values, and the size of what is left.
std::pair<VectorX, double> linear_fit(const Eigen::MatrixXd& columns, const VectorX& values) {
  VectorX found = least_squares(columns, values);
  const double left = (columns * found - values).norm();
  return {std::move(found), left};
}

Eigen::MatrixXd exponential_columns(const VectorX& times, double time) {
  Eigen::MatrixXd columns(times.size(), 2);
  columns.col(0).setOnes();
  columns.col(1) = (-(times.array() - times[0]) / time).exp();
  return columns;
}

Eigen::MatrixXd vibration_columns(const VectorX& times, double circular_frequency, double decay_rate) {
  const Eigen::ArrayXd decay = (-decay_rate * times.array()).exp();
  Eigen::MatrixXd columns(times.size(), 3);
  columns.col(0).setOnes();
  columns.col(1) = decay * (circular_frequency * times.array()).cos();
  columns.col(2) = decay * (circular_frequency * times.array()).sin();
  return columns;
}

VectorX crossings(const Series& series, double level, bool upwards) {
  std::vector<double> found;
  for (Eigen::Index i = 1; i < series.values.size(); ++i) {
    const double before = series.values[i - 1] - level, now = series.values[i] - level;
    if (upwards ? before < 0 && now >= 0 : before > 0 && now <= 0)
      found.push_back(series.times[i - 1] + (series.times[i] - series.times[i - 1]) * before / (before - now));
  }
  return Eigen::Map<const VectorX>(found.data(), static_cast<Eigen::Index>(found.size()));
}

double spread_of(const VectorX& values) { return (values.array() - values.mean()).matrix().norm(); }

/// The damped cosine nearest to the values, found from where they cross a level.
std::optional<VibrationFit> vibration_about(const Series& series, double level) {
  const VectorX up = crossings(series, level, true), down = crossings(series, level, false);
  if (up.size() + down.size() < 3) return std::nullopt;
  const VectorX& more = up.size() >= down.size() ? up : down;
  const double period = (more[more.size() - 1] - more[0]) / static_cast<double>(more.size() - 1);
  VectorX times = series.times.array() - series.times[0];
  double frequency = 2 * std::numbers::pi / period, decay = 0;
  const auto misfit = [&](double w, double d) {
    return linear_fit(vibration_columns(times, w, d), series.values).second;
  };
  // One after the other, each the more narrowly: they depend little on each other.
  const double narrow = 1 / std::max(1., static_cast<double>(more.size()));
  for (double reach = 0.5 * narrow; reach > 1e-9; reach /= 2) {
    frequency =
        least_of([&](double w) { return misfit(w, decay); }, frequency * (1 - reach), frequency * (1 + reach), 8);
    const double slack = 4 * reach * frequency;
    decay = least_of([&](double d) { return misfit(frequency, d); }, decay - slack, decay + slack, 8);
  }
  const auto [found, left] = linear_fit(vibration_columns(times, frequency, decay), series.values);
  return VibrationFit{frequency, decay, found[0], found[1], found[2], left / spread_of(series.values)};
}

}  // namespace

std::optional<ExponentialFit> fit_exponential(const Series& series) {
  if (series.times.size() < 4) return std::nullopt;
  const double range = series.values.maxCoeff() - series.values.minCoeff();
  if (!(range > 1e-6 * series.values.cwiseAbs().maxCoeff())) return std::nullopt;
  const Eigen::Index last = series.times.size() - 1;
  const double duration = series.times[last] - series.times[0];
  const auto misfit = [&](double logarithm) {
    return linear_fit(exponential_columns(series.times, std::exp(logarithm)), series.values).second;
  };
  const double step = (series.times.tail(last) - series.times.head(last)).minCoeff();
  const double time = std::exp(least_of(misfit, std::log(step / 10), std::log(100 * duration), 60));
  if (!(time >= step && time <= 10 * duration)) return std::nullopt;
  const auto [found, left] = linear_fit(exponential_columns(series.times, time), series.values);
  return ExponentialFit{time, found[0] + found[1], found[0], left / spread_of(series.values)};
}

std::optional<VibrationFit> fit_vibration(const Series& series) {
  // What dies away ends near its mean, what does not has it halfway between its extremes.
  const double middle = (series.values.maxCoeff() + series.values.minCoeff()) / 2,
               late = series.values.tail((series.values.size() + 3) / 4).mean();
  const auto about_middle = vibration_about(series, middle);
  if (about_middle && about_middle->misfit < 0.01) return about_middle;
  const auto about_late = vibration_about(series, late);
  if (!about_middle || !about_late) return about_middle ? about_middle : about_late;
  return about_late->misfit < about_middle->misfit ? about_late : about_middle;
}

VibrationFit fit_sine(const Series& series, double circular_frequency) {
  const auto [found, left] = linear_fit(vibration_columns(series.times, circular_frequency, 0), series.values);
  return {circular_frequency, 0, found[0], found[1], found[2], left / spread_of(series.values)};
}

std::optional<double> period_of(const Series& series, double level) {
  const VectorX up = crossings(series, level, true), down = crossings(series, level, false);
  const VectorX& more = up.size() >= down.size() ? up : down;
  if (more.size() < 2) return std::nullopt;
  return (more[more.size() - 1] - more[0]) / static_cast<double>(more.size() - 1);
}

Series turning_points(const Series& series) {
  std::vector<double> times, values;
  for (Eigen::Index i = 1; i + 1 < series.values.size(); ++i) {
    const double before = series.values[i] - series.values[i - 1], after = series.values[i + 1] - series.values[i];
    if (!(before * after < 0 || (before != 0 && after == 0))) continue;
    const double bend = after - before, slope = (after + before) / 2, at = -slope / bend;
    times.push_back(series.times[i] + at * (series.times[i + 1] - series.times[i]));
    values.push_back(series.values[i] + slope * at + bend * at * at / 2);
  }
  const auto size = static_cast<Eigen::Index>(times.size());
  return {Eigen::Map<const VectorX>(times.data(), size), Eigen::Map<const VectorX>(values.data(), size)};
}

}  // namespace elastin::lab
