#pragma once
#include <utility>
#include <vector>

namespace elastin {

/// A number that changes over time: the factor of a load or a displacement. At a jump it has the value that follows, at
/// a kink the rate before it, with which a step that ends there went; where it begins, the rate that follows. A time
/// that is next to a point but for rounding is that point's.
class TimeFunction {
 public:
  /// 1 at all times.
  TimeFunction() : TimeFunction({{0, 1}}) {}
  /// Straight between points {time [s], value}, times not falling (two of one time make a jump); constant before the
  /// first and after the last. Throws InputError if there are no points, or on a time that falls.
  explicit TimeFunction(std::vector<std::pair<double, double>> points);
  /// From 0 at time 0 to 1 at `duration` [s].
  static TimeFunction ramp(double duration) { return TimeFunction({{0, 0}, {duration, 1}}); }
  /// 0 before `at` [s], 1 from then on.
  static TimeFunction step(double at) { return TimeFunction({{at, 0}, {at, 1}}); }
  /// mean + sin(2π f t + φ), f = `frequency` [Hz], φ = `phase` [rad].
  static TimeFunction sine(double frequency, double phase = 0, double mean = 0);

  double value(double time) const;
  /// [1/s]
  double rate(double time) const;
  /// Whether it is one number from time 0 on.
  bool constant() const;

  /// The first time after `time` [s] at which it jumps or has a kink; infinity where none comes.
  double next_corner(double time) const;
  /// Longest step [s] between its corners that sees it: a fortieth of a period, with which the trapezoidal rule is
  /// right to 0.2 %; infinity where it is straight.
  double longest_step() const;
  /// Shortest time [s] in which it goes to and fro by more than a tenth of its range; infinity where it never does.
  double shortest_swing() const;

 private:
  /// Index of the first point that lies after a time; not before it.
  std::size_t after(double time) const;
  std::size_t not_before(double time) const;
  std::vector<std::pair<double, double>> points_;  // empty: a sine
  double circular_frequency_ = 0, phase_ = 0, mean_ = 0;
};

}  // namespace elastin
