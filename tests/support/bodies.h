#pragma once
#include <random>

#include "core/shapes/orders.h"
#include "elastin/core/model/material.h"
#include "elastin/core/model/state.h"
#include "elastin/core/shapes/arrays.h"
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

/// A box of cells of `kind`, hexahedra split into two prisms each if these are requested; every corner is moved by up
/// to `jitter` times the cells' width, and if `curved` the nodes between them too; on the box's faces within these.
inline Body cell_box(const CellKind& kind, const std::array<int, 3>& cells, const Vector3& size, double jitter,
                     bool curved = false) {
  const double width = (size.array() / Eigen::Array3d(cells[0], cells[1], cells[2])).minCoeff();
  Body corners;
  if (kind.corners == 4) {
    corners = tetrahedral_block(BlockKind::body_centred, cells, size);
  } else {
    corners = cubic_lattice({cells[0] + 1, cells[1] + 1, cells[2] + 1}, 1, {true, false, false});
    stretch(corners, Vector3(size[0] / cells[0], size[1] / cells[1], size[2] / cells[2]));
  }
  if (jitter > 0 && !curved) add_jitter(corners, jitter * width, 5);
  Body body = kind.corners == 6 ? with_order(corners, 1) : with_cells(corners, kind);
  if (kind.corners == 6) {
    CellBlock prisms{&kind, {}, {}};
    for (int cell = 0; cell < body.blocks[0].size(); ++cell)
      for (const std::size_t corner : {0, 1, 2, 4, 5, 6, 0, 2, 3, 4, 6, 7})
        prisms.nodes.push_back(body.blocks[0].cell(cell)[corner]);
    body.blocks = {prisms};
    set_simplices(body);
  }
  if (curved) add_jitter(body, jitter * width, 5);
  set_matter(body, width / 4, 1000, 0, 0);
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

/// A curved sheet of triangles with nodes in the middle of their sides.
inline Body quadratic_sheet(double thickness) {
  Body body = with_order(sheet(thickness), 2);
  std::mt19937_64 generator(17);
  for (int i = 0; i < body.rest.size(); ++i)
    body.rest.data()[i] += 0.0004 * (2 * static_cast<double>(generator() >> 11) * 0x1p-53 - 1);
  set_present_lengths(body);
  set_matter(body, 0.003, 1000, thickness, 0);
  return body;
}

inline Positions random_motion(const Body& body, unsigned seed) {
  std::mt19937_64 generator(seed);
  Positions motion(3, body.size());
  for (int i = 0; i < motion.size(); ++i) motion.data()[i] = 2 * static_cast<double>(generator() >> 11) * 0x1p-53 - 1;
  return motion;
}

/// A strained body in motion.
inline State moving(const Body& body) {
  State state = state_at_rest(body);
  state.positions = deformed(body, 3e-4);
  state.velocities = random_motion(body, 31);
  return state;
}

}  // namespace elastin::testing
