#include <algorithm>

#include "contact/search.h"
#include "core/geometry/boundary.h"
#include "elastin/core/shapes/surfaces.h"

namespace elastin::contact {
namespace {

std::array<int, 3> sorted(std::array<int, 3> corners) {
  std::sort(corners.begin(), corners.end());
  return corners;
}

}  // namespace

Cells<3> surface_triangles(const Body& body) {
  Cells<3> found = boundary_of(body.tetrahedra);
  for (const auto& [a, b, c, d] : boundary_of(body.cubes)) {
    found.push_back({a, b, c});
    found.push_back({a, c, d});
  }
  if (body.triangles.empty()) return found;
  Cells<3> taken = faces_of(body.tetrahedra);
  for (auto& face : taken) face = sorted(face);
  std::sort(taken.begin(), taken.end());
  for (const auto& triangle : body.triangles)
    if (!std::binary_search(taken.begin(), taken.end(), sorted(triangle))) found.push_back(triangle);
  return found;
}

std::vector<int> surface_molecules(const Body& body) {
  std::vector<char> inside(body.size(), 0);
  const auto mark = [&](const auto& cells, char what) {
    for (const auto& cell : cells)
      for (const int molecule : cell) inside[molecule] = what;
  };
  mark(body.tetrahedra, 1);
  mark(body.cubes, 1);
  mark(surface_triangles(body), 0);
  std::vector<int> found;
  for (int molecule = 0; molecule < body.size(); ++molecule)
    if (!inside[molecule]) found.push_back(molecule);
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
    sample.piece = piece_of[molecule];
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
      sample.weights[k] = 2. / 3;
      sample.count = 3;
      sample.area = area_vector(body.rest, triangle).norm() / 3;
      sample.piece = piece_of[triangle[0]];
      samples.push_back(sample);
    }
  return samples;
}

}  // namespace elastin::contact
