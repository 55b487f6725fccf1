#pragma once
#include <algorithm>
#include <cmath>

namespace elastin {

/// How many sweeps a step may take so that it ends in time, by how long those before it took.
class Budget {
 public:
  /// Sweeps of the next step, 1 or more, where the last one had `last` of them.
  int next(double budget, int last) const {
    if (!(seconds_a_sweep_ > 0)) return last;
    const double most = kShare * budget / seconds_a_sweep_;
    return static_cast<int>(std::clamp(std::floor(most), 1., 2. * last));
  }
  /// The first step after a rebuild allocates memory: it does not count.
  void took(double seconds, int sweeps) {
    const double own = seconds / std::max(1, sweeps);
    if (steps_++ == 0) return;
    seconds_a_sweep_ = seconds_a_sweep_ > 0 && own < seconds_a_sweep_ ? (7 * seconds_a_sweep_ + own) / 8 : own;
  }
  void restart() { steps_ = 0; }

 private:
  static constexpr double kShare = 0.8;  // of the budget: some steps take longer than others
  double seconds_a_sweep_ = 0;           // follows what is slower at once, what is faster in some eight steps
  int steps_ = 0;
};

}  // namespace elastin
