#include "core/shapes/orders.h"

#include <algorithm>
#include <map>
#include <string>
#include <utility>

#include "core/shapes/block_orders.h"
#include "elastin/core/base/error.h"

namespace elastin {
std::vector<CellBlock> blocks_of(const Body& body) {
  if (!body.blocks.empty()) return body.blocks;
  std::vector<CellBlock> blocks;
  const auto add = [&](const char* name, const auto& cells, const std::vector<std::size_t>& order) {
    if (cells.empty()) return;
    CellBlock block{&cell_kind(name), {}, {}};
    for (const auto& cell : cells)
      for (const std::size_t corner : order) block.nodes.push_back(cell[corner]);
    if (body.cell_stiffness.size() == static_cast<Eigen::Index>(cells.size())) block.stiffness = body.cell_stiffness;
    blocks.push_back(std::move(block));
  };
  add("tetrahedron4", body.tetrahedra, {0, 1, 2, 3});
  if (body.tetrahedra.empty()) add("hexahedron8", body.cubes, {0, 1, 3, 2, 4, 5, 7, 6});
  if (body.tetrahedra.empty() && body.cubes.empty()) add("triangle3", body.triangles, {0, 1, 2});
  if (blocks.empty()) throw InputError("the body has no cells whose order could be chosen");
  return blocks;
}

const CellKind& first_order_of(const CellKind& kind) {
  for (const CellKind& other : cell_kinds())
    if (other.nodes == other.corners && other.dimensions == kind.dimensions && other.corners == kind.corners)
      return other;
  return kind;
}

namespace {

/// What a change of cells does not keep.
Body bare(const Body& body) {
  if (!body.parts.empty()) throw InputError("the order of cells is chosen before bodies are put together");
  Body result = body;
  result.blocks.clear(), result.cubes.clear(), result.grid.reset(), result.voronoi.reset();
  result.connection_stiffness.resize(0), result.cell_stiffness.resize(0);
  return result;
}

/// Leaves out molecules that no cell has: those between the corners of cells that were of second order. Says whether
/// there were any.
bool leave_out_unused(Body& body) {
  std::vector<int> number(body.size(), -1), kept;
  for (const CellBlock& block : body.blocks)
    for (const int node : block.nodes) number[node] = 0;
  for (int molecule = 0; molecule < body.size(); ++molecule) {
    if (number[molecule] < 0) continue;
    number[molecule] = static_cast<int>(kept.size());
    kept.push_back(molecule);
  }
  body.rest = body.rest(Eigen::all, kept).eval();
  for (CellBlock& block : body.blocks)
    for (int& node : block.nodes) node = number[node];
  return kept.size() < number.size();
}

}  // namespace

Body with_cells(const Body& body, const CellKind& kind) {
  Body result = bare(body);
  std::vector<Vector3> added;
  std::vector<MoleculeBetween> weights_of_added;
  std::map<std::vector<int>, int> between;  // node by the corners that it lies between
  for (const CellBlock& block : blocks_of(body)) {
    if (block.kind->corners != kind.corners || block.kind->dimensions != kind.dimensions)
      throw InputError("the body has " + std::string(block.kind->plural) + ", which cannot become " +
                       std::string(kind.plural));
    const CellKind& linear = first_order_of(kind);
    CellBlock changed{&kind, {}, block.stiffness};
    changed.nodes.reserve(block.size() * kind.nodes);
    for (int cell = 0; cell < block.size(); ++cell) {
      const auto corners = block.cell(cell).first(static_cast<std::size_t>(kind.corners));
      changed.nodes.insert(changed.nodes.end(), corners.begin(), corners.end());
      for (int a = kind.corners; a < kind.nodes; ++a) {
        const VectorX weights = linear.functions(kind.reference.col(a));
        std::vector<int> ends;
        Vector3 place = Vector3::Zero();
        for (int c = 0; c < kind.corners; ++c) {
          if (!(weights[c] > 1e-9)) continue;
          ends.push_back(corners[c]);
          place += weights[c] * body.rest.col(ends.back());
        }
        std::sort(ends.begin(), ends.end());
        const auto [at, is_new] = between.emplace(std::move(ends), body.size() + static_cast<int>(added.size()));
        if (is_new) {
          added.push_back(place);
          auto& own = weights_of_added.emplace_back();
          for (int c = 0; c < kind.corners; ++c)
            if (weights[c] > 1e-9) own.emplace_back(corners[c], weights[c]);
        }
        changed.nodes.push_back(at->second);
      }
    }
    result.blocks.push_back(std::move(changed));
  }
  result.rest.conservativeResize(3, body.size() + static_cast<Eigen::Index>(added.size()));
  for (std::size_t i = 0; i < added.size(); ++i) result.rest.col(body.size() + static_cast<Eigen::Index>(i)) = added[i];
  if (leave_out_unused(result)) {
    result.mass.resize(0), result.radius.resize(0), result.between.clear();
  } else {
    carry_matter(body, weights_of_added, result);
    result.between.insert(result.between.end(), weights_of_added.begin(), weights_of_added.end());
  }
  set_simplices(result);
  return result;
}

Body with_order(const Body& body, int order) {
  const std::vector<CellBlock> blocks = blocks_of(body);
  const CellKind& corners = first_order_of(*blocks.front().kind);
  for (const CellBlock& block : blocks)
    if (&first_order_of(*block.kind) != &corners)
      throw InputError("the order of a body whose cells have several shapes cannot be chosen");
  const auto has_it = [&](const CellBlock& block) { return block.kind->order == order; };
  if (!body.blocks.empty() && std::all_of(blocks.begin(), blocks.end(), has_it)) return body;
  if (order == 1) return with_cells(body, corners);
  const std::string_view names[] = {"triangle6", "tetrahedron10", "hexahedron27"};
  for (const auto& name : names)
    if (&first_order_of(cell_kind(name)) == &corners) return with_cells(body, cell_kind(name));
  throw InputError(std::string(corners.plural) + " have no second order here");
}

}  // namespace elastin
