// Scenes name what a program has added to its catalog.

#include "support/own_rows.h"

#include <catch2/catch.hpp>

#include "elastin/lab/scene/experiment_catalog.h"
#include "elastin/lab/study/laboratory.h"
#include "lab/study/check.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;
using namespace elastin::testing;
using Catch::Contains;

namespace {

const std::string kScene =
    "title: A scene\n"
    "body: {lattice: {kind: cubic, molecules: [3, 3, 3], spacing: 1 mm, connections: [axis, face]}}\n"
    "material: {youngs_modulus: 10 kPa, density: 1000 kg/m3}\nstiffness: lattice\n"
    "experiment: {kind: motion}\n"
    "loads:\n  - ratchet: {molecules: [26], growth: [0 N, 0 N, 1 uN]}\n"
    "solver: {linear_solver: own}\n"
    "time: {duration: 1 ms, frames: 2, step: 20 us, integrator: {scheme: in_parts, parts: 2}}\n";

}  // namespace

TEST_CASE("a scene runs with a stepper, a linear solver and a load of the program's own", "[tables][scene]") {
  const TemporaryFolder folder;
  const std::string path = folder.write("own.yaml", kScene);
  Laboratory laboratory(path, {}, catalog_with_own_rows());
  const LaboratoryResult result = laboratory.run();
  CHECK(result.cause == "");
  CHECK(result.solver == "in_parts");
  CHECK(result.positions(2, 26) > laboratory.body().rest(2, 26));
  CHECK_THROWS_WITH(Laboratory(path), Contains("linear solver 'own' is not known here"));
  CHECK_THROWS_WITH(Laboratory(path, {"time.integrator.parts=0"}, catalog_with_own_rows()), Contains("whole number"));
  CHECK_THROWS_WITH(Laboratory(path, {"solver.linear_solver=owm"}, catalog_with_own_rows()),
                    Contains("did you mean 'own'?"));
}

TEST_CASE("`list` prints every row of every table", "[tables]") {
  const Catalog catalog = catalog_with_own_rows();
  const std::string text = catalog_text(catalog, built_in_experiments(), false);
  for (const std::string& name : catalog.names()) CHECK_THAT(text, Contains(name));
  for (const auto& names : {catalog.steppers.names(), catalog.linear_solvers.names(), catalog.loads.names()})
    for (const std::string& name : names) CHECK_THAT(text, Contains(name));
  CHECK_THAT(text, Contains("face.traction") && Contains("in_parts.parts") && Contains("floor.stiffness"));
}
