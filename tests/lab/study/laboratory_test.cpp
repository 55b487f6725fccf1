#include "elastin/lab/study/laboratory.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <string>

#include "elastin/core/base/error.h"
#include "lab/scene/scene.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

namespace {

const std::string kScenes = std::string(ELASTIN_SOURCE_DIR) + "/scenes/";
const std::string kTable1b = kScenes + "tension/table1-b.yaml", kCube = kScenes + "tension/cube-27-face.yaml";

/// What the command's own way to run a scene gives.
Run direct_run(const std::string& path, const std::string& strategy) {
  const Catalog catalog = built_in_catalog();
  const auto scene = load_scene(path, catalog);
  const StrategyChoice choice = choose_strategy(*scene, catalog, strategy);
  prepare(scene->specimen, choice.strategy);
  RunOptions options;
  options.statics = scene->statics;
  options.time = scene->time;
  return run_strategy(scene->specimen, *scene->experiment, choice, options);
}

void require_equal(const std::vector<Measured>& list, const Measures& measures) {
  REQUIRE(list.size() == measures.all().size());
  for (std::size_t i = 0; i < list.size(); ++i) {
    CHECK(list[i].name == measures.all()[i].first);
    CHECK(list[i].value == measures.all()[i].second);
    CHECK(list[i].unit == find_measure(list[i].name).unit_text());
  }
}

std::string refusal(const std::string& scene, const std::vector<std::string>& overrides = {},
                    const std::string& strategy = "") {
  try {
    Laboratory(scene, overrides).run(strategy);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("A laboratory measures what the command does, to the last bit", "[laboratory]") {
  for (const std::string path : {"tension/table1-a", "tension/table1-b", "tension/table1-c", "tension/table1-d",
                                 "dynamics/drag-stokes", "contact/patch-test", "membrane/sphere-corners-type-1"}) {
    INFO(path);
    Laboratory laboratory(kScenes + path + ".yaml");
    for (const std::string& strategy : laboratory.strategies()) {
      INFO(strategy);
      const LaboratoryResult result = laboratory.run(strategy);
      const Run run = direct_run(kScenes + path + ".yaml", strategy);
      CHECK(result.strategy == run.strategy);
      CHECK(result.outcome == run.outcome);
      CHECK(result.suited == run.suited);
      CHECK(result.cause == run.cause);
      CHECK(result.linear_iterations == run.linear_iterations);
      require_equal(result.measures, run.measures);
      REQUIRE(result.curve.size() == run.curve.size());
      for (std::size_t row = 0; row < run.curve.size(); ++row) {
        CHECK(result.curve[row].at == (run.time ? run.curve[row].time : run.curve[row].load_factor));
        require_equal(result.curve[row].measures, run.curve[row].measures);
      }
    }
  }
}

TEST_CASE("A laboratory reports what its scene says", "[laboratory]") {
  const Laboratory laboratory(kTable1b);
  CHECK(laboratory.name() == "table1-b");
  CHECK_THAT(laboratory.title(), StartsWith("[M03] Table 1 b"));
  CHECK(laboratory.strategy() == "standard");
  CHECK(laboratory.material().youngs_modulus == 5000);
  CHECK(laboratory.body().connections.size() == direct_run(kTable1b, "standard").constants.size());
  REQUIRE(!laboratory.expectations().empty());
  const Stated first = laboratory.expectations().front();
  CHECK(first.strategy == "standard");
  CHECK(first.measured.name == "effective_modulus");
  CHECK(first.measured.unit == "Pa");
  CHECK(first.source == "[M03] Table 1 b");
}

TEST_CASE("A result says whether all expectations of the scene hold", "[laboratory]") {
  CHECK(Laboratory(kTable1b).run().good);
  CHECK_FALSE(Laboratory(kTable1b, {"material.youngs_modulus=6000"}).run().good);
  const LaboratoryResult unsuited = Laboratory(kCube).run("neo_hookean");
  CHECK_FALSE(unsuited.good);
  CHECK_FALSE(unsuited.suited);
  CHECK(std::isnan(unsuited.get("effective_modulus")));
  CHECK(unsuited.positions.cols() == 0);
}

TEST_CASE("Errors against the material, and the state reached", "[laboratory]") {
  const LaboratoryResult result = Laboratory(kCube).run("standard");
  REQUIRE(result.main.front() == "effective_modulus");
  REQUIRE(result.errors.front().name == "effective_modulus");
  CHECK(result.errors.front().value == Approx(result.get("effective_modulus") / 5000 - 1).epsilon(1e-12));
  // The pull on the upper end goes through the connections that cross the middle between two layers.
  const Body body = Laboratory(kCube).body();
  double pull = 0;
  for (int c = 0; c < body.connections.size(); ++c) {
    const auto& [a, b] = body.connections.ends[c];
    const bool crosses = (body.rest(2, a) < 0.01) != (body.rest(2, b) < 0.01);
    const Vector3 along = (result.positions.col(b) - result.positions.col(a)).normalized();
    if (crosses) pull += result.tensions[c] * std::abs(along.z());
  }
  CHECK(pull == Approx(11.25e-6).epsilon(1e-6));
}

TEST_CASE("A laboratory says errors as the command does", "[laboratory]") {
  CHECK_THAT(refusal(kCube + "x"), Contains("did you mean"));
  CHECK_THAT(refusal(kCube, {"stiffness=latice"}), Contains("did you mean 'lattice'"));
  CHECK(refusal(kCube, {}, "latice") == "unknown strategy 'latice'" + suggestion("latice", built_in_catalog().names()));
}

TEST_CASE("Who watches a run may end it", "[laboratory]") {
  std::vector<std::string> told;
  RunWatch watch;
  watch.progress = [&](const std::string& doing) { told.push_back(doing); };
  Laboratory laboratory(kCube);
  laboratory.run("", watch);
  CHECK(told == std::vector<std::string>{"building", "solving"});
  watch.progress = [](const std::string& doing) { throw std::domain_error(doing); };
  CHECK_THROWS_AS(laboratory.run("", watch), std::domain_error);
  watch = {{}, [] { return true; }};
  CHECK(Laboratory(kScenes + "dynamics/drag-stokes.yaml").run("", watch).outcome == Outcome::interrupted);
}

TEST_CASE("A program's own rule runs in a scene", "[laboratory]") {
  Catalog catalog = built_in_catalog();
  const Strategy standard = catalog.find("standard");
  catalog.add(make_spring_rule("own", [standard](const Body& body, const Material& material, const ParameterValues&) {
    return standard.constants(body, material, {});
  }));
  Laboratory laboratory(kCube, {}, catalog);
  CHECK(laboratory.run("own").get("effective_modulus") == laboratory.run("standard").get("effective_modulus"));
  CHECK(laboratory.run("calibrated:own").get("effective_modulus") ==
        laboratory.run("calibrated:standard").get("effective_modulus"));
}

TEST_CASE("A scene's body, held and loaded, settles where its run does", "[laboratory]") {
  for (const std::string path : {"tension/cube-27-face", "material/shear", "contact/patch-test"}) {
    INFO(path);
    Laboratory laboratory(kScenes + path + ".yaml");
    const LaboratoryResult result = laboratory.run();
    Simulation tissue = laboratory.simulation();
    CHECK(tissue.positions() == laboratory.body().rest);
    REQUIRE(tissue.settle().outcome == Outcome::converged);
    const double displacement = (result.positions - laboratory.body().rest).cwiseAbs().maxCoeff();
    CHECK((tissue.positions() - result.positions).cwiseAbs().maxCoeff() < 1e-6 * displacement);
  }
}

TEST_CASE("A scene's body settles where its run does though its load is sought", "[laboratory]") {
  const TemporaryFolder folder;
  const std::string block =
      "body: {tetrahedra: {kind: body_centred, cubes: [3, 3, 2], size: [15 mm, 15 mm, 10 mm]}}\n"
      "material: {youngs_modulus: 10 kPa, poissons_ratio: 0.3}\nstiffness: neo_hookean\nexperiment: ";
  for (const std::string& text :
       {block +
            "{kind: indentation, axis: z, indenter: {sphere: {radius: 8 mm}}, force: 20 mN}\ncontact: {friction: 0}\n",
        std::string("body: {sphere: {radius: 1 cm, divisions: 4}}\nmaterial: {youngs_modulus: 10 kPa, "
                    "poissons_ratio: 0.3, thickness: 1 mm}\nstiffness: neo_hookean_membrane\n"
                    "experiment: {kind: inflation, volume_ratio: 1.3}\n")}) {
    INFO(text);
    Laboratory laboratory(folder.write("scene.yaml", text));
    const LaboratoryResult result = laboratory.run();
    INFO(result.cause);
    REQUIRE(result.outcome == Outcome::converged);
    Simulation tissue = laboratory.simulation();
    CHECK(tissue.positions() == laboratory.body().rest);
    REQUIRE(tissue.settle().outcome == Outcome::converged);
    const double displacement = (result.positions - laboratory.body().rest).cwiseAbs().maxCoeff();
    CHECK((tissue.positions() - result.positions).cwiseAbs().maxCoeff() < 1e-3 * displacement);
  }
}

TEST_CASE("A simulation of a scene lives without its laboratory", "[laboratory]") {
  auto laboratory = std::make_unique<Laboratory>(kScenes + "dynamics/shake.yaml");
  Simulation tissue = laboratory->simulation(), other = laboratory->simulation();
  laboratory.reset();
  const Positions start = tissue.positions();
  for (int step = 0; step < 20; ++step) REQUIRE(tissue.step(1e-4).outcome == Outcome::converged);
  CHECK(tissue.positions() != start);  // the experiment goes on to shake it
  CHECK(other.positions() == start);
}

TEST_CASE("Simulations of a scene and its runs do not disturb each other", "[laboratory]") {
  const auto twenty_steps = [](Simulation& tissue) {
    for (int step = 0; step < 20; ++step) REQUIRE(tissue.step(1e-4).outcome == Outcome::converged);
    return tissue.positions();
  };
  for (const std::string name : {"torsion-released", "shake"}) {  // the second is driven as time goes on
    const std::string path = kScenes + "dynamics/" + name + ".yaml";
    auto timed = std::make_unique<Laboratory>(path);
    Simulation first = timed->simulation(), second = timed->simulation();
    timed.reset();
    const Positions expected = twenty_steps(first);
    CHECK((expected - first.body().rest).norm() > 0);
    CHECK(twenty_steps(second) == expected);
  }
  Laboratory laboratory(kCube);
  // Each has its own load, and a run in between changes none.
  Simulation tissue = laboratory.simulation();
  const double before = laboratory.run().get("elongation");
  Simulation other = laboratory.simulation("lattice");
  REQUIRE(tissue.settle().outcome == Outcome::converged);
  REQUIRE(other.settle().outcome == Outcome::converged);
  Simulation fresh = Laboratory(kCube).simulation();
  REQUIRE(fresh.settle().outcome == Outcome::converged);
  CHECK(tissue.positions() == fresh.positions());
  CHECK(laboratory.run().get("elongation") == before);
}

TEST_CASE("What cannot be simulated is said", "[laboratory]") {
  const auto said = [](const std::string& strategy) -> std::string {
    try {
      Laboratory(kCube).simulation(strategy);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  CHECK_THAT(said("neo_hookean"), StartsWith("strategy 'neo_hookean' cannot run here: "));
  CHECK_THAT(said("latice"), Contains("did you mean 'lattice'"));
}

TEST_CASE("A body is made as scenes describe one", "[laboratory]") {
  std::vector<std::string> warnings;
  const Material material{5000};
  const Body body =
      make_body("lattice: {kind: cubic, molecules: [3, 3, 3], spacing: 7.5 mm, connections: [axis, face]}", material,
                warnings, warnings);
  const Body scenes = Laboratory(kCube).body();
  CHECK(body.rest == scenes.rest);
  CHECK(body.mass == scenes.mass);
  CHECK(body.radius == scenes.radius);
  CHECK(body.connections.ends == scenes.connections.ends);
  CHECK(warnings.empty());
  CHECK_THROWS_WITH(make_body("lattice: {kind: cubik, molecules: [3, 3, 3], spacing: 1}", material, warnings, warnings),
                    StartsWith("body:1:17: ") && Contains("did you mean 'cubic'"));
  CHECK_THROWS_WITH(make_body("disc: {radius: 1, rings: 2}", material, warnings, warnings), Contains("thickness"));
}

TEST_CASE("laboratory: a simulation without a scene calibrates as the experiment `material` does", "[slow]") {
  const Catalog catalog = built_in_catalog();
  for (const auto& [name, strategy] : {std::pair{"cube-stiffness", "calibrated:standard"},
                                       {"cube-stiffness", "calibrated:angles"},
                                       {"cube-stiffness", "calibrated:statistical+volume"},
                                       {"filled-ball", "calibrated:patch"}}) {
    INFO(name << ", " << strategy);
    const std::string path = kScenes + "material/" + name + ".yaml";
    const Run run = direct_run(path, strategy);
    REQUIRE(run.outcome == Outcome::converged);
    const auto scene = load_scene(path, catalog);
    prepare(scene->specimen, catalog.find(strategy));
    const VectorX constants = catalog.find(strategy).constants(scene->specimen.body, scene->specimen.material, {});
    CHECK((constants - run.constants).norm() < 1e-12 * run.constants.norm());
    CHECK(std::abs(run.calibration_factor - 1) > 1e-3);  // or there was nothing to find
  }
}
