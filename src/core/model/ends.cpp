#include "core/model/ends.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/base/disjoint_sets.h"
#include "core/geometry/boundary.h"
#include "core/geometry/rim.h"
#include "elastin/core/model/share.h"

namespace elastin {
namespace {

const double kLooksAlong = std::sqrt(0.5);    ///< cosine of 45°
const double kTurnsAway = std::sqrt(3.) / 2;  ///< cosine of 30°

/// A side of the surface; of a membrane its first two corners count.
struct SurfaceSide {
  std::array<int, 3> corners{};
  Vector3 area = Vector3::Zero();  ///< outward [m²]; of a membrane's rim [m]
};

bool has_solid_cells(const Body& body) { return any_over(body, !body.tetrahedra.empty()); }

std::vector<SurfaceSide> sides_of_solid(const Body& body, const Cells<4>& cells) {
  std::vector<SurfaceSide> sides;
  for (const auto& triangle : boundary_of(cells)) {
    const auto& [a, b, c] = triangle;
    const Vector3 first = body.rest.col(b) - body.rest.col(a), second = body.rest.col(c) - body.rest.col(a);
    sides.push_back({triangle, first.cross(second) / 2});
  }
  return sides;
}

std::vector<SurfaceSide> sides_of_membrane(const Body& body, const Cells<3>& cells) {
  // The triangle of each side, whose third corner says which way is out.
  std::vector<std::array<int, 3>> corners;
  for (const auto& cell : cells)
    for (std::size_t k = 0; k < 3; ++k) corners.push_back({cell[k], cell[(k + 1) % 3], cell[(k + 2) % 3]});
  std::vector<SurfaceSide> sides;
  std::sort(corners.begin(), corners.end());
  for (const auto& [a, b] : boundary_of(cells)) {
    const auto own = std::lower_bound(corners.begin(), corners.end(), std::array<int, 3>{a, b, 0});
    const Vector3 along = body.rest.col(b) - body.rest.col(a), out = body.rest.col(a) - body.rest.col((*own)[2]);
    const Vector3 across = out - along * (along.dot(out) / along.squaredNorm());
    sides.push_back({*own, across.normalized() * along.norm()});
  }
  return sides;
}

/// The sides of the surface with a molecule that is marked, each where its process owns the first of its corners.
std::vector<SurfaceSide> surface_sides(const Body& body, const std::vector<char>& marked) {
  const bool solid = has_solid_cells(body);
  const auto meets = [&](const auto& cell) {
    return std::any_of(cell.begin(), cell.end(), [&](int molecule) { return marked[molecule] != 0; });
  };
  std::vector<SurfaceSide> sides;
  if (solid) {
    Cells<4> cells;
    std::copy_if(body.tetrahedra.begin(), body.tetrahedra.end(), std::back_inserter(cells), meets);
    sides = sides_of_solid(body, cells);
  } else {
    Cells<3> cells;
    std::copy_if(body.triangles.begin(), body.triangles.end(), std::back_inserter(cells), meets);
    sides = sides_of_membrane(body, cells);
  }
  const std::ptrdiff_t corners = solid ? 3 : 2;
  std::erase_if(sides, [&](const SurfaceSide& side) {
    const std::vector<int> own(side.corners.begin(), side.corners.begin() + corners);
    return !meets(own) || lowest_in_whole(body, own) >= owned_molecules(body);
  });
  return sides;
}

/// A side of the whole that looks along a direction.
struct FacingSide {
  std::array<double, 3> corners;  ///< numbers in the whole; of a membrane the second twice
  double low, high;               ///< of its corners along the direction [m]
  Vector3 area;
};

/// Those of all processes, in the same order on each.
std::vector<FacingSide> facing_sides(const Body& body, const Vector3& direction) {
  const std::size_t corners = has_solid_cells(body) ? 3 : 2;
  std::vector<double> own;
  for (const SurfaceSide& side : surface_sides(body, std::vector<char>(static_cast<std::size_t>(body.size()), 1))) {
    if (!(side.area.dot(direction) >= kLooksAlong * side.area.norm())) continue;
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (std::size_t k = 0; k < 3; ++k) {
      const int corner = side.corners[std::min(k, corners - 1)];
      const double height = direction.dot(body.rest.col(corner));
      low = std::min(low, height), high = std::max(high, height);
      own.push_back(static_cast<double>(number_in_whole(body, corner)));
    }
    own.insert(own.end(), {low, high, side.area.x(), side.area.y(), side.area.z()});
  }
  const std::vector<double> all = gathered_over(body, own);
  std::vector<FacingSide> sides;
  for (std::size_t at = 0; at + 8 <= all.size(); at += 8)
    sides.push_back({{all[at], all[at + 1], all[at + 2]}, all[at + 3], all[at + 4], Vector3(&all[at + 5])});
  return sides;
}

/// The patch that each side belongs to, by the number of its first side.
std::vector<std::size_t> patches_of(const std::vector<FacingSide>& sides) {
  std::vector<std::pair<double, int>> met;
  for (std::size_t side = 0; side < sides.size(); ++side)
    for (const double corner : sides[side].corners) met.emplace_back(corner, static_cast<int>(side));
  std::sort(met.begin(), met.end());
  DisjointSets patches(sides.size());
  for (std::size_t i = 1; i < met.size(); ++i)
    if (met[i].first == met[i - 1].first) patches.join(met[i].second, met[i - 1].second);
  std::vector<std::size_t> patch;
  for (int side = 0; side < static_cast<int>(sides.size()); ++side)
    patch.push_back(static_cast<std::size_t>(patches.set_of(side)));
  return patch;
}

}  // namespace

EndSides end_sides(const Body& body, const Vector3& direction) {
  const std::vector<FacingSide> sides = facing_sides(body, direction);
  const std::vector<std::size_t> patch = patches_of(sides);
  constexpr double infinity = std::numeric_limits<double>::infinity();
  std::vector<double> low(sides.size(), infinity), high(sides.size(), -infinity);
  EndSides end;
  if (sides.empty()) return end;
  for (std::size_t side = 0; side < sides.size(); ++side) {
    low[patch[side]] = std::min(low[patch[side]], sides[side].low);
    high[patch[side]] = std::max(high[patch[side]], sides[side].high);
  }
  // Patches by their tops, the furthest first: each that reaches into the heights of those before it counts.
  std::vector<std::size_t> order;
  for (std::size_t side = 0; side < sides.size(); ++side)
    if (patch[side] == side) order.push_back(side);
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return high[a] > high[b]; });
  double reach = low[order.front()];
  std::vector<char> counts(sides.size(), 0);
  for (const std::size_t own : order) {
    if (high[own] < reach) break;
    counts[own] = 1;
    reach = std::min(reach, low[own]);
  }
  for (std::size_t side = 0; side < sides.size(); ++side) {
    if (!counts[patch[side]]) continue;
    end.normal += sides[side].area;
    for (const double corner : sides[side].corners)
      if (const int molecule = molecule_of_whole(body, static_cast<std::int64_t>(corner)); molecule >= 0)
        end.molecules.push_back(molecule);
  }
  end.normal.normalize();
  std::sort(end.molecules.begin(), end.molecules.end());
  end.molecules.erase(std::unique(end.molecules.begin(), end.molecules.end()), end.molecules.end());
  return end;
}

bool is_plane_end(const Body& body, const std::vector<int>& molecules, const Vector3& direction) {
  std::vector<char> among(static_cast<std::size_t>(body.size()), 0);
  for (const int molecule : molecules) among[molecule] = 1;
  const std::ptrdiff_t corners = has_solid_cells(body) ? 3 : 2;
  std::array<double, 3> counts{0, 0, 0};  // in the plane, turning away behind it, going on
  for (const SurfaceSide& side : surface_sides(body, among)) {
    const auto in_plane = std::count_if(side.corners.begin(), side.corners.begin() + corners,
                                        [&](int corner) { return among[corner] != 0; });
    if (in_plane == corners)
      ++counts[0];
    else if (in_plane == corners - 1)
      ++counts[side.area.dot(direction) < kTurnsAway * side.area.norm() ? 1 : 2];
  }
  sum_over(body, counts);
  return counts[0] > 0 && counts[1] >= counts[2];
}

}  // namespace elastin
