#include "elastin/core/forces/time_function.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "elastin/core/base/error.h"

namespace elastin {

TimeFunction::TimeFunction(std::vector<std::pair<double, double>> points) : points_(std::move(points)) {
  if (points_.empty()) throw InputError("a function of time needs at least one point");
  for (std::size_t i = 1; i < points_.size(); ++i)
    if (points_[i].first < points_[i - 1].first)
      throw InputError("the times of a function must not fall: point " + std::to_string(i) + " does");
}

TimeFunction TimeFunction::sine(double frequency, double phase, double mean) {
  TimeFunction function;
  function.points_.clear();
  function.circular_frequency_ = 2 * std::numbers::pi * frequency;
  function.phase_ = phase;
  function.mean_ = mean;
  return function;
}

namespace {

/// Times are sums of many steps: what lies within this part of a point is at the point.
constexpr double kRounding = 1e-10;
double slack(double time, double point) { return kRounding * std::max(std::abs(time), std::abs(point)); }

constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr double kStepsInPeriod = 40;
constexpr double kSwing = 0.1;  ///< part of the range

}  // namespace

std::size_t TimeFunction::after(double time) const {
  const auto found = std::partition_point(points_.begin(), points_.end(), [&](const auto& point) {
    return point.first <= time + slack(time, point.first);
  });
  return static_cast<std::size_t>(found - points_.begin());
}

std::size_t TimeFunction::not_before(double time) const {
  const auto found = std::partition_point(
      points_.begin(), points_.end(), [&](const auto& point) { return point.first < time - slack(time, point.first); });
  return static_cast<std::size_t>(found - points_.begin());
}

double TimeFunction::value(double time) const {
  if (points_.empty()) return mean_ + std::sin(circular_frequency_ * time + phase_);
  const std::size_t next = after(time);
  if (next == 0) return points_.front().second;
  if (next == points_.size()) return points_.back().second;
  const auto& before = points_[next - 1];
  const double fraction = (time - before.first) / (points_[next].first - before.first);
  return before.second + fraction * (points_[next].second - before.second);
}

double TimeFunction::rate(double time) const {
  if (points_.empty()) return circular_frequency_ * std::cos(circular_frequency_ * time + phase_);
  std::size_t next = not_before(time);
  if (next == 0) next = after(time);
  if (next == 0 || next == points_.size()) return 0;
  const auto& before = points_[next - 1];
  return (points_[next].second - before.second) / (points_[next].first - before.first);
}

bool TimeFunction::constant() const {
  if (points_.empty()) return circular_frequency_ == 0;
  return std::all_of(points_.begin(), points_.end(),
                     [&](const auto& point) { return point.first <= 0 || point.second == value(0); });
}

double TimeFunction::next_corner(double time) const {
  const auto slope = [&](std::size_t end) {  // of the line that ends at a point; level before the first, after the last
    if (end == 0 || end == points_.size()) return 0.;
    return (points_[end].second - points_[end - 1].second) / (points_[end].first - points_[end - 1].first);
  };
  for (std::size_t i = after(time); i < points_.size(); ++i) {
    const double before = slope(i), then = slope(i + 1), change = std::abs(then - before);  // not finite at a jump
    const bool straight = change <= kRounding * std::max(std::abs(before), std::abs(then));
    if (!straight || !std::isfinite(change)) return points_[i].first;
  }
  return kNever;
}

double TimeFunction::longest_step() const {
  return circular_frequency_ == 0 ? kNever : 2 * std::numbers::pi / (kStepsInPeriod * std::abs(circular_frequency_));
}

double TimeFunction::shortest_swing() const {
  if (circular_frequency_ != 0) return std::numbers::pi / std::abs(circular_frequency_);
  double low = kNever, high = -kNever;
  for (const auto& [time, value] : points_) low = std::min(low, value), high = std::max(high, value);
  const double least = kSwing * (high - low);
  double shortest = kNever;
  std::size_t begin = 0, turn = 0;  // of the way that it goes now: where that begins, and its farthest point
  for (std::size_t i = 1; i < points_.size(); ++i) {
    const double there = points_[turn].second - points_[begin].second, back = points_[turn].second - points_[i].second;
    if (there == 0 || there * back < 0) {
      turn = i;
      while (begin + 1 < turn && points_[begin + 1].second == points_[begin].second) ++begin;
    } else if (std::abs(back) > least) {
      const auto& [last_time, last] = points_[i - 1];
      const auto& [time, value] = points_[i];
      const double left = std::abs(back) - least;  // beyond the tenth
      if (std::abs(there) > least)
        shortest = std::min(shortest, time - left / std::abs(value - last) * (time - last_time) - points_[begin].first);
      begin = turn, turn = i;
      while (points_[begin + 1].second == points_[begin].second) ++begin;
    }
  }
  return shortest;
}

}  // namespace elastin
