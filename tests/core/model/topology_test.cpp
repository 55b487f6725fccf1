// Bodies that are cut, torn and bereft of cells: what is left keeps its volume, its masses and its stiffness.

#include "elastin/core/model/topology.h"

#include <catch2/catch.hpp>
#include <numeric>

#include "core/simulation/tissues.h"
#include "elastin/core/base/error.h"
#include "elastin/core/shapes/shapes.h"

using namespace elastin;
using namespace elastin::testing;
using Catch::Contains;

namespace {

constexpr double kDensity = 1000;  // kg/m³

/// n³ cubes of a millimetre, six tetrahedra each.
Body block(int n) {
  Body body = tetrahedral_block(BlockKind::kuhn, {n, n, n}, Vector3::Constant(n * 1e-3));
  set_matter(body, 5e-4, kDensity, 0, 0);
  return body;
}

double volume(const Body& body) {
  double sum = 0;
  for (const auto& cell : body.tetrahedra) sum += signed_volume(body.rest, cell);
  return sum;
}

/// What a plane x = of the block leaves behind it, by the cells' middles.
CutSurface across_x(double x) { return CutSurface::plane({x, 0, 0}, {1, 0, 0}); }

void check_shares(const Body& before, const ChangedBody& changed) {
  const int n = changed.body.size(), count = changed.body.connections.size();
  REQUIRE(static_cast<int>(changed.molecule_from.size()) == n);
  REQUIRE(static_cast<int>(changed.connection_from.size()) == count);
  VectorX stiffness = VectorX::Zero(before.connections.size());
  for (int c = 0; c < count; ++c) {
    const auto own = static_cast<std::size_t>(c);
    const int from = changed.connection_from[own];
    stiffness[from] += changed.connection_share[own];
    for (int end = 0; end < 2; ++end)
      CHECK(changed.molecule_from[changed.body.connections.ends[own][end]] == before.connections.ends[from][end]);
    CHECK(changed.body.connections.rest_length[own] == before.connections.rest_length[from]);
  }
  for (int c = 0; c < before.connections.size(); ++c)
    if (stiffness[c] > 0) CHECK(stiffness[c] == Approx(1).epsilon(1e-14));
  for (int molecule = 0; molecule < n; ++molecule)
    CHECK(changed.body.rest.col(molecule) == before.rest.col(changed.molecule_from[molecule]));
}

}  // namespace

TEST_CASE("a plane between layers of cells makes two bodies with the old volume and masses", "[topology]") {
  const Body body = block(4);
  const ChangedBody changed = cut(body, body.rest, across_x(2e-3));
  CHECK(changed.split_molecules == 25);
  CHECK(changed.removed_connections == 0);
  CHECK(changed.body.size() == 150);
  CHECK(inspect(changed.body).pieces == 2);
  CHECK(volume(changed.body) == volume(body));  // bitwise: the same cells in the same order
  CHECK(changed.body.mass.sum() == Approx(body.mass.sum()).epsilon(1e-14));
  const VectorX lumped = lumped_mass(changed.body.rest, {}, changed.body.tetrahedra, kDensity, 0);
  CHECK((changed.body.mass - lumped).cwiseAbs().maxCoeff() < 1e-14 * lumped.maxCoeff());
  check_shares(body, changed);
  for (const auto& cell : changed.body.tetrahedra) {  // nothing reaches over the plane
    double low = 1, high = 0;
    for (const int molecule : cell)
      low = std::min(low, changed.body.rest(0, molecule)), high = std::max(high, changed.body.rest(0, molecule));
    CHECK((high < 2.0001e-3 || low > 1.9999e-3));
  }
}

TEST_CASE("an oblique plane through a strained body parts it in two, too", "[topology]") {
  const Body body = block(4);
  Positions strained = body.rest;
  strained.row(2) += 0.3 * body.rest.row(0);
  const CutSurface plane = CutSurface::plane({2.1e-3, 1.9e-3, 2.2e-3}, {1, 0.3, 0.5});
  const ChangedBody changed = cut(body, strained, plane);
  CHECK(inspect(changed.body).pieces == 2);
  CHECK(volume(changed.body) == volume(body));
  const VectorX lumped = lumped_mass(changed.body.rest, {}, changed.body.tetrahedra, kDensity, 0);
  CHECK((changed.body.mass - lumped).cwiseAbs().maxCoeff() < 1e-14 * lumped.maxCoeff());
  check_shares(body, changed);
  CHECK_FALSE(cut(changed.body, strained(Eigen::all, changed.molecule_from), plane).changed);  // once is enough
}

TEST_CASE("a blade leaves the tip of its cut whole, and two of them meet", "[topology]") {
  const Body body = block(4);
  const auto blade = [](double from, double to) {
    return CutSurface::blade({Vector3(from, -1, 2e-3), Vector3(from, 1, 2e-3)},
                             {Vector3(to, -1, 2e-3), Vector3(to, 1, 2e-3)});
  };
  const ChangedBody first = cut(body, body.rest, blade(-1, 2e-3));
  CHECK(first.split_molecules == 10);  // x = 0 and 1 mm; those at 2 mm are the tip
  CHECK(inspect(first.body).pieces == 1);
  const ChangedBody second = cut(first.body, first.body.rest, blade(2e-3, 1));
  CHECK(second.split_molecules == 15);
  CHECK(inspect(second.body).pieces == 2);
  CHECK(volume(second.body) == volume(body));
  const ChangedBody nothing = cut(body, body.rest, blade(-1, -0.5));
  CHECK_FALSE(nothing.changed);
  CHECK(nothing.body.connections.ends == body.connections.ends);
}

