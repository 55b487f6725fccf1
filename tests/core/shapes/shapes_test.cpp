#include "elastin/core/shapes/shapes.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>

#include "elastin/core/base/error.h"

using namespace elastin;

namespace {

double shortest_distance(const Positions& positions) {
  double least = INFINITY;
  for (int a = 0; a < positions.cols(); ++a)
    for (int b = 0; b < a; ++b) least = std::min(least, (positions.col(a) - positions.col(b)).norm());
  return least;
}

std::vector<int> neighbour_counts(const Body& body) {
  std::vector<int> counts(static_cast<std::size_t>(body.size()), 0);
  for (const auto& [a, b] : body.connections.ends) ++counts[a], ++counts[b];
  return counts;
}

}  // namespace

TEST_CASE("cubic lattices have the molecules and connections of the papers", "[model]") {
  struct Case {
    std::array<int, 3> molecules;
    CubicPattern pattern;
    int connections;
  };
  // 27 and 1000 molecules: [M03] Tables 1 and 2; 22^3 and 47^3: 3n²(n−1) axis and 6n(n−1)² face connections.
  const std::vector<Case> cases{{{1, 1, 2}, {true, false, false}, 1},      {{3, 3, 3}, {true, false, false}, 54},
                                {{3, 3, 3}, {true, true, false}, 126},     {{3, 3, 3}, {true, true, true}, 158},
                                {{10, 10, 10}, {true, true, false}, 7560}, {{22, 22, 22}, {true, true, false}, 88704}};
  for (const Case& c : cases) {
    const Body body = cubic_lattice(c.molecules, 0.5, c.pattern);
    CHECK(body.size() == c.molecules[0] * c.molecules[1] * c.molecules[2]);
    CHECK(body.connections.size() == c.connections);
    for (int i = 0; i < body.connections.size(); ++i) {
      const auto& [a, b] = body.connections.ends[i];
      const double squared = std::pow(body.connections.rest_length[i] / 0.5, 2);
      REQUIRE(squared == Approx(std::round(squared)).epsilon(1e-12));
      REQUIRE(squared < 3.5);
      REQUIRE(a != b);
    }
    CHECK(inspect(body).duplicate_connections.empty());
  }
}

TEST_CASE("body- and face-centred lattices have their coordination numbers inside", "[model]") {
  const auto most = [](const Body& body) {
    const auto counts = neighbour_counts(body);
    return *std::max_element(counts.begin(), counts.end());
  };
  CHECK(most(body_centred_lattice({3, 3, 3}, 2, false)) == 8);
  CHECK(most(body_centred_lattice({3, 3, 3}, 2, true)) == 14);
  CHECK(most(face_centred_lattice({3, 3, 3}, 2, false)) == 12);
  CHECK(most(face_centred_lattice({3, 3, 3}, 2, true)) == 18);
  CHECK(body_centred_lattice({3, 3, 3}, 2, false).size() == 64 + 27);
  CHECK(face_centred_lattice({3, 3, 3}, 2, false).size() == 64 + 3 * 4 * 9);
}

