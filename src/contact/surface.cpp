#include <algorithm>

#include "contact/search.h"
#include "elastin/core/shapes/surfaces.h"

namespace elastin::contact {
namespace {

/// A part of a cell's surface by its corners in ascending order, so that the same part of two cells is found.
template <std::size_t corners>
struct CellPart {
  std::array<int, corners> sorted;
  std::array<int, corners> turned;  ///< seen from outside counter-clockwise
  explicit CellPart(const std::array<int, corners>& ring) : sorted(ring), turned(ring) {
    std::sort(sorted.begin(), sorted.end());
  }
  bool operator<(const CellPart& other) const { return sorted < other.sorted; }
};

/// Those that stand alone, in the order of their corners.
template <std::size_t corners>
std::vector<std::array<int, corners>> alone(std::vector<CellPart<corners>> parts) {
  std::stable_sort(parts.begin(), parts.end());
  std::vector<std::array<int, corners>> found;
  for (std::size_t i = 0, next; i < parts.size(); i = next) {
    for (next = i + 1; next < parts.size() && parts[next].sorted == parts[i].sorted;) ++next;
    if (next == i + 1) found.push_back(parts[i].turned);
  }
  return found;
}

std::vector<CellPart<3>> sides(const Cells<4>& tetrahedra) {
  std::vector<CellPart<3>> parts;
  parts.reserve(4 * tetrahedra.size());
  for (const auto& [a, b, c, d] : tetrahedra)
    for (const std::array<int, 3>& side : {std::array{a, c, b}, {a, b, d}, {a, d, c}, {b, c, d}})
      parts.emplace_back(side);
  return parts;
}

std::vector<CellPart<4>> faces(const Cells<8>& cubes) {
  std::vector<CellPart<4>> parts;
  parts.reserve(6 * cubes.size());
  for (const auto& cube : cubes)
    for (int axis = 0; axis < 3; ++axis) {
      const int u = 1 << (axis + 1) % 3, v = 1 << (axis + 2) % 3, up = 1 << axis;
      parts.emplace_back(std::array{cube[up], cube[up | u], cube[up | u | v], cube[up | v]});
      parts.emplace_back(std::array{cube[0], cube[v], cube[u | v], cube[u]});
    }
  return parts;
}

}  // namespace

Cells<3> surface_triangles(const Body& body) {
  const std::vector<CellPart<3>> all_sides = sides(body.tetrahedra);
  Cells<3> found = alone(all_sides);
  for (const auto& [a, b, c, d] : alone(faces(body.cubes))) {
    found.push_back({a, b, c});
    found.push_back({a, c, d});
  }
  std::vector<std::array<int, 3>> taken;
  if (!body.triangles.empty())
    for (const CellPart<3>& side : all_sides) taken.push_back(side.sorted);
  std::sort(taken.begin(), taken.end());
  for (const auto& triangle : body.triangles)
    if (!std::binary_search(taken.begin(), taken.end(), CellPart<3>(triangle).sorted)) found.push_back(triangle);
  return found;
}

std::vector<int> surface_molecules(const Body& body) {
  std::vector<char> inside(static_cast<std::size_t>(body.size()), 0);
  const auto mark = [&](const auto& cells, char what) {
    for (const auto& cell : cells)
      for (const int molecule : cell) inside[static_cast<std::size_t>(molecule)] = what;
  };
  mark(body.tetrahedra, 1);
  mark(body.cubes, 1);
  mark(surface_triangles(body), 0);
  std::vector<int> found;
  for (int molecule = 0; molecule < body.size(); ++molecule)
    if (!inside[static_cast<std::size_t>(molecule)]) found.push_back(molecule);
  return found;
}

std::vector<Sample> sphere_samples(const Body& body, const std::vector<int>& molecules) {
  const std::vector<int> piece_of = inspect(body).piece_of;
  std::vector<Sample> samples;
  samples.reserve(molecules.size());
  for (const int molecule : molecules) {
    Sample sample;
    sample.molecules[0] = molecule;
    sample.weights[0] = 1;
    sample.radius = body.radius[molecule];
    sample.area = 4 * sample.radius * sample.radius;
    sample.piece = piece_of[static_cast<std::size_t>(molecule)];
    samples.push_back(sample);
  }
  return samples;
}

std::vector<Sample> triangle_samples(const Body& body, const Cells<3>& triangles) {
  const std::vector<int> piece_of = inspect(body).piece_of;
  std::vector<Sample> samples;
  samples.reserve(3 * triangles.size());
  for (const auto& triangle : triangles)
    for (int k = 0; k < 3; ++k) {
      Sample sample;
      sample.molecules = triangle;
      sample.weights = {1. / 6, 1. / 6, 1. / 6};
      sample.weights[static_cast<std::size_t>(k)] = 2. / 3;
      sample.count = 3;
      sample.area = area_vector(body.rest, triangle).norm() / 3;
      sample.piece = piece_of[static_cast<std::size_t>(triangle[0])];
      samples.push_back(sample);
    }
  return samples;
}

}  // namespace elastin::contact
