// What a recommended strategy makes of the material in other directions than those of the experiment.

#include "lab/report/directions.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/base/dense.h"
#include "lab/report/comparison.h"
#include "lab/report/files.h"
#include "lab/report/records.h"
#include "lab/study/reference.h"
#include "lab/study/study.h"
#include "support/shell.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;
using Catch::Matchers::Contains;
using Json = nlohmann::json;

namespace {

/// Stiffness of a cubic crystal along its axes.
Stiffness6 cubic(double c11, double c12, double c44) {
  Stiffness6 stiffness = Stiffness6::Zero();
  stiffness.topLeftCorner<3, 3>().setConstant(c12);
  for (int i = 0; i < 3; ++i) stiffness(i, i) = c11, stiffness(i + 3, i + 3) = c44;
  return stiffness;
}

Material material_of(double modulus, double ratio) {
  Material material;
  material.youngs_modulus = modulus;
  material.poissons_ratio = ratio;
  return material;
}

const std::string kLattice =
    "body: {lattice: {kind: cubic, molecules: [5, 5, 5], spacing: 1 cm, connections: [axis, face]}}\n";

std::string scene_of(const std::string& experiment, const std::string& body = kLattice) {
  return "title: A block\n" + body + "material: {youngs_modulus: 10 kPa}\nstiffness: lattice\nexperiment: {" +
         experiment + "}\n";
}

/// The runs of `compare` by their strategies.
std::map<std::string, Json> compared(const TemporaryFolder& folder, const std::string& scene,
                                     const std::string& strategies) {
  folder.write("scene.yaml", scene);
  REQUIRE(shell(folder, "$elastin compare scene.yaml --json r.json --out o --strategies " + strategies) == 0);
  std::map<std::string, Json> runs;
  const Json all = Json::parse(text_of_file(folder.path("r.json")));
  for (const Json& run : all["runs"]) runs[run["strategy"]] = run;
  return runs;
}

Record record_of(const std::string& strategy, double error, double elsewhere) {
  Record record;
  record.scene = "block";
  record.run.strategy = strategy;
  record.main_measures = {{"effective_modulus", 1.}};
  record.errors = {{"effective_modulus", error}};
  record.directions.emplace();
  record.directions->youngs = {error, error, error};
  record.directions->largest_shear = elsewhere;
  return record;
}

}  // namespace

TEST_CASE("an isotropic stiffness has no error in any direction", "[directions]") {
  const double lambda = 4, mu = 3;
  const double E = mu * (3 * lambda + 2 * mu) / (lambda + mu), nu = lambda / (2 * (lambda + mu));
  const DirectionErrors errors = direction_errors(cubic(lambda + 2 * mu, lambda, mu), material_of(E, nu));
  CHECK(errors.worst() < 1e-13);
  CHECK(direction_text(errors) == "E and G within 0.1 % in all of them");
  CHECK(direction_errors(cubic(lambda + 2 * mu, lambda, mu), material_of(E / 2, nu)).worst() == Approx(1));
}

