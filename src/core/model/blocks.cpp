#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

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
  struct Entry {
    std::vector<int> sorted;
    BlockFace face;
  };
  std::vector<Entry> all;
  for (const CellBlock& block : body.blocks)
    for (int cell = 0; cell < block.size(); ++cell) {
      const auto nodes = block.cell(cell);
      for (std::size_t f = 0; f < block.kind->faces.size(); ++f) {
        Entry entry;
        entry.face.kind = block.kind->face_kinds[f];
        for (const int own : block.kind->faces[f]) entry.face.nodes.push_back(nodes[own]);
        entry.sorted = entry.face.nodes;
        std::sort(entry.sorted.begin(), entry.sorted.end());
        all.push_back(std::move(entry));
      }
    }
  std::sort(all.begin(), all.end(), [](const Entry& a, const Entry& b) { return a.sorted < b.sorted; });
  std::vector<BlockFace> found;
  for (std::size_t f = 0; f < all.size(); ++f)
    if ((f == 0 || all[f].sorted != all[f - 1].sorted) && (f + 1 == all.size() || all[f].sorted != all[f + 1].sorted))
      found.push_back(std::move(all[f].face));
  return found;
}

}  // namespace elastin
