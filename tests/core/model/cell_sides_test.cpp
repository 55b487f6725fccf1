#include <algorithm>
#include <catch2/catch.hpp>
#include <map>

#include "elastin/core/simulation/catalog.h"
#include "support/bodies.h"

using namespace elastin;
using namespace elastin::testing;

namespace {

const Material kMaterial{.youngs_modulus = 5000, .poissons_ratio = 0.3, .density = 1000, .thickness = 0};

/// The jittered block as it is, and with every second of its connections no connection proper.
Body whole() { return jittered_block(); }
Body thinned() {
  Body body = whole();
  const auto all = body.connections.ends;
  body.connections.ends.clear();
  for (std::size_t c = 0; c < all.size(); c += 2) body.connections.ends.push_back({all[c][1], all[c][0]});
  set_present_lengths(body);
  return body;
}

using ByPair = std::map<std::array<int, 2>, double>;
ByPair by_pair(const Body& body, const VectorX& values) {
  ByPair result;
  for (int c = 0; c < body.connections.size(); ++c) {
    auto pair = body.connections.ends[c];
    std::sort(pair.begin(), pair.end());
    result[pair] = values[c];
  }
  return result;
}

}  // namespace

TEST_CASE("sides of cells come last, ascending, and each only if it is no connection yet", "[cell_sides]") {
  Body body = thinned();
  const int proper = body.connections.size();
  add_cell_sides(body, sides_of(body.tetrahedra));
  CHECK(body.connections.proper() == proper);
  CHECK(body.connections.size() == whole().connections.size());
  const auto& ends = body.connections.ends;
  CHECK(std::is_sorted(ends.begin() + proper, ends.end()));
  for (int c = 0; c < body.connections.size(); ++c) {
    const auto [a, b] = ends[c];
    REQUIRE(body.connections.rest_length[c] == (body.rest.col(b) - body.rest.col(a)).norm());
  }
  // Once more, from two lots: nothing new, and still in order.
  Body twice = thinned();
  add_cell_sides(twice, {{body.tetrahedra[5][3], body.tetrahedra[5][0]}});
  add_cell_sides(twice, sides_of(body.tetrahedra));
  CHECK(twice.connections.ends == ends);
  CHECK(without_cell_sides(twice).connections.ends == thinned().connections.ends);
}

TEST_CASE("only rules and laws that work on cells give sides of cells a stiffness", "[cell_sides]") {
  const Body plain = thinned(), full = whole();
  Body body = plain;
  add_cell_sides(body, sides_of(body.tetrahedra));
  const Catalog catalog = built_in_catalog();
  for (const std::string rule : {"standard", "statistical", "angles", "uniform", "patch"}) {
    CAPTURE(rule);
    const VectorX k = catalog.find(rule).constants(body, kMaterial, {});
    CHECK(k.head(plain.connections.size()) == catalog.find(rule).constants(plain, kMaterial, {}));
    CHECK(k.tail(body.connections.cell_sides).isZero(0));
  }
  for (const std::string rule : {"van_gelder", "van_gelder_simplified", "lloyd"})
    CHECK(by_pair(body, catalog.find(rule).constants(body, kMaterial, {})) ==
          by_pair(full, catalog.find(rule).constants(full, kMaterial, {})));
  const Positions positions = deformed(full, 1e-4);
  const auto force_densities = [&](const std::string& law, const Body& of) {
    VectorX q = VectorX::Zero(of.connections.size());
    Workspace workspace;
    Model model(of);
    model.add(catalog.find(law).make(of, kMaterial, {}));
    for (const auto* edges : model.edge_laws()) edges->add_force_densities(positions, q, workspace);
    return q;
  };
  CHECK(by_pair(body, force_densities("neo_hookean", body)) == by_pair(full, force_densities("neo_hookean", full)));
  const VectorX updated = force_densities("angles_update", body);
  CHECK(updated.head(plain.connections.size()) == force_densities("angles_update", plain));
  CHECK(updated.tail(body.connections.cell_sides).isZero(0));
}

TEST_CASE("pieces are those of the connections proper", "[cell_sides]") {
  Body body = whole();
  body.connections = {};
  add_cell_sides(body, sides_of(body.tetrahedra));
  CHECK(inspect(body).pieces == body.size());
  CHECK(static_cast<int>(inspect(body).isolated_molecules.size()) == body.size());
}