TEST_CASE("a cubic crystal has its closed forms along its axes and diagonals", "[directions]") {
  // Iron: C11 = 231.4, C12 = 134.7, C44 = 116.4 GPa; extremes of E along [100] and [111], of G on {110} and {100}.
  const Stiffness6 iron = cubic(231.4, 134.7, 116.4);
  const Stiffness6 s = inverse(iron);
  const double s11 = s(0, 0), s12 = s(0, 1), s44 = s(3, 3);
  const double along_axis = 1 / s11, along_diagonal = 1 / (s11 - 2. / 3 * (s11 - s12 - s44 / 2));
  const double on_sides = 1 / s44, on_diagonals = 1 / (2 * (s11 - s12));
  const Material material = material_of(along_axis, 0.25);
  const double G = along_axis / 2.5;
  for (const double angle : {0., 0.7}) {  // in any axes
    Stiffness6 turned = iron;
    if (angle > 0) {  // about z: Bond's matrix of the strains
      const double c = std::cos(angle), q = std::sin(angle);
      Stiffness6 bond = Stiffness6::Identity();
      bond.row(0) << c * c, q * q, 0, 0, 0, c * q;
      bond.row(1) << q * q, c * c, 0, 0, 0, -c * q;
      bond.row(3) << 0, 0, 0, c, -q, 0;
      bond.row(4) << 0, 0, 0, q, c, 0;
      bond.row(5) << -2 * c * q, 2 * c * q, 0, 0, 0, c * c - q * q;
      turned = bond.transpose() * iron * bond;
    }
    const DirectionErrors errors = direction_errors(turned, material);
    CHECK(errors.youngs[2] == Approx(0).margin(1e-12));
    CHECK(errors.least_youngs == Approx(0).margin(1e-3));
    CHECK(errors.largest_youngs == Approx(along_diagonal / along_axis - 1).epsilon(2e-3));
    CHECK(errors.largest_shear == Approx(on_sides / G - 1).margin(2e-3));
    CHECK(errors.least_shear == Approx(on_diagonals / G - 1).margin(2e-3));
  }
  CHECK(direction_errors(iron, material).youngs[0] == Approx(0).margin(1e-12));
  CHECK_THAT(
      direction_text(direction_errors(iron, material)),
      Contains("E 0.0000 % along x, y, z (0.0000 % to +114 % over all), G ") && Contains(": do not use it in shear"));
  CHECK(direction_errors(Stiffness6::Zero(), material).trouble == "its stiffness is singular or not positive");
}

TEST_CASE("the words name the axes in which a strategy fails", "[directions]") {
  DirectionErrors errors;
  errors.youngs = {0.001, -0.3, 0.85};
  errors.least_youngs = -0.3, errors.largest_youngs = 0.85;
  errors.least_shear = -0.02, errors.largest_shear = 0.03;
  CHECK(direction_text(errors) ==
        "E +0.100 %, -30.00 %, +85.00 % along x, y, z, G -2.00 % to +3.00 %: do not use it along y, z");
  errors.largest_shear = 0.2;
  CHECK_THAT(direction_text(errors), Contains(": do not use it along y, z, or in shear"));
  errors.youngs = {0, 0, 0};
  errors.least_youngs = -0.2, errors.largest_youngs = 0;
  errors.least_shear = errors.largest_shear = 0.01;
  CHECK(direction_text(errors) ==
        "E 0.0000 % along x, y, z (-20.00 % to 0.0000 % over all), G +1.00 %: do not use it askew to its axes");
  errors.least_youngs = -0.02;
  CHECK_THAT(direction_text(errors), !Contains("do not use"));
}

TEST_CASE("what is near in one direction alone is passed over, and recommended with that word where there is no other",
          "[directions][texts]") {
  const std::vector<Record> records{record_of("springs", 1e-9, 0.2), record_of("solid", 8e-3, 0.01),
                                    record_of("far", 0.2, 0.2)};
  const Ranking ranking = rank_strategies(records);
  CHECK(ranking.best == &records[1]);
  CHECK(ranking.tied.empty());
  const std::vector<Record> alone{records[0], records[2]};
  const Ranking of_two = rank_strategies(alone);
  CHECK(of_two.best == alone.data());
  CHECK_THAT(advice_text(of_two, false),
             Contains("recommended: springs: E ") &&
                 Contains("in other directions, by small strains of the surface: E 0.0000 % along x, y, z, "
                          "G 0.0000 % to +20.00 %: do not use it in shear"));
  // What is not known is no reason.
  std::vector<Record> unknown = records;
  unknown[1].directions->trouble = "the body is large";
  CHECK(rank_strategies(unknown).best == unknown.data());
  unknown[0].directions->trouble = "the body is large";
  CHECK(rank_strategies(unknown).best == unknown.data());
  CHECK_THAT(advice_text(rank_strategies(unknown), false),
             Contains("not measured (the body is large): what is said holds for this experiment alone"));
}

