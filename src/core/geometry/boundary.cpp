#include "core/geometry/boundary.h"

#include <algorithm>

#include "core/geometry/rim.h"

namespace elastin {
namespace {

/// Corners counter-clockwise seen from outside.
constexpr std::array<std::array<int, 2>, 3> kSidesOfTriangle{{{0, 1}, {1, 2}, {2, 0}}};
constexpr std::array<std::array<int, 3>, 4> kFacesOfTetrahedron{{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};
constexpr std::array<std::array<int, 4>, 6> kFacesOfCube{
    {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};

template <std::size_t corners, std::size_t face_count, std::size_t sides>
std::vector<std::array<int, sides>> all_faces(const std::vector<std::array<int, corners>>& cells,
                                              const std::array<std::array<int, sides>, face_count>& faces) {
  std::vector<std::array<int, sides>> all;
  all.reserve(cells.size() * face_count);
  for (const auto& cell : cells)
    for (const auto& face : faces) {
      auto& added = all.emplace_back();
      for (std::size_t side = 0; side < sides; ++side) added[side] = cell[face[side]];
    }
  return all;
}

/// Those that stand alone, in the order of their sorted corners.
template <std::size_t sides>
std::vector<std::array<int, sides>> alone(const std::vector<std::array<int, sides>>& faces) {
  struct Face {
    std::array<int, sides> sorted, turned;
  };
  std::vector<Face> all;
  all.reserve(faces.size());
  for (const auto& face : faces) {
    all.push_back({face, face});
    std::sort(all.back().sorted.begin(), all.back().sorted.end());
  }
  std::sort(all.begin(), all.end(), [](const Face& a, const Face& b) { return a.sorted < b.sorted; });
  std::vector<std::array<int, sides>> found;
  for (std::size_t f = 0; f < all.size(); ++f)
    if ((f == 0 || all[f].sorted != all[f - 1].sorted) && (f + 1 == all.size() || all[f].sorted != all[f + 1].sorted))
      found.push_back(all[f].turned);
  return found;
}

}  // namespace

Cells<3> faces_of(const Cells<4>& tetrahedra) { return all_faces(tetrahedra, kFacesOfTetrahedron); }

Cells<3> boundary_of(const Cells<4>& tetrahedra) { return alone(faces_of(tetrahedra)); }

std::vector<std::array<int, 4>> faces_of(const Cells<8>& cubes) { return all_faces(cubes, kFacesOfCube); }

std::vector<std::array<int, 4>> boundary_of(const Cells<8>& cubes) { return alone(faces_of(cubes)); }

std::vector<std::array<int, 2>> boundary_of(const Cells<3>& triangles) {
  return alone(all_faces(triangles, kSidesOfTriangle));
}

std::vector<int> rim_of(const Cells<3>& triangles) {
  std::vector<int> rim;
  for (const auto& side : boundary_of(triangles)) rim.insert(rim.end(), side.begin(), side.end());
  std::sort(rim.begin(), rim.end());
  rim.erase(std::unique(rim.begin(), rim.end()), rim.end());
  return rim;
}

}  // namespace elastin
