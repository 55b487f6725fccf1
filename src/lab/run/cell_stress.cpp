#include "lab/run/cell_stress.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <unordered_map>

#include "core/base/dense.h"
#include "elastin/core/geometry/cell_kind.h"

namespace elastin::lab {
namespace {

/// Connections by their two molecules.
class SideFinder {
 public:
  explicit SideFinder(const Connections& connections) {
    numbers_.reserve(static_cast<std::size_t>(connections.size()));
    for (int c = 0; c < connections.size(); ++c) {
      const auto& [a, b] = connections.ends[c];
      numbers_.emplace(key(a, b), c);
    }
  }
  /// −1 without one.
  int find(int a, int b) const {
    const auto found = numbers_.find(key(a, b));
    return found == numbers_.end() ? -1 : found->second;
  }

 private:
  static std::uint64_t key(int a, int b) {
    return static_cast<std::uint64_t>(std::min(a, b)) << 32 | static_cast<std::uint32_t>(std::max(a, b));
  }
  std::unordered_map<std::uint64_t, int> numbers_;
};

/// Edges from the first corner, a column each.
template <std::size_t Corners>
auto edges_of(const std::array<int, Corners>& cell, const Positions& positions) {
  Eigen::Matrix<double, 3, static_cast<int>(Corners) - 1> edges;
  for (std::size_t k = 1; k < Corners; ++k)
    edges.col(static_cast<Eigen::Index>(k) - 1) = positions.col(cell[k]) - positions.col(cell[0]);
  return edges;
}

/// Volume or area.
template <class Edges>
double size_of(const Edges& edges) {
  if constexpr (Edges::ColsAtCompileTime == 3)
    return std::abs(edges.determinant()) / 6;
  else
    return edges.col(0).cross(edges.col(1)).norm() / 2;
}

template <class Edges>
Matrix3 green_strain(const Edges& rest, const Edges& now) {
  const auto metric = (rest.transpose() * rest).eval();
  const auto inverse = (metric.inverse() * rest.transpose()).eval();  // of the rest edges, in their own plane
  const Matrix3 strain = inverse.transpose() * (now.transpose() * now - metric) * inverse / 2;
  return strain.allFinite() ? strain : Matrix3(Matrix3::Zero());
}

/// A cell at rest and now: of a block's cell the sums of its simplices and the mean of their strain.
struct CellGeometry {
  double rest_size = 0, size = 0;
  Matrix3 strain = Matrix3::Zero();

  template <std::size_t Corners>
  void add(const std::array<int, Corners>& simplex, const Body& body, const Positions& positions) {
    const auto rest = edges_of(simplex, body.rest), now = edges_of(simplex, positions);
    const double own = size_of(rest), all = rest_size + own;
    if (all > 0) strain += own / all * (green_strain(rest, now) - strain);
    rest_size = all, size += size_of(now);
  }
};

/// visit(nodes, geometry) of each cell in turn.
template <class Visit>
void for_each_cell(const Body& body, const Positions& positions, Visit&& visit) {
  const OwnSimplices own(body);
  const auto visit_own = [&](const auto& simplices, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      CellGeometry geometry;
      geometry.add(simplices[i], body, positions);
      visit(std::span<const int>(simplices[i]), geometry);
    }
  };
  visit_own(body.triangles, own.triangles);
  visit_own(body.tetrahedra, own.tetrahedra);
  std::size_t triangle = 0, tetrahedron = 0;
  for (const CellBlock& block : body.blocks)
    for (int cell = 0; cell < block.size(); ++cell) {
      CellGeometry geometry;
      for (std::size_t i = simplices_of(*block.kind, block.cell(cell)).size(); i > 0; --i)
        if (block.kind->dimensions == 3)
          geometry.add(body.tetrahedra[tetrahedron++], body, positions);
        else
          geometry.add(body.triangles[triangle++], body, positions);
      visit(std::span<const int>(block.cell(cell)), geometry);
    }
}

template <class Visit>
void visit_sides(std::span<const int> nodes, const SideFinder& sides, const Visit& visit) {
  for (std::size_t i = 0; i < nodes.size(); ++i)
    for (std::size_t j = i + 1; j < nodes.size(); ++j)
      if (const int side = sides.find(nodes[i], nodes[j]); side >= 0) visit(side, nodes[i], nodes[j]);
}

}  // namespace

OwnSimplices::OwnSimplices(const Body& body)
    : triangles(has_blocks(body, 2) ? 0 : body.triangles.size()),
      tetrahedra(has_blocks(body, 3) ? 0 : body.tetrahedra.size()) {}

std::vector<CellState> cell_states(const Body& body, const Snapshot& shot) {
  const std::size_t own = OwnSimplices(body).size();
  std::vector<CellState> states = shot.block_states;
  const bool of_law = !states.empty();  // which shows its own force densities, too
  states.insert(states.begin(), own, CellState{});
  states.resize(own + cells_in_blocks(body));
  const VectorX& densities = of_law ? shot.edge_force_densities : shot.force_densities;
  const bool any_force = densities.size() && densities.cwiseAbs().maxCoeff() > 0;
  if (of_law && own == 0 && !any_force) return states;
  const SideFinder sides(any_force ? body.connections : Connections{});
  VectorX shared = VectorX::Zero(body.connections.size());  // rest size of all cells on a side
  for_each_cell(body, shot.positions, [&](std::span<const int> nodes, const CellGeometry& geometry) {
    visit_sides(nodes, sides, [&](int side, int, int) { shared[side] += geometry.rest_size; });
  });
  for_each_cell(body, shot.positions,
                [&, number = std::size_t{0}](std::span<const int> nodes, const CellGeometry& geometry) mutable {
                  CellState& state = states[number++];
                  if (state.strain.isZero(0)) state.strain = geometry.strain;
                  visit_sides(nodes, sides, [&](int side, int a, int b) {
                    const Vector3 d = shot.positions.col(b) - shot.positions.col(a);
                    if (shared[side] > 0 && geometry.size > 0)
                      state.stress +=
                          geometry.rest_size / shared[side] / geometry.size * densities[side] * d * d.transpose();
                  });
                  if (!state.stress.allFinite()) state.stress.setZero();
                });
  return states;
}

double largest_strain(const CellState& cell) {
  const double largest = symmetric_eigenvalues3(cell.strain)[2];
  return std::sqrt(std::max(0., 1 + 2 * largest)) - 1;
}

double von_mises(const CellState& cell) {
  const Matrix3 deviator = cell.stress - cell.stress.trace() / 3 * Matrix3::Identity();
  return std::sqrt(1.5) * deviator.norm();
}

}  // namespace elastin::lab
