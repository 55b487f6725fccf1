#include "elastin/core/shapes/refinement.h"

#include <algorithm>
#include <map>

#include "elastin/core/base/error.h"
#include "elastin/core/shapes/surfaces.h"

namespace elastin {
namespace {

/// The diagonals of the octahedron between the middles of a tetrahedron's sides, each with the ring of the other four.
struct Diagonal {
  std::array<int, 2> ends;
  std::array<int, 4> ring;
};
/// Numbers of the sides in the order 01 02 03 12 13 23.
constexpr Diagonal kDiagonals[] = {{{0, 5}, {1, 3, 4, 2}}, {{1, 4}, {0, 3, 5, 2}}, {{2, 3}, {0, 4, 5, 1}}};

void check_refinable(const Body& body) {
  if (body.tetrahedra.empty() && body.triangles.empty()) throw InputError("a body without cells cannot be refined");
  if (!body.parts.empty() || !body.ties.empty()) throw InputError("a body of several parts cannot be refined");
  if (!body.cables.empty()) throw InputError("a body with cables cannot be refined");
}

/// Numbers of the middles of sides, which are ascending.
class Middles {
 public:
  explicit Middles(const Body& body)
      : first_(body.size()), sides_(connections_of_cells(body.rest, body.triangles, body.tetrahedra).ends) {}
  int of(int a, int b) const {
    const std::array<int, 2> side{std::min(a, b), std::max(a, b)};
    return first_ + static_cast<int>(std::lower_bound(sides_.begin(), sides_.end(), side) - sides_.begin());
  }
  const std::vector<std::array<int, 2>>& sides() const { return sides_; }