TEST_CASE("tetrahedral blocks fill their box with positive cells that share whole faces", "[model]") {
  const Vector3 size(0.2, 0.3, 0.4);
  for (const auto& [kind, inner_cells] :
       {std::pair{BlockKind::kuhn, 6}, {BlockKind::alternating, 5}, {BlockKind::body_centred, 12}}) {
    const Body body = tetrahedral_block(kind, {4, 3, 2}, size);
    double volume = 0;
    std::vector<std::array<int, 3>> faces;
    for (const auto& t : body.tetrahedra) {
      REQUIRE(signed_volume(body.rest, t) > 0);
      volume += signed_volume(body.rest, t);
      for (int skip = 0; skip < 4; ++skip) {
        std::array<int, 3> face{};
        int slot = 0;
        for (int i = 0; i < 4; ++i)
          if (i != skip) face[slot++] = t[i];
        std::sort(face.begin(), face.end());
        faces.push_back(face);
      }
    }
    CHECK(volume == Approx(size.prod()).epsilon(1e-12));
    // A face belongs to two cells, or to one and lies on the box: so the single ones have the box's surface.
    std::sort(faces.begin(), faces.end());
    double surface = 0;
    for (std::size_t i = 0; i < faces.size();) {
      const std::size_t same =
          static_cast<std::size_t>(std::upper_bound(faces.begin() + static_cast<long>(i), faces.end(), faces[i]) -
                                   faces.begin()) -
          i;
      REQUIRE(same <= 2);
      if (same == 1) {
        const auto& [a, b, c] = faces[i];
        const Vector3 ab = body.rest.col(b) - body.rest.col(a), ac = body.rest.col(c) - body.rest.col(a);
        surface += ab.cross(ac).norm() / 2;
      }
      i += same;
    }
    CHECK(surface == Approx(2 * (0.2 * 0.3 + 0.3 * 0.4 + 0.2 * 0.4)).epsilon(1e-12));
    CHECK(inspect(body).pieces == 1);
    if (kind != BlockKind::body_centred) CHECK(body.tetrahedra.size() == static_cast<std::size_t>(inner_cells) * 24);
    // 12 a cube inside; a surface face has 2 instead of its half of 4: the same number.
    if (kind == BlockKind::body_centred) CHECK(body.tetrahedra.size() == 12u * 24u);
  }
}

TEST_CASE("a random packing keeps its distance, its density and its seed", "[model][slow]") {
  const Vector3 size(0.012, 0.010, 0.014);
  const double distance = 0.001;
  const Body one = random_packing(size, distance, 1.5 * distance, 7),
             same = random_packing(size, distance, 1.5 * distance, 7),
             other = random_packing(size, distance, 1.5 * distance, 8);
  CHECK(shortest_distance(one.rest) >= distance);
  CHECK(one.rest == same.rest);
  CHECK((one.size() != other.size() || one.rest != other.rest));
  CHECK((one.rest.array() >= 0).all());
  CHECK((one.rest.colwise() - size).maxCoeff() <= 0);
  // Random close packing is 0.64 in the bulk; walls and a gap of 0.1 % cost some of it.
  const double filled = one.size() * std::numbers::pi / 6 * std::pow(distance, 3) / (size.array() + distance).prod();
  CHECK(filled > 0.56);
  CHECK(filled < 0.64);
  for (const double length : one.connections.rest_length) REQUIRE(length <= 1.5 * distance);
}

TEST_CASE("connections by distance equal all pairs tried", "[model]") {
  const Body body = random_packing({0.5, 0.3, 0.2}, 0.06, 0.1, 3);
  std::vector<std::array<int, 2>> wanted;
  for (int a = 0; a < body.size(); ++a)
    for (int b = a + 1; b < body.size(); ++b)
      if ((body.rest.col(a) - body.rest.col(b)).norm() <= 0.1) wanted.push_back({a, b});
  CHECK(body.connections.ends == wanted);
  // Places below zero and far from it fall into other buckets, not into other answers.
  Positions moved = body.rest;
  moved.colwise() += Vector3(-3.21, 100, -0.05);
  CHECK(connections_within(moved, 0.1).ends.size() == wanted.size());
}

TEST_CASE("jitter moves the inside, keeps the faces plane and the body unstressed", "[model]") {
  Body body = cubic_lattice({4, 4, 4}, 1, {true, true, false});
  const Positions before = body.rest;
  add_jitter(body, 0.15, 5);
  CHECK((body.rest - before).cwiseAbs().maxCoeff() <= 0.15);
  CHECK((body.rest - before).cwiseAbs().maxCoeff() > 0.1);
  for (int i = 0; i < body.size(); ++i)
    for (int axis = 0; axis < 3; ++axis)
      if (before(axis, i) == 0 || before(axis, i) == 3) REQUIRE(body.rest(axis, i) == before(axis, i));
  for (int c = 0; c < body.connections.size(); ++c) {
    const auto& [a, b] = body.connections.ends[c];
    REQUIRE(body.connections.rest_length[c] == (body.rest.col(b) - body.rest.col(a)).norm());
  }
}

