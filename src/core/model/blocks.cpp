#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "core/geometry/reference_slopes.h"
#include "core/model/block_geometry.h"
#include "elastin/core/model/body.h"

namespace elastin {

bool has_blocks(const Body& body, int dimensions) {
  return std::any_of(body.blocks.begin(), body.blocks.end(),
                     [&](const CellBlock& block) { return block.kind->dimensions == dimensions; });
}

void set_simplices(Body& body) {
  if (has_blocks(body, 2)) body.triangles.clear();
  if (has_blocks(body, 3)) body.tetrahedra.clear();
  for (const CellBlock& block : body.blocks)
    for (int cell = 0; cell < block.size(); ++cell) {
      const auto nodes = block.cell(cell);
      const auto node = [&](int own) { return nodes[own]; };
      for (const auto& simplex : simplices_of(*block.kind, nodes))
        if (block.kind->dimensions == 2)
          body.triangles.push_back({node(simplex[0]), node(simplex[1]), node(simplex[2])});
        else
          body.tetrahedra.push_back({node(simplex[0]), node(simplex[1]), node(simplex[2]), node(simplex[3])});
    }
  body.connections = connections_of_cells(body.rest, body.triangles, body.tetrahedra);
}

std::size_t cells_in_blocks(const Body& body) {
  std::size_t count = 0;
  for (const CellBlock& block : body.blocks) count += static_cast<std::size_t>(block.size());
  return count;
}

std::size_t count_cells(const Body& body) {
  return cells_in_blocks(body) + (has_blocks(body, 2) ? 0 : body.triangles.size()) +
         (has_blocks(body, 3) ? 0 : body.tetrahedra.size());
}

std::size_t solid_cells(const Body& body) {
  if (!has_blocks(body, 3)) return body.tetrahedra.size();
  std::size_t count = 0;
  for (const CellBlock& block : body.blocks)
    if (block.kind->dimensions == 3) count += static_cast<std::size_t>(block.size());
  return count;
}

std::vector<int> flat_or_inverted_in_blocks(const Body& body, const Positions& positions) {
  std::vector<int> found;
  int number = 0;
  for (const CellBlock& block : body.blocks) {
    if (block.kind->dimensions != 3) continue;
    const ReferenceSlopes<3> slopes(*block.kind);
    const auto points = static_cast<std::ptrdiff_t>(block.kind->slopes.size());
    PointGradients<3> edges;
    for (int cell = 0; cell < block.size(); ++cell, ++number) {
      const NodeVectors own = positions_of(positions, block.cell(cell));
      double longest = 0;
      for (const auto& [a, b] : block.kind->edges) longest = std::max(longest, (own.col(a) - own.col(b)).norm());
      slopes.gradients(own, edges);
      const auto is_flat = [&](const Matrix3& at_point) {
        return !(at_point.determinant() > 1e-12 * longest * longest * longest);
      };
      if (std::any_of(edges.begin(), edges.begin() + points, is_flat)) found.push_back(number);
    }
  }
  return found;
}

VectorX lumped_volumes(const Body& body, double thickness) {
  VectorX volumes = VectorX::Zero(body.size());
  for (const CellBlock& block : body.blocks) {
    const CellKind& kind = *block.kind;
    for (int cell = 0; cell < block.size(); ++cell) {
      const auto nodes = block.cell(cell);
      const Eigen::MatrixXd own = positions_of(body.rest, nodes);
      VectorX squares = VectorX::Zero(kind.nodes);
      double volume = 0;
      for (std::size_t g = 0; g < kind.slopes.size(); ++g) {
        const auto point = static_cast<Eigen::Index>(g);
        const double weight = kind.weights[point] * measure_of(own * kind.slopes[g].transpose());
        volume += weight;
        squares += weight * kind.values.col(point).cwiseAbs2();
      }
      if (kind.dimensions == 2) volume *= thickness;
      for (int a = 0; a < kind.nodes; ++a) volumes[nodes[a]] += volume * squares[a] / squares.sum();
    }
  }
  return volumes;
}

Eigen::MatrixXd positions_of(const Positions& positions, std::span<const int> nodes) {
  Eigen::MatrixXd own(3, static_cast<Eigen::Index>(nodes.size()));
  for (std::size_t a = 0; a < nodes.size(); ++a) own.col(static_cast<Eigen::Index>(a)) = positions.col(nodes[a]);
  return own;
}

double measure_of(const Eigen::MatrixXd& edges) {
  const Vector3 first = edges.col(0), second = edges.col(1), normal = first.cross(second);
  return edges.cols() == 2 ? normal.norm() : normal.dot(Vector3(edges.col(2)));
}

VectorX face_shares(const Body& body, const std::vector<int>& molecules, const Vector3& direction) {
  std::vector<char> among(body.size(), 0);
  for (const int molecule : molecules) among[molecule] = 1;
  VectorX areas = VectorX::Zero(body.size());
  for (const BlockFace& face : boundary_faces(body)) {
    if (!std::all_of(face.nodes.begin(), face.nodes.end(), [&](int molecule) { return among[molecule] != 0; }))
      continue;
    const CellKind& kind = *face.kind;
    const Eigen::MatrixXd own = positions_of(body.rest, face.nodes);
    for (std::size_t g = 0; g < kind.slopes.size(); ++g) {
      const Eigen::MatrixXd edges = own * kind.slopes[g].transpose();
      const auto point = static_cast<Eigen::Index>(g);
      const double area =
          kind.weights[point] * std::abs(Vector3(edges.col(0)).cross(Vector3(edges.col(1))).dot(direction));
      for (int a = 0; a < kind.nodes; ++a) areas[face.nodes[a]] += area * kind.values(a, point);
    }
  }
  return areas(molecules);
}

std::vector<BlockFace> boundary_faces(const Body& body) {
  struct CellFace {
    const CellBlock* block;
    int cell, face;
  };
  struct Entry {
    std::array<int, 9> sorted;  // −1: no node
    CellFace of;
  };
  const auto visit_faces = [&](const auto& visit) {  // with its lowest node
    for (const CellBlock& block : body.blocks)
      for (int cell = 0; cell < block.size(); ++cell) {
        const auto nodes = block.cell(cell);
        for (std::size_t f = 0; f < block.kind->faces.size(); ++f) {
          int lowest = body.size();
          for (const int own : block.kind->faces[f]) lowest = std::min(lowest, nodes[own]);
          visit(lowest, CellFace{&block, cell, static_cast<int>(f)});
        }
      }
  };
  std::vector<std::size_t> ends(static_cast<std::size_t>(body.size()) + 1, 0);  // of the faces by their lowest node
  visit_faces([&](int lowest, const CellFace&) { ++ends[lowest + 1]; });
  std::partial_sum(ends.begin(), ends.end(), ends.begin());
  std::vector<CellFace> faces(ends.back());
  visit_faces([&](int lowest, const CellFace& face) { faces[ends[lowest]++] = face; });
  std::vector<BlockFace> found;
  std::vector<Entry> same;
  for (std::size_t node = 0, first = 0; node + 1 < ends.size(); first = ends[node++]) {
    same.clear();
    for (std::size_t i = first; i < ends[node]; ++i) {
      const auto nodes = faces[i].block->cell(faces[i].cell);
      Entry& entry = same.emplace_back(Entry{{}, faces[i]});
      entry.sorted.fill(-1);
      auto end = entry.sorted.begin();
      for (const int own : faces[i].block->kind->faces[faces[i].face]) *end++ = nodes[own];
      std::sort(entry.sorted.begin(), end);
    }
    std::sort(same.begin(), same.end(), [](const Entry& a, const Entry& b) { return a.sorted < b.sorted; });
    for (std::size_t i = 0; i < same.size(); ++i) {
      if ((i > 0 && same[i].sorted == same[i - 1].sorted) ||
          (i + 1 < same.size() && same[i].sorted == same[i + 1].sorted))
        continue;
      const auto& [block, cell, f] = same[i].of;
      BlockFace& face = found.emplace_back(BlockFace{block->kind->face_kinds[f], {}});
      for (const int own : block->kind->faces[f]) face.nodes.push_back(block->cell(cell)[own]);
    }
  }
  return found;
}

}  // namespace elastin
