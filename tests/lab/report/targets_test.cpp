// What a run is compared with: at a strain the law's own secant there, and nothing where the specimen does not show it.

#include <catch2/catch.hpp>
#include <cmath>

#include "lab/report/comparison.h"
#include "lab/report/records.h"
#include "lab/run/specimen.h"
#include "support/cells.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;
using namespace elastin::testing;
using Catch::Matchers::Contains;

namespace {

const Catalog kCatalog = built_in_catalog();
constexpr double kE = 120e3, kNu = 0.3, kMu = kE / (2 * (1 + kNu)), kLambda = 2 * kMu * kNu / (1 - 2 * kNu);

std::unique_ptr<Scene> scene_of(const std::string& experiment, const std::string& strategy,
                                const std::string& material = "{youngs_modulus: 120 kPa, poissons_ratio: 0.3}",
                                const std::string& more = "") {
  const TemporaryFolder folder;
  folder.write("scene.yaml",
               "body: {tetrahedra: {kind: body_centred, cubes: [3, 2, 2], size: [15 mm, 10 mm, 10 mm]}}\n"
               "material: " +
                   material + "\nstiffness: " + strategy + "\nexperiment: " + experiment + "\n" + more);
  return load_scene(folder.path("scene.yaml"), kCatalog);
}

Record record_of(const Scene& scene) {
  RunOptions options;
  options.statics = scene.statics;
  return make_record(scene, run_strategy(scene.specimen, *scene.experiment, scene.stiffness, options));
}

const MainMeasure& target_of(const Record& record, const std::string& name) {
  const MainMeasure* target = record.law_target(name);
  REQUIRE(target);
  return *target;
}

}  // namespace

TEST_CASE("a bar's target is the secant of its law at the bar's strain", "[targets]") {
  for (const UniaxialRow& row : kNeoHookeanUniaxial) {
    if (row.poissons_ratio != kNu) continue;
    const double strain = row.stretch - 1;
    CAPTURE(strain);
    const Record record = record_of(
        *scene_of("{kind: tension, axis: x, load_steps: 5, strain: " + std::to_string(strain) + "}", "neo_hookean"));
    const MainMeasure& modulus = target_of(record, "effective_modulus");
    CHECK(modulus.strain == Approx(strain).epsilon(1e-9));
    CHECK(modulus.prescribed == Approx(kE * row.nominal / strain).epsilon(1e-5));  // the table's digits
    CHECK(target_of(record, "poissons_ratio").prescribed == Approx((1 - row.lateral) / strain).epsilon(1e-4));
    CHECK(std::abs(record.error("effective_modulus")) < 1e-8);
    CHECK(std::abs(record.error("poissons_ratio")) < 1e-8);
  }
}

TEST_CASE("shear and pressure have targets of their law, too", "[targets]") {
  constexpr double shear = 0.4, stretch = 1.1, J = stretch * stretch * stretch;
  const Record sheared =
      record_of(*scene_of("{kind: shear, axis: z, direction: x, strain: 0.4, sides: affine}", "st_venant_kirchhoff"));
  // P₁₂ = γ (μ + (λ/2 + μ) γ²)
  CHECK(target_of(sheared, "shear_modulus").prescribed ==
        Approx(kMu + (kLambda / 2 + kMu) * shear * shear).epsilon(1e-9));
  CHECK(std::abs(sheared.error("shear_modulus")) < 1e-8);
  const Record pressed = record_of(*scene_of("{kind: hydrostatic, strain: 0.1}", "neo_hookean"));
  const double stress = (kMu * (stretch - 1 / stretch) + kLambda * (J - 1) * stretch * stretch) / (stretch * stretch);
  CHECK(target_of(pressed, "bulk_modulus").prescribed == Approx(stress / (J - 1)).epsilon(1e-9));
  const Record drawn = record_of(*scene_of("{kind: biaxial, axis: x, across: y, strain: [0.3, 0.1]}", "neo_hookean"));
  CHECK(std::abs(drawn.error("effective_modulus")) < 1e-8);
  CHECK(std::abs(drawn.error("poissons_ratio")) < 1e-8);
}

TEST_CASE("every strategy is compared with the law that the material states, and the table says where", "[targets]") {
  const std::string ogden = "{law: ogden, terms: [[100 Pa, 4]], bulk_modulus: 3000 Pa}",
                    pulled = "{kind: tension, axis: x, strain: 0.5, load_steps: 4}";
  const Record own = record_of(*scene_of(pulled, "{strategy: ogden, volume: none}", ogden));
  CHECK(std::abs(own.error("effective_modulus")) < 1e-8);
  CHECK(std::abs(own.error("poissons_ratio")) < 1e-8);  // not its ν at rest, 0.467
  const Record other = record_of(*scene_of(pulled, "{strategy: neo_hookean, volume: none}", ogden));
  CHECK(target_of(other, "effective_modulus").prescribed == target_of(own, "effective_modulus").prescribed);
  CHECK(other.error("effective_modulus") < -0.2);
  CHECK_THAT(other.warnings.at(0), Contains("takes of the material's law ogden only its E and nu at rest"));
  const std::string text = comparison_text({own, other}, false);
  CHECK_THAT(text, Contains("target at strain") && Contains("572.24 Pa at 50 %"));
  CHECK(record_of_json(json_line(own)).law_target("effective_modulus")->strain == Approx(0.5));
}