TEST_CASE("masses add up to the body's", "[model]") {
  Body block = tetrahedral_block(BlockKind::kuhn, {3, 2, 2}, {0.3, 0.2, 0.2});
  set_matter(block, 0.01, 1100, 0, 0);
  CHECK(block.mass.sum() == Approx(1100 * 0.3 * 0.2 * 0.2).epsilon(1e-12));
  CHECK(block.mass.minCoeff() > 0);
  Body lattice = cubic_lattice({3, 3, 3}, 0.1, {});
  set_matter(lattice, 0.05, 1000, 0, 0.008);
  CHECK(lattice.mass.sum() == Approx(8).epsilon(1e-12));
}

TEST_CASE("inspect names pieces, isolated molecules and bad connections and cells", "[model]") {
  Body body = listed_body({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {5, 0, 0}, {6, 0, 0}, {9, 9, 9}, {1, 0, 0}},
                          {{0, 1}, {1, 2}, {2, 1}, {3, 4}, {1, 6}});
  body.tetrahedra = {{0, 1, 2, 3}};
  const BodyFindings findings = inspect(body);
  CHECK(findings.pieces == 3);
  CHECK(findings.piece_of == std::vector<int>{0, 0, 0, 1, 1, 2, 0});
  CHECK(findings.isolated_molecules == std::vector<int>{5});
  CHECK(findings.duplicate_connections == std::vector<int>{2});
  CHECK(findings.zero_length_connections == std::vector<int>{4});
  CHECK(findings.flat_or_inverted_cells == std::vector<int>{0});
}

TEST_CASE("a graded body keeps its ends, and its spacings grow by the ratio", "[model]") {
  const double ratio = GENERATE(0.5, 1., 3.);
  Body body = cubic_lattice({3, 2, 9}, 0.01, {true, true, false});
  grade(body, 2, ratio);
  const auto height = [&](int layer) { return body.rest(2, 6 * layer); };
  CHECK(height(0) == 0);
  CHECK(height(8) == Approx(0.08).epsilon(1e-12));
  // s ∝ ratio^u: the spacings of neighbouring layers are in the ratio ratio^(1/8).
  for (int layer = 1; layer < 8; ++layer)
    CHECK((height(layer + 1) - height(layer)) / (height(layer) - height(layer - 1)) ==
          Approx(std::pow(ratio, 1. / 8)).epsilon(1e-10));
  for (int m = 0; m < body.size(); ++m) REQUIRE(body.rest(2, m) == height(m / 6));  // planes stay plane
  for (int c = 0; c < body.connections.size(); ++c) {
    const auto [a, b] = body.connections.ends[c];
    REQUIRE(body.connections.rest_length[c] == (body.rest.col(b) - body.rest.col(a)).norm());
  }
}

TEST_CASE("shapes of impossible sizes are refused", "[shapes]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH(cubic_lattice({0, 1, 1}, 1, {}), Catch::Contains("molecules: 0 along an axis"));
  for (const double spacing : {-1., 0., nan})
    CHECK_THROWS_WITH(cubic_lattice({2, 2, 2}, spacing, {}), Catch::Contains("above 0"));
  CHECK_THROWS_WITH(body_centred_lattice({1, -1, 1}, 1, false), Catch::Contains("cells: -1 along an axis"));
  CHECK_THROWS_WITH(tetrahedral_block(BlockKind::kuhn, {1, 0, 1}, {1, 1, 1}),
                    Catch::Contains("cubes: 0 along an axis"));
  CHECK_THROWS_WITH(tetrahedral_block(BlockKind::kuhn, {1, 1, 1}, {1, -1, 1}), Catch::Contains("a side of -1 m"));
  Body body = cubic_lattice({2, 2, 2}, 1, {});
  CHECK_THROWS_WITH(grade(body, 5, 2), Catch::Contains("axis 5"));
  CHECK_THROWS_WITH(grade(body, 2, -2), Catch::Contains("ratio of spacings of -2"));
}
