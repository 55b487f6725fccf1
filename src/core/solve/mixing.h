#pragma once
#include <vector>

#include "elastin/core/base/types.h"

namespace elastin {

/// Iterations that lead from x to x + r, mixed: where the last ones would lead to if all went on like these. Of the
/// combinations of the last ends, the one whose r is shortest in least squares.   [Anderson 1965; Walker & Ni 2011]
class Mixing {
 public:
  static constexpr int kMost = 20;
  /// `memory`: number of the last iterations that count, 0 … kMost.
  explicit Mixing(int memory) : pasts_(memory) {}

  /// Restarts with memory for these molecules: nothing after it allocates.
  void begin(Eigen::Index molecules);
  /// Changes the motion r that an iteration makes from x. False, and nothing, as long as there is nothing to mix.
  bool mix(const Positions& from, Positions& motion);

 private:
  struct Past {
    Positions end, motion;  ///< changes from one iteration to the next
  };
  std::vector<Past> pasts_;  ///< in a ring
  int used_ = 0;
  bool known_ = false;
  Positions last_from_, last_motion_;
};

}  // namespace elastin
