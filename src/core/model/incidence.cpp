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

std::vector<int> connections_of_some_pairs(const Connections& connections, std::span<const int> nodes, int of_each) {
  std::unordered_map<std::uint64_t, int> index;
  index.reserve(connections.ends.size());
  for (int c = 0; c < connections.size(); ++c) index[pair_key(connections.ends[c][0], connections.ends[c][1])] = c;
  std::vector<int> result;
  result.reserve(nodes.size() * static_cast<std::size_t>(of_each - 1) / 2);
  for (std::size_t first = 0; first < nodes.size(); first += static_cast<std::size_t>(of_each)) {
    const auto cell = nodes.subspan(first, static_cast<std::size_t>(of_each));
    for (std::size_t i = 0; i < cell.size(); ++i)
      for (std::size_t j = i + 1; j < cell.size(); ++j) {
        const auto found = index.find(pair_key(cell[i], cell[j]));
        result.push_back(found == index.end() ? -1 : found->second);
      }
  }
  return result;
}

std::vector<int> connections_of_pairs(const Connections& connections, std::span<const int> nodes, int of_each) {
  std::vector<int> result = connections_of_some_pairs(connections, nodes, of_each);
  const auto none = std::find(result.begin(), result.end(), -1);
  if (none == result.end()) return result;
  const auto pairs = static_cast<std::ptrdiff_t>(of_each) * (of_each - 1) / 2, cell = (none - result.begin()) / pairs;
  std::ptrdiff_t pair = (none - result.begin()) % pairs;
  int i = 0;
  for (; pair >= of_each - 1 - i; ++i) pair -= of_each - 1 - i;
  const auto node = [&](std::ptrdiff_t number) { return nodes[cell * of_each + number]; };
  throw InputError("cell " + std::to_string(cell) + " has no connection between molecules " + std::to_string(node(i)) +
                   " and " + std::to_string(node(i + 1 + pair)));
}

template <int corners>
std::vector<std::array<int, corners*(corners - 1) / 2>> connections_of_each_cell(
    const Connections& connections, const std::vector<std::array<int, static_cast<std::size_t>(corners)>>& cells) {
  constexpr std::size_t sides = corners * (corners - 1) / 2;
  const int* nodes = cells.empty() ? nullptr : cells.front().data();
  const std::vector<int> pairs = connections_of_pairs(connections, {nodes, cells.size() * corners}, corners);
  std::vector<std::array<int, sides>> result(cells.size());
  for (std::size_t cell = 0; cell < cells.size(); ++cell)
    std::copy_n(pairs.begin() + static_cast<std::ptrdiff_t>(cell * sides), sides, result[cell].begin());
  return result;
}

template std::vector<std::array<int, 3>> connections_of_each_cell<3>(const Connections&, const Cells<3>&);
template std::vector<std::array<int, 6>> connections_of_each_cell<4>(const Connections&, const Cells<4>&);

}  // namespace elastin
