// Scenes name what a program has added to its catalog.

#include "support/own_rows.h"

#include <catch2/catch.hpp>

#include "elastin/lab/experiment/experiment_catalog.h"
#include "elastin/lab/study/laboratory.h"
#include "lab/study/study.h"
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
    "time: {duration: 1 ms, frames: 2, step: 20 us, stepper: {method: in_parts, parts: 2}}\n";

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
  CHECK_THROWS_WITH(Laboratory(path, {"time.stepper.parts=0"}, catalog_with_own_rows()), Contains("whole number"));
  CHECK_THROWS_WITH(Laboratory(path, {"solver.linear_solver=owm"}, catalog_with_own_rows()),
                    Contains("did you mean 'own'?"));
}

TEST_CASE("a scene finds its equilibria with an engine of the program's own", "[tables][scene]") {
  const std::string body =
      "body: {lattice: {kind: cubic, molecules: [3, 3, 4], spacing: 1 mm, connections: [axis, face]}}\n"
      "material: {youngs_modulus: 10 kPa, density: 1000 kg/m3}\nstiffness: lattice\n";
  const TemporaryFolder folder;
  const std::string path = folder.write("engine.yaml", body + "experiment: {kind: tension, axis: z, force: 1 mN}\n");
  const Catalog catalog = catalog_with_own_rows();
  for (const std::string displacements : {"small", "large"}) {
    const std::vector<std::string> kind{"solver.displacements=" + displacements};
    const int before = OwnEngine::calls;
    const double plain = Laboratory(path, kind, catalog).run().get("effective_modulus");
    CHECK(OwnEngine::calls == before);
    CHECK(Laboratory(path, {kind[0], "solver.engine=own"}, catalog).run().get("effective_modulus") == plain);
    CHECK(OwnEngine::calls > before);
  }
  const std::string pulled =
      folder.write("pulled.yaml", body + "experiment: {kind: tension, axis: z, displacement: 0.1 mm}\n");
  const LaboratoryResult refused = Laboratory(pulled, {"solver.engine=own"}, catalog).run();
  CHECK_FALSE(refused.suited);
  CHECK(refused.cause == "the engine of the host wants a load");
}

TEST_CASE("an answer whose reactions do not balance the loads has not converged", "[tables][scene]") {
  const TemporaryFolder folder;
  const std::string path =
      folder.write("engine.yaml",
                   "body: {lattice: {kind: cubic, molecules: [3, 3, 4], spacing: 1 mm, connections: [axis, face]}}\n"
                   "material: {youngs_modulus: 10 kPa, density: 1000 kg/m3}\nstiffness: lattice\n"
                   "experiment: {kind: tension, axis: z, force: 1 mN}\nsolver: {engine: own}\n");
  const Catalog catalog = catalog_with_own_rows();
  const auto outcome_with = [&](double times) {
    OwnEngine::reactions_times = times;
    const LaboratoryResult result = Laboratory(path, {}, catalog).run();
    OwnEngine::reactions_times = 1;
    return std::pair{result.outcome, result.cause};
  };
  CHECK(outcome_with(1).first == Outcome::converged);
  const auto [outcome, cause] = outcome_with(1.01);
  CHECK(outcome == Outcome::limit_reached);
  CHECK_THAT(cause, Contains("the reactions do not balance the loads: they leave"));
}

TEST_CASE("an engine is refused by name and place where it cannot work", "[tables][scene]") {
  const TemporaryFolder folder;
  const std::string
      body =
          "body: {lattice: {kind: cubic, molecules: [3, 3, 4], spacing: 1 mm, connections: [axis, face]}}\n"
          "material: {youngs_modulus: 10 kPa, density: 1000 kg/m3}\nstiffness: lattice\n",
      pulled = "experiment: {kind: tension, axis: z, force: 1 mN}\n";
  const auto said = [&](const std::string& rest, const Catalog& catalog) -> std::string {
    const std::string path = folder.write("engine.yaml", body + rest);
    try {
      Laboratory laboratory(path, {}, catalog);
    } catch (const InputError& error) {
      return std::string(error.what()).substr(path.size());
    }
    return "";
  };
  const Catalog own = catalog_with_own_rows(), built_in = built_in_catalog();
  CHECK(said(pulled + "solver: {engine: threads}\n", built_in) == "");
  CHECK_THAT(said(pulled + "solver: {engine: petcs}\n", built_in),
             Contains(":5:18: solver.engine: engine 'petcs' is not known here; did you mean 'petsc'?"));
  CHECK_THAT(
      said(pulled + "solver: {engine: petsc}\n", built_in),
      Contains(":5:18: solver.engine: 'petsc': this program was built without PETSc") && Contains("libpetsc-real-dev"));
  CHECK_THAT(said(pulled + "solver: {engine: own, method: explicit}\n", own),
             Contains(":5:31: solver.method: 'explicit' does not go with engine: own"));
  CHECK_THAT(said(pulled + "solver: {engine: own, linear_solver: direct}\n", own),
             Contains(":5:38: solver.linear_solver: 'direct' does not go with engine: own; allowed: automatic"));
  CHECK_THAT(said("experiment: {kind: motion}\nsolver: {engine: own}\ntime: {duration: 1 ms}\n", own),
             Contains(":5:18: solver.engine: 'own' steps bodies of which each process has its share, and of this one "
                      "each has the whole"));
  CHECK_THAT(said(pulled + "solver: {engine: own}\ncontact: {surface: spheres}\n", own),
             Contains(":5:18: solver.engine: 'own' goes without contact, which stays on one process"));
}

TEST_CASE("`list WORD` prints the rows that have the word in them, in either case", "[tables]") {
  const auto text = [](const std::string& word) {
    return catalog_text(catalog_with_own_rows(), built_in_experiments(), false, word);
  };
  CHECK_THAT(text("restitution"), Contains("Measures") && Contains("restitution") && !Contains("Stiffness strategies"));
  CHECK_THAT(text("Van_Gelder"), Contains("van_gelder_simplified") && !Contains("lattice") && !Contains("Measures"));
  CHECK(text("no such word").empty());
}

TEST_CASE("`list` prints every row of every table", "[tables]") {
  const Catalog catalog = catalog_with_own_rows();
  const std::string text = catalog_text(catalog, built_in_experiments(), false);
  for (const std::string& name : catalog.names()) CHECK_THAT(text, Contains(name));
  for (const auto& names :
       {catalog.steppers.names(), catalog.linear_solvers.names(), catalog.loads.names(), catalog.engines.names()})
    for (const std::string& name : names) CHECK_THAT(text, Contains(name));
  CHECK_THAT(text, Contains("face.traction") && Contains("in_parts.parts") && Contains("floor.stiffness"));
}