 private:
  int first_;
  std::vector<std::array<int, 2>> sides_;
};

void add_oriented(const Positions& rest, std::array<int, 4> cell, Cells<4>& cells) {
  if (signed_volume(rest, cell) < 0) std::swap(cell[2], cell[3]);
  cells.push_back(cell);
}

void cut(const std::array<int, 4>& cell, const Middles& middles, const Positions& rest, Cells<4>& cells) {
  const auto& [a, b, c, d] = cell;
  const std::array<int, 6> m{middles.of(a, b), middles.of(a, c), middles.of(a, d),
                             middles.of(b, c), middles.of(b, d), middles.of(c, d)};
  for (const auto& corner : {std::array{a, m[0], m[1], m[2]}, std::array{b, m[0], m[3], m[4]},
                             std::array{c, m[1], m[3], m[5]}, std::array{d, m[2], m[4], m[5]}})
    add_oriented(rest, corner, cells);
  const Diagonal* shortest = kDiagonals;
  const auto length = [&](const Diagonal& diagonal) {
    return (rest.col(m[static_cast<std::size_t>(diagonal.ends[1])]) -
            rest.col(m[static_cast<std::size_t>(diagonal.ends[0])]))
        .norm();
  };
  for (const Diagonal& diagonal : kDiagonals)
    if (length(diagonal) < length(*shortest) * (1 - 1e-9)) shortest = &diagonal;
  const auto at = [&](int side) { return m[static_cast<std::size_t>(side)]; };
  for (std::size_t i = 0; i < 4; ++i)
    add_oriented(rest,
                 {at(shortest->ends[0]), at(shortest->ends[1]), at(shortest->ring[i]), at(shortest->ring[(i + 1) % 4])},
                 cells);
}

void cut(const std::array<int, 3>& cell, const Middles& middles, const Positions& /*rest*/, Cells<3>& cells) {
  const auto& [a, b, c] = cell;
  const int ab = middles.of(a, b), bc = middles.of(b, c), ca = middles.of(c, a);
  for (const auto& part : {std::array{a, ab, ca}, std::array{ab, b, bc}, std::array{ca, bc, c}, std::array{ab, bc, ca}})
    cells.push_back(part);
}

double measure(const Positions& rest, const std::array<int, 4>& cell) { return signed_volume(rest, cell); }
double measure(const Positions& rest, const std::array<int, 3>& cell) { return area_vector(rest, cell).norm(); }

/// Lumps what the cells measure, each times the factor of the cell that it came from.
template <std::size_t corners>
void add_lumped(const Positions& rest, const std::vector<std::array<int, corners>>& cells, const VectorX& factors,
                std::size_t children, VectorX& lumped) {
  for (std::size_t cell = 0; cell < cells.size(); ++cell)
    for (const int molecule : cells[cell])
      lumped[molecule] += factors[static_cast<Eigen::Index>(cell / children)] * measure(rest, cells[cell]) / corners;
}

/// How much heavier than the cells' mean each cell is, from the molecules at its corners.
template <std::size_t corners>
VectorX weights_of(const std::vector<std::array<int, corners>>& cells, const VectorX& mass, const VectorX& lumped) {
  VectorX weights = VectorX::Zero(static_cast<Eigen::Index>(cells.size()));
  for (std::size_t cell = 0; cell < cells.size(); ++cell)
    for (const int molecule : cells[cell])
      weights[static_cast<Eigen::Index>(cell)] += mass[molecule] / lumped[molecule] / corners;
  return weights;
}

void set_masses(const Body& coarse, Body& fine) {
  if (coarse.mass.size() == 0) return;
  const bool solid = !coarse.tetrahedra.empty();
  VectorX before = VectorX::Zero(coarse.size()), after = VectorX::Zero(fine.size());
  const auto ones = [](std::size_t count) { return VectorX::Ones(static_cast<Eigen::Index>(count)); };
  if (solid) {
    add_lumped(coarse.rest, coarse.tetrahedra, ones(coarse.tetrahedra.size()), 1, before);
    add_lumped(fine.rest, fine.tetrahedra, weights_of(coarse.tetrahedra, coarse.mass, before), 8, after);
  } else {
    add_lumped(coarse.rest, coarse.triangles, ones(coarse.triangles.size()), 1, before);
    add_lumped(fine.rest, fine.triangles, weights_of(coarse.triangles, coarse.mass, before), 4, after);
  }
  for (int molecule = 0; molecule < coarse.size(); ++molecule)  // one that belongs to no cell
    if (!(before[molecule] > 0)) after[molecule] = coarse.mass[molecule];
  fine.mass = after * (coarse.mass.sum() / after.sum());
}

VectorX repeated(const VectorX& values, Eigen::Index times) {
  VectorX all(values.size() * times);
  for (Eigen::Index i = 0; i < all.size(); ++i) all[i] = values[i / times];
  return all;
}

}  // namespace

Body refined(const Body& coarse) {
  check_refinable(coarse);
  const Middles middles(coarse);
  Body fine;
  const auto old = coarse.size(), added = static_cast<int>(middles.sides().size());
  fine.rest.resize(3, old + added);
  fine.rest.leftCols(old) = coarse.rest;
  if (coarse.radius.size()) {
    fine.radius.resize(old + added);
    fine.radius.head(old) = coarse.radius / 2;
  }
  for (int side = 0; side < added; ++side) {
    const auto& [a, b] = middles.sides()[static_cast<std::size_t>(side)];
    fine.rest.col(old + side) = (coarse.rest.col(a) + coarse.rest.col(b)) / 2;
    if (coarse.radius.size()) fine.radius[old + side] = (coarse.radius[a] + coarse.radius[b]) / 4;
  }
  for (const auto& cell : coarse.tetrahedra) cut(cell, middles, fine.rest, fine.tetrahedra);
  for (const auto& cell : coarse.triangles) cut(cell, middles, fine.rest, fine.triangles);
  fine.connections = connections_of_cells(fine.rest, fine.triangles, fine.tetrahedra);
  fine.between = coarse.between;
  fine.between.insert(fine.between.end(), middles.sides().begin(), middles.sides().end());
  set_masses(coarse, fine);
  if (coarse.cell_stiffness.size())
    fine.cell_stiffness = repeated(coarse.cell_stiffness, coarse.tetrahedra.empty() ? 4 : 8);
  return fine;
}

Body with_tetrahedra_in_cubes(const Body& lattice) {
  if (lattice.cubes.empty()) throw InputError("the body has no cubes to put tetrahedra into");
  constexpr std::array<std::array<int, 4>, 6> faces{
      {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};
  struct Shared {
    std::array<int, 4> ring;
    int first, second = -1;
  };
  const auto old = lattice.size(), added = static_cast<int>(lattice.cubes.size());
  Body body;
  body.rest.resize(3, old + added);
  body.rest.leftCols(old) = lattice.rest;
  std::map<std::array<int, 4>, Shared> shared;
  for (int c = 0; c < added; ++c) {
    const auto& cube = lattice.cubes[static_cast<std::size_t>(c)];
    Vector3 middle = Vector3::Zero();
    for (const int corner : cube) middle += lattice.rest.col(corner) / 8;
    body.rest.col(old + c) = middle;
    for (const auto& face : faces) {
      std::array<int, 4> ring{};
      for (std::size_t i = 0; i < 4; ++i) ring[i] = cube[static_cast<std::size_t>(face[i])];
      std::array<int, 4> key = ring;
      std::sort(key.begin(), key.end());
      const auto [at, fresh] = shared.try_emplace(key, Shared{ring, old + c});
      if (!fresh) at->second.second = old + c;
    }
  }
  for (const auto& [key, face] : shared) {
    const auto& [ring, first, second] = face;
    if (second < 0) {
      add_oriented(body.rest, {first, ring[0], ring[1], ring[2]}, body.tetrahedra);
      add_oriented(body.rest, {first, ring[0], ring[2], ring[3]}, body.tetrahedra);
      continue;
    }
    for (std::size_t i = 0; i < 4; ++i)
      add_oriented(body.rest, {first, second, ring[i], ring[(i + 1) % 4]}, body.tetrahedra);
  }
  body.connections = connections_of_cells(body.rest, {}, body.tetrahedra);
  return body;
}

std::array<double, 10> moments_of_cells(const Body& body) {
  std::array<double, 10> sum{};
  const auto add = [&](double size, const auto& cell) {
    Vector3 middle = Vector3::Zero();
    Matrix3 spread = Matrix3::Zero();
    const double n = static_cast<double>(cell.size());
    for (const int corner : cell) middle += body.rest.col(corner) / n;
    for (const int corner : cell) spread += body.rest.col(corner) * body.rest.col(corner).transpose();
    // ∫ x xᵀ of a simplex with n corners is (Σ x_a x_aᵀ + n² m mᵀ) / (n (n + 1)) of its size.
    const Matrix3 second = (spread + n * n * middle * middle.transpose()) / (n * (n + 1));
    sum[0] += size;
    for (int i = 0; i < 3; ++i) sum[static_cast<std::size_t>(1 + i)] += size * middle[i];
    for (int i = 0, at = 4; i < 3; ++i)
      for (int j = i; j < 3; ++j, ++at) sum[static_cast<std::size_t>(at)] += size * second(i, j);
  };
  for (const auto& cell : body.tetrahedra) add(measure(body.rest, cell), cell);
  if (body.tetrahedra.empty())
    for (const auto& cell : body.triangles) add(measure(body.rest, cell), cell);
  return sum;
}

}  // namespace elastin
