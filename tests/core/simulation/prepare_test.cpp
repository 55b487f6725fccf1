#include "elastin/core/simulation/prepare.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

#include "core/forces/bending.h"
#include "core/shapes/surfaces.h"
#include "elastin/core/base/error.h"
#include "elastin/core/shapes/shapes.h"
#include "elastin/core/simulation/simulation.h"
#include "elastin/mesh/voronoi.h"

using namespace elastin;
using Catch::Matchers::Contains;

namespace {

const Catalog kCatalog = built_in_catalog();
const Material kSoft{.youngs_modulus = 1e4};

Body lattice(const std::array<int, 3>& molecules, const CubicPattern& pattern = {true, true, false}) {
  Body body = cubic_lattice(molecules, 0.01, pattern);
  set_matter(body, 0.005, 1000, 0, 1e-6 * (molecules[0] - 1) * (molecules[1] - 1) * (molecules[2] - 1));
  return body;
}

Body sheet() {
  Body body = rectangular_sheet({0.04, 0.02}, {8, 4}, SheetPattern::alternating);
  set_matter(body, 0.001, 1000, 0.001, 0);
  return body;
}

template <class Work>
std::string refusal(const Work& work) {
  try {
    work();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

/// Elastic energy [J] of a simulation's model at other positions.
double energy_at(Simulation& simulation, const Positions& positions) {
  return simulation.model().elastic_energy(positions);
}

/// Constants that are those of the lattice rule, times a factor that calibration is there to find.
Strategy wrong_by(double factor) {
  return make_spring_rule("wrong", [factor](const Body& body, const Material& material, const ParameterValues&) {
    return VectorX(factor * kCatalog.find("lattice").constants(body, material, {}));
  });
}

}  // namespace

TEST_CASE("the catalog finds a strategy by its whole name", "[strategy]") {
  CHECK(kCatalog.find("lattice+volume").name == "lattice+volume");
  CHECK(kCatalog.find("hencky_energy_membrane+wrinkling").name == "hencky_energy_membrane+wrinkling");
  CHECK(kCatalog.find("calibrated").name == "calibrated:standard");
  const Strategy both = kCatalog.find("calibrated:patch+volume");
  CHECK(both.name == "calibrated:patch+volume");
  REQUIRE(both.calibrates);
  CHECK(both.calibrates->name == "patch+volume");
  CHECK(both.calibrates->volume_modulus);
  CHECK_THROWS_WITH(kCatalog.find("latice+volume"), Contains("did you mean 'lattice'"));
  CHECK_THROWS_WITH(kCatalog.find("lattice+volum"), Contains("did you mean '+volume'"));
  CHECK_THROWS_WITH(kCatalog.find("calbrated:lattice"), Contains("did you mean 'calibrated:'"));
  CHECK_THROWS_WITH(kCatalog.find("volume"), Contains("goes with a rule: lattice+volume"));
  CHECK_THROWS_WITH(kCatalog.find("calibrated:neo_hookean"), Contains("only a spring rule can be calibrated"));
  CHECK(kCatalog.find("prony:fitted+volume").name == "prony:fitted:standard+volume");
  CHECK_THROWS_WITH(kCatalog.find("fitted:neo_hookean"), Contains("only a spring rule can be fitted"));
  CHECK_THROWS_WITH(kCatalog.find("calibrated:fitted:patch"), Contains("the rule is calibrated already"));
  CHECK_THROWS_WITH(kCatalog.find("calibrated:calibrated:patch"), Contains("'calibrated:' is repeated"));
}

TEST_CASE("a simulation prepares bending: a sheet rolled to a cylinder has D/2 times its curvature squared") {
  // All strain energy is bending's: E is nothing. Poisson's ratio 0: no curvature across. Half a square at either end
  // has no neighbour to bend against.
  const double D = 1e-3, radius = 0.5, area = (0.04 - 0.005) * 0.02;
  const Material material{.youngs_modulus = 1e-9, .poissons_ratio = 0, .thickness = 1e-3, .bending_rigidity = D};
  Simulation simulation(sheet(), kCatalog.find("st_venant_kirchhoff_membrane"), material);
  CHECK(simulation.body().connections.cell_sides > 0);
  Positions rolled = simulation.body().rest;
  for (Eigen::Index i = 0; i < rolled.cols(); ++i) {
    const double angle = rolled(0, i) / radius;
    rolled(0, i) = radius * std::sin(angle);
    rolled(2, i) = radius * (1 - std::cos(angle));
  }
  CHECK(energy_at(simulation, rolled) == Approx(D / 2 * area / (radius * radius)).epsilon(1e-3));
  CHECK_THAT(refusal([&] {
               Simulation(lattice({3, 3, 3}), kCatalog.find("lattice"), material);
             }),
             Contains("bending needs triangles"));
}

TEST_CASE("a body that is prepared is left as it is, and regions keep their stiffness") {
  const Material material{.youngs_modulus = 1e4, .thickness = 1e-3, .bending_rigidity = 1e-3};
  const Strategy membrane = kCatalog.find("st_venant_kirchhoff_membrane");
  Body once = sheet();
  set_region(once, {0, 0, 0}, {0.02, 0.02, 0}, 3, 1);
  const VectorX before = once.connection_stiffness;
  prepare(once, membrane, {material}, {});
  REQUIRE(once.connection_stiffness.size() == once.connections.size());
  CHECK(once.connection_stiffness.head(before.size()) == before);
  CHECK(once.connection_stiffness.tail(once.connections.cell_sides).maxCoeff() == 1);
  once.connection_stiffness.tail(once.connections.cell_sides).setLinSpaced(5, 6);
  rotate(once, Matrix3(Eigen::AngleAxisd(0.3, Vector3(1, 2, 3).normalized())));
  Body twice = once;
  prepare(twice, membrane, {material}, {});
  CHECK(twice.connections.ends == once.connections.ends);
  CHECK(twice.connections.rest_length == once.connections.rest_length);
  CHECK(twice.connection_stiffness == once.connection_stiffness);
  // A side more: those that were there keep theirs.
  add_cell_sides(twice, {{0, twice.size() - 1}});
  CHECK(twice.connections.cell_sides == once.connections.cell_sides + 1);
  CHECK(twice.connection_stiffness.tail(twice.connections.cell_sides).sum() ==
        Approx(once.connection_stiffness.tail(once.connections.cell_sides).sum() + 1));
}

TEST_CASE("a simulation gives cells the sides that are no connections") {
  Body bare = tetrahedral_block(BlockKind::kuhn, {2, 2, 2}, Vector3::Constant(0.02));
  set_matter(bare, 0.001, 1000, 0, 0);
  const Body whole = bare;
  bare.connections.ends.resize(9), bare.connections.rest_length.resize(9);
  Positions stretched = whole.rest;
  stretched.row(2) *= 1.1;
  for (const char* law : {"neo_hookean", "neo_hookean+volume"}) {
    Simulation with_all(whole, kCatalog.find(law), kSoft), with_some(bare, kCatalog.find(law), kSoft);
    CHECK(with_some.body().connections.proper() == 9);
    CHECK(energy_at(with_some, stretched) == Approx(energy_at(with_all, stretched)).epsilon(1e-12));
  }
}

TEST_CASE("a simulation makes Voronoi cells where it is given their maker") {
  // Faces of cells fill the hull, sum A L = 3 V: a dilation by e takes sum k (L e)^2 / 2 = 3 E V e^2.
  const Body body = lattice({4, 3, 5}, {true, false, false});
  const Strategy voronoi = kCatalog.find("voronoi");
  CHECK_THAT(refusal([&] { Simulation(body, voronoi, kSoft); }), Contains("make_voronoi"));
  Simulation simulation(body, voronoi, kSoft, {.make_voronoi = mesh::voronoi_cells});
  const double e = 1e-3, volume = 3 * 2 * 4 * 1e-6;
  CHECK(energy_at(simulation, (1 + e) * body.rest) == Approx(3 * 1e4 * volume * e * e).epsilon(1e-9));
}

TEST_CASE("calibrated gives back the constants that are exact on a lattice") {
  const Body body = lattice({4, 3, 5});
  const VectorX exact = kCatalog.find("lattice").constants(body, kSoft, {});
  const VectorX found = calibrated(wrong_by(3.7)).constants(body, kSoft, {});
  CHECK((found - exact).norm() < 1e-8 * exact.norm());

  // With a volume term the springs bear G and the volumes the rest: both come back, and so does any Poisson's ratio.
  for (const double nu : {0.1, 0.4}) {
    const Material material{.youngs_modulus = 1e4, .poissons_ratio = nu};
    Simulation own(body, calibrated(with_volume(wrong_by(0.2))), material);
    Simulation known(body, kCatalog.find("lattice+volume"), material);
    Positions stretched = body.rest;
    const double e = 1e-4;
    stretched.row(2) *= 1 + e, stretched.topRows(2) *= 1 - nu * e;
    const double volume = 3 * 2 * 4 * 1e-6;
    CHECK(energy_at(known, stretched) == Approx(1e4 * e * e / 2 * volume).epsilon(1e-3));
    CHECK(energy_at(own, stretched) == Approx(1e4 * e * e / 2 * volume).epsilon(2e-3));
  }
}

TEST_CASE("calibrated reports what it cannot do") {
  const Strategy rule = kCatalog.find("calibrated:standard");
  CHECK_THAT(refusal([&] {
               Simulation(lattice({3, 3, 3}, {true, false, false}), rule, kSoft);
             }),
             Contains("no modulus to calibrate to"));
  Body regions = lattice({3, 3, 3});
  set_region(regions, Vector3::Zero(), Vector3::Constant(0.01), 10, 1);
  CHECK_THAT(refusal([&] { Simulation(regions, rule, kSoft); }), Contains("a body with regions"));
  CHECK_THAT(refusal([&] { Simulation(sheet(), rule, kSoft); }), Contains("a membrane of triangles is no solid"));
  const Strategy fitted = kCatalog.find("fitted:standard");
  CHECK_THAT(refusal([&] { Simulation(regions, fitted, kSoft); }), Contains("a body with regions"));
  CHECK_THAT(refusal([&] { Simulation(sheet(), fitted, kSoft); }), Contains("'fitted:standard' on this body"));
  Body packing = random_packing({0.05, 0.05, 0.05}, 0.01, 0.016, 1);
  set_matter(packing, 0.005, 1000, 0, 1.25e-4);
  CHECK_THAT(refusal([&] { Simulation(packing, fitted, kSoft); }), Contains("write cells: delaunay"));
}

TEST_CASE("a body whose lists name what it does not have is refused by name", "[prepare][simulation]") {
  struct Case {
    void (*damage)(Body&);
    const char* message;
  };
  const Body whole = tetrahedral_block(BlockKind::kuhn, {1, 1, 1}, Vector3(0.01, 0.01, 0.01));
  for (const Case& one :
       {Case{[](Body& b) { b.connections.ends[3][1] = 8; },
             "the body's connection 3 has molecule 8; there are molecules 0 to 7"},
        Case{[](Body& b) { b.connections.ends[0][0] = -1; }, "the body's connection 0 has molecule -1"},
        Case{[](Body& b) { b.connections.ends[0][0] = 2000000000; }, "has molecule 2000000000"},
        Case{[](Body& b) { b.connections.rest_length.pop_back(); }, "rest lengths"},
        Case{[](Body& b) { b.connections.cell_sides = 1000; }, "1000 sides of cells"},
        Case{[](Body& b) { b.tetrahedra[2][0] = 8; }, "the body's tetrahedron 2 has molecule 8"},
        Case{[](Body& b) {
               b.triangles.push_back({0, 1, 99});
             },
             "the body's triangle 0 has molecule 99"},
        Case{[](Body& b) {
               b.cubes.push_back({0, 1, 2, 3, 4, 5, 6, -7});
             },
             "the body's cube 0 has molecule -7"},
        Case{[](Body& b) {
               b.cables.push_back({500, 1.});
             },
             "the body's cable 0 has connection 500"},
        Case{[](Body& b) {
               b.ties.push_back({0, {0, 1, 70}, {}, 1.});
             },
             "the body's tie 0 has molecule 70"},
        Case{[](Body& b) {
               b.between.push_back({{9, 1.}});
             },
             "the body's molecule between others 0 has molecule 9"},
        Case{[](Body& b) {
               b.blocks.push_back({&cell_kind("hexahedron8"), {0, 1, 2, 3, 4, 5, 6, 8}, {}});
             },
             "the body's hexahedron8 0 has molecule 8"},
        Case{[](Body& b) {
               b.blocks.push_back({nullptr, {0}, {}});
             },
             "the body's block 0 has no kind of cells"},
        Case{[](Body& b) { b.parts.emplace_back().name = "a", b.parts[0].first = 4, b.parts[0].count = 5; },
             "the body's part 'a' has 5 molecules from 4"}}) {
    INFO(one.message);
    Body body = whole;
    set_matter(body, 0.005, 1000, 0, 1e-6);
    one.damage(body);
    CHECK_THAT(refusal([&] { Simulation(body, kCatalog.find("neo_hookean"), kSoft); }), Contains(one.message));
    CHECK_THAT(refusal([&] { prepare(body, kCatalog.find("neo_hookean"), {kSoft}, {}); }), Contains(one.message));
    CHECK_THAT(refusal([&] { Model model(body); }), Contains(one.message));
  }
}
