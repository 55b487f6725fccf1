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

/// With molecules in another order; gives their new numbers.
Numbers permute_molecules(RenumberedBody& result) {
  Body& own = result.body;
  Numbers number(result.molecule_from.size());
  for (std::size_t at = 0; at < number.size(); ++at) number[result.molecule_from[at]] = static_cast<int>(at);
  permute(own.rest, result.molecule_from);
  permute(own.mass, result.molecule_from);
  permute(own.radius, result.molecule_from);
  own.grid.reset();
  return number;
}

constexpr const char* kKeepsNumbers = "a body of several parts, or a refined one, keeps its numbers";

void check_whole(const Body& body) {
  if (!body.parts.empty() || !body.ties.empty() || body.share) throw InputError(kKeepsNumbers);
}

/// Of what lies between others, these come first in the new numbers, too, or the body is refused.
void renumber_between(const Numbers& from, const Numbers& number, Body& body) {
  if (body.between.empty()) return;
  const std::vector<MoleculeBetween> before = std::exchange(body.between, std::vector<MoleculeBetween>(from.size()));
  const int first = body.size() - static_cast<int>(before.size());
  for (int at = 0; at < body.size(); ++at) {
    if (from[at] < first) continue;
    body.between[at] = before[from[at] - first];
    for (auto& [other, weight] : body.between[at])
      if ((other = number[other]) >= at) throw InputError(kKeepsNumbers);
  }
}

/// A cell as it was given, with the simplices that it makes.
struct LabelledCell {
  int label;
  const CellBlock* block;  ///< null: it is its one simplex, or a cube
  int number;              ///< in the block
  int first, count;        ///< simplices
};

template <std::size_t corners>
CellRange append(const LabelledCell& cell, const Cells<corners>& from, const Numbers& number, Cells<corners>& to) {
  for (int simplex = cell.first; simplex < cell.first + cell.count; ++simplex) {
    to.push_back(from[simplex]);
    for (int& corner : to.back()) corner = number[corner];
  }
  return {static_cast<int>(to.size()) - cell.count, cell.count};
}

void extend(CellRange& range, const CellRange& by) {
  if (range.count == 0) range.first = by.first;
  range.count += by.count;
}

/// Its cells in the order of their labels.
std::vector<LabelledCell> labelled_cells(const Body& body, const std::vector<int>& labels) {
  std::vector<LabelledCell> cells;
  int first = 0;
  for (const CellBlock& block : body.blocks)
    for (int cell = 0; cell < block.size(); ++cell) {
      const int count = static_cast<int>(simplices_of(*block.kind, block.cell(cell)).size());
      cells.push_back({0, &block, cell, first, count});
      first += count;
    }
  if (cells.empty())
    for (std::size_t i = 0; i < std::max(body.tetrahedra.size(), body.triangles.size()); ++i)
      cells.push_back({0, nullptr, 0, static_cast<int>(i), 1});
  for (std::size_t i = 0; i < body.cubes.size(); ++i) cells.push_back({0, nullptr, static_cast<int>(i), 0, 0});
  if (cells.empty()) throw InputError("labels: are those of cells, and the body has none");
  if (cells.size() != labels.size())
    throw InputError("labels: has " + std::to_string(labels.size()) + " values; the body has " +
                     std::to_string(cells.size()) + " cells");
  for (std::size_t i = 0; i < cells.size(); ++i) cells[i].label = labels[i];
  std::stable_sort(cells.begin(), cells.end(), [](const auto& a, const auto& b) { return a.label < b.label; });
  return cells;
}

}  // namespace

RenumberedBody parts_of_labels(const Body& body, const std::vector<int>& labels) {
  check_whole(body);
  const bool solid = !body.tetrahedra.empty(), cubes = !body.cubes.empty();
  if (body.cell_stiffness.size() || (cubes && (solid || !body.triangles.empty())))
    throw InputError(
        "labels: a body with cubes next to other cells, or with a stiffness of each cell, keeps it: give materials to "
        "labels");
  const std::vector<LabelledCell> cells = labelled_cells(body, labels);
  const auto nodes = [&](const LabelledCell& cell) {
    if (cell.block) return Numbers(cell.block->cell(cell.number).begin(), cell.block->cell(cell.number).end());
    if (cubes) return Numbers(body.cubes[cell.number].begin(), body.cubes[cell.number].end());
    return solid ? Numbers(body.tetrahedra[cell.first].begin(), body.tetrahedra[cell.first].end())
                 : Numbers(body.triangles[cell.first].begin(), body.triangles[cell.first].end());
  };
  Numbers owner(body.size(), -1);  // what the label of a molecule without cells is does not matter
  for (const LabelledCell& cell : cells)
    for (const int node : nodes(cell))
      if (owner[node] < 0) owner[node] = static_cast<int>(&cell - cells.data());
  const auto label_of = [&](int molecule) {
    return owner[molecule] < 0 ? cells[0].label : cells[owner[molecule]].label;
  };

  RenumberedBody result{body, {}, {}};
  append_in_order(0, body.size(), label_of, result.molecule_from);
  const Numbers number = permute_molecules(result);
  Body& own = result.body;
  renumber_between(result.molecule_from, number, own);
  append_in_order(
      0, own.connections.size(), [](int) { return 0; }, result.connection_from);
  for (auto& ends : own.connections.ends) {
    for (int& end : ends) end = number[end];
    std::sort(ends.begin(), ends.end());
  }
  own.tetrahedra.clear(), own.triangles.clear(), own.cubes.clear(), own.blocks.clear(), own.voronoi.reset();
  for (const LabelledCell& cell : cells) {
    if (own.parts.empty() || own.parts.back().name != std::to_string(cell.label)) {
      Part part;
      part.name = std::to_string(cell.label), part.material = static_cast<int>(own.parts.size());
      part.first = own.parts.empty() ? 0 : own.parts.back().first + own.parts.back().count;
      for (int molecule = 0; molecule < body.size(); ++molecule) part.count += label_of(molecule) == cell.label;
      part.blocks.first = static_cast<int>(own.blocks.size());
      own.parts.push_back(std::move(part));
    }
    Part& part = own.parts.back();
    if (cubes) {
      own.cubes.push_back(body.cubes[cell.number]);
      for (int& corner : own.cubes.back()) corner = number[corner];
      extend(part.cubes, {static_cast<int>(own.cubes.size()) - 1, 1});
    } else if (solid)
      extend(part.tetrahedra, append(cell, body.tetrahedra, number, own.tetrahedra));
    else
      extend(part.triangles, append(cell, body.triangles, number, own.triangles));
    const Numbers at = nodes(cell);
    if (cell.block) {
      if (part.blocks.count == 0 || own.blocks.back().kind != cell.block->kind)
        own.blocks.push_back({cell.block->kind, {}, {}}), ++part.blocks.count;
      for (const int node : at) own.blocks.back().nodes.push_back(number[node]);
    }
    for (const int node : at)
      if (label_of(node) != cell.label) part.shared.push_back(number[node]);
  }
  for (Part& part : own.parts) {
    std::sort(part.shared.begin(), part.shared.end());
    part.shared.erase(std::unique(part.shared.begin(), part.shared.end()), part.shared.end());
  }
  return result;
}

RenumberedBody numbered_in_space(const Body& body) {
  check_whole(body);
  if (!body.between.empty()) throw InputError(kKeepsNumbers);
  RenumberedBody result{body, order_in_space(body.rest), {}};
  Body& own = result.body;
  const Numbers number = permute_molecules(result);

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
