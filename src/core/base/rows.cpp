#include "core/base/rows.h"

#include <limits>
#include <string>

#include "elastin/core/base/error.h"

namespace elastin {

int numbered(std::int64_t count, const char* what) {
  constexpr int most = std::numeric_limits<int>::max();
  if (count > most)
    throw InputError(std::to_string(count) + " " + what + " are more than " + std::to_string(most) +
                     ", the most that a body can have");
  return static_cast<int>(count);
}

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
