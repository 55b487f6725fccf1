#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>

#include "core/base/rows.h"
#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"
#include "elastin/core/shapes/shapes.h"

namespace elastin {
namespace {

void check_counts(const std::array<int, 3>& counts, const char* what) {
  for (const int count : counts)
    if (count < 1)
      throw InputError(std::string(what) + ": " + std::to_string(count) + " along an axis; allowed: 1 or more");
}

void check_length(double length, const char* what) {
  if (!(length > 0) || !std::isfinite(length))
    throw InputError(std::string(what) + " of " + number(length) + " m: it must be above 0 and finite");
}

/// Offsets to half of the neighbours (each pair once) of a simple cubic lattice with `nonzero` coordinates not zero.
std::vector<Eigen::Vector3i> half_neighbours(int nonzero) {
  std::vector<Eigen::Vector3i> offsets;
  for (int z = -1; z <= 1; ++z)
    for (int y = -1; y <= 1; ++y)
      for (int x = -1; x <= 1; ++x) {
        const Eigen::Vector3i offset(x, y, z);
        const bool second_half = z > 0 || (z == 0 && (y > 0 || (y == 0 && x > 0)));
        if (second_half && offset.cwiseAbs().sum() == nonzero) offsets.push_back(offset);
      }
  return offsets;
}

std::vector<Eigen::Vector3i> offsets_of(const CubicPattern& pattern) {
  std::vector<Eigen::Vector3i> offsets;
  for (const auto& [wanted, nonzero] : {std::pair{pattern.axis, 1}, {pattern.face, 2}, {pattern.space, 3}})
    if (wanted)
      for (const auto& offset : half_neighbours(nonzero)) offsets.push_back(offset);
  return offsets;
}

/// Pairs of molecules of a simple cubic lattice that are so far apart.
std::int64_t pairs_along(const std::array<int, 3>& molecules, const Eigen::Vector3i& offset) {
  std::int64_t pairs = 1;
  for (int axis = 0; axis < 3; ++axis) pairs *= std::max(0, molecules[axis] - std::abs(offset[axis]));
  return pairs;
}

/// Connections of a simple cubic lattice.
std::int64_t connections_of(const std::array<int, 3>& molecules, const CubicPattern& pattern) {
  std::int64_t pairs = 0;
  for (const Eigen::Vector3i& offset : offsets_of(pattern)) pairs += pairs_along(molecules, offset);
  return pairs;
}

/// The Bravais lattices share everything but their basis and reach.
Body centred_lattice(const std::array<int, 3>& cells, double spacing, const std::vector<Vector3>& basis, double reach) {
  check_counts(cells, "cells"), check_length(spacing, "a spacing");
  std::vector<Vector3> positions;
  for (int z = 0; z <= cells[2]; ++z)
    for (int y = 0; y <= cells[1]; ++y)
      for (int x = 0; x <= cells[0]; ++x)
        for (const Vector3& shift : basis) {
          const Vector3 position = Vector3(x, y, z) + shift;
          if ((position.array() <= Vector3(cells[0], cells[1], cells[2]).array()).all())
            positions.push_back(spacing * position);
        }
  Body body = listed_body(positions, {});
  body.connections = connections_within(body.rest, reach * spacing * (1 + 1e-9));
  return body;
}

/// Every face of a cube is shared by two pyramids, tips in the middles of the cubes on both sides; the pair is cut into
/// four equal tetrahedra around the line between the tips (12 a cube in all). A pyramid on the surface is cut in two.
/// The middle of cube c will be molecule body.size() + c.
void add_body_centred(const std::array<int, 3>& cubes, Body& body) {
  const int count = static_cast<int>(body.cubes.size());
  const std::array<int, 3> stride{1, cubes[0], cubes[0] * cubes[1]};
  for (int c = 0; c < count; ++c) {
    const auto& cube = body.cubes[c];
    const int middle = body.size() + c;
    for (int axis = 0; axis < 3; ++axis)
      for (const int side : {0, 1}) {
        const int u = 1 << (axis + 1) % 3, v = 1 << (axis + 2) % 3, base = side << axis;
        const std::array<int, 4> ring{cube[base], cube[base | u], cube[base | u | v], cube[base | v]};
        const int index = c / stride[axis] % cubes[axis];
        if (index + (side ? 1 : -1) < 0 || index + (side ? 1 : -1) >= cubes[axis]) {
          body.tetrahedra.push_back({middle, ring[0], ring[1], ring[2]});
          body.tetrahedra.push_back({middle, ring[0], ring[2], ring[3]});
        } else if (side == 1) {  // each inner face once, from the cube below it
          for (int i = 0; i < 4; ++i)
            body.tetrahedra.push_back({middle, middle + stride[axis], ring[i], ring[(i + 1) % 4]});
        }
      }
  }
}

}  // namespace

Body cubic_lattice(const std::array<int, 3>& molecules, double spacing, const CubicPattern& pattern) {
  check_counts(molecules, "molecules"), check_length(spacing, "a spacing");
  const int nx = molecules[0], ny = molecules[1], nz = molecules[2];
  const auto index = [nx, ny](int x, int y, int z) { return x + nx * (y + ny * z); };
  const auto inside = [&](int x, int y, int z) { return x >= 0 && x < nx && y >= 0 && y < ny && z >= 0 && z < nz; };
  const std::vector<Eigen::Vector3i> offsets = offsets_of(pattern);
  numbered(std::int64_t{numbered(std::int64_t{nx} * ny, "molecules")} * nz, "molecules");
  const std::int64_t connections = connections_of(molecules, pattern);
  Body body;
  body.grid = molecules;
  body.rest.resize(3, static_cast<Eigen::Index>(nx) * ny * nz);
  body.connections.ends.reserve(numbered(connections, "connections"));
  body.cubes.reserve(pairs_along(molecules, {1, 1, 1}));
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x) {
        const int here = index(x, y, z);
        body.rest.col(here) = spacing * Vector3(x, y, z);
        for (const auto& o : offsets)
          if (inside(x + o.x(), y + o.y(), z + o.z()))
            body.connections.ends.push_back({here, index(x + o.x(), y + o.y(), z + o.z())});
        if (inside(x + 1, y + 1, z + 1))
          body.cubes.push_back({here, index(x + 1, y, z), index(x, y + 1, z), index(x + 1, y + 1, z),
                                index(x, y, z + 1), index(x + 1, y, z + 1), index(x, y + 1, z + 1),
                                index(x + 1, y + 1, z + 1)});
      }
  set_present_lengths(body);
  return body;
}

