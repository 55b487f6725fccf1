#include "elastin/core/shapes/orders.h"

#include <algorithm>
#include <map>
#include <string>
#include <utility>

#include "elastin/core/base/error.h"

namespace elastin {
namespace {

/// The cells of a body as blocks, of first order where it has no blocks.
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

/// The first-order kind with the same corners.
const CellKind& first_order(const CellKind& kind) {
  for (const CellKind& other : cell_kinds())
    if (other.nodes == other.corners && other.dimensions == kind.dimensions && other.corners == kind.corners)
      return other;
  return kind;
}

/// What a change of cells does not keep.
Body bare(const Body& body) {
  if (!body.parts.empty()) throw InputError("the order of cells is chosen before bodies are put together");
  Body result = body;
  result.blocks.clear(), result.cubes.clear(), result.grid.reset(), result.voronoi.reset();
  result.connection_stiffness.resize(0), result.cell_stiffness.resize(0);
  return result;
}

/// Leaves out molecules that no cell has: those between the corners of cells that were of second order.
void leave_out_unused(Body& body) {
  std::vector<int> number(static_cast<std::size_t>(body.size()), -1), kept;
  for (const CellBlock& block : body.blocks)
    for (const int node : block.nodes) number[static_cast<std::size_t>(node)] = 0;
  for (int molecule = 0; molecule < body.size(); ++molecule) {
    if (number[static_cast<std::size_t>(molecule)] < 0) continue;
    number[static_cast<std::size_t>(molecule)] = static_cast<int>(kept.size());
    kept.push_back(molecule);
  }
  body.rest = body.rest(Eigen::all, kept).eval();
  for (CellBlock& block : body.blocks)
    for (int& node : block.nodes) node = number[static_cast<std::size_t>(node)];
}

}  // namespace

Body with_cells(const Body& body, const CellKind& kind) {
  Body result = bare(body);
  std::vector<Vector3> added;
  std::map<std::vector<int>, int> between;  // node by the corners that it lies between
  for (const CellBlock& block : blocks_of(body)) {
    if (block.kind->corners != kind.corners || block.kind->dimensions != kind.dimensions)
      throw InputError("the body has " + std::string(block.kind->plural) + ", which cannot become " +
                       std::string(kind.plural));
    const CellKind& linear = first_order(kind);
    CellBlock changed{&kind, {}, block.stiffness};
    changed.nodes.reserve(static_cast<std::size_t>(block.size() * kind.nodes));
    for (int cell = 0; cell < block.size(); ++cell) {
      const auto corners = block.cell(cell).first(static_cast<std::size_t>(kind.corners));
      changed.nodes.insert(changed.nodes.end(), corners.begin(), corners.end());
      for (int a = kind.corners; a < kind.nodes; ++a) {
        const VectorX weights = linear.functions(kind.reference.col(a));
        std::vector<int> ends;
        Vector3 place = Vector3::Zero();
        for (int c = 0; c < kind.corners; ++c) {
          if (!(weights[c] > 1e-9)) continue;
          ends.push_back(corners[static_cast<std::size_t>(c)]);
          place += weights[c] * body.rest.col(ends.back());
        }
        std::sort(ends.begin(), ends.end());
        const auto [at, is_new] = between.emplace(std::move(ends), body.size() + static_cast<int>(added.size()));
        if (is_new) added.push_back(place);
        changed.nodes.push_back(at->second);
      }
    }
    result.blocks.push_back(std::move(changed));
  }
  result.rest.conservativeResize(3, body.size() + static_cast<Eigen::Index>(added.size()));
  for (std::size_t i = 0; i < added.size(); ++i) result.rest.col(body.size() + static_cast<Eigen::Index>(i)) = added[i];
  leave_out_unused(result);
  set_simplices(result);
  return result;
}

Body with_order(const Body& body, int order) {
  const std::vector<CellBlock> blocks = blocks_of(body);
  const CellKind& corners = first_order(*blocks.front().kind);
  for (const CellBlock& block : blocks)
    if (&first_order(*block.kind) != &corners)
      throw InputError("the order of a body whose cells have several shapes cannot be chosen");
  if (order == 1) return with_cells(body, corners);
  const std::string_view names[] = {"triangle6", "tetrahedron10", "hexahedron27"};
  for (const auto& name : names)
    if (&first_order(cell_kind(name)) == &corners) return with_cells(body, cell_kind(name));
  throw InputError(std::string(corners.plural) + " have no second order here");
}

Body refined(const Body& body) {
  const std::vector<CellBlock> blocks = blocks_of(body);
  const bool is_fine = std::all_of(blocks.begin(), blocks.end(), [](const CellBlock& block) {
    return block.kind->name == "tetrahedron10" || block.kind->name == "hexahedron27" || block.kind->name == "triangle6";
  });
  const Body fine = is_fine ? body : with_order(body, 2);
  Body result = bare(fine);
  for (const CellBlock& block : fine.blocks) {
    const CellKind& linear = first_order(*block.kind);
    CellBlock parts{&linear, {}, {}};
    std::vector<double> stiffness;
    for (int cell = 0; cell < block.size(); ++cell) {
      const auto nodes = block.cell(cell);
      std::vector<std::vector<int>> cells;
      if (linear.corners == 8)
        cells = hexahedra_of_27();
      else
        cells = simplices_of(*block.kind, nodes);
      for (const auto& own : cells) {
        for (const int node : own) parts.nodes.push_back(nodes[static_cast<std::size_t>(node)]);
        if (block.stiffness.size()) stiffness.push_back(block.stiffness[cell]);
      }
    }
    parts.stiffness = Eigen::Map<const VectorX>(stiffness.data(), static_cast<Eigen::Index>(stiffness.size()));
    result.blocks.push_back(std::move(parts));
  }
  set_simplices(result);
  return result;
}

}  // namespace elastin
