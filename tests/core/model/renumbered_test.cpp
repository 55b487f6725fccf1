#include "elastin/core/model/renumbered.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>

#include "elastin/core/forces/model.h"
#include "elastin/core/shapes/shapes.h"
#include "elastin/core/simulation/catalog.h"
#include "support/bodies.h"

using namespace elastin;
using namespace elastin::testing;

namespace {

double mean_span(const Connections& connections) {
  double sum = 0;
  for (const auto& [a, b] : connections.ends) sum += std::abs(a - b);
  return sum / connections.size();
}

/// The body with its molecules numbered by steps of 0.618 of their count: each far from the one before.
Body scattered(Body body) {
  const int count = body.size();
  int step = static_cast<int>(0.618 * count);
  while (std::gcd(step, count) != 1) ++step;
  const auto number = [&](int molecule) { return static_cast<int>(static_cast<long long>(molecule) * step % count); };
  const Body before = body;
  for (int a = 0; a < count; ++a) {
    body.rest.col(number(a)) = before.rest.col(a);
    body.mass[number(a)] = before.mass[a], body.radius[number(a)] = before.radius[a];
  }
  const auto renumber = [&](auto& cells) {
    for (auto& cell : cells)
      for (int& node : cell) node = number(node);
  };
  renumber(body.connections.ends), renumber(body.triangles), renumber(body.tetrahedra), renumber(body.cubes);
  for (CellBlock& block : body.blocks)
    for (int& node : block.nodes) node = number(node);
  body.grid.reset();
  return body;
}

Positions forces_at(const Body& body, const char* strategy, const Positions& positions) {
  Model model(body);
  Material material;
  material.youngs_modulus = 1e4, material.poissons_ratio = 0.3, material.thickness = 1e-3;
  model.add(built_in_catalog().find(strategy).make(body, material, {}));
  return model.elastic_forces(positions);
}

void check(const Body& body, const char* strategy) {
  INFO(strategy << " on " << body.size() << " molecules");
  const RenumberedBody ordered = numbered_in_space(body);
  REQUIRE(ordered.body.size() == body.size());
  REQUIRE(ordered.body.connections.size() == body.connections.size());
  CHECK(ordered.body.connections.cell_sides == body.connections.cell_sides);
  const Positions positions = deformed(body, 2e-5);
  const Positions before = forces_at(body, strategy, positions);
  const Positions after = forces_at(ordered.body, strategy, positions(Eigen::all, ordered.molecule_from));
  const Positions same = before(Eigen::all, ordered.molecule_from);
  CHECK((after - same).norm() <= 1e-12 * same.norm());  // sums in another order
  CHECK(ordered.body.mass == body.mass(ordered.molecule_from));
  for (int c = 0; c < body.connections.size(); ++c)
    CHECK(ordered.body.connections.rest_length[c] == body.connections.rest_length[ordered.connection_from[c]]);
}

}  // namespace

TEST_CASE("a body numbered along a curve that fills space has the same forces", "[numbering]") {
  Body block = jittered_block();
  set_region(block, {0, 0, 0}, {0.015, 0.02, 0.02}, 3, 2);
  const Body springs = scattered(jittered_lattice()), cells = scattered(block);
  check(springs, "standard");
  check(cells, "van_gelder");
  check(cells, "neo_hookean");
  check(scattered(cell_box(cell_kind("hexahedron8"), {4, 3, 3}, {0.04, 0.03, 0.03}, 0.1)), "neo_hookean");
  check(scattered(sheet(1e-3)), "st_venant_kirchhoff_membrane");
}

TEST_CASE("in the order of the curve neighbours have numbers that are near", "[numbering]") {
  Body lattice = cubic_lattice({16, 16, 16}, 1e-3, {true, false, false});
  set_matter(lattice, 5e-4, 1000, 0, 0);
  const double own = mean_span(lattice.connections), before = mean_span(scattered(lattice).connections);
  REQUIRE(before > 10 * own);
  CHECK(mean_span(numbered_in_space(scattered(lattice)).body.connections) < 1.2 * own);
}

TEST_CASE("a body that is in order keeps its molecules near, and bodies of parts their numbers", "[numbering]") {
  const Body line = listed_body({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1}, {1, 2}});
  const RenumberedBody same = numbered_in_space(line);
  CHECK(same.molecule_from == std::vector{0, 1, 2});
  CHECK(same.connection_from == std::vector{0, 1});
  Body parts = line;
  parts.parts.emplace_back();
  CHECK_THROWS_WITH(numbered_in_space(parts), Catch::Contains("keeps its numbers"));
}
