#include <catch2/catch.hpp>

#include "core/laws/springs/statistical.h"
#include "elastin/core/simulation/catalog.h"
#include "support/bodies.h"

using namespace elastin;
using namespace elastin::testing;

namespace {

const Material kMaterial{.youngs_modulus = 5000, .poissons_ratio = 0.3, .density = 1000, .thickness = 0.002};

VectorX constants(const std::string& rule, const Body& body, const Material& material = kMaterial,
                  const ParameterValues& values = {}) {
  return built_in_catalog().find(rule).constants(body, material, values);
}

/// Two molecules 15 mm apart with the section of [M03] Table 1 a.
Body pair_of_molecules() {
  Body body = cubic_lattice({1, 1, 2}, 0.015, {});
  set_matter(body, 0.015, 1000, 0, 1);
  return body;
}

}  // namespace

TEST_CASE("a lone connection: E A / L, and twice that by the statistical rule", "[rules]") {
  // [M03] Table 1 a: A = 9 cm², L = 15 mm: 300 N/m.
  for (const auto& [rule, k] :
       {std::pair{"standard", 300.}, {"divided", 80.}, {"angles", 300.}, {"statistical", 600.}, {"uniform", 1.}})
    CHECK(constants(rule, pair_of_molecules())[0] == Approx(k).epsilon(1e-14));
}

TEST_CASE("the statistical rule's sharers, as printed, with its two gaps filled as said", "[rules]") {
  for (const auto& [connections, sharers] : {std::pair{1, 1.},
                                             {3, 3.},
                                             {7, 7.},
                                             {8, 7.},
                                             {9, 8.},
                                             {11, 10.},
                                             {12, 8.},
                                             {13, 9.},
                                             {18, 14.},
                                             {19, 15.},
                                             {20, 10.},
                                             {26, 13.}})
    CHECK(Statistical::sharers(connections) == sharers);
}

TEST_CASE("the angles rule by hand: a right angle and one of 60 degrees", "[rules]") {
  // Connections 0–1 along x, 0–2 along y, 0–3 at 60° to 0–1 in the xz plane, all 1 m; r = 0.5 m: E A / L = 5000 N/m.
  Body body = listed_body({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.5, 0, std::sqrt(0.75)}}, {{0, 1}, {0, 2}, {0, 3}});
  set_matter(body, 0.5, 1000, 0, 1);
  // Only the shared end 0 counts, halved by the mean with the bare end: 1 + cos 60° / 2 = 1.25.
  const VectorX k = constants("angles", body);
  CHECK(k[0] == Approx(5000 / 1.25).epsilon(1e-12));
  CHECK(k[1] == Approx(5000).epsilon(1e-12));
  CHECK(k[2] == Approx(5000 / 1.25).epsilon(1e-12));
  // A neighbour of twice the length counts twice as much with p = 1, the same with p = 0, half with p = −1.
  body.rest.col(3) *= 2;
  for (const auto& [exponent, share] : {std::pair{1., 0.5}, {0., 0.25}, {-1., 0.125}})
    CHECK(constants("angles", body, kMaterial, {{"exponent", exponent}})[0] ==
          Approx(5000 / (1 + share)).epsilon(1e-12));
}

TEST_CASE("van_gelder: one regular tetrahedron and one right triangle by hand", "[rules]") {
  Body tetrahedron = listed_body({{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}}, {});
  tetrahedron.tetrahedra = {{0, 2, 1, 3}};
  tetrahedron.connections = connections_of_cells(tetrahedron.rest, {}, tetrahedron.tetrahedra);
  // V = 8/3, L² = 8.
  CHECK((constants("van_gelder", tetrahedron).array() - 5000. / 3).abs().maxCoeff() < 1e-9);
  CHECK((constants("lloyd", tetrahedron).array() - 24. / 25 * 5000 / 3).abs().maxCoeff() < 1e-9);

  Body triangle = listed_body({{0, 0, 0}, {3, 0, 0}, {0, 4, 0}}, {});
  triangle.triangles = {{0, 1, 2}};
  triangle.connections = connections_of_cells(triangle.rest, triangle.triangles, {});
  // [TP eq. 1] with |T| = 6, E t = 10, ν = 0.3: side 3 has the others 4 and 5.
  const double stretch = 10 / 1.3, shear = 10 * 0.3 / (1 - 0.09) / (8 * 6);
  const VectorX k = constants("van_gelder", triangle);
  CHECK(k[0] == Approx(stretch * 6 / 9 + shear * (16 + 25 - 9)).epsilon(1e-12));
  CHECK(k[1] == Approx(stretch * 6 / 16 + shear * (9 + 25 - 16)).epsilon(1e-12));
  CHECK(k[2] == Approx(stretch * 6 / 25 + shear * (9 + 16 - 25)).epsilon(1e-12));
}

TEST_CASE("van_gelder is negative across an obtuse angle", "[rules]") {
  Body triangle = listed_body({{0, 0, 0}, {10, 0, 0}, {5, 0.5, 0}}, {});
  triangle.triangles = {{0, 1, 2}};
  triangle.connections = connections_of_cells(triangle.rest, triangle.triangles, {});
  CHECK(constants("van_gelder", triangle)[0] < 0);
  CHECK(constants("van_gelder_simplified", triangle).minCoeff() > 0);
}

TEST_CASE("lloyd on triangles is van_gelder_simplified", "[rules]") {
  const Body body = sheet(kMaterial.thickness);
  const VectorX one = constants("lloyd", body), other = constants("van_gelder_simplified", body);
  CHECK((one - other).norm() <= 1e-13 * other.norm());
}