Body cubic_lattice_share(const std::array<int, 3>& molecules, double spacing, const CubicPattern& pattern,
                         const std::shared_ptr<const Processes>& processes) {
  const int layers = molecules[2], count = processes->count(), rank = processes->rank();
  const auto first_of = [&](int process) { return static_cast<int>(std::int64_t{layers} * process / count); };
  const int first = std::max(0, first_of(rank) - 2), end = std::min(layers, first_of(rank + 1) + 2);
  Body slab = cubic_lattice({molecules[0], molecules[1], end - first}, spacing, pattern);
  const std::int64_t of_layer = std::int64_t{molecules[0]} * molecules[1], before = of_layer * first;
  for (int molecule = 0; molecule < slab.size(); ++molecule)
    slab.rest(2, molecule) = spacing * static_cast<double>(first + molecule / of_layer);
  set_present_lengths(slab);
  const auto number = [&](int molecule) { return before + molecule; };
  const auto owner = [&](int molecule) {
    const int layer = static_cast<int>(number(molecule) / of_layer);
    return layer < first_of(rank) ? rank - 1 : layer < first_of(rank + 1) ? rank : rank + 1;
  };
  Body body = make_share(slab, {owner, number, number, of_layer * layers}, rank);
  auto share = std::make_shared<Share>(*body.share);
  share->processes = processes;
  share->connections = connections_of(molecules, pattern);
  share->cells = 0;
  body.share = std::move(share);
  return body;
}

Body body_centred_lattice(const std::array<int, 3>& cells, double spacing, bool second) {
  return centred_lattice(cells, spacing, {{0, 0, 0}, {.5, .5, .5}}, second ? 1 : std::sqrt(3.) / 2);
}

Body face_centred_lattice(const std::array<int, 3>& cells, double spacing, bool second) {
  return centred_lattice(cells, spacing, {{0, 0, 0}, {.5, .5, 0}, {.5, 0, .5}, {0, .5, .5}},
                         second ? 1 : std::sqrt(.5));
}

