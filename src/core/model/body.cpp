#include "elastin/core/model/body.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <span>
#include <utility>

#include "core/base/rows.h"
#include "core/geometry/point_buckets.h"
#include "core/model/block_geometry.h"
#include "core/model/neighbours.h"
#include "core/model/solid_cells.h"
#include "elastin/core/base/error.h"
#include "elastin/core/model/parts.h"

namespace elastin {
namespace {

/// In ascending order, each once. Pairs of cells come many times: they are put by their first molecule before they are
/// compared, a few at a time.
void sort_once(std::vector<std::array<int, 2>>& pairs) {
  int most = -1;
  for (const auto& pair : pairs) most = std::max(most, pair[0]);
  std::vector<std::size_t> next(static_cast<std::size_t>(most) + 2, 0);
  for (const auto& pair : pairs) ++next[pair[0] + 1];
  for (std::size_t row = 1; row < next.size(); ++row) next[row] += next[row - 1];
  std::vector<int> seconds(pairs.size());
  for (const auto& pair : pairs) seconds[next[pair[0]]++] = pair[1];
  pairs.clear();
  auto begin = seconds.begin();
  for (int first = 0; first <= most; ++first) {
    const auto end = seconds.begin() + static_cast<std::ptrdiff_t>(next[first]);
    std::sort(begin, end);
    for (auto last = std::unique(begin, end); begin != last; ++begin) pairs.push_back({first, *begin});
    begin = end;
  }
}

Connections with_present_lengths(const Positions& positions, std::vector<std::array<int, 2>> ends) {
  sort_once(ends);
  numbered(static_cast<std::int64_t>(ends.size()), "connections");
  Connections connections{std::move(ends), {}, 0};
  connections.rest_length.reserve(connections.ends.size());
  for (const auto& [a, b] : connections.ends)
    connections.rest_length.push_back((positions.col(b) - positions.col(a)).norm());
  return connections;
}

/// More connections than this is a mistake: each molecule would have a thousand neighbours.
std::size_t most_connections(Eigen::Index molecules) {
  constexpr std::size_t few = 1000000, all = 500000000;
  return std::clamp(500 * static_cast<std::size_t>(molecules), few, all);
}

std::string too_wide(Eigen::Index molecules, std::size_t most) {
  return "the reach is too wide: that is more than " + std::to_string(most) + " connections between " +
         std::to_string(molecules) + " molecules";
}

template <class CellList>
void add_edges(const CellList& cells, std::vector<std::array<int, 2>>& ends) {
  for (const auto& cell : cells)
    for (std::size_t i = 0; i < cell.size(); ++i)
      for (std::size_t j = i + 1; j < cell.size(); ++j)
        ends.push_back({std::min(cell[i], cell[j]), std::max(cell[i], cell[j])});
}

}  // namespace

Connections connections_within(const Positions& positions, double reach) {
  PointBuckets buckets(reach);
  for (int molecule = 0; molecule < positions.cols(); ++molecule) buckets.add(positions.col(molecule), molecule);

  const std::size_t most = most_connections(positions.cols());
  std::vector<std::array<int, 2>> ends;
  for (int first = 0; first < positions.cols(); ++first) {
    const bool too_many = buckets.visit_near(positions.col(first), [&](int second) {
      if (second > first && (positions.col(second) - positions.col(first)).squaredNorm() <= reach * reach)
        ends.push_back({first, second});
      return ends.size() > most;
    });
    if (too_many) throw InputError(too_wide(positions.cols(), most));
  }
  return with_present_lengths(positions, std::move(ends));
}

Connections connections_of_cells(const Positions& positions, const Cells<3>& triangles, const Cells<4>& tetrahedra) {
  std::vector<std::array<int, 2>> ends;
  ends.reserve(3 * triangles.size() + 6 * tetrahedra.size());
  add_edges(triangles, ends);
  add_edges(tetrahedra, ends);
  return with_present_lengths(positions, std::move(ends));
}

void set_present_lengths(Body& body) {
  auto& [ends, lengths, _] = body.connections;
  numbered(static_cast<std::int64_t>(ends.size()), "connections");
  lengths.resize(ends.size());
  for (std::size_t c = 0; c < ends.size(); ++c)
    lengths[c] = (body.rest.col(ends[c][1]) - body.rest.col(ends[c][0])).norm();
}

std::vector<std::array<int, 2>> sides_of(const Cells<4>& tetrahedra) {
  std::vector<std::array<int, 2>> sides;
  sides.reserve(6 * tetrahedra.size());
  add_edges(tetrahedra, sides);
  sort_once(sides);
  return sides;
}

void add_cell_sides(Body& body, const std::vector<std::array<int, 2>>& sides) {
  const auto ascending = [](const std::array<int, 2>& pair) {
    return std::array{std::min(pair[0], pair[1]), std::max(pair[0], pair[1])};
  };
  Connections& connections = body.connections;
  std::vector<std::array<int, 2>> known, added;
  for (int c = 0; c < connections.proper(); ++c) known.push_back(ascending(connections.ends[c]));
  for (const auto& side : sides) added.push_back(ascending(side));
  const std::vector<std::array<int, 2>> sides_before(connections.ends.begin() + connections.proper(),
                                                     connections.ends.end());
  added.insert(added.end(), sides_before.begin(), sides_before.end());
  std::sort(known.begin(), known.end());
  std::erase_if(added, [&](const auto& pair) { return std::binary_search(known.begin(), known.end(), pair); });
  const Connections tail = with_present_lengths(body.rest, std::move(added));

  const auto proper = static_cast<std::size_t>(connections.proper());
  connections.ends.resize(proper), connections.rest_length.resize(proper);
  connections.ends.insert(connections.ends.end(), tail.ends.begin(), tail.ends.end());
  connections.rest_length.insert(connections.rest_length.end(), tail.rest_length.begin(), tail.rest_length.end());
  if (VectorX& stiffness = body.connection_stiffness; stiffness.size()) {  // a new side is as stiff as the material
    const VectorX before = std::exchange(stiffness, VectorX::Ones(static_cast<Eigen::Index>(proper) + tail.size()));
    stiffness.head(static_cast<Eigen::Index>(proper)) = before.head(static_cast<Eigen::Index>(proper));
    for (std::size_t old = 0; old < sides_before.size(); ++old) {
      const auto at = std::lower_bound(tail.ends.begin(), tail.ends.end(), ascending(sides_before[old]));
      stiffness[static_cast<Eigen::Index>(proper) + (at - tail.ends.begin())] =
          before[static_cast<Eigen::Index>(proper + old)];
    }
  }
  connections.cell_sides = tail.size();
}

Body without_cell_sides(const Body& body) {
  Body proper = body;
  proper.connections.ends.resize(body.connections.proper());
  proper.connections.rest_length.resize(body.connections.proper());
  proper.connections.cell_sides = 0;
  if (proper.connection_stiffness.size()) proper.connection_stiffness.conservativeResize(body.connections.proper());
  return proper;
}

VectorX lumped_mass(const Positions& positions, const Cells<3>& triangles, const Cells<4>& tetrahedra, double density,
                    double thickness) {
  VectorX mass = VectorX::Zero(positions.cols());
  for (const auto& cell : tetrahedra)
    for (const int molecule : cell) mass[molecule] += density * signed_volume(positions, cell) / 4;
  for (const auto& [a, b, c] : triangles) {
    const double area = 0.5 * (positions.col(b) - positions.col(a)).cross(positions.col(c) - positions.col(a)).norm();
    for (const int molecule : {a, b, c}) mass[molecule] += density * thickness * area / 3;
  }
  return mass;
}

std::size_t set_region(Body& body, const Vector3& low, const Vector3& high, double stiffness, double mass) {
  const Vector3 slack = Vector3::Constant(1e-9 * (high - low).norm());
  const auto inside = [&](const Vector3& position) {
    return ((position - low + slack).array() >= 0).all() && ((high + slack - position).array() >= 0).all();
  };
  const auto middle_of = [&](std::span<const int> molecules) {
    Vector3 middle = Vector3::Zero();
    for (const int molecule : molecules) middle += body.rest.col(molecule) / static_cast<double>(molecules.size());
    return middle;
  };
  std::size_t count = 0;
  const auto set_those_inside = [&](const auto& members, VectorX& factors) {
    if (factors.size() == 0) factors = VectorX::Ones(static_cast<Eigen::Index>(members.size()));
    for (std::size_t member = 0; member < members.size(); ++member) {
      if (!inside(middle_of(members[member]))) continue;
      factors[static_cast<Eigen::Index>(member)] = stiffness;
      ++count;
    }
  };
  if (body.tetrahedra.empty())
    set_those_inside(body.triangles, body.cell_stiffness);
  else
    set_those_inside(body.tetrahedra, body.cell_stiffness);
  for (CellBlock& block : body.blocks) {
    std::vector<std::vector<int>> cells;
    for (int cell = 0; cell < block.size(); ++cell)
      cells.emplace_back(block.cell(cell).begin(), block.cell(cell).end());
    set_those_inside(cells, block.stiffness);
  }
  for (const auto& cube : body.cubes) count += inside(middle_of(cube));
  if (count == 0)
    set_those_inside(body.connections.ends, body.connection_stiffness);
  else
    change_by_cells(
        body, body.connection_stiffness,
        [&](std::span<const int> molecules, double& factor) {
          if (inside(middle_of(molecules))) factor = stiffness;
        },
        true);
  for (int molecule = 0; molecule < body.size(); ++molecule)
    if (inside(body.rest.col(molecule))) body.mass[molecule] *= mass;
  return count;
}

bool has_other_stiffness(const Body& body) {
  const auto other = [](const VectorX& factors) { return (factors.array() != 1).any(); };
  return other(body.connection_stiffness) || other(body.cell_stiffness) ||
         std::any_of(body.blocks.begin(), body.blocks.end(),
                     [&](const CellBlock& block) { return other(block.stiffness); });
}

double signed_volume(const Positions& positions, const std::array<int, 4>& tetrahedron) {
  const Vector3 origin = positions.col(tetrahedron[0]);
  const Vector3 a = positions.col(tetrahedron[1]) - origin, b = positions.col(tetrahedron[2]) - origin,
                c = positions.col(tetrahedron[3]) - origin;
  return a.dot(b.cross(c)) / 6;
}

std::vector<int> flat_or_inverted_cells(const Body& body, const Positions& positions) {
  if (has_blocks(body, 3)) return flat_or_inverted_in_blocks(body, positions);
  std::vector<int> cells;
  for (std::size_t cell = 0; cell < body.tetrahedra.size(); ++cell) {
    const auto& corners = body.tetrahedra[cell];
    double longest = 0;
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < i; ++j)
        longest = std::max(longest, (positions.col(corners[i]) - positions.col(corners[j])).norm());
    if (!(signed_volume(positions, corners) > 1e-12 * longest * longest * longest))
      cells.push_back(static_cast<int>(cell));
  }
  return cells;
}