TEST_CASE("lattice: full constants inside, shares on faces and edges", "[rules]") {
  Body body = cubic_lattice({3, 3, 3}, 0.01, {true, true, false});
  set_matter(body, 0.005, 1000, 0, 1);
  const VectorX k = constants("lattice", body);
  const double full = 0.4 * 5000 * 0.01;  // k₁ = k₂ = 0.4 E a
  // An axis connection touches 4 cubes inside, 2 on a face, 1 on an edge of the body; a face diagonal 2 or 1.
  for (int c = 0; c < k.size(); ++c) {
    const auto& [a, b] = body.connections.ends[c];
    const Vector3 middle = (body.rest.col(a) + body.rest.col(b)) / 0.02;
    const int outside = static_cast<int>((middle.array() < 1e-9 || middle.array() > 2 - 1e-9).count());
    CHECK(k[c] == Approx(full / std::pow(2, outside)).epsilon(1e-12));
  }
  // k₁ = k₂ + 8/3 k₃ and 2.5 (k₂ + 4/3 k₃)/a = E whatever part the faces carry.
  Body rich = cubic_lattice({3, 3, 3}, 0.01, {true, true, true});
  for (const double part : {0.2, 0.5, 0.9}) {
    const VectorX shared = constants("lattice", rich, kMaterial, {{"face_part", part}});
    double k1 = 0, k2 = 0, k3 = 0;
    for (int c = 0; c < shared.size(); ++c) {
      const double squared = std::round(std::pow(rich.connections.rest_length[c] / 0.01, 2));
      (squared == 1 ? k1 : squared == 2 ? k2 : k3) = std::max(squared == 1 ? k1 : squared == 2 ? k2 : k3, shared[c]);
    }
    CHECK(k1 == Approx(k2 + 8. / 3 * k3).epsilon(1e-12));
    CHECK(2.5 * (k2 + 4. / 3 * k3) / 0.01 == Approx(5000).epsilon(1e-12));
  }
}

TEST_CASE("rules say on which bodies they cannot run", "[rules]") {
  const Catalog catalog = built_in_catalog();
  const Body axes = cubic_lattice({3, 3, 3}, 1, {true, false, false}), packing = random_packing({5, 5, 5}, 1, 1.5, 1);
  CHECK_THAT(catalog.find("lattice").unsuited(axes), Catch::Contains("shear"));
  CHECK_THAT(catalog.find("lattice").unsuited(packing), Catch::Contains("cubic lattice"));
  CHECK_THAT(catalog.find("van_gelder").unsuited(packing), Catch::Contains("tetrahedra"));
  CHECK(catalog.find("van_gelder").unsuited(jittered_block()).empty());
  CHECK(catalog.find("standard").unsuited(packing).empty());
}

TEST_CASE("lattice balances a uniform strain on box lattices, graded ones too", "[rules]") {
  const CubicPattern pattern = GENERATE(CubicPattern{true, true, false}, CubicPattern{true, true, true});
  constexpr double E = 5000;
  Body body = cubic_lattice({4, 4, 5}, 1, pattern);
  stretch(body, {0.01, 0.011, 0.0105});
  grade(body, 2, 1.1);
  REQUIRE(built_in_catalog().find("lattice").unsuited(body).empty());
  const VectorX k =
      constants("lattice", body, {.youngs_modulus = E, .poissons_ratio = 0.25, .density = 1, .thickness = 0});
  CHECK(k.minCoeff() >= 0);
  Matrix3 strain;
  strain << 1, .3, -.7, .3, -.4, .5, -.7, .5, .2;
  // ν = ¼: λ = μ = 0.4 E. Inside, forces balance; in all, Σ x f = −V σ.
  const Matrix3 stress = 0.4 * E * (strain.trace() * Matrix3::Identity() + 2 * strain);
  Positions force = Positions::Zero(3, body.size());
  for (int c = 0; c < body.connections.size(); ++c) {
    const auto [a, b] = body.connections.ends[c];
    const Vector3 gap = body.rest.col(b) - body.rest.col(a);
    const Vector3 tension = k[c] * gap * gap.dot(strain * gap) / gap.squaredNorm();
    force.col(a) += tension;
    force.col(b) -= tension;
  }
  const Vector3 high = body.rest.rowwise().maxCoeff();
  for (int m = 0; m < body.size(); ++m) {
    const bool inside = (body.rest.col(m).array() > 1e-9 && body.rest.col(m).array() < high.array() - 1e-9).all();
    if (inside) REQUIRE(force.col(m).norm() < 1e-12 * stress.norm() * high.squaredNorm());
  }
  CHECK((body.rest * force.transpose() + high.prod() * stress).norm() < 1e-12 * high.prod() * stress.norm());
}

TEST_CASE("lattice says which boxes it cannot serve", "[rules]") {
  const auto unsuited = [](const Body& body) { return built_in_catalog().find("lattice").unsuited(body); };
  Body body = cubic_lattice({3, 3, 3}, 1, {true, true, false});
  stretch(body, {2, 1, 1});  // 1.2 < 0.4 (4 + 4)
  CHECK(unsuited(body) == "the lattice's spacings differ too much: no positive constants give E");
  Body space = cubic_lattice({3, 3, 3}, 1, {true, false, true});
  CHECK(unsuited(space).empty());
  stretch(space, {1.2, 1, 1});
  CHECK(unsuited(space) == "needs face diagonals: space diagonals alone are exact on cubes only");
}
