#include "core/model/incidence.h"

#include <algorithm>
#include <cstdint>
#include <string>
#include <unordered_map>

#include "elastin/core/base/error.h"

namespace elastin {
namespace {

std::uint64_t pair_key(int a, int b) {
  return static_cast<std::uint64_t>(std::min(a, b)) << 32 | static_cast<std::uint32_t>(std::max(a, b));
}

}  // namespace

Rows connections_of_molecules(int molecules, const Connections& connections) {
  const int* ends = connections.ends.empty() ? nullptr : connections.ends.front().data();
  Rows rows = rows_by_target(molecules, {ends, 2 * connections.ends.size()});
  for (int& slot : rows.entries) slot /= 2;
  return rows;
}

template <int corners>
std::vector<std::array<int, corners*(corners - 1) / 2>> connections_of_each_cell(
    const Connections& connections, const std::vector<std::array<int, static_cast<std::size_t>(corners)>>& cells) {
  std::unordered_map<std::uint64_t, int> index;
  index.reserve(connections.ends.size());
  for (int c = 0; c < connections.size(); ++c) index[pair_key(connections.ends[c][0], connections.ends[c][1])] = c;
  std::vector<std::array<int, corners*(corners - 1) / 2>> result;
  result.reserve(cells.size());
  for (const auto& cell : cells) {
    auto& row = result.emplace_back();
    int slot = 0;
    for (int i = 0; i < corners; ++i)
      for (int j = i + 1; j < corners; ++j) {
        const auto found = index.find(pair_key(cell[i], cell[j]));
        if (found == index.end())
          throw InputError("cell " + std::to_string(result.size() - 1) + " has no connection between molecules " +
                           std::to_string(cell[i]) + " and " + std::to_string(cell[j]));
        row[slot++] = found->second;
      }
  }
  return result;
}

template std::vector<std::array<int, 3>> connections_of_each_cell<3>(const Connections&, const Cells<3>&);
template std::vector<std::array<int, 6>> connections_of_each_cell<4>(const Connections&, const Cells<4>&);

}  // namespace elastin
