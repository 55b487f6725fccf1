// What a simulation says that its results are doubtful for, and what it refuses.

#include <catch2/catch.hpp>

#include "core/simulation/tissues.h"
#include "core/simulation/warnings.h"
#include "elastin/core/base/error.h"
#include "elastin/core/shapes/arrays.h"
#include "support/bodies.h"

using namespace elastin;
using namespace elastin::testing;
using Catch::Contains;

namespace {

BodyArrays two_tetrahedra(double apart) {
  BodyArrays arrays;
  arrays.positions.resize(3, 8);
  for (int corner = 0; corner < 4; ++corner) {
    const Vector3 at(corner == 1, corner == 2, corner == 3);
    arrays.positions.col(corner) = 1e-2 * at;
    arrays.positions.col(corner + 4) = 1e-2 * at + Vector3(apart, 0, 0);
  }
  arrays.tetrahedra = {{0, 1, 2, 3}, {4, 5, 6, 7}};
  return arrays;
}

std::vector<std::string> warnings_of(const BodyArrays& arrays, const std::string& strategy,
                                     Material material = kTissue) {
  return Simulation(make_body(arrays), built_in_catalog().find(strategy), material).warnings();
}

}  // namespace

TEST_CASE("a quadrilateral side on triangular ones is named, whichever diagonal they have", "[simulation]") {
  BodyArrays arrays;  // a cube with the top that two tetrahedra of one diagonal make, and their apex
  arrays.positions.resize(3, 9);
  for (int corner = 0; corner < 8; ++corner)
    arrays.positions.col(corner) = 1e-2 * Vector3(corner & 1, corner >> 1 & 1, corner >> 2);
  arrays.positions.col(8) = 1e-2 * Vector3(0.5, 0.5, 2);
  const std::vector<int> cube{0, 1, 3, 2, 4, 5, 7, 6};
  for (const Cells<4>& roof : {Cells<4>{{4, 5, 7, 8}, {4, 7, 6, 8}}, Cells<4>{{4, 5, 6, 8}, {5, 7, 6, 8}}}) {
    arrays.blocks = {{&cell_kind("hexahedron8"), cube, {}}, {&cell_kind("tetrahedron4"), {}, {}}};
    for (const auto& cell : roof) arrays.blocks[1].nodes.insert(arrays.blocks[1].nodes.end(), cell.begin(), cell.end());
    CHECK_THAT(warning_of_seams(make_body(arrays), "the body"),
               Contains("1 quadrilateral side of cells of the body lies on triangular sides of others"));
  }
  arrays.blocks.resize(1);
  arrays.positions.conservativeResize(3, 8);
  CHECK(warning_of_seams(make_body(arrays), "the body").empty());
}

TEST_CASE("a simulation warns as the laboratory does", "[simulation]") {
  BodyArrays one = two_tetrahedra(0.1);
  one.positions.conservativeResize(3, 4);
  one.tetrahedra.pop_back();
  CHECK(warnings_of(one, "neo_hookean").empty());
  CHECK_THAT(warnings_of(two_tetrahedra(0.1), "neo_hookean").at(0),
             Contains("the body is not connected: 2 pieces") && !Contains("same place"));
  CHECK_THAT(warnings_of(two_tetrahedra(0), "neo_hookean").at(0), Contains("pairs of molecules at the same place"));
  // Joined by one corner alone.
  BodyArrays seam = two_tetrahedra(0);
  seam.positions.middleCols(4, 3) = seam.positions.middleCols(5, 3).eval();
  seam.positions.conservativeResize(3, 7);
  seam.tetrahedra[1] = {0, 4, 5, 6};
  CHECK_THAT(warning_of_seams(make_body(seam), "the body"), Contains("3 pairs of molecules at the same place"));
  CHECK(warning_of_seams(make_body(one), "the body").empty());
  // A side against a larger one, which they share one corner of.
  BodyArrays against = seam;
  against.positions.rightCols(3) *= 0.5;
  against.positions.col(4).x() *= -1;
  against.tetrahedra[1] = {0, 4, 6, 5};
  CHECK_THAT(warning_of_seams(make_body(against), "the body"), Contains("lie against cells that do not have them"));
  // A curved side lies before its own flat triangles, not before another cell.
  Body curved = cell_box(cell_kind("hexahedron27"), {1, 1, 1}, {1, 1, 1}, 0);
  curved.rest = curved.rest.colwise() - curved.rest.rowwise().mean();
  for (int a = 0; a < curved.size(); ++a)
    curved.rest.col(a) *= curved.rest.col(a).cwiseAbs().maxCoeff() / std::max(curved.rest.col(a).norm(), 1e-9);
  CHECK(warning_of_seams(curved, "the body").empty());
  BodyArrays twice = one;
  twice.tetrahedra.push_back({1, 0, 2, 3});
  CHECK_THAT(warnings_of(twice, "neo_hookean").at(0),
             Contains("1 cell is given twice: there the body is twice as stiff"));
  Material soft = kTissue;
  soft.poissons_ratio = 0.49;
  CHECK_THAT(warnings_of(one, "neo_hookean", soft).at(0), Contains("nu = 0.49") && Contains("neo_hookean+volume"));

  BodyArrays chain;  // 3 × 3 − 6 directions, 2 rods: it bends
  chain.positions.resize(3, 3);
  chain.positions << 0, 1e-2, 2e-2, 0, 0, 0, 0, 0, 1e-3;
  chain.connections = {{0, 1}, {1, 2}};
  CHECK(warnings_of(chain, "standard") == std::vector<std::string>{"mechanism: 1 zero-energy mode"});

  BodyArrays triangle = chain;  // with one side there and back
  triangle.positions(1, 2) = 1e-2;
  triangle.connections = {{0, 1}, {1, 2}, {2, 0}, {1, 0}};
  CHECK(warnings_of(triangle, "standard") ==
        std::vector<std::string>{"1 connection is given twice, or both ways: there the body is twice as stiff"});

  Simulation pushed(make_body(triangle), built_in_catalog().find("uniform"), kTissue,
                    {.parameters = {{"constant", -1}}});
  CHECK(pushed.warnings().at(1) == "4 spring constants are negative (of 4): the body may have no stable equilibrium");

  BodyArrays sheet;
  sheet.positions = chain.positions;
  sheet.triangles = {{0, 1, 2}};
  sheet.masses = VectorX::Ones(3), sheet.radii = VectorX::Ones(3);
  Material thin = kTissue;
  thin.thickness = 0;
  CHECK_THAT(warnings_of(sheet, "neo_hookean_membrane", thin).at(0), Contains("no thickness"));
}

TEST_CASE("a budget that no number of sweeps keeps is reported", "[simulation]") {
  SimulationOptions options;
  options.stepper.method = "block_descent";
  options.budget = 1e-9;
  Simulation tissue(tissue_block(), built_in_catalog().find("neo_hookean"), kTissue, options);
  CHECK(tissue.warnings().empty());
  for (int step = 0; step < 12; ++step) REQUIRE(tissue.step(1e-3).outcome == Outcome::converged);
  CHECK_THAT(tissue.warnings().at(0), Contains("the budget of 1e-09 s is not kept"));
}

TEST_CASE("an invalid material is refused", "[simulation]") {
  for (const double modulus : {0., -1e3, std::numeric_limits<double>::quiet_NaN()}) {
    Material material = kTissue;
    material.youngs_modulus = modulus;
    CHECK_THROWS_WITH(Simulation(tissue_cube(3), built_in_catalog().find("lattice"), material),
                      Contains("youngs_modulus") && Contains("above 0 is allowed"));
  }
}
