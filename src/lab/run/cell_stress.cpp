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

template <std::size_t Corners>
Eigen::Matrix<double, 3, static_cast<int>(Corners)> corners_of(const std::array<int, Corners>& cell,
                                                               const Positions& positions) {
  return positions(Eigen::all, cell);
}

/// Volume or area.
template <class Corners>
double size_of(const Corners& corners) {
  const Vector3 a = corners.col(1) - corners.col(0), b = corners.col(2) - corners.col(0);
  if constexpr (Corners::ColsAtCompileTime == 4)
    return std::abs(a.cross(b).dot(corners.col(3) - corners.col(0))) / 6;
  else
    return a.cross(b).norm() / 2;
}

/// A cell at rest and now: of a block's cell the sums of its simplices and the mean of their strain.
struct CellGeometry {
  double rest_size = 0, size = 0;
  Matrix3 strain = Matrix3::Zero();

  template <std::size_t Corners>
  void add(const std::array<int, Corners>& simplex, const Body& body, const Positions& positions) {
    const auto rest = corners_of(simplex, body.rest), now = corners_of(simplex, positions);
    const double own = size_of(rest), all = rest_size + own;
    if (all > 0) strain += own / all * (simplex_state(rest, now, {}).strain - strain);
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

CellNodes::CellNodes(const Body& body) {
  const OwnSimplices own(body);
  cells_.reserve(own.size() + cells_in_blocks(body));
  cells_.assign(body.triangles.begin(), body.triangles.begin() + static_cast<std::ptrdiff_t>(own.triangles));
  cells_.insert(cells_.end(), body.tetrahedra.begin(),
                body.tetrahedra.begin() + static_cast<std::ptrdiff_t>(own.tetrahedra));
  for (const CellBlock& block : body.blocks)
    for (int cell = 0; cell < block.size(); ++cell) cells_.push_back(block.cell(cell));
}

namespace {

/// Calls visit(number, entry) for the numbers of a kept state.
template <class State, class Visit>
void visit_kept(State& state, const Visit& visit) {
  constexpr std::array<std::array<int, 2>, 6> entries{{{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}}};
  for (std::size_t k = 0; k < entries.size(); ++k) {
    const auto [i, j] = entries[k];
    visit(k, state.strain(i, j), state.strain(j, i));
    visit(k + entries.size(), state.stress(i, j), state.stress(j, i));
  }
}

}  // namespace

void keep_states(Snapshot& shot) {
  shot.kept_states.reserve(shot.states_of_laws.size());
  for (const CellState& state : shot.states_of_laws) {
    auto& kept = shot.kept_states.emplace_back();
    visit_kept(state, [&](std::size_t k, double entry, double) { kept.at(k) = static_cast<float>(entry); });
  }
  shot.states_of_laws = std::vector<CellState>();  // frees the memory, as {} does not
}

std::vector<CellState> cell_states(const Body& body, const Snapshot& shot) {
  std::vector<CellState> states = shot.states_of_laws;
  for (const auto& kept : shot.kept_states)
    visit_kept(states.emplace_back(),
               [&](std::size_t k, double& entry, double& mirrored) { entry = mirrored = double{kept.at(k)}; });
  const bool of_law = !states.empty();
  states.resize(OwnSimplices(body).size() + cells_in_blocks(body));
  const VectorX& densities = of_law ? shot.other_force_densities : shot.force_densities;
  const bool any_force = densities.size() && densities.cwiseAbs().maxCoeff() > 0;
  if (of_law && !any_force) return states;
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
