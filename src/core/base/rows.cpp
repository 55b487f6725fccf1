#include "core/base/rows.h"

#include "core/base/count.h"

namespace elastin {

Rows rows_by_target(int rows, std::span<const int> targets) {
  numbered(static_cast<std::int64_t>(targets.size()), "ends of connections or corners of cells");
  Rows result;
  result.start.assign(rows + 1, 0);
  for (const int target : targets) ++result.start[target + 1];
  for (int row = 0; row < rows; ++row) result.start[row + 1] += result.start[row];
  result.entries.resize(targets.size());
  std::vector<int> next(result.start.begin(), result.start.end() - 1);
  for (std::size_t slot = 0; slot < targets.size(); ++slot)
    result.entries[next[targets[slot]]++] = static_cast<int>(slot);
  return result;
}

}  // namespace elastin
