#pragma once
#include <random>

#include "elastin/core/model/material.h"
#include "elastin/core/shapes/shapes.h"

namespace elastin::testing {

/// A jittered lattice with axis, face and space connections, radii half of the spacing.
inline Body jittered_lattice(double jitter = 0.12) {
  Body body = cubic_lattice({4, 3, 3}, 0.01, {true, true, true});
  add_jitter(body, jitter * 0.01, 11);
  set_matter(body, 0.005, 1000, 0, 0.03 * 0.02 * 0.02);
  return body;
}

/// A jittered block of tetrahedra.
inline Body jittered_block() {
  Body body = tetrahedral_block(BlockKind::kuhn, {3, 2, 2}, {0.03, 0.02, 0.02});
  add_jitter(body, 0.0015, 12);
  set_matter(body, 0.003, 1000, 0, 0);
  return body;
}

/// A curved sheet of irregular triangles.
inline Body sheet(double thickness) {
  constexpr int n = 5;
  std::mt19937_64 generator(13);
  std::vector<Vector3> positions;
  const auto wobble = [&] { return 0.002 * (static_cast<double>(generator() >> 11) * 0x1p-53 - 0.5); };
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x)
      positions.emplace_back(0.01 * x + wobble(), 0.01 * y + wobble(), 0.2 * 0.0001 * x * x + wobble());
  Body body = listed_body(positions, {});
  for (int y = 0; y + 1 < n; ++y)
    for (int x = 0; x + 1 < n; ++x) {
      const int a = x + n * y, b = a + 1, c = a + n, d = c + 1;
      body.triangles.push_back({a, b, d});
      body.triangles.push_back({a, d, c});
    }
  body.connections = connections_of_cells(body.rest, body.triangles, {});
  set_matter(body, 0.003, 1000, thickness, 0);
  return body;
}

/// Random places around the body's, each coordinate moved by up to `amount` [m], after a stretch of its whole.
inline Positions deformed(const Body& body, double amount, unsigned seed = 1) {
  std::mt19937_64 generator(seed);
  Matrix3 stretch;
  stretch << 1.08, 0.05, 0, -0.02, 0.95, 0.04, 0.03, 0, 1.04;
  Positions positions = stretch * body.rest;
  for (int i = 0; i < positions.size(); ++i)
    positions.data()[i] += amount * (2 * static_cast<double>(generator() >> 11) * 0x1p-53 - 1);
  return positions;
}

inline Positions random_motion(const Body& body, unsigned seed) {
  std::mt19937_64 generator(seed);
  Positions motion(3, body.size());
  for (int i = 0; i < motion.size(); ++i) motion.data()[i] = 2 * static_cast<double>(generator() >> 11) * 0x1p-53 - 1;
  return motion;
}

}  // namespace elastin::testing
