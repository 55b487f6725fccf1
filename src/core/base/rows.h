#pragma once
#include <cstdint>
#include <span>
#include <vector>

namespace elastin {

/// The count as a number that molecules, connections, cells and slots have: 32 bits, at most 2³¹ − 1. Throws InputError
/// where it is larger: "3000000000 connections are more than 2147483647, the most that a body can have".
int numbered(std::int64_t count, const char* what);

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
