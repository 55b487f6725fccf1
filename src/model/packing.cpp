#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "elastin/model/shapes.h"

namespace elastin {
namespace {

/// A number in [0, 1) from the top 53 bits: std::uniform_real_distribution differs between standard libraries.
double unit_random(std::mt19937_64& generator) { return static_cast<double>(generator() >> 11) * 0x1.0p-53; }

/// Pushes overlapping pairs apart, half of the overlap each, and back into the box. Returns the largest overlap.
double push_apart(Positions& places, const Vector3& size, double distance) {
  double worst = 0;
  for (const auto& [a, b] : connections_within(places, distance).ends) {
    const Vector3 gap = places.col(b) - places.col(a);
    const double length = gap.norm(), overlap = distance - length;
    if (overlap <= 0) continue;
    worst = std::max(worst, overlap);
    const Vector3 shift = length > 0 ? Vector3(gap * (0.5 * overlap / length)) : Vector3(0.5 * overlap, 0, 0);
    places.col(a) -= shift;
    places.col(b) += shift;
  }
  places = places.cwiseMax(0).cwiseMin(size.replicate(1, places.cols()));
  return worst;
}

}  // namespace

Body random_packing(const Vector3& size, double distance, double reach, std::uint64_t seed) {
  // Centres fill `size`, so the spheres themselves fill half a diameter more on every side. 0.60 of that volume is just
  // below random close packing (0.64): denser takes ever longer to push apart and loses more molecules at the end.
  constexpr double fraction = 0.60;
  constexpr int sweeps = 600;
  const double volume = (size.array() + distance).prod(), sphere = std::numbers::pi / 6 * std::pow(distance, 3);
  const int count = std::max(1, static_cast<int>(fraction * volume / sphere));
  std::mt19937_64 generator(seed);
  Positions places(3, count);
  for (int molecule = 0; molecule < count; ++molecule)
    for (int axis = 0; axis < 3; ++axis) places(axis, molecule) = size[axis] * unit_random(generator);

  for (int sweep = 0; sweep < sweeps && push_apart(places, size, distance * 1.001) > 1e-3 * distance; ++sweep) {
  }
  // Whoever is still too close goes, most crowded molecule first, so that the minimum distance holds exactly.
  std::vector<char> kept(count, 1);
  for (;;) {
    std::vector<int> overlaps(count, 0);
    int most = 0;
    for (const auto& [a, b] : connections_within(places, distance * (1 - 1e-12)).ends)
      if (kept[a] && kept[b]) most = std::max({most, ++overlaps[a], ++overlaps[b]});
    if (most == 0) break;
    for (int molecule = 0; molecule < count; ++molecule)
      if (overlaps[molecule] == most) {
        kept[molecule] = 0;
        break;
      }
  }
  std::vector<Vector3> rest;
  for (int molecule = 0; molecule < count; ++molecule)
    if (kept[molecule]) rest.push_back(places.col(molecule));
  Body body = listed_body(rest, {});
  body.connections = connections_within(body.rest, reach);
  return body;
}

void add_jitter(Body& body, double amount, std::uint64_t seed) {
  std::mt19937_64 generator(seed);
  const Vector3 low = body.rest.rowwise().minCoeff(), high = body.rest.rowwise().maxCoeff();
  const double tolerance = 1e-9 * (high - low).norm();
  for (int molecule = 0; molecule < body.size(); ++molecule)
    for (int axis = 0; axis < 3; ++axis) {
      const double move = amount * (2 * unit_random(generator) - 1);
      double& place = body.rest(axis, molecule);
      if (place > low[axis] + tolerance && place < high[axis] - tolerance) place += move;
    }
  auto& [ends, lengths] = body.connections;
  for (std::size_t c = 0; c < ends.size(); ++c)
    lengths[c] = (body.rest.col(ends[c][1]) - body.rest.col(ends[c][0])).norm();
}

void rotate(Body& body, const Matrix3& rotation) { body.rest = (rotation * body.rest).eval(); }

void set_matter(Body& body, double radius, double density, double thickness, double volume) {
  body.radius = VectorX::Constant(body.size(), radius);
  const bool has_cells = !body.triangles.empty() || !body.tetrahedra.empty();
  body.mass = has_cells ? lumped_mass(body.rest, body.triangles, body.tetrahedra, density, thickness)
                        : VectorX::Constant(body.size(), density * volume / body.size());
}

}  // namespace elastin
