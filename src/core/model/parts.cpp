#include "elastin/core/model/parts.h"

#include <algorithm>
#include <utility>

#include "core/base/named.h"
#include "elastin/core/base/error.h"
#include "elastin/core/geometry/cell_kind.h"

namespace elastin {
namespace {

/// Puts the rows of `added` behind those of `cells`, their corners `shift` further on; says where they are.
template <class CellList>
CellRange append(CellList& cells, const CellList& added, int shift) {
  const CellRange range{static_cast<int>(cells.size()), static_cast<int>(added.size())};
  for (auto cell : added) {
    for (int& corner : cell) corner += shift;
    cells.push_back(cell);
  }
  return range;
}

void append(VectorX& values, const VectorX& added) {
  values.conservativeResize(values.size() + added.size());
  values.tail(added.size()) = added;
}

/// One number a connection of two bodies, those proper of both first.
VectorX proper_first(const VectorX& one, int one_proper, const VectorX& other, int other_proper) {
  VectorX all(one.size() + other.size());
  all << one.head(one_proper), other.head(other_proper), one.tail(one.size() - one_proper),
      other.tail(other.size() - other_proper);
  return all;
}

VectorX or_ones(const VectorX& factors, std::size_t size) {
  return factors.size() ? factors : VectorX::Ones(static_cast<Eigen::Index>(size));
}

std::size_t cells_of(const Body& body) {
  return body.tetrahedra.empty() ? body.triangles.size() : body.tetrahedra.size();
}

void append_connections(Body& whole, const Body& body, int shift) {
  Connections all;
  const auto add = [&](const Connections& from, int first, int last, int by) {
    for (int c = first; c < last; ++c) {
      const auto& [a, b] = from.ends[c];
      all.ends.push_back({a + by, b + by});
      all.rest_length.push_back(from.rest_length[c]);
    }
  };
  const Connections &one = whole.connections, &other = body.connections;
  add(one, 0, one.proper(), 0);
  add(other, 0, other.proper(), shift);
  add(one, one.proper(), one.size(), 0);
  add(other, other.proper(), other.size(), shift);
  all.cell_sides = one.cell_sides + other.cell_sides;
  whole.connections = std::move(all);
}

void append_stiffness(Body& whole, const Body& body) {
  if (whole.connection_stiffness.size() || body.connection_stiffness.size())
    whole.connection_stiffness =
        proper_first(or_ones(whole.connection_stiffness, whole.connections.ends.size()), whole.connections.proper(),
                     or_ones(body.connection_stiffness, body.connections.ends.size()), body.connections.proper());
  if (!whole.cell_stiffness.size() && !body.cell_stiffness.size()) return;
  if (cells_of(whole) && cells_of(body) && whole.tetrahedra.empty() != body.tetrahedra.empty())
    throw InputError("regions: not in a body of triangles and one of tetrahedra together");
  VectorX factors = or_ones(whole.cell_stiffness, cells_of(whole));
  append(factors, or_ones(body.cell_stiffness, cells_of(body)));
  whole.cell_stiffness = std::move(factors);
}

std::vector<CellBlock> blocks_of(const Body& whole, const Part& part) {
  const auto first = whole.blocks.begin() + part.blocks.first;
  return {first, first + part.blocks.count};
}

bool is_simplex(const CellKind& kind) { return kind.nodes == kind.dimensions + 1; }

/// Where a part has blocks of cells of some dimension, all parts have: those who look at blocks look at nothing else.
template <class CellList>
void make_blocks_of_all(Body& whole, int dimensions, const CellList& simplices, CellRange Part::*range) {
  if (!has_blocks(whole, dimensions)) return;
  const CellKind& kind = cell_kind(dimensions == 3 ? "tetrahedron4" : "triangle3");
  int more = 0;
  for (Part& part : whole.parts) {
    part.blocks.first += more;
    const std::vector<CellBlock> own = blocks_of(whole, part);
    const auto [first, count] = part.*range;
    if (count == 0 || std::any_of(own.begin(), own.end(),
                                  [&](const CellBlock& block) { return block.kind->dimensions == dimensions; }))
      continue;
    CellBlock block{&kind, {}, {}};
    for (auto cell = simplices.begin() + first; cell != simplices.begin() + first + count; ++cell)
      block.nodes.insert(block.nodes.end(), cell->begin(), cell->end());
    if (whole.cell_stiffness.size() && (dimensions == 3 || whole.tetrahedra.empty()))
      block.stiffness = whole.cell_stiffness.segment(first, count);
    whole.blocks.insert(whole.blocks.begin() + part.blocks.first + part.blocks.count, std::move(block));
    ++part.blocks.count, ++more;
  }
}

/// Of a body that is one part again: cells that its triangles and tetrahedra say need no block.
void leave_simplices(std::vector<CellBlock>& blocks) {
  for (const int dimensions : {2, 3}) {
    const auto of = [&](const CellBlock& block) { return block.kind->dimensions == dimensions; };
    if (std::all_of(blocks.begin(), blocks.end(), [&](const CellBlock& b) { return !of(b) || is_simplex(*b.kind); }))
      std::erase_if(blocks, of);
  }
}

/// A body without an outline is bounded by its molecules.
void append_outline(Body& whole, const Body& body) {
  if (whole.outline.cols() + body.outline.cols() == 0) return;
  const Positions& before = whole.outline.cols() > 0 ? whole.outline : whole.rest;
  const Positions& added = body.outline.cols() > 0 ? body.outline : body.rest;
  Positions outline(3, before.cols() + added.cols());
  outline << before, added;
  whole.outline = std::move(outline);
}

}  // namespace

void add_part(Body& whole, const Body& body, Part what) {
  for (const Part& other : whole.parts)
    if (other.name == what.name) throw InputError("there is a body '" + what.name + "' already");
  append_stiffness(whole, body);
  append_outline(whole, body);
  what.first = whole.size(), what.count = body.size();
  if (whole.parts.empty()) whole.assumed_density = body.assumed_density;
  if (body.assumed_density != whole.assumed_density) whole.assumed_density = 0;
  const int shift = what.first, cable_shift = whole.connections.proper();
  append_connections(whole, body, shift);
  for (Cable cable : body.cables) cable.connection += cable_shift, whole.cables.push_back(cable);
  whole.rest.conservativeResize(3, shift + body.size());
  whole.rest.rightCols(body.size()) = body.rest;
  append(whole.mass, body.mass), append(whole.radius, body.radius);
  what.triangles = append(whole.triangles, body.triangles, shift);
  what.tetrahedra = append(whole.tetrahedra, body.tetrahedra, shift);
  what.cubes = append(whole.cubes, body.cubes, shift);
  what.blocks = {static_cast<int>(whole.blocks.size()), static_cast<int>(body.blocks.size())};
  for (CellBlock block : body.blocks) {
    for (int& node : block.nodes) node += shift;
    whole.blocks.push_back(std::move(block));
  }
  whole.grid.reset(), whole.voronoi.reset();
  what.voronoi = body.voronoi, what.shared.clear();
  whole.parts.push_back(std::move(what));
  make_blocks_of_all(whole, 2, whole.triangles, &Part::triangles);
  make_blocks_of_all(whole, 3, whole.tetrahedra, &Part::tetrahedra);
}

std::vector<int> molecules_of(const Part& part) {
  std::vector<int> molecules = part.shared;
  for (int molecule = part.first; molecule < part.first + part.count; ++molecule) molecules.push_back(molecule);
  std::sort(molecules.begin(), molecules.end());
  return molecules;
}

const Part& find_part(const Body& body, const std::string& name) {
  if (body.parts.empty()) throw InputError("'" + name + "': the scene has no named bodies; give it `bodies:`");
  return named(body.parts, name, "there is no body '" + name + "'");
}

PartAlone part_alone(const Body& whole, const Part& part) {
  PartAlone result;
  Body& body = result.body;
  result.molecules = molecules_of(part);
  std::vector<int> own(whole.size(), -1);
  for (std::size_t i = 0; i < result.molecules.size(); ++i) own[result.molecules[i]] = static_cast<int>(i);
  body.rest = whole.rest(Eigen::all, result.molecules);
  body.unstressed = whole.unstressed;
  body.mass = whole.mass(result.molecules), body.radius = whole.radius(result.molecules);
  for (int c = 0; c < whole.connections.size(); ++c) {
    const auto& [a, b] = whole.connections.ends[c];
    const std::array ends{own[a], own[b]};
    if (ends[0] < 0 || ends[1] < 0) continue;
    result.connections.push_back(c);
    body.connections.ends.push_back(ends);
    body.connections.rest_length.push_back(whole.connections.rest_length[c]);
    body.connections.cell_sides += c >= whole.connections.proper();
  }
  const auto take = [&](auto& to, const auto& from, const CellRange& range) {
    to.assign(from.begin() + range.first, from.begin() + range.first + range.count);
    for (auto& cell : to)
      for (int& corner : cell) corner = own[corner];
  };
  take(body.triangles, whole.triangles, part.triangles);
  take(body.tetrahedra, whole.tetrahedra, part.tetrahedra);
  take(body.cubes, whole.cubes, part.cubes);
  body.blocks = blocks_of(whole, part);
  leave_simplices(body.blocks);
  for (CellBlock& block : body.blocks)
    for (int& node : block.nodes) node = own[node];
  if (whole.connection_stiffness.size()) body.connection_stiffness = whole.connection_stiffness(result.connections);
  if (whole.cell_stiffness.size()) {
    const CellRange& range = whole.tetrahedra.empty() ? part.triangles : part.tetrahedra;
    body.cell_stiffness = whole.cell_stiffness.segment(range.first, range.count);
  }
  body.voronoi = part.voronoi;
  return result;
}

Body with_cells_of(const Body& whole, const Part& part) {
  Body body = whole;
  const auto keep = [](auto& cells, const CellRange& range) {
    cells = std::remove_reference_t<decltype(cells)>(cells.begin() + range.first,
                                                     cells.begin() + range.first + range.count);
  };
  keep(body.triangles, part.triangles), keep(body.tetrahedra, part.tetrahedra), keep(body.cubes, part.cubes);
  body.blocks = blocks_of(whole, part);
  leave_simplices(body.blocks);
  if (whole.cell_stiffness.size()) {
    const CellRange& range = whole.tetrahedra.empty() ? part.triangles : part.tetrahedra;
    body.cell_stiffness = whole.cell_stiffness.segment(range.first, range.count).eval();
  }
  body.voronoi.reset();
  return body;
}

Body without_cells(const Body& whole) {
  Body body = whole;
  body.triangles.clear(), body.tetrahedra.clear(), body.blocks.clear();
  for (Part& part : body.parts) part.triangles = part.tetrahedra = part.blocks = {};
  return body;
}

}  // namespace elastin