std::string flat_or_inverted_text(const std::vector<int>& cells, std::size_t of) {
  constexpr std::size_t shown = 10;
  std::string text = cells.size() == 1 ? "cell" : "cells";
  for (std::size_t i = 0; i < std::min(shown, cells.size()); ++i) text += (i ? ", " : " ") + std::to_string(cells[i]);
  if (cells.size() > shown) text += " and " + std::to_string(cells.size() - shown) + " more";
  return text + " of " + std::to_string(of) + (cells.size() == 1 ? " is" : " are") + " flat or inverted";
}

DisjointSets pieces_of(const Body& body) {
  DisjointSets pieces(static_cast<std::size_t>(body.size()));
  for (int connection = 0; connection < body.connections.proper() && pieces.count() > 1; ++connection) {
    const auto& [a, b] = body.connections.ends[connection];
    pieces.join(a, b);
  }
  for (const Part& part : body.parts)
    if (part.rigid)
      for (const int molecule : molecules_of(part))
        pieces.join(part.count > 0 ? part.first : part.shared.front(), molecule);
  for (const Tie& tie : body.ties)
    for (const int corner : tie.corners) pieces.join(tie.molecule, corner);
  return pieces;
}

BodyFindings inspect(const Body& body) {
  BodyFindings findings;
  const int n = body.size();
  std::vector<int> degree(n, 0);
  const double size = n ? (body.rest.rowwise().maxCoeff() - body.rest.rowwise().minCoeff()).norm() : 0;
  std::vector<std::pair<std::array<int, 2>, int>> sorted;
  for (int connection = 0; connection < body.connections.proper(); ++connection) {
    auto [a, b] = body.connections.ends[connection];
    ++degree[a], ++degree[b];
    if (!(body.connections.rest_length[connection] > 1e-12 * size))
      findings.zero_length_connections.push_back(connection);
    sorted.push_back({{std::min(a, b), std::max(a, b)}, connection});
  }
  std::sort(sorted.begin(), sorted.end());
  for (std::size_t i = 1; i < sorted.size(); ++i)
    if (sorted[i].first == sorted[i - 1].first) findings.duplicate_connections.push_back(sorted[i].second);
  std::sort(findings.duplicate_connections.begin(), findings.duplicate_connections.end());

  const DisjointSets pieces = pieces_of(body);
  findings.pieces = pieces.count();
  findings.piece_of = pieces.numbers();
  for (int molecule = 0; molecule < n; ++molecule)
    if (degree[molecule] == 0) findings.isolated_molecules.push_back(molecule);
  findings.flat_or_inverted_cells = flat_or_inverted_cells(body, body.rest);
  return findings;
}

}  // namespace elastin
