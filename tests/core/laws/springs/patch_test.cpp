#include "core/laws/springs/patch.h"

#include <Eigen/SparseCholesky>
#include <catch2/catch.hpp>
#include <cmath>
#include <tuple>
#include <vector>

#include "core/laws/springs/lattice.h"
#include "elastin/core/shapes/shapes.h"
#include "elastin/mesh/voronoi.h"

using namespace elastin;
using namespace elastin::mesh;

namespace {

Material material_of(double youngs_modulus) {
  Material material;
  material.youngs_modulus = youngs_modulus;
  return material;
}

/// Which faces of the box from the origin to `size` a molecule lies in: −1, 0 or 1 an axis.
Vector3 sides(const Vector3& position, const Vector3& size) {
  const auto low = (position.array() < 1e-9 * size.array()).cast<double>();
  const auto high = (position.array() > (1 - 1e-9) * size.array()).cast<double>();
  return high - low;
}

/// Surface vector of a molecule of an undisturbed cubic lattice, from its place alone: h² in the middle of a face, half
/// on an edge, a quarter at a corner.
Vector3 lattice_surface(const Vector3& position, const Vector3& size, double spacing) {
  const Vector3 side = sides(position, size);
  Vector3 area;
  for (int axis = 0; axis < 3; ++axis) {
    const double across = side.squaredNorm() - side[axis] * side[axis];
    area[axis] = side[axis] * spacing * spacing / std::pow(2, across);
  }
  return area;
}

struct Tension {
  double modulus, poissons_ratio;
};

/// A cube of side 1 m pulled along z between two frictionless plates: E from the plate's force, ν from the side walls.
Tension pull(const Body& body, const VectorX& k) {
  const int unknowns = 3 * body.size();
  std::vector<Eigen::Triplet<double>> entries;
  for (int c = 0; c < body.connections.size(); ++c) {
    const auto [a, b] = body.connections.ends[c];
    const Vector3 n = (body.rest.col(b) - body.rest.col(a)).normalized();
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        for (const auto& [row, column, sign] : {std::tuple{a, a, 1}, {b, b, 1}, {a, b, -1}, {b, a, -1}})
          entries.emplace_back(3 * row + i, 3 * column + j, sign * k[c] * n[i] * n[j]);
  }
  Eigen::SparseMatrix<double> stiffness(unknowns, unknowns);
  stiffness.setFromTriplets(entries.begin(), entries.end());

  // The plates are z = 0 and z = 1; three more numbers at two corners stop sliding and turning.
  constexpr double strain = 1e-3;
  VectorX given = VectorX::Constant(unknowns, std::nan(""));
  for (int molecule = 0; molecule < body.size(); ++molecule) {
    const Vector3 side = sides(body.rest.col(molecule), Vector3::Ones());
    if (side.z() != 0) given[3 * molecule + 2] = side.z() > 0 ? strain : 0;
    if (side == Vector3(-1, -1, -1)) given[3 * molecule] = given[3 * molecule + 1] = 0;
    if (side == Vector3(1, -1, -1)) given[3 * molecule + 1] = 0;
  }
  const auto is_given = [&](Eigen::Index i) { return !std::isnan(given[i]); };
  VectorX right = VectorX::Zero(unknowns);
  Eigen::SparseMatrix<double> reduced = stiffness;
  for (Eigen::Index column = 0; column < unknowns; ++column)
    for (Eigen::SparseMatrix<double>::InnerIterator entry(reduced, column); entry; ++entry)
      if (is_given(entry.row()) || is_given(column)) {
        if (!is_given(entry.row())) right[entry.row()] -= entry.value() * given[column];
        entry.valueRef() = entry.row() == column ? 1 : 0;
      }
  for (Eigen::Index i = 0; i < unknowns; ++i)
    if (is_given(i)) right[i] = given[i];
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(reduced);
  REQUIRE(solver.info() == Eigen::Success);
  const VectorX moved = solver.solve(right), force = stiffness * moved;

  double plate = 0, spread = 0;
  int walls = 0;
  for (int molecule = 0; molecule < body.size(); ++molecule) {
    const Vector3 side = sides(body.rest.col(molecule), Vector3::Ones());
    if (side.z() > 0) plate += force[3 * molecule + 2];
    if (side.x() != 0) ++walls;
    spread += 2 * side.x() * moved[3 * molecule];
  }
  return {plate / strain, -spread / walls / strain};
}

Body cube(int molecules, bool space_diagonals, double jitter = 0, std::uint64_t seed = 1) {
  const double spacing = 1. / (molecules - 1);
  Body body = cubic_lattice({molecules, molecules, molecules}, spacing, {true, true, space_diagonals});
  if (jitter > 0) add_jitter(body, jitter * spacing, seed);
  return body;
}

}  // namespace

