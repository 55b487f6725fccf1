#pragma once
#include <cstddef>
#include <span>

namespace elastin {

/// One vector of each molecule of a row of a grid: all x, then all y, then all z, each `pitch` numbers after the last.
struct RowOf3 {
  double* x;
  std::ptrdiff_t pitch;
  double* y() const { return x + pitch; }
  double* z() const { return x + 2 * pitch; }
  RowOf3 from(int molecule) const { return {x + molecule, pitch}; }
};

/// Springs from each of `count` molecules to its partner in another row: adds q d to on_from and −q d to on_to, with
/// d = to − from, q = k (|d| − L)/|d|, 0 where |d| = 0. The four rows must not overlap.
using AddRowFlows = void (*)(RowOf3 from, RowOf3 to, const double* constants, const double* rest_lengths, int count,
                             RowOf3 on_from, RowOf3 on_to);

/// The same function for each vector width that this processor has, the best one last. All give the same bits.
std::span<const AddRowFlows> row_flows();

}  // namespace elastin