Body listed_body(const std::vector<Vector3>& positions, const std::vector<std::array<int, 2>>& pairs) {
  Body body;
  body.rest.resize(3, static_cast<Eigen::Index>(positions.size()));
  for (std::size_t molecule = 0; molecule < positions.size(); ++molecule)
    body.rest.col(static_cast<Eigen::Index>(molecule)) = positions[molecule];
  body.connections.ends = pairs;
  set_present_lengths(body);
  return body;
}

void stretch(Body& body, const Vector3& factors) {
  body.rest = factors.asDiagonal() * body.rest;
  set_present_lengths(body);
}

void grade(Body& body, int axis, double ratio) {
  if (axis < 0 || axis > 2) throw InputError("axis " + std::to_string(axis) + ": allowed: 0, 1 and 2");
  if (!(ratio > 0) || !std::isfinite(ratio))
    throw InputError("a ratio of spacings of " + number(ratio) + ": it must be above 0 and finite");
  const double low = body.rest.row(axis).minCoeff(), length = body.rest.row(axis).maxCoeff() - low;
  const double growth = std::log(ratio);
  if (!(length > 0) || growth == 0) return;
  for (double& position : body.rest.row(axis))
    position = low + length * std::expm1(growth * (position - low) / length) / std::expm1(growth);
  set_present_lengths(body);
}

Body tetrahedral_block(BlockKind kind, const std::array<int, 3>& cubes, const Vector3& size) {
  check_counts(cubes, "cubes");
  for (const double length : size) check_length(length, "a side");
  const Vector3 side = size.array() / Vector3(cubes[0], cubes[1], cubes[2]).array();
  Body body = cubic_lattice({cubes[0] + 1, cubes[1] + 1, cubes[2] + 1}, 1, {});
  // Corner c of a cube sits at (c & 1, c >> 1 & 1, c >> 2).
  static constexpr std::array<std::array<int, 4>, 6> kuhn{
      {{0, 1, 3, 7}, {0, 5, 1, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, {0, 4, 5, 7}, {0, 6, 4, 7}}};
  static constexpr std::array<std::array<int, 4>, 5> five{
      {{0, 1, 2, 4}, {3, 2, 1, 7}, {5, 1, 4, 7}, {6, 4, 2, 7}, {1, 2, 4, 7}}};
  std::vector<Vector3> middles;
  for (std::size_t c = 0; c < body.cubes.size(); ++c) {
    const auto& cube = body.cubes[c];
    if (kind == BlockKind::kuhn) {
      for (const auto& t : kuhn) body.tetrahedra.push_back({cube[t[0]], cube[t[1]], cube[t[2]], cube[t[3]]});
    } else if (kind == BlockKind::alternating) {
      const int number = static_cast<int>(c);
      const bool mirrored = (number % cubes[0] + number / cubes[0] % cubes[1] + number / cubes[0] / cubes[1]) % 2;
      // The mirror image in x swaps bit 0 of every corner; swapping two corners restores the orientation.
      for (auto t : five) {
        if (mirrored) t = {t[1] ^ 1, t[0] ^ 1, t[2] ^ 1, t[3] ^ 1};
        body.tetrahedra.push_back({cube[t[0]], cube[t[1]], cube[t[2]], cube[t[3]]});
      }
    } else {
      middles.push_back((body.rest.col(cube[0]) + body.rest.col(cube[7])) / 2);
    }
  }
  if (kind == BlockKind::body_centred) add_body_centred(cubes, body), body.grid.reset();
  body.rest.conservativeResize(3, body.rest.cols() + static_cast<Eigen::Index>(middles.size()));
  for (std::size_t m = 0; m < middles.size(); ++m)
    body.rest.col(body.rest.cols() - static_cast<Eigen::Index>(middles.size() - m)) = middles[m];
  body.rest = side.asDiagonal() * body.rest;
  body.cubes.clear();
  for (auto& t : body.tetrahedra)
    if (signed_volume(body.rest, t) < 0) std::swap(t[2], t[3]);
  body.connections = connections_of_cells(body.rest, {}, body.tetrahedra);
  return body;
}

}  // namespace elastin