TEST_CASE("patch constants balance a uniform strain at every molecule of a lattice", "[patch]") {
  const bool space_diagonals = GENERATE(false, true);
  constexpr double spacing = 0.02, E = 5000;
  const Vector3 size = spacing * Vector3(2, 3, 4);
  const Body body = cubic_lattice({3, 4, 5}, spacing, {true, true, space_diagonals});
  const VectorX k = Patch{}.constants(body, material_of(E));
  CHECK(k.minCoeff() >= 0);

  Matrix3 strain;
  strain << 1, .3, -.7, .3, -.4, .5, -.7, .5, .2;
  // ν = ¼: λ = μ = 0.4 E.
  const Matrix3 stress = 0.4 * E * (strain.trace() * Matrix3::Identity() + 2 * strain);
  Positions force(3, body.size());
  for (int molecule = 0; molecule < body.size(); ++molecule)
    force.col(molecule) = stress * lattice_surface(body.rest.col(molecule), size, spacing);
  for (int c = 0; c < body.connections.size(); ++c) {
    const auto [a, b] = body.connections.ends[c];
    const Vector3 gap = body.rest.col(b) - body.rest.col(a);
    const Vector3 tension = k[c] * gap * gap.dot(strain * gap) / gap.squaredNorm();
    force.col(a) += tension;
    force.col(b) -= tension;
  }
  // The least-squares iteration ends at 1e-7 of its own scale and is drawn to the mean by 1e-6.
  CHECK(force.cwiseAbs().maxCoeff() < 2e-5 * stress.norm() * spacing * spacing);
}

TEST_CASE("patch gives a cubic lattice its E and one quarter", "[patch]") {
  const bool space_diagonals = GENERATE(false, true);
  const Body body = cube(6, space_diagonals);
  const auto [modulus, poissons_ratio] = pull(body, Patch{}.constants(body, material_of(1)));
  // An independent prototype: 0.9999 and 0.2505; exactly 1 and ¼ where the patch test holds exactly.
  CHECK(modulus == Approx(1).epsilon(2e-4));
  CHECK(poissons_ratio == Approx(0.25).epsilon(2e-3));
}

TEST_CASE("patch softens a disordered lattice by a few per cent", "[patch]") {
  const Body body = cube(7, true, 0.15, GENERATE(1, 2, 3));
  const VectorX k = Patch{}.constants(body, material_of(1));
  CHECK(k.minCoeff() >= 0);
  // An independent prototype had 0.952 for one such body; another size and other random numbers move it by a per cent
  // or so.
  CHECK(pull(body, k).modulus == Approx(0.952).margin(0.02));
}

TEST_CASE("patch finds the exact rule of the lattice with face diagonals, where no other is exact", "[patch]") {
  const Body body = cubic_lattice({3, 4, 5}, 0.1, {true, true, false});
  const VectorX found = Patch{}.constants(body, material_of(2e4)), exact = Lattice{}.constants(body, material_of(2e4));
  CHECK((found - exact).norm() < 1e-4 * exact.norm());
}

TEST_CASE("patch constants don't depend on direction and scale as E times length", "[patch]") {
  Body body = cube(4, false, 0.1);
  const VectorX before = Patch{}.constants(body, material_of(1));
  const Matrix3 turn = Eigen::AngleAxisd(0.7, Vector3(1, 2, 3).normalized()).toRotationMatrix();
  rotate(body, turn);
  body.rest *= 1e-3;
  for (double& length : body.connections.rest_length) length *= 1e-3;
  const VectorX after = Patch{}.constants(body, material_of(1e5));
  // Same problem in other numbers: the iteration may end one step apart.
  CHECK((after - 100 * before).norm() < 1e-4 * 100 * before.norm());
}

TEST_CASE("patch on one regular tetrahedron is the fit done by hand", "[patch]") {
  // All six k are equal by symmetry. At a corner, the three connections n_j with n_i · n_j = ½ (i ≠ j) meet the outward
  // area A, a third of the opposite face √3/4 L², with n_j · A = −√(2/3) |A|. Least squares of
  // k L Σ n n n + 0.4 E (δ A + …) and of w (3 k L − 12 E V/(4 L)), V = L³/(6 √2), in units of E L²:
  // (3 + 6/8 + 9 w²) k/(E L) = 0.4 · 3 · 3 √(2/3) · √3/12 + 9 w²/(6 √2).
  constexpr double side = 0.03, E = 5000;
  const double h = side / std::sqrt(8.);
  Body body =
      listed_body({{h, h, h}, {h, -h, -h}, {-h, h, -h}, {-h, -h, h}}, {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}});
  body.tetrahedra = {{0, 2, 1, 3}};
  REQUIRE(signed_volume(body.rest, body.tetrahedra[0]) > 0);
  const VectorX k = Patch{}.constants(body, material_of(E));
  const double w2 = kPatchVolumeWeight * kPatchVolumeWeight, root2 = std::sqrt(2.);
  const double expected = (0.3 * root2 + 1.5 * w2 / root2) / (3.75 + 9 * w2) * E * side;
  CHECK((k.array() / expected - 1).abs().maxCoeff() < 1e-5);
}