TEST_CASE("springs have no law: their target is E at rest", "[targets]") {
  const Record record = record_of(*scene_of("{kind: tension, axis: x, strain: 0.1}", "standard"));
  CHECK(record.law_target("effective_modulus") == nullptr);
  CHECK(record.main_measures.front().prescribed == 120e3);
}

TEST_CASE("between clamps nothing is compared with the material", "[targets]") {
  const Record record = record_of(
      *scene_of("{kind: tension, axis: x, strain: 0.1, fixed_grip: clamped, loaded_grip: clamped}", "neo_hookean"));
  CHECK(record.errors.empty());
  CHECK_THAT(run_text(record, false, false), !Contains(" %  Young's modulus"));
}

TEST_CASE("where nothing touches the gap is said", "[targets]") {
  const Record record =
      record_of(*scene_of("{kind: indentation, indenter: tool, depth: 1 mm}", "neo_hookean",
                          "{youngs_modulus: 120 kPa, poissons_ratio: 0.3}",
                          "contact: {obstacles: [{name: tool, sphere: {radius: 2 mm}, at: [5 mm, 5 mm, 15 mm]}]}\n"));
  CHECK(record.run.remark == "the indenter touches nothing: the obstacle 'tool' is 2 mm away");  // 15 − 2 − 10 − 1
}

TEST_CASE("a study of Poisson's ratio shows what was measured", "[targets]") {
  std::vector<Record> records;
  for (const char* ratio : {"0.2", "0.3"}) {
    records.push_back(record_of(*scene_of("{kind: tension, axis: x, strain: 0.000001}", "neo_hookean",
                                          std::string("{youngs_modulus: 120 kPa, poissons_ratio: ") + ratio + "}")));
    records.back().variant = {{"material.poissons_ratio", ratio}};
  }
  const std::string text = study_table(records, rank_strategies(records)).text(false);
  CHECK_THAT(text, Contains("Poisson's ratio") && Contains("its target") && Contains("0.2000") && Contains("0.3000"));
}

TEST_CASE("a study of what has nothing to compare with shows what was measured", "[targets]") {
  const std::vector<Record> records{record_of(
      *scene_of("{kind: tension, axis: x, strain: 0.1, fixed_grip: clamped, loaded_grip: clamped}", "neo_hookean"))};
  REQUIRE(records.front().errors.empty());
  const std::string text = study_table(records, rank_strategies(records)).text(false),
                    modulus = readable(records.front().run.measures.get("effective_modulus"), dimension::pressure);
  CHECK_THAT(text, Contains(" E ") && Contains(modulus) && Contains("Poisson's ratio") && !Contains("error"));
}

TEST_CASE("what is nearer and faster than the recommended strategy is named, with the reason", "[targets]") {
  std::vector<Record> records;
  for (const char* name : {"standard", "neo_hookean"}) {
    records.push_back(record_of(*scene_of("{kind: tension, axis: x, strain: 0.000001}", "neo_hookean")));
    records.back().run.strategy = name;
  }
  records[0].errors = {{"effective_modulus", 1e-5}}, records[1].errors = {{"effective_modulus", 2e-4}};
  records[0].run.solve_seconds = 1e-3, records[1].run.solve_seconds = 1;
  records[0].run.warnings = {"something"}, records[1].run.warnings.clear();
  const Ranking ranking = rank_strategies(records);
  REQUIRE(ranking.best == &records[1]);
  CHECK_THAT(advice_text(ranking, false), Contains("not standard, which is nearer and faster: it has a warning"));
  records[0].errors = {{"effective_modulus", 2e-16}}, records[1].errors = {{"effective_modulus", 7e-9}};
  CHECK_THAT(advice_text(rank_strategies(records), false), !Contains("nearer"));  // both meet it
}

TEST_CASE("laws that each meet their own target are no recommendation where the material states none", "[targets]") {
  const auto advice = [](double strain, const std::string& material) {
    const std::string pulled = "{kind: tension, axis: x, load_steps: 3, strain: " + std::to_string(strain) + "}";
    std::vector<Record> records;
    for (const std::string law : {"st_venant_kirchhoff", "neo_hookean"})
      records.push_back(record_of(*scene_of(pulled, "{strategy: " + law + ", volume: none}", material)));
    const Ranking ranking = rank_strategies(records);
    REQUIRE(ranking.best);
    return advice_text(ranking, false);
  };
  const std::string moduli = "{youngs_modulus: 120 kPa, poissons_ratio: 0.3}";
  // At λ = 1.3 St. Venant and Kirchhoff's secant is E λ (λ + 1)/2.
  CHECK_THAT(advice(0.3, moduli),
             Contains("no recommendation: st_venant_kirchhoff, neo_hookean each meet their own target") &&
                 Contains("to 179.40 kPa (st_venant_kirchhoff)") && Contains("state its `law` or `curve`"));
  CHECK_THAT(advice(0.001, moduli), Contains("recommended: st_venant_kirchhoff (tied with neo_hookean)"));
}