TEST_CASE("directions are the reason for passing over a strategy only where another one is near in all of them",
          "[directions][texts]") {
  std::vector<Record> records{record_of("fastest", 0.1, 0.6), record_of("simplest", 0.1, 0.6),
                              record_of("nearer", 0.099, 0.6)};
  for (std::size_t i = 0; i < records.size(); ++i) {
    records[i].run.solve_seconds = std::array{1e-3, 3e-3, 2e-3}[i];
    records[i].run.order = std::array{3, 1, 2}[i];
  }
  const Ranking ranking = rank_strategies(records);
  CHECK(ranking.best == &records[1]);  // tied with the fastest
  CHECK(ranking.passed_over.empty());
  records.push_back(record_of("solid", 0.01, 0.01));
  records.back().run.solve_seconds = 1;
  records[2].errors.front().second = 1e-4;
  const Ranking with_solid = rank_strategies(records);
  CHECK(with_solid.best == &records[3]);
  REQUIRE(with_solid.passed_over.size() == 1);
  CHECK(with_solid.passed_over.front().first == &records[2]);
  CHECK(with_solid.passed_over.front().second == "it is not near in other directions");
}

TEST_CASE("a comparison measures what it recommends in all directions", "[directions][command]") {
  const TemporaryFolder folder;
  const auto runs =
      compared(folder, scene_of("kind: tension, axis: z, displacement: 1 um"), "standard,calibrated:standard,lattice");
  CHECK_FALSE(runs.at("standard").contains("direction_errors"));  // far from E: never recommended
  const Json &springs = runs.at("calibrated:standard")["direction_errors"],
             &solid = runs.at("lattice")["direction_errors"];
  for (const char* axis : {"x", "y", "z", "least", "largest"})
    CHECK(solid["youngs_modulus"][axis].get<double>() == Approx(0).margin(1e-6));
  CHECK(solid["shear_modulus"]["largest"].get<double>() == Approx(0).margin(1e-6));
  // The same springs, measured by the experiment itself, in any size.
  const TemporaryFolder other;
  const Json measured = compared(other, scene_of("kind: material"), "standard").at("standard")["measures"];
  const double factor = runs.at("calibrated:standard")["calibration_factor"];
  CHECK(springs["youngs_modulus"]["x"].get<double>() ==
        Approx(factor * measured["youngs_modulus_x"].get<double>() / 1e4 - 1).epsilon(1e-6));
  const double shear = factor * measured["shear_modulus"].get<double>() / 4e3 - 1;  // a mean over all
  CHECK(springs["shear_modulus"]["least"].get<double>() < shear);
  CHECK(springs["shear_modulus"]["largest"].get<double>() > shear);
  const std::string out = text_of_file(folder.path("out"));
  CHECK_THAT(
      out,
      Contains("recommended: lattice: E ") &&
          Contains(
              "in other directions, by small strains of the surface: E and G within 0.1 % in all of them; nothing was "
              "run beyond a strain of 0.00"));
  CHECK_THAT(text_of_file(folder.path("o/report.html")),
             Contains("in other directions, by small strains of the surface: E and G"));
  // Alone it is recommended, with that word.
  const TemporaryFolder alone;
  const std::string cells =
      "body: {lattice: {kind: cubic, molecules: [5, 5, 5], spacing: 1 cm, connections: [axis, face]}, cells: "
      "delaunay}\n";
  compared(alone, scene_of("kind: tension, axis: z, displacement: 1 um", cells), "van_gelder,calibrated:van_gelder");
  CHECK_THAT(text_of_file(alone.path("out")),
             Contains("recommended: calibrated:van_gelder: E ") && Contains("in shear; nothing was run beyond"));
  // A record comes back with them.
  CHECK_THAT(text_of_file(alone.path("o/runs.jsonl")), Contains("direction_errors"));
  REQUIRE(shell(alone, "$elastin compare scene.yaml --strategies van_gelder,calibrated:van_gelder --resume o") == 0);
  CHECK_THAT(text_of_file(alone.path("out")), Contains("in shear; nothing was run beyond"));
}