TEST_CASE("patch on bodies without cells", "[patch][slow]") {
  Body body = random_packing({1, 1, 1}, 0.15, 0.225, GENERATE(1, 2));
  CHECK(!Patch::unsuited(body).empty());
  body.voronoi = voronoi_cells(body);
  CHECK(Patch::unsuited(body).empty());
  const VectorX k = Patch{}.constants(body, material_of(1));
  CHECK(k.minCoeff() >= 0);
  // Springs that meet in balance cannot be stiffer than the solid they stand for, Σ k L² = 6 E V; and the volume
  // equations keep them within some per cent of it, though 12 neighbours are too few to balance.
  const Eigen::Map<const VectorX> length(body.connections.rest_length.data(), body.connections.size());
  const double affine = k.dot(length.cwiseAbs2()) / (6 * body.voronoi->volume.sum());
  CHECK(affine > 0.93);
  CHECK(affine < 1.005);
}

TEST_CASE("fibres as springs lie on the connections along them, with their share of the section", "[patch][fibre]") {
  const bool space_diagonals = GENERATE(false, true);
  constexpr double spacing = 0.02;
  const Vector3 size = spacing * Vector3(2, 3, 4);
  const Body body = cubic_lattice({3, 4, 5}, spacing, {true, true, space_diagonals});
  const VectorX sections = fibre_sections(body, Vector3::UnitZ());
  for (int c = 0; c < body.connections.size(); ++c) {
    const auto [a, b] = body.connections.ends[c];
    const Vector3 gap = body.rest.col(b) - body.rest.col(a), side = sides(body.rest.col(a), size);
    // A row of connections has the section h² in the body, half of it on a face, a quarter on an edge: w = section/h.
    const double share = 1 / std::pow(2, side.head<2>().squaredNorm());
    const double expected = std::abs(gap.z()) > 0.99 * gap.norm() ? share * spacing : 0;
    CHECK(sections[c] == Approx(expected).margin(1e-5 * spacing));
  }
}

TEST_CASE("fibres as springs balance a uniform strain along a face diagonal too", "[patch][fibre]") {
  constexpr double spacing = 0.02;
  const Vector3 size = spacing * Vector3(3, 4, 5), a = Vector3(1, 1, 0).normalized();
  const Body body = cubic_lattice({4, 5, 6}, spacing, {true, true, false});
  const VectorX sections = fibre_sections(body, a);
  Matrix3 strain;
  strain << 1, .3, -.7, .3, -.4, .5, -.7, .5, .2;
  const Matrix3 stress = a.dot(strain * a) * a * a.transpose();
  Positions force(3, body.size());
  for (int molecule = 0; molecule < body.size(); ++molecule)
    force.col(molecule) = stress * lattice_surface(body.rest.col(molecule), size, spacing);
  for (int c = 0; c < body.connections.size(); ++c) {
    const auto [first, second] = body.connections.ends[c];
    const Vector3 gap = body.rest.col(second) - body.rest.col(first);
    const Vector3 tension = sections[c] * gap * gap.dot(strain * gap) / gap.squaredNorm();
    force.col(first) += tension;
    force.col(second) -= tension;
  }
  double worst = 0;
  for (int molecule = 0; molecule < body.size(); ++molecule)
    if (sides(body.rest.col(molecule), size).isZero(0)) worst = std::max(worst, force.col(molecule).norm());
  // Inside. On the edges of the body a diagonal has no neighbour to share its load with.
  CHECK(worst < 2e-5 * stress.norm() * spacing * spacing);
}

TEST_CASE("patch says what it needs", "[patch]") {
  CHECK(Patch::unsuited(cube(3, false)).empty());
  CHECK(Patch::unsuited(tetrahedral_block(BlockKind::kuhn, {1, 1, 1}, {1, 1, 1})).empty());
  CHECK(Patch::unsuited(listed_body({{0, 0, 0}, {1, 0, 0}}, {{0, 1}})) ==
        "needs tetrahedra, cubes or the Voronoi cells of its molecules");
  Body flat = cubic_lattice({3, 3, 1}, 1, {});
  flat.voronoi = voronoi_cells(flat);
  CHECK(Patch::unsuited(flat) == "needs molecules that do not lie in one plane");
}
