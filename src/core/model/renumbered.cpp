#include "elastin/core/model/renumbered.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "elastin/core/base/error.h"
#include "elastin/core/geometry/numbering.h"

namespace elastin {
namespace {

using Numbers = std::vector<int>;

/// The numbers first … last − 1 in the order of their keys; equal ones keep their order.
template <class Key>
void append_in_order(int first, int last, const Key& key, Numbers& all) {
  const auto begin = all.insert(all.end(), static_cast<std::size_t>(last - first), 0);
  std::iota(begin, all.end(), first);
  std::stable_sort(begin, all.end(), [&](int a, int b) { return key(a) < key(b); });
}

template <class Values>
void permute(Values& values, const Numbers& from) {
  if (values.size() == 0) return;
  const Values before = values;
  for (std::size_t at = 0; at < from.size(); ++at) values[at] = before[from[at]];
}
void permute(VectorX& values, const Numbers& from) {
  if (values.size()) values = values(from).eval();
}
void permute(Positions& values, const Numbers& from) {
  if (values.cols()) values = values(Eigen::all, from).eval();
}

/// Cells of new molecules in the order of their lowest one.
template <std::size_t nodes>
Numbers renumber(std::vector<std::array<int, nodes>>& cells, const Numbers& number) {
  for (auto& cell : cells)
    for (int& node : cell) node = number[node];
  Numbers from;
  append_in_order(
      0, static_cast<int>(cells.size()),
      [&](int cell) {
        const auto& own = cells[cell];
        return *std::min_element(own.begin(), own.end());
      },
      from);
  permute(cells, from);
  return from;
}

void renumber(CellBlock& block, const Numbers& number) {
  for (int& node : block.nodes) node = number[node];
  Numbers from;
  append_in_order(
      0, block.size(), [&](int cell) { return *std::min_element(block.cell(cell).begin(), block.cell(cell).end()); },
      from);
  const CellBlock before = block;
  auto to = block.nodes.begin();
  for (const int cell : from) to = std::copy(before.cell(cell).begin(), before.cell(cell).end(), to);
  permute(block.stiffness, from);
}

}  // namespace

RenumberedBody numbered_in_space(const Body& body) {
  if (!body.parts.empty() || !body.ties.empty() || !body.between.empty() || body.share)
    throw InputError("a body of several parts, or a refined one, keeps its numbers");
  RenumberedBody result{body, order_in_space(body.rest), {}};
  Body& own = result.body;
  Numbers number(result.molecule_from.size());
  for (std::size_t at = 0; at < number.size(); ++at) number[result.molecule_from[at]] = static_cast<int>(at);

  permute(own.rest, result.molecule_from);
  permute(own.mass, result.molecule_from);
  permute(own.radius, result.molecule_from);
  own.grid.reset();

  Connections& connections = own.connections;
  for (auto& ends : connections.ends) {
    for (int& end : ends) end = number[end];
    std::sort(ends.begin(), ends.end());
  }
  const auto ends_of = [&](int connection) { return connections.ends[connection]; };
  append_in_order(0, connections.proper(), ends_of, result.connection_from);
  append_in_order(connections.proper(), connections.size(), ends_of, result.connection_from);
  permute(connections.ends, result.connection_from);
  permute(connections.rest_length, result.connection_from);
  permute(own.connection_stiffness, result.connection_from);
  if (!own.cables.empty()) {
    Numbers connection(result.connection_from.size());
    for (std::size_t at = 0; at < connection.size(); ++at)
      connection[result.connection_from[at]] = static_cast<int>(at);
    for (Cable& cable : own.cables) cable.connection = connection[cable.connection];
  }

  const Numbers triangles = renumber(own.triangles, number), tetrahedra = renumber(own.tetrahedra, number);
  permute(own.cell_stiffness, own.tetrahedra.empty() ? triangles : tetrahedra);
  renumber(own.cubes, number);
  for (CellBlock& block : own.blocks) renumber(block, number);
  if (own.voronoi) {
    permute(own.voronoi->face_area,
            Numbers(result.connection_from.begin(), result.connection_from.begin() + connections.proper()));
    permute(own.voronoi->volume, result.molecule_from);
    permute(own.voronoi->surface_area, result.molecule_from);
  }
  return result;
}

}  // namespace elastin