TEST_CASE("lattices are split between cubes, sheets between triangles, springs alone across", "[topology]") {
  Body lattice = tissue_cube(5);
  const ChangedBody cubes = cut(lattice, lattice.rest, across_x(4e-3));
  CHECK(cubes.split_molecules == 25);
  CHECK(inspect(cubes.body).pieces == 2);
  CHECK_FALSE(cubes.body.grid.has_value());
  CHECK(cubes.body.mass.sum() == Approx(lattice.mass.sum()).epsilon(1e-14));
  check_shares(lattice, cubes);

  Body springs = lattice;
  springs.cubes.clear();
  const ChangedBody apart = cut(springs, springs.rest, across_x(3e-3));  // between two layers
  CHECK(apart.split_molecules == 0);
  CHECK(apart.removed_connections == 25 + 4 * 20);  // axes, and two face diagonals in each of two planes
  CHECK(inspect(apart.body).pieces == 2);
  CHECK(apart.body.mass == springs.mass);

  Body sheet = block(4);
  sheet.tetrahedra.clear(), sheet.triangles.clear();
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 4; ++x) {
      const int a = x + 5 * y;
      sheet.triangles.push_back({a, a + 1, a + 6}), sheet.triangles.push_back({a, a + 6, a + 5});
    }
  sheet.rest = Positions(sheet.rest.leftCols(25));
  sheet.connections = connections_of_cells(sheet.rest, sheet.triangles, {});
  sheet.mass = VectorX::Ones(25), sheet.radius = VectorX::Ones(25);
  const ChangedBody parted = cut(sheet, sheet.rest, across_x(2e-3));
  CHECK(parted.split_molecules == 5);
  CHECK(inspect(parted.body).pieces == 2);
  CHECK(parted.body.mass.sum() == Approx(25).epsilon(1e-14));
}

TEST_CASE("cells that are removed take their mass with them, and the molecules that they leave alone", "[topology]") {
  const Body body = block(2);
  std::vector<int> corner;  // all cells at the last molecule
  double lost = 0;
  for (std::size_t cell = 0; cell < body.tetrahedra.size(); ++cell) {
    const auto& own = body.tetrahedra[cell];
    if (std::find(own.begin(), own.end(), 26) == own.end()) continue;
    corner.push_back(static_cast<int>(cell));
    lost += signed_volume(body.rest, own);
  }
  const ChangedBody changed = without(body, {}, corner);
  CHECK(changed.removed_cells == static_cast<int>(corner.size()));
  CHECK(changed.body.size() == 26);
  CHECK(volume(changed.body) == Approx(volume(body) - lost).epsilon(1e-14));
  CHECK(changed.body.mass.sum() == Approx(kDensity * (volume(body) - lost)).epsilon(1e-13));
  check_shares(body, changed);
  CHECK_THROWS_WITH(without(body, {}, {48}), Contains("no cell 48: there are 48"));
  CHECK_THROWS_WITH(without(body, {0}, {}), Contains("connection 0 is a side of cells that stay"));
  std::vector<int> all(body.tetrahedra.size());
  std::iota(all.begin(), all.end(), 0);
  CHECK_THROWS_WITH(without(body, {}, all), Contains("nothing would be left"));
}

TEST_CASE("a bar tears across its pull where it is strained most", "[topology]") {
  Body bar = tetrahedral_block(BlockKind::kuhn, {8, 2, 2}, {8e-3, 2e-3, 2e-3});
  set_matter(bar, 5e-4, kDensity, 0, 0);
  Positions pulled = bar.rest;  // the strain is largest, 0.3, in the middle
  for (int molecule = 0; molecule < bar.size(); ++molecule) {
    const double x = bar.rest(0, molecule) - 4e-3;
    pulled(0, molecule) += 0.3 * 2e-3 * std::tanh(x / 2e-3);
  }
  CHECK_FALSE(tear(bar, pulled, 0.31).changed);
  int torn = 0;
  Body body = bar;
  for (ChangedBody next = tear(body, pulled, 0.2); next.changed; next = tear(body, pulled, 0.2)) {
    torn += next.split_molecules;
    for (std::size_t molecule = static_cast<std::size_t>(body.size()); molecule < next.molecule_from.size(); ++molecule)
      CHECK(next.body.rest(0, molecule) == Approx(4e-3).margin(1.5e-3));
    pulled = Positions(pulled(Eigen::all, next.molecule_from));
    body = next.body;
    REQUIRE(torn < 200);
  }
  CHECK(torn > 0);
  CHECK(volume(body) == volume(bar));
  CHECK(body.mass.sum() == Approx(bar.mass.sum()).epsilon(1e-13));

  Body springs = tissue_cube(4);
  springs.cubes.clear();
  Positions stretched = springs.rest;
  stretched.row(0) *= 1.2;
  const ChangedBody apart = tear(springs, stretched, 0.15);  // along x 0.2, its diagonals 0.104
  CHECK(apart.removed_connections == 48);
  CHECK_THROWS_WITH(tear(springs, stretched, 0), Contains("strain of 0 is out of range"));
}

TEST_CASE("what cannot be split is refused, and so is an invalid surface", "[topology]") {
  CHECK_THROWS_WITH(CutSurface::plane({0, 0, 0}, {0, 0, 0}), Contains("normal that is not zero"));
  CHECK_THROWS_WITH(CutSurface::triangles(Positions::Zero(3, 2), {{0, 1, 2}}), Contains("corner 2; there are 2"));
  Body parts = block(2);
  parts.parts.emplace_back().name = "a";
  CHECK_THROWS_WITH(cut(parts, parts.rest, across_x(1e-3)), Contains("several parts"));
}