TEST_CASE("where no other direction has a modulus the reason is stated", "[directions][command]") {
  const std::string pull = "kind: tension, axis: z, displacement: 1 um";
  for (const auto& [body, why] :
       {std::pair{
            "body: {molecules: [[0 cm, 0 cm, 0 cm], [1 cm, 0 cm, 0 cm], [0 cm, 1 cm, 0 cm], [0.2 cm, 0.2 cm, 1 cm], "
            "[0.3 cm, 0.2 cm, 2 cm]], connections: {within: 5 cm}, radius: 5 mm}\n",
            "the body is no box"},
        {"bodies: [{name: a, tetrahedra: {kind: kuhn, cubes: [2, 2, 2], size: [1 cm, 1 cm, 1 cm]}}, {name: b, "
         "tetrahedra: "
         "{kind: kuhn, cubes: [2, 2, 2], size: [1 cm, 1 cm, 1 cm]}, at: [0 cm, 0 cm, 1 cm]}]\n",
         "the scene has several bodies"}}) {
    const TemporaryFolder folder;
    const auto scene = load_scene(folder.write("scene.yaml", scene_of(pull, body)), built_in_catalog());
    const StrategyChoice choice = choose_strategy(built_in_catalog(), "standard");
    CHECK(measure_directions(*scene, choice, {}, {}).trouble == why);
  }
  const TemporaryFolder folder;
  const std::string large =
      "body: {lattice: {kind: cubic, molecules: [28, 28, 28], spacing: 1 mm, connections: [axis, face]}}\n";
  const auto scene = load_scene(folder.write("scene.yaml", scene_of(pull, large)), built_in_catalog());
  CHECK(measure_directions(*scene, scene->stiffness, {}, {}).trouble == "the body has more than 20000 molecules");
}

TEST_CASE("a law with directions has its own moduli as the target, or none", "[directions][reference][slow]") {
  const std::string tendon =
      "body: {tetrahedra: {kind: body_centred, cubes: [3, 3, 6], size: [3 mm, 3 mm, 6 mm]}}\nmaterial: {law: "
      "transversely_isotropic, c1: 10 kPa, c3: 2 kPa, c4: 20, c5: 300 kPa, lambda_max: 1.07, direction: z, "
      "bulk_modulus: "
      "30 kPa}\nstiffness: transversely_isotropic\n";
  const Catalog catalog = built_in_catalog();
  const TemporaryFolder folder;
  const auto load = [&](const std::string& experiment) {
    return load_scene(folder.write("scene.yaml", tendon + "experiment: {" + experiment + "}\n"), catalog);
  };
  const std::string why = "the law transversely_isotropic has directions";
  for (const char* experiment : {"kind: material", "kind: bending, axis: z, force: 1 uN, direction: x"}) {
    INFO(experiment);
    const auto scene = load(experiment);
    CHECK_THAT(no_reference(*scene), Catch::Matchers::StartsWith(why + ", so its E, G and nu at rest"));
    const Run run = run_strategy(scene->specimen, *scene->experiment, scene->stiffness, {.statics = scene->statics});
    CHECK(measure_directions(*scene, scene->stiffness, {}, run).trouble == why);
    const Record blind = make_record(*scene, run);
    CHECK(rank_strategies({blind}).best == nullptr);
    CHECK(blind.errors.empty());
    if (scene->experiment->name() != "material") continue;  // computed in half a minute
    ReferenceStore store;
    scene->specimen.references = compute_references(*scene, catalog, {}, store, {}, {}).references;
    REQUIRE_FALSE(scene->specimen.references.empty());
    const Record record = make_record(*scene, run);  // a uniform body is exact at any fineness
    CHECK(record.error("effective_modulus_to_reference") == Approx(0).margin(1e-5));
    CHECK(rank_strategies({record}).best != nullptr);
  }
  CHECK(no_reference(*load("kind: tension, axis: z, strain: 1 %")).empty());
  CHECK_THAT(no_reference(*load("kind: torsion, axis: z, angle: 1 deg")), Contains("cannot warp"));
  const auto tension = load("kind: tension, axis: z, strain: 1 %");
  const Run springs =
      run_strategy(tension->specimen, *tension->experiment, choose_strategy(catalog, "calibrated:van_gelder+volume"),
                   {.statics = tension->statics});
  INFO(springs.cause);
  CHECK(std::any_of(springs.warnings.begin(), springs.warnings.end(), [](const std::string& warning) {
    return warning.find("one value for all directions, where the law transversely_isotropic has") != std::string::npos;
  }));
}

