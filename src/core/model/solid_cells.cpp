#include "core/model/solid_cells.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <iterator>
#include <map>
#include <optional>

#include "elastin/core/model/share.h"

namespace elastin {

std::vector<SolidCell> solid_cells_of(const Body& body) {
  std::vector<SolidCell> cells;
  for (const CellBlock& block : body.blocks)
    for (int c = 0; c < block.size() && block.kind->dimensions == 3; ++c)
      cells.push_back({block.kind, {block.cell(c).begin(), block.cell(c).end()}});
  if (cells.empty())
    for (const auto& [a, b, c, d] : body.tetrahedra) cells.push_back({&cell_kind("tetrahedron4"), {a, b, c, d}});
  if (cells.empty())
    for (const auto& [a, b, c, d, e, f, g, h] : body.cubes)  // which count x first
      cells.push_back({&cell_kind("hexahedron8"), {a, b, d, c, e, f, h, g}});
  return cells;
}

double volume_of(const SolidCell& cell, const Positions& positions) {
  const Positions nodes = positions(Eigen::all, cell.nodes);
  double volume = 0;
  for (Eigen::Index point = 0; point < cell.kind->weights.size(); ++point) {
    const Matrix3 slope = nodes * cell.kind->slopes[point].transpose();
    volume += cell.kind->weights[point] * slope.determinant();
  }
  return volume;
}

double volume_of_cells(const Body& body, const Positions& positions) {
  double volume = 0;
  for (const SolidCell& cell : solid_cells_of(body))
    if (lowest_in_whole(body, cell.nodes) < owned_molecules(body)) volume += volume_of(cell, positions);
  return sum_over(body, volume);
}

std::vector<CellBorder> borders_of(const std::vector<SolidCell>& cells, const Positions& rest) {
  std::map<std::vector<int>, int> seen;
  std::vector<CellBorder> borders;
  for (std::size_t cell = 0; cell < cells.size(); ++cell) {
    const CellKind& kind = *cells[cell].kind;
    for (std::size_t face = 0; face < kind.faces.size(); ++face) {
      std::vector<int> corners;
      for (int i = 0; i < kind.face_kinds[face]->corners; ++i)
        corners.push_back(cells[cell].nodes[kind.faces[face][i]]);
      Vector3 area = Vector3::Zero();
      for (std::size_t i = 2; i < corners.size(); ++i)
        area += (rest.col(corners[i - 1]) - rest.col(corners[0]))
                    .cross(rest.col(corners[i]) - rest.col(corners[0]).eval()) /
                2;
      std::sort(corners.begin(), corners.end());
      const auto [other, first] = seen.try_emplace(corners, static_cast<int>(cell));
      if (!first) borders.push_back({other->second, static_cast<int>(cell), area.norm()});
    }
  }
  return borders;
}

Eigen::SparseMatrix<double, Eigen::RowMajor> shares_of_cells(const std::vector<SolidCell>& cells,
                                                             const std::vector<std::array<int, 2>>& connections,
                                                             int molecules) {
  std::vector<std::vector<int>> around(molecules);
  for (std::size_t cell = 0; cell < cells.size(); ++cell)
    for (const int node : cells[cell].nodes) around[node].push_back(static_cast<int>(cell));
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t row = 0; row < connections.size(); ++row) {
    const auto& a = around[connections[row][0]];
    const auto& b = around[connections[row][1]];
    std::vector<int> common;
    std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(common));
    if (common.empty()) std::set_union(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(common));
    for (const int cell : common)
      entries.emplace_back(static_cast<int>(row), cell, 1 / static_cast<double>(common.size()));
  }
  Eigen::SparseMatrix<double, Eigen::RowMajor> shares(static_cast<Eigen::Index>(connections.size()),
                                                      static_cast<Eigen::Index>(cells.size()));
  shares.setFromTriplets(entries.begin(), entries.end());
  return shares;
}

void change_by_cells(const Body& body, VectorX& factors,
                     const std::function<void(std::span<const int> molecules, double& factor)>& change, bool of_cubes) {
  std::vector<SolidCell> cells;
  if (of_cubes || !body.blocks.empty() || !body.tetrahedra.empty()) cells = solid_cells_of(body);
  if (cells.empty())
    for (const auto& triangle : body.triangles) cells.push_back({nullptr, {triangle.begin(), triangle.end()}});
  if (factors.size() == 0) factors = VectorX::Ones(body.connections.size());
  const auto& ends = body.connections.ends;
  const auto shares = shares_of_cells(cells, ends, body.size());
  for (int connection = 0; connection < body.connections.size(); ++connection) {
    double& factor = factors[connection];
    std::optional<double> first;  // where all are alike their mean is, to the last digit
    double difference = 0;
    for (decltype(shares)::InnerIterator share(shares, connection); share; ++share) {
      double own = factor;
      change(cells[share.col()].nodes, own);
      if (!first) first = own;
      difference += share.value() * (own - *first);
    }
    if (first)
      factor = *first + difference;
    else
      change(ends[connection], factor);
  }
}

}  // namespace elastin
