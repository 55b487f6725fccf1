#pragma once
#include <span>
#include <vector>

namespace elastin {

/// Rows of integers of different length, one behind the other.
struct Rows {
  std::vector<int> start;  ///< row r is entries[start[r]] … entries[start[r+1]−1]
  std::vector<int> entries;
  std::span<const int> operator[](int row) const {
    return {entries.data() + start[row], static_cast<std::size_t>(start[row + 1] - start[row])};
  }
};

/// The slots that write to each target, ascending; targets[slot] in 0 … rows−1. Throws InputError beyond 2³¹ − 1 slots.
Rows rows_by_target(int rows, std::span<const int> targets);

}  // namespace elastin
