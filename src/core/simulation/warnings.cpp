#include "core/simulation/warnings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "core/model/block_geometry.h"
#include "core/model/carried_points.h"
#include "core/simulation/simulation_impl.h"
#include "elastin/core/base/text.h"
#include "elastin/core/model/parts.h"
#include "elastin/core/model/share.h"
#include "elastin/core/model/surface.h"

namespace elastin {
namespace {

/// Cells of this process whose nodes are another's.
int cells_given_twice(const Body& body) {
  std::vector<std::vector<int>> cells;
  const auto add = [&](const auto& all) {
    for (const auto& cell : all)
      if (lowest_in_whole(body, cell) < owned_molecules(body)) cells.emplace_back(cell.begin(), cell.end());
  };
  if (body.blocks.empty()) add(body.tetrahedra), add(body.triangles);
  for (const CellBlock& block : body.blocks)
    for (int cell = 0; cell < block.size(); ++cell) {
      const auto nodes = block.cell(cell);
      cells.emplace_back(nodes.begin(), nodes.end());
    }
  for (std::vector<int>& cell : cells) std::sort(cell.begin(), cell.end());
  std::sort(cells.begin(), cells.end());
  int count = 0;
  for (std::size_t cell = 1; cell < cells.size(); ++cell) count += cells[cell] == cells[cell - 1];
  return count;
}

/// Pairs of molecules that more than one connection joins, of those whose first molecule is this process's.
int connections_given_twice(const Body& body) {
  std::vector<std::uint64_t> pairs;
  pairs.reserve(body.connections.proper());
  for (int c = 0; c < body.connections.proper(); ++c) {
    const auto [a, b] = body.connections.ends[c];
    const auto low = static_cast<std::uint64_t>(std::min(a, b)), high = static_cast<std::uint64_t>(std::max(a, b));
    if (lowest_in_whole(body, body.connections.ends[c]) < owned_molecules(body)) pairs.push_back(low << 32 | high);
  }
  std::sort(pairs.begin(), pairs.end());
  int count = 0;
  for (std::size_t pair = 1; pair < pairs.size(); ++pair) count += pairs[pair] == pairs[pair - 1];
  return count;
}

double largest_in(const Body& body, const std::vector<Material>& materials) {
  double most = -1;
  for (const Material& material : materials) most = std::max(most, largest_poissons_ratio(material, body));
  return most;
}

constexpr double kSamePlace = 1e-6;  ///< of the body's extent

/// Molecules that lie where another one does, by places on a fine raster, of which round places are no borders.
int molecules_at_one_place(const Positions& rest) {
  if (rest.cols() == 0) return 0;
  const Vector3 low = rest.rowwise().minCoeff();
  const double width = kSamePlace * (rest.rowwise().maxCoeff() - low).maxCoeff();
  if (!(width > 0)) return 0;
  std::vector<std::array<std::int64_t, 3>> places(rest.cols());
  for (Eigen::Index a = 0; a < rest.cols(); ++a)
    for (int k = 0; k < 3; ++k) places[a][k] = std::llround((rest(k, a) - low[k]) / width + 0.217);
  std::sort(places.begin(), places.end());
  return static_cast<int>(places.end() - std::unique(places.begin(), places.end()));
}

/// Whether sides of a body's cells that nothing lies behind are looked for. Not of a grid.
bool has_sides(const Body& body) {
  constexpr std::size_t most_cells = 200000;
  return !body.tetrahedra.empty() && body.tetrahedra.size() <= most_cells && !body.grid && body.outline.cols() == 0;
}

/// Quadrilateral sides of cells, by their nodes, all corners of a triangular side of another cell being among them.
std::vector<std::vector<int>> quadrilaterals_on_triangles(const Body& body) {
  if (!has_sides(body) || !has_blocks(body, 3)) return {};
  std::vector<std::vector<int>> quadrilaterals;
  std::map<std::array<int, 3>, std::size_t> by_corners;  // any three of a quadrilateral's
  const std::vector<BlockFace> faces = boundary_faces(body);
  for (const BlockFace& face : faces)
    if (face.kind->corners == 4) {
      std::array<int, 4> corners{face.nodes[0], face.nodes[1], face.nodes[2], face.nodes[3]};
      std::sort(corners.begin(), corners.end());
      const auto [a, b, c, d] = corners;
      for (const auto& three : {std::array{a, b, c}, {a, b, d}, {a, c, d}, {b, c, d}})
        by_corners[three] = quadrilaterals.size();
      quadrilaterals.push_back(face.nodes);
    }
  std::set<std::size_t> found;
  for (const BlockFace& face : faces)
    if (face.kind->corners == 3) {
      std::array<int, 3> corners{face.nodes[0], face.nodes[1], face.nodes[2]};
      std::sort(corners.begin(), corners.end());
      if (const auto under = by_corners.find(corners); under != by_corners.end()) found.insert(under->second);
    }
  std::vector<std::vector<int>> on_triangles;
  for (const std::size_t number : found) on_triangles.push_back(std::move(quadrilaterals[number]));
  return on_triangles;
}

/// Of the surface of a solid: sides with another cell behind them, and how many were looked at. Not those of `joined`
/// sides, all of whose nodes cells on both sides of them have.
std::pair<int, int> sides_against_cells(const Body& body, const std::vector<std::vector<int>>& joined) {
  constexpr std::size_t most_sides = 2000;
  constexpr double behind = 1e-3;  // of a side's size
  if (!has_sides(body)) return {0, 0};
  Cells<3> sides = surface_of(body);
  std::vector<std::vector<std::size_t>> joined_at(joined.empty() ? 0 : static_cast<std::size_t>(body.size()));
  for (std::size_t number = 0; number < joined.size(); ++number)
    for (const int node : joined[number]) joined_at[node].push_back(number);
  const auto is_joined = [&](const std::array<int, 3>& side) {
    const auto has = [&](std::size_t number, int node) {
      return std::find(joined[number].begin(), joined[number].end(), node) != joined[number].end();
    };
    const auto& near = joined_at[side[0]];
    return std::any_of(near.begin(), near.end(), [&](std::size_t n) { return has(n, side[1]) && has(n, side[2]); });
  };
  if (!joined.empty()) std::erase_if(sides, is_joined);
  const std::size_t every = sides.size() / most_sides + 1;
  Positions points(3, static_cast<Eigen::Index>((sides.size() + every - 1) / every));
  for (Eigen::Index point = 0; point < points.cols(); ++point) {
    const auto& [a, b, c] = sides[static_cast<std::size_t>(point) * every];
    const Vector3 area = (body.rest.col(b) - body.rest.col(a)).cross(body.rest.col(c) - body.rest.col(a)) / 2;
    points.col(point) = (body.rest.col(a) + body.rest.col(b) + body.rest.col(c)) / 3 +
                        behind * area / std::sqrt(std::max(area.norm(), std::numeric_limits<double>::min()));
  }
  const CarriedPoints carried(body, points);
  int against = 0;
  for (int point = 0; point < carried.size(); ++point) {
    // A curved side of a cell may bulge beyond its flat triangle, so that the cell lies behind its own side.
    const auto begin = carried.molecules.begin() + carried.starts[point],
               end = carried.molecules.begin() + carried.starts[point + 1];
    const auto& side = sides[static_cast<std::size_t>(point) * every];
    const bool own =
        std::all_of(side.begin(), side.end(), [&](int node) { return std::find(begin, end, node) != end; });
    against += carried.beyond[point] == 0 && !own;
  }
  return {against, carried.size()};
}

std::string pairs_at_one_place(int count) {
  return counted(count, "pair") + " of molecules at the same place (of a mesh, `join` makes one of each)";
}

}  // namespace

std::string warning_of_pieces(const Body& body, const std::string& name) {
  const BodyFindings findings = inspect(body);
  if (findings.pieces <= 1) return "";
  const auto isolated = findings.isolated_molecules.size();
  const int same = molecules_at_one_place(body.rest);
  return name + " is not connected: " + std::to_string(findings.pieces) + " pieces" +
         (isolated == 0   ? ""
          : isolated == 1 ? ", one of them an isolated molecule"
                          : ", " + std::to_string(isolated) + " of them isolated molecules") +
         (same == 0 ? "" : "; " + pairs_at_one_place(same));
}

std::string warning_of_seams(const Body& body, const std::string& name) {
  if (body.tetrahedra.empty() && body.triangles.empty()) return "";
  if (const int same = molecules_at_one_place(body.rest); same > 0)
    return name + " has a crack, or a seam that nothing joins: " + pairs_at_one_place(same);
  const std::vector<std::vector<int>> joined = quadrilaterals_on_triangles(body);
  const auto [against, seen] = sides_against_cells(body, joined);
  if (against > 0)
    return "of " + counted(seen, "side") + " of the surface of " + name + ", " + std::to_string(against) +
           " lie against cells that do not have them: parts of a mesh that do not share the molecules between them "
           "come apart there; give them as `bodies` and join these by `ties`";
  if (joined.empty()) return "";
  const auto count = static_cast<std::ptrdiff_t>(joined.size());
  return counted(count, "quadrilateral side") + " of cells of " + name + (count == 1 ? " lies" : " lie") +
         " on triangular sides of others: their corners move together, but between these the displacements differ, so "
         "that stress nearby, and the modulus by up to some percent, are off; mesh both with sides of one shape there";
}

std::string warning_of_doubles(const Body& body, bool uses_cells) {
  const auto said = [&](int doubles, const char* what, const char* how, bool counts) {
    return counted(doubles, what) + (doubles == 1 ? " is" : " are") + how +
           (counts ? ": there the body is twice as stiff" : "");
  };
  if (const int cells = static_cast<int>(sum_over(body, cells_given_twice(body))); cells > 0)
    return said(cells, "cell", " given twice", uses_cells);
  const int pairs = uses_cells ? 0 : static_cast<int>(sum_over(body, connections_given_twice(body)));
  return pairs == 0 ? "" : said(pairs, "connection", " given twice, or both ways", true);
}

std::string warning_of_negative(const Body& body, const VectorX& constants) {
  int negative = 0;
  for (Eigen::Index c = 0; c < constants.size(); ++c)
    negative += constants[c] < 0 && computes(body, static_cast<int>(c));
  negative = static_cast<int>(sum_over(body, negative));
  return negative == 0 ? ""
                       : counted(negative, "spring constant is", "spring constants are") + " negative (of " +
                             std::to_string(constants.size()) + "): the body may have no stable equilibrium";
}

std::string warning_of_modes(const ModeReport& report) {
  if (report.zero_energy_modes == 0) return "";
  return "mechanism: " + std::string(report.counted ? "" : "at least ") +
         counted(report.zero_energy_modes, "zero-energy mode", "zero-energy modes") +
         (report.out_of_plane == 0
              ? ""
              : ", " + std::to_string(report.out_of_plane) + " of them out of the plane of the flat body");
}

double largest_poissons_ratio(const Material& material, const Body& body) {
  double most = material.poissons_ratio;
  for (int molecule = 0; material.field && molecule < body.size(); ++molecule)
    most = std::max(most, local_material(material, body.rest.col(molecule)).poissons_ratio);
  return most;
}

bool may_lock(const Body& body, const std::vector<Material>& materials, const Strategy& strategy) {
  return strategy.kind == StrategyKind::cell_law && strategy.dimensions == 3 && !strategy.volume_modulus &&
         largest_in(body, materials) > kLocking;
}

std::string warning_of_locking(const Body& body, const std::vector<Material>& materials, const Strategy& strategy) {
  const bool can = strategy.make_without_volume || strategy.make_mixed, blocks = has_blocks(body, 3);
  if (!may_lock(body, materials, strategy) || (!can && blocks)) return "";
  StrategyName with_volume(strategy.name);
  with_volume.volume = true;
  const std::string with = "stiffness: " + with_volume.text(),
                    found = "nu = " + number(largest_in(body, materials), 4) +
                            ": cells without a volume term may lock, and are then too stiff; ";
  if (strategy.make_without_volume || (strategy.make_mixed && blocks)) return found + "write " + with;
  if (strategy.make_mixed) return found + "write `order: 2` in the body and " + with;
  return found + (strategy.has_history ? "give the law behind the colon one: neo_hookean+volume"
                                       : "neo_hookean+volume has one");
}

std::vector<std::string> Simulation::warnings(bool mechanisms) const {
  constexpr double few = 0.1;
  const Impl& in = *impl_;
  std::vector<std::string> all;
  const auto add = [&](std::string text) {
    if (!text.empty()) all.push_back(std::move(text));
  };
  if (in.body.parts.empty()) add(warning_of_pieces(in.body, "the body"));
  for (const Part& part : in.body.parts)
    if (!part.rigid) add(warning_of_pieces(part_alone(in.body, part).body, "body '" + part.name + "'"));
  const bool cells = in.strategy && in.strategy->kind == StrategyKind::cell_law;
  add(warning_of_doubles(in.body, cells));
  if (cells && in.strategy->dimensions == 2 && !(in.material->thickness > 0))
    add("the material has no thickness: a membrane without one has no stiffness");
  if (in.strategy && in.body.parts.empty()) add(warning_of_locking(in.body, {*in.material}, *in.strategy));
  VectorX constants;
  if (mechanisms) constants = in.constants.size() || !in.recipe.constants ? in.constants : in.recipe.constants(in);
  add(warning_of_negative(in.body, constants));
  if (mechanisms && !(in.material && in.material->bending_rigidity > 0)) {
    std::vector<char> stiff(in.body.connections.ends.size(), 1);
    if (in.strategy && !cells) std::fill(stiff.begin() + in.body.connections.proper(), stiff.end(), 0);
    for (Eigen::Index c = 0; c < constants.size(); ++c) stiff[c] = constants[c] != 0;
    add(warning_of_modes(find_modes_in_parts(in.body, in.model.supports, stiff)));
  }
  if (in.late_steps > few * in.timed_steps)
    add("the budget of " + number(in.options.budget) + " s is not kept: " + std::to_string(in.late_steps) + " of " +
        counted(in.timed_steps, "step") + " took longer with one sweep or iteration alone");
  return all;
}

}  // namespace elastin
