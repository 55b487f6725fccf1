// The tables of what can be plugged in: by name, with rows of a program's own.

#include <catch2/catch.hpp>
#include <set>

#include "core/simulation/tissues.h"
#include "support/own_rows.h"
#include "support/refusal.h"

using namespace elastin;
using namespace elastin::testing;
using Catch::Contains;

namespace {

template <class Row>
void check_rows(const Table<Row>& table) {
  std::set<std::string> names;
  for (const auto& row : table) {
    INFO(table.kind() << " " << row->name);
    CHECK(names.insert(row->name).second);
    CHECK_FALSE(row->summary.empty());
    CHECK(table.find(row->name) == row);
    for (const ParameterInfo& info : row->parameters) {
      INFO(info.name);
      CHECK_FALSE(info.text.empty());
      const bool number = info.kind == ValueKind::number || info.kind == ValueKind::whole;
      if (number && !std::isnan(info.fallback))
        CHECK_NOTHROW(checked_parameter(row->name, row->parameters, info.name, info.fallback));
    }
  }
}

}  // namespace

TEST_CASE("every row has a name of its own, a summary, and defaults within their ranges", "[tables]") {
  check_rows(built_in_steppers());
  check_rows(built_in_linear_solvers());
  check_rows(built_in_loads());
  CHECK_THAT(refusal([] { StepperMethod("newmrk"); }),
             Contains("stepper 'newmrk'") && Contains("did you mean 'newmark'?"));
  Table<StepperKind> steppers = built_in_steppers();
  CHECK_THAT(refusal([&] { steppers.add({{"newmark", "", ""}}); }), Contains("there is a stepper 'newmark' already"));
}

TEST_CASE("a stepper of one's own is taken by name", "[tables]") {
  const Catalog catalog = catalog_with_own_rows();
  SimulationOptions options;
  options.stepper.parameters = {{"parts", 4}};
  Simulation own = simulation_of(tissue_cube(3), catalog.steppers.find("in_parts"), "lattice", options);
  Simulation verlet = simulation_of(tissue_cube(3), "velocity_verlet");
  for (Simulation* tissue : {&own, &verlet}) tissue->couple(26, Vector3(0.02, 0.02, 0.03), 1);
  REQUIRE(own.step(4e-5).outcome == Outcome::converged);
  for (int part = 0; part < 4; ++part) REQUIRE(verlet.step(1e-5).outcome == Outcome::converged);
  CHECK((own.positions().array() == verlet.positions().array()).all());
  options.stepper.parameters = {{"parts", 2.5}};
  CHECK_THAT(refusal([&] { simulation_of(tissue_cube(3), catalog.steppers.find("in_parts"), "lattice", options); }),
             Contains("in_parts.parts: 2.5 is out of range: it must be whole, at least 1 and at most 100"));
}

TEST_CASE("a linear solver of one's own is taken by name", "[tables]") {
  const Catalog catalog = catalog_with_own_rows();
  const auto settled = [&](const LinearMethod& method) {
    Simulation tissue = simulation_of(tissue_cube(4));
    for (int molecule = 0; molecule < 16; ++molecule) tissue.fix(molecule);
    tissue.add_load(*built_in_loads().find("gravity"), {.vectors = {{"acceleration", Vector3(0, 0, -1)}}});
    StaticResult result = tissue.settle({.method = method});
    return std::pair{result.solver, tissue.positions()};
  };
  const auto [own, own_positions] = settled(catalog.linear_solvers.find("own"));
  const auto [pcg, pcg_positions] = settled("pcg");
  CHECK(own == "newton own");
  CHECK(pcg == "newton pcg");
  CHECK((own_positions.array() == pcg_positions.array()).all());
}

TEST_CASE("loads check what they are given", "[tables][loads]") {
  Simulation tissue = simulation_of(tissue_cube(3));
  const auto add = [&](const char* load, const LoadValues& values) {
    return refusal([&] { tissue.add_load(*built_in_loads().find(load), values); });
  };
  CHECK_THAT(add("gravity", {}), Contains("gravity.acceleration is missing"));
  CHECK_THAT(add("gravity", {.numbers = {{"acceleration", 1}}}), Contains("gravity.acceleration: must be a vector"));
  CHECK_THAT(add("damping", {.numbers = {{"coeficient", 1}}}), Contains("did you mean 'coefficient'?"));
  CHECK_THAT(add("damping", {.numbers = {{"coefficient", -1}}}), Contains("it must be at least 0 N s/m"));
  CHECK_THAT(add("point", {.vectors = {{"force", Vector3(1, 0, 0)}}, .molecules = {{"molecules", {27}}}}),
             Contains("no molecule 27"));
  CHECK_THAT(add("rayleigh", {}), Contains("give mass"));
  CHECK_THAT(add("air", {}), Contains("the body has none"));
  CHECK_THAT(add("cell_damping", {.numbers = {{"bulk", 1}, {"shear", 1}}}), Contains("tetrahedra"));
  CHECK_THAT(add("gas", {.numbers = {{"amount", 1}}}), Contains("closed surface"));
  CHECK(tissue.model().loads().empty());
  // The floor's stiffness comes from the material, where it is not given.
  const LoadValues plane{.vectors = {{"point", Vector3::Zero()}, {"normal", Vector3(0, 0, 2)}}};
  CHECK(add("floor", plane).empty());
  CHECK(tissue.model().loads().size() == 1);
  Model apart(tissue.body());
  CHECK_THAT(refusal([&] { add_load(apart, *built_in_loads().find("floor"), plane); }),
             Contains("floor.stiffness is missing"));
}

TEST_CASE("settling may allocate memory, and says so", "[tables]") {
  CHECK_FALSE(noexcept(std::declval<Simulation&>().settle()));
}
