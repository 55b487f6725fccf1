#pragma once
#include <vector>

#include "elastin/core/base/types.h"

namespace elastin {

/// A law with a history (one block, whose first number is the time) that knows what a function m of later states
/// changes with: slopes ∂m/∂(number of the block), in the block's order.
class TransposedHistory {
 public:
  virtual ~TransposedHistory() = default;
  /// Of LawHistory::commit_step at the end of a step [s]: slopes by the block there become those by the block at the
  /// step's beginning, and those by the positions there are added.
  virtual void transpose_commit(double step, const Positions& positions, std::vector<double>& slopes,
                                Positions& of_positions) const = 0;
  /// Adds what m has by the block at the beginning of a step [s] through the forces f in it, of which it has λ·δf.
  virtual void transpose_forces(double step, const Positions& positions, const Positions& lambda,
                                std::vector<double>& slopes) const = 0;
};

}  // namespace elastin