TEST_CASE("springs that relax are calibrated as the scene says", "[directions][scene]") {
  const TemporaryFolder folder;
  const Catalog catalog = built_in_catalog();
  const auto factor = [&](const std::string& strategy, const std::string& more) {
    std::string text = scene_of("kind: tension, axis: z, displacement: 1 um") + more;
    text.replace(text.find("material: {"), 11,
                 "material: {relaxation: {terms: [[0.5, 1 s]]}, softening: {r: 2, m: 1 Pa, beta: 0.1}, ");
    const auto scene = load_scene(folder.write("scene.yaml", text), catalog);
    Run run = run_strategy(scene->specimen, *scene->experiment, choose_strategy(catalog, strategy),
                           {.statics = scene->statics});
    INFO(run.cause);
    REQUIRE(run.outcome == Outcome::converged);
    REQUIRE(run.suited);
    return std::pair{run.calibration_factor, run.measures.get("effective_modulus")};
  };
  const std::string shear = "calibrate: {experiment: {kind: shear, direction: x, strain: 1e-6, sides: affine}}\n";
  for (const std::string& more : {std::string(), shear}) {
    const auto [expected, modulus] = factor("calibrated:standard", more);
    for (const std::string strategy :
         {"prony:calibrated:standard", "mullins:calibrated:standard", "prony:mullins:calibrated:standard"}) {
      INFO(strategy << more);
      const auto [found, shown] = factor(strategy, more);
      CHECK(found == Approx(expected).epsilon(1e-12));
      CHECK(shown == Approx(modulus).epsilon(1e-3));  // rods of a curve, and what has softened a little
    }
  }
}

TEST_CASE("calibration may have an experiment of its own", "[directions][scene]") {
  const TemporaryFolder folder;
  const Catalog catalog = built_in_catalog();
  const auto run = [&](const std::string& text) {
    const auto scene = load_scene(folder.write("scene.yaml", text), catalog);
    return run_strategy(scene->specimen, *scene->experiment, choose_strategy(catalog, "calibrated:standard"),
                        {.statics = scene->statics});
  };
  const std::string pull = scene_of("kind: tension, axis: z, displacement: 1 um"),
                    shear = "kind: shear, direction: x, strain: 1e-6, sides: affine";
  const Run own = run(pull), of_material = run(scene_of("kind: material")), of_shear = run(scene_of(shear));
  CHECK(of_shear.calibration_factor != Approx(own.calibration_factor).epsilon(0.02));
  const Run by_material = run(pull + "calibrate: {experiment: {kind: material}}\n"),
            by_shear = run(pull + "calibrate: {experiment: {" + shear + "}}\n");
  CHECK(by_material.calibration_factor == Approx(of_material.calibration_factor).epsilon(1e-12));
  CHECK(by_shear.calibration_factor == Approx(of_shear.calibration_factor).epsilon(1e-12));
  // Then what is measured is a test of the calibration: forces are in proportion to the springs.
  CHECK(by_shear.measures.get("effective_modulus") / own.measures.get("effective_modulus") ==
        Approx(of_shear.calibration_factor / own.calibration_factor).epsilon(1e-6));
  CHECK_THROWS_WITH(
      run(pull + "calibrate: {experiment: {kind: release, fixture: {kind: tension, force: 1 mN}}}\n"),
      Contains("scene.yaml:6:25") && Contains("calibrate.experiment: a release experiment measures on this body "
                                              "no modulus to calibrate to; take tension, shear or material"));
  CHECK_THROWS_WITH(run(pull + "calibrate: {experimemt: {kind: material}}\n"),
                    Contains("scene.yaml:6:") && Contains("experiment"));
}

TEST_CASE("a list for stiffness points to strategies", "[scene]") {
  const TemporaryFolder folder;
  CHECK_THROWS_WITH(
      load_scene(folder.write("scene.yaml", "title: A block\n" + kLattice +
                                                "material: {youngs_modulus: 10 kPa}\nstiffness: [standard, "
                                                "lattice]\nexperiment: {kind: material}\n"),
                 built_in_catalog()),
      Contains("scene.yaml:4:12: stiffness: is a list, and names one strategy: a word, or {strategy: NAME, …}; "
               "several are for `compare`, as strategies: [standard, lattice] next to it or --strategies"));
}
