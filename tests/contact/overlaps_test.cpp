#include "contact/overlaps.h"

#include <catch2/catch.hpp>
#include <set>

#include "support/bodies.h"

using namespace elastin;
using namespace elastin::contact;
using namespace elastin::testing;

TEST_CASE("overlapping spheres equal all pairs tried, but for those that a connection joins", "[contact]") {
  Body body = jittered_lattice(0.3);
  for (int molecule = 0; molecule < body.size(); ++molecule) body.radius[molecule] = 0.004 + 0.0001 * molecule;
  body.connections.ends.resize(40);  // so that many neighbours are not joined
  body.connections.rest_length.resize(40);
  const std::set<std::array<int, 2>> joined(body.connections.ends.begin(), body.connections.ends.end());
  const Positions positions = deformed(body, 1e-3);
  std::vector<Overlap> expected;
  for (int a = 0; a < body.size(); ++a)
    for (int b = a + 1; b < body.size(); ++b) {
      const double depth = body.radius[a] + body.radius[b] - (positions.col(b) - positions.col(a)).norm();
      if (depth > 1e-6 * std::min(body.radius[a], body.radius[b]) && !joined.count({a, b}))
        expected.push_back({a, b, depth});
    }
  REQUIRE(expected.size() > 20);
  const std::vector<Overlap> found = find_overlaps(body, positions);
  REQUIRE(found.size() == expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    CHECK(found[i].first == expected[i].first);
    CHECK(found[i].second == expected[i].second);
    CHECK(found[i].depth == Approx(expected[i].depth).epsilon(1e-12));
  }
}

TEST_CASE("spheres that touch do not overlap", "[contact]") {
  Body body = listed_body({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}}, {});
  set_matter(body, 0.5, 1000, 0, 1);
  CHECK(find_overlaps(body, body.rest).empty());
  body.radius[2] = 0.6;
  const auto found = find_overlaps(body, body.rest);
  REQUIRE(found.size() == 1);
  CHECK(found[0].depth == Approx(0.1));
}