// A muscle along z that bears T in simple shear along x adds T f(l)/l^2, f = 1 - 4 (1 - l)^2, l = sqrt(1 + g^2) to mu.
TEST_CASE("the target of a muscle at work is its law's own where every point is alike, and is none in tension",
          "[targets][muscle]") {
  const std::string muscle = "{youngs_modulus: 120 kPa, poissons_ratio: 0.3, active: {direction: z, stress: 30 kPa}}";
  const double g = 0.05, l = std::sqrt(1 + g * g);
  const Record sheared = record_of(
      *scene_of("{kind: shear, axis: z, direction: x, sides: affine, strain: 0.05}", "neo_hookean_log", muscle));
  CHECK(target_of(sheared, "shear_modulus").prescribed ==
        Approx(kMu + 30e3 * (1 - 4 * (1 - l) * (1 - l)) / (l * l)).epsilon(1e-8));
  CHECK(std::abs(sheared.error("shear_modulus")) < 1e-8);
  CHECK(std::abs(
            record_of(*scene_of("{kind: hydrostatic, strain: 2 %}", "neo_hookean_log", muscle)).error("bulk_modulus")) <
        1e-7);
  const Record biaxial =
      record_of(*scene_of("{kind: biaxial, axis: x, across: y, strain: 2 %}", "neo_hookean_log", muscle));
  CHECK(std::abs(biaxial.error("effective_modulus")) < 1e-6);
  const Record pulled = record_of(*scene_of("{kind: tension, axis: x, strain: 2 %}", "neo_hookean_log", muscle));
  CHECK_THAT(pulled.no_reference, Contains("muscle is at work"));
  CHECK_FALSE(std::isfinite(pulled.error("effective_modulus")));
}

TEST_CASE("a body that other loads have strained has no target of one at rest, and the run says why", "[targets]") {
  const auto record = [](const std::string& acceleration) {
    return record_of(*scene_of("{kind: tension, axis: x, strain: 1 %}", "neo_hookean",
                               "{youngs_modulus: 120 kPa, poissons_ratio: 0.3, density: 1000 kg/m3}",
                               "loads: [{gravity: [" + acceleration + ", 0, 0]}]\n"));
  };
  const Record light = record("10 m/s2"), heavy = record("1000 m/s2");
  CHECK(light.no_reference.empty());
  CHECK(std::isfinite(light.error("effective_modulus")));
  CHECK(light.run.measures.get("preload_strain") < 0.02);
  CHECK_THAT(heavy.no_reference, Contains("the scene's own loads strain the body by up to "));
  CHECK_FALSE(std::isfinite(heavy.error("effective_modulus")));
}

TEST_CASE("directions askew to the load have no one modulus, and along or across it they have", "[targets][fibres]") {
  const auto of_fibres = [](const std::string& direction) {
    return record_of(*scene_of("{kind: tension, axis: x, strain: 0.2, load_steps: 2}", "neo_hookean",
                               "{youngs_modulus: 120 kPa, poissons_ratio: 0.3, fibre: {direction: " + direction +
                                   ", youngs_modulus: 600 kPa}}"));
  };
  const Record askew = of_fibres("[1, 0, 1]");
  CHECK_THAT(askew.no_reference, Contains("askew to the load") && Contains("another where they may tilt"));
  CHECK_FALSE(std::isfinite(askew.error("effective_modulus")));
  for (const std::string direction : {"x", "z"}) {
    INFO(direction);
    CHECK(std::abs(of_fibres(direction).error("effective_modulus")) < 1e-8);
  }
  const Record law =
      record_of(*scene_of("{kind: tension, axis: x, strain: 0.2, load_steps: 2}", "transversely_isotropic",
                          "{law: transversely_isotropic, c1: 10 kPa, c3: 2 kPa, c4: 20, c5: 300 kPa, "
                          "lambda_max: 1.07, direction: [1, 0, 1], bulk_modulus: 30 kPa}"));
  CHECK_THAT(law.no_reference, Contains("askew to the load") && Contains("Pa where they may tilt"));
}

TEST_CASE("at rest a material of instantaneous moduli is compared with what is left of them", "[targets]") {
  const std::string material =
      "{youngs_modulus: 120 kPa, poissons_ratio: 0.3, relaxation: {terms: [[0.5, 1 s]], moduli: instantaneous}}";
  for (const char* strain : {"1e-6", "0.2"}) {
    CAPTURE(strain);
    const std::string experiment = std::string("{kind: tension, axis: x, load_steps: 5, strain: ") + strain + "}";
    const Record relaxed = record_of(*scene_of(experiment, "\"prony:neo_hookean\"", material));
    CHECK(std::abs(relaxed.error("effective_modulus")) < 1e-6);
    const Record elastic = record_of(*scene_of(experiment, "neo_hookean", material));
    CHECK(elastic.error("effective_modulus") == Approx(1).epsilon(1e-6));
    CHECK_THAT(relaxed.prescribed, Contains("at rest 0.5 of it, E = 60.000 kPa"));
  }
}
