#include "lab/run/cell_stress.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>

#include "core/base/dense.h"

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

template <std::size_t Corners, class Visit>
void visit_sides(const std::array<int, Corners>& cell, const SideFinder& sides, const Visit& visit) {
  for (std::size_t i = 0; i < Corners; ++i)
    for (std::size_t j = i + 1; j < Corners; ++j)
      if (const int side = sides.find(cell[i], cell[j]); side >= 0) visit(side, cell[i], cell[j]);
}

template <std::size_t Corners>
void add_states(const std::vector<std::array<int, Corners>>& cells, const Body& body, const SideFinder& sides,
                const Positions& positions, const VectorX& force_densities, std::vector<CellState>& states) {
  VectorX shared = VectorX::Zero(body.connections.size());  // rest size of all cells on a side
  for (const auto& cell : cells) {
    const double size = size_of(edges_of(cell, body.rest));
    visit_sides(cell, sides, [&](int side, int, int) { shared[side] += size; });
  }
  for (const auto& cell : cells) {
    const auto rest = edges_of(cell, body.rest), now = edges_of(cell, positions);
    const double rest_size = size_of(rest), size = size_of(now);
    CellState state;
    state.strain = green_strain(rest, now);
    visit_sides(cell, sides, [&](int side, int a, int b) {
      const Vector3 d = positions.col(b) - positions.col(a);
      if (shared[side] > 0 && size > 0)
        state.stress += rest_size / shared[side] / size * force_densities[side] * d * d.transpose();
    });
    if (!state.stress.allFinite()) state.stress.setZero();
    states.push_back(state);
  }
}

}  // namespace

std::vector<CellState> cell_states(const Body& body, const Positions& positions, const VectorX& force_densities) {
  std::vector<CellState> states;
  if (body.triangles.empty() && body.tetrahedra.empty()) return states;
  const SideFinder sides(body.connections);
  add_states(body.triangles, body, sides, positions, force_densities, states);
  add_states(body.tetrahedra, body, sides, positions, force_densities, states);
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
