// Specimens in their grips, relaxation, and springs fitted to the same curve.

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>

#include "lab/identify/fit.h"
#include "lab/identify/identify.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;

namespace {

const Catalog kCatalog = built_in_catalog();
const std::string kScenes = std::string(ELASTIN_SOURCE_DIR) + "/scenes/identify/";

}  // namespace

TEST_CASE("a dog-bone in its clamps gives E to 0.1 per cent, where section and length are far off",
          "[identify][slow]") {
  // The force is that of E = 200 kPa on cells of half the size.
  const Answer answer =
      identify(kScenes + "dogbone.yaml", kCatalog, {.overrides = {"material.youngs_modulus=190 kPa"}}).front();
  CHECK(answer.outcome == FitOutcome::converged);
  CHECK(answer.numbers.front().value == Approx(200e3).epsilon(1e-3));
  CHECK(answer.tests[1].relative_rms > 0.02);  // what the material gives without clamps, compared with the force
}

TEST_CASE("a bubble gives E to 0.5 per cent from the heights of the exact membrane", "[identify][slow]") {
  const Answer answer = identify(kScenes + "bubble.yaml", kCatalog, {.overrides = {"body.disc.rings=8"}}).front();
  INFO(answer.cause);
  REQUIRE(answer.outcome == FitOutcome::converged);
  CHECK(answer.numbers.front().value == Approx(1.8e6).epsilon(5e-3));
  CHECK(answer.tests.front().relative_rms < 2e-3);
}

TEST_CASE("an indentation gives E to 0.5 per cent from the forces of a finer body", "[identify][slow]") {
  const Answer answer =
      identify(kScenes + "indentation.yaml", kCatalog, {.overrides = {"material.youngs_modulus=11 kPa"}}).front();
  INFO(answer.cause);
  REQUIRE(answer.outcome == FitOutcome::converged);
  CHECK(answer.numbers.front().value == Approx(12e3).epsilon(5e-3));
}

TEST_CASE("relaxation gives the law and its Prony terms", "[identify][slow]") {
  const Answer answer = identify(kScenes + "relaxation.yaml", kCatalog, {}).front();
  const double made_with[] = {400, 0.3, 1, 0.25, 12};
  REQUIRE(answer.numbers.size() == 5);
  for (std::size_t i = 0; i < 5; ++i) {
    INFO(answer.numbers[i].name);
    CHECK(answer.numbers[i].deviation < 0.04 * made_with[i]);
    CHECK(std::abs(answer.numbers[i].value - made_with[i]) < 3 * answer.numbers[i].deviation);
  }
  CHECK(answer.tests.front().relative_rms == Approx(3e-3).epsilon(0.4));  // the scatter that they were made with
}

TEST_CASE("of the brain one Ogden term is enough that is stable and determined, next to the published numbers",
          "[identify]") {
  // Budday et al. 2017, Table 7, at second hand: quoted from another paper's table.
  struct Region {
    std::string scene;
    double mu, alpha;
  };
  for (const auto& [scene, mu, alpha] :
       {Region{"brain-cortex", 1430, -19}, Region{"brain-corona-radiata", 660, -24.3}}) {
    INFO(scene);
    const Answer answer =
        identify(kScenes + scene + ".yaml", kCatalog, {.laws = "ogden/1,mooney_rivlin,yeoh/2"}).front();
    CHECK(answer.laws.front().label == "ogden/1");
    CHECK(answer.numbers[0].published == Approx(mu));
    CHECK(answer.numbers[1].published == Approx(alpha));
    CHECK(answer.numbers[0].value == Approx(mu).epsilon(0.15));
    CHECK(answer.numbers[1].value == Approx(alpha).epsilon(0.15));
    CHECK(answer_text(answer, false).find("published: Budday et al. 2017") != std::string::npos);
  }
  const Answer other = identify(kScenes + "brain-cortex.yaml", kCatalog, {.laws = "mooney_rivlin"}).front();
  CHECK(other.published_source.empty());  // of another law they say nothing
}

TEST_CASE("a published number that the material does not have is named", "[identify]") {
  const TemporaryFolder folder;
  folder.write("data.csv", "stretch,nominal_stress [Pa]\n1.1,270\n1.2,520\n1.3,710\n1.4,900\n");
  const auto scene = [&](const std::string& published) {
    return folder.write("scene.yaml", "material: {law: yeoh, terms: [300 Pa]}\nidentify:\n  published: " + published +
                                          "\n  tests: [{kind: uniaxial, file: data.csv}]\n");
  };
  CHECK_THROWS_WITH(identify(scene("{source: me, c_2: 1 Pa}"), kCatalog, {}),
                    Catch::Matchers::Contains("scene.yaml:3:") && Catch::Matchers::Contains("no number 'c_2'") &&
                        Catch::Matchers::Contains("'c_1'"));
  CHECK_THROWS_WITH(identify(scene("{source: me, c_1: 1 mm}"), kCatalog, {}),
                    Catch::Matchers::Contains("scene.yaml:3:"));
  CHECK_THROWS_WITH(identify(scene("{c_1: 1 Pa}"), kCatalog, {}), Catch::Matchers::Contains("key 'source' is missing"));
}

TEST_CASE("springs are fitted to the same curve as the solid", "[identify]") {
  const TemporaryFolder folder;
  folder.write("data.csv", "displacement [mm],force [mN]\n0.2,30\n0.4,60\n0.6,90\n");
  const std::string scene = folder.write(
      "scene.yaml",
      "body: {tetrahedra: {kind: body_centred, cubes: [2, 2, 4], size: [10 mm, 10 mm, 20 mm]}}\nmaterial: "
      "{youngs_modulus: 10 kPa, poissons_ratio: 0.25}\nstiffness: neo_hookean\nexperiment: {kind: tension, "
      "axis: z, displacement: 1 mm}\nidentify: {tests: [{kind: specimen, file: data.csv}]}\n");
  const auto answers = identify(scene, kCatalog, {.strategies = "neo_hookean,van_gelder,calibrated:van_gelder"});
  REQUIRE(answers.size() == 3);
  for (const Answer& answer : answers) {
    INFO(answer.strategy << ": " << answer.cause);
    REQUIRE(answer.outcome == FitOutcome::converged);
    CHECK(answer.tests.front().relative_rms < 0.05);
  }
  // 30 mN over 1 cm² at 1 % of strain; the body-centred springs of [VG98] show 0.916 of their E.
  CHECK(answers[0].numbers.front().value == Approx(30e3).epsilon(0.05));
  CHECK(answers[2].numbers.front().value == Approx(answers[0].numbers.front().value).epsilon(0.05));
  CHECK(answers[1].numbers.front().value / answers[2].numbers.front().value == Approx(1 / 0.916).epsilon(0.02));
  // One that is unsuited does not take the others away.
  const auto some = identify(scene, kCatalog, {.strategies = "lattice,neo_hookean"});
  REQUIRE(some.size() == 2);
  CHECK(some[0].outcome == FitOutcome::failed);
  CHECK(some[0].cause.find("needs a simple cubic lattice") != std::string::npos);
  CHECK(answers_text(some, false).find("needs a simple cubic lattice") != std::string::npos);
  CHECK(some[1].outcome == FitOutcome::converged);
  CHECK_THROWS_WITH(identify(scene, kCatalog, {.strategies = "lattice"}),
                    Catch::Matchers::Contains("needs a simple cubic lattice"));
}

TEST_CASE("a specimen's readings that scatter to the other side of rest are left out", "[identify]") {
  const TemporaryFolder folder;
  const auto modulus = [&](const std::string& at_rest) {
    folder.write("data.csv", "displacement [mm],force [mN]\n" + at_rest + "0.2,30\n0.4,60\n0.6,90\n");
    return identify(folder.write("scene.yaml",
                                 "body: {tetrahedra: {kind: body_centred, cubes: [2, 2, 4], size: [10 mm, 10 mm, 20 "
                                 "mm]}}\nmaterial: {youngs_modulus: 10 kPa, poissons_ratio: 0.25}\nstiffness: "
                                 "neo_hookean\nexperiment: {kind: tension, axis: z, displacement: 1 mm}\nidentify: "
                                 "{tests: [{kind: specimen, file: data.csv}]}\n"),
                    kCatalog, {})
        .front()
        .numbers.front()
        .value;
  };
  CHECK(modulus("-0.0003,0\n") == Approx(modulus("")));
  CHECK(modulus("-0.0003,0.1\n0,-0.1\n-0.002,0\n") == Approx(modulus("")));
  CHECK_THROWS_WITH(modulus("-0.01,0\n"),
                    Catch::Matchers::Contains("data.csv:2: displacement of -1e-05 has the other sign"));
  CHECK_THROWS_WITH(modulus("-0.0003,5\n"), Catch::Matchers::Contains("data.csv:2: force is 0.005 (SI) at rest"));
}

TEST_CASE("a specimen's search that is settled at a bound ends there", "[identify]") {
  const TemporaryFolder folder;
  folder.write("data.csv", "displacement [mm],force [N]\n1,0.05\n2,0.1\n");
  int iterations = 0;
  const Answer answer =
      identify(folder.write("scene.yaml",
                            "body: {tetrahedra: {kind: body_centred, cubes: [2, 2, 4], size: [10 mm, 10 mm, 20 mm]}}\n"
                            "material: {youngs_modulus: 8 kPa, poissons_ratio: 0.3}\nstiffness: neo_hookean\n"
                            "experiment: {kind: tension, axis: z, displacement: 2 mm}\nidentify: {unknowns: "
                            "{youngs_modulus: {high: 10 kPa}}, tests: [{kind: specimen, file: data.csv}]}\n"),
               kCatalog, {.progress = [&](const std::string&) { ++iterations; }})
          .front();
  INFO(answer.cause);
  CHECK(answer.outcome == FitOutcome::bound_reached);
  CHECK(answer.numbers.front().value == Approx(10e3));
  CHECK(iterations < 10);
}

TEST_CASE("another law than the scene's is fitted to a specimen as that law's cells", "[identify]") {
  const TemporaryFolder folder;
  const auto scene = [&](const std::string& material, const std::string& stiffness) {
    return folder.write("scene.yaml",
                        "body: {tetrahedra: {kind: kuhn, cubes: [2, 2, 3], size: [8 mm, 8 mm, 12 mm]}}\nmaterial: " +
                            material + "\nstiffness: " + stiffness +
                            "\nexperiment: {kind: tension, axis: z, displacement: 9 mm, fixed_grip: clamped, "
                            "loaded_grip: clamped}\nidentify: {tests: [{kind: specimen, file: data.csv}]}\n");
  };
  folder.write("data.csv", "displacement [mm],force [N]\n1.5,1\n3,2\n4.5,3\n6,4\n7.5,5\n9,6\n");
  const std::string path = scene("{law: yeoh, terms: [500 Pa, 300 Pa], bulk_modulus: 8 kPa}", "yeoh");
  const IdentifyTask task = load_identify_task(path, kCatalog);
  const auto row = kCatalog.material_laws.find("yeoh");
  const auto made = make_measured_test(task.tests.front(), kCatalog, row.get(), task.material, {})
                        ->predict({row.get(), task.material, {}});
  REQUIRE(made.has_value());
  std::string data = "displacement [mm],force [N]\n";
  for (int i = 0; i < 6; ++i) data += fmt::format("{},{:.12g}\n", 1.5 * (i + 1), made->values[i]);
  folder.write("data.csv", data);
  for (const auto& [material, stiffness] :
       {std::pair{"{law: mooney_rivlin, c1: 1 kPa, c2: 0.2 kPa, bulk_modulus: 8 kPa}", "mooney_rivlin"},
        std::pair{"{youngs_modulus: 2.82352941 kPa, poissons_ratio: 0.441176471}", "neo_hookean"}}) {
    const Answer answer = identify(scene(material, stiffness), kCatalog, {.laws = "yeoh/1,yeoh/2"}).front();
    INFO(answer.cause);
    REQUIRE(answer.laws.size() == 2);
    CHECK(answer.laws.front().label == "yeoh/2");
    REQUIRE(answer.numbers.size() == 2);
    CHECK(answer.numbers[0].value == Approx(500).epsilon(1e-4));
    CHECK(answer.numbers[1].value == Approx(300).epsilon(1e-4));
    REQUIRE(answer.keys.size() == 1);
    CHECK(answer.keys.front() == std::pair<std::string, std::string>{"stiffness", "yeoh"});
  }
}

TEST_CASE(
    "a search that does with rough equilibria ends where the exact one does, to a hundredth of the deviations, and "
    "so does its profile, to a twentieth of the interval",
    "[identify][slow]") {
  const TemporaryFolder folder;
  folder.write("data.csv", "displacement [mm],force [mN]\n1,47.3\n2,87.7\n3,124.1\n4,156.2\n5,184.9\n6,211.8\n");
  const IdentifyTask task = load_identify_task(
      folder.write("scene.yaml",
                   "body: {tetrahedra: {kind: kuhn, cubes: [3, 3, 5], size: [8 mm, 8 mm, 15 mm]}}\nmaterial: {law: "
                   "mooney_rivlin, c1: 1.5 kPa, c2: 1.5 kPa, bulk_modulus: 15 kPa}\nstiffness: mooney_rivlin\n"
                   "experiment: {kind: tension, axis: z, displacement: 6 mm, fixed_grip: clamped, loaded_grip: "
                   "clamped}\nidentify: {tests: [{kind: specimen, file: data.csv}]}\n"),
      kCatalog);
  const auto row = kCatalog.material_laws.find("mooney_rivlin");
  UnknownMaterial unknown{"", row.get(), task.material, material_numbers(row.get(), task.material)};
  unknown.unknowns.resize(2);  // c1 and c2
  Fit fits[2];
  std::pair<double, double> ends[2];
  for (const bool rough : {false, true}) {
    std::vector<WeightedTest> tests;
    tests.push_back(
        {&task.tests.front(), make_measured_test(task.tests.front(), kCatalog, row.get(), task.material, {})});
    FitOptions options;
    options.starts = 1, options.rough = rough;
    fits[rough] = fit_material(unknown, tests, options);
    INFO(fits[rough].cause);
    REQUIRE(fits[rough].outcome == FitOutcome::converged);
    const Uncertainty known = uncertainty(fits[rough].residuals, fits[rough].jacobian, fits[rough].values);
    ends[rough] = profile_interval(unknown, tests, fits[rough], known, 0);
  }
  CHECK(ends[1].first == Approx(ends[0].first).margin(0.05 * (ends[0].second - ends[0].first)));
  CHECK(ends[1].second == Approx(ends[0].second).margin(0.05 * (ends[0].second - ends[0].first)));
  const Uncertainty known = uncertainty(fits[0].residuals, fits[0].jacobian, fits[0].values);
  for (Eigen::Index i = 0; i < 2; ++i)
    CHECK(std::abs(fits[1].values[i] - fits[0].values[i]) < 0.01 * known.deviations[i]);
  CHECK(fits[1].evaluations < fits[0].evaluations);
}

TEST_CASE("a specimen whose scene does not prescribe what was measured is refused", "[identify]") {
  const TemporaryFolder folder;
  const auto message = [&](const std::string& data, const std::string& experiment) {
    folder.write("data.csv", data);
    try {
      identify(folder.write("scene.yaml",
                            "body: {tetrahedra: {kind: kuhn, cubes: [1, 1, 2], size: [10 mm, 10 mm, 20 mm]}}\n"
                            "material: {youngs_modulus: 10 kPa}\nstiffness: neo_hookean\nexperiment: " +
                                experiment + "\nidentify: {tests: [{kind: specimen, file: data.csv}]}\n"),
               kCatalog, {});
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const std::string pulled = "{kind: tension, axis: z, displacement: 1 mm}";
  CHECK(message("displacement [mm],force [N]\n1,0.1\n2,0.2\n", pulled)
            .find("data.csv:3: displacement of 0.002 is beyond") != std::string::npos);
  CHECK(message("angle [deg],torque [N m]\n1,0.1\n2,0.2\n", pulled).find("it shows no angle") != std::string::npos);
  CHECK(message("displacement [mm],force [N]\n0.5,0.1\n1,0.2\n", "{kind: tension, axis: z, force: 1 N}")
            .find("the data must be over what the scene prescribes") != std::string::npos);
  const std::string pressed = "{kind: compression, axis: z, displacement: 1 mm}";
  CHECK(message("displacement [mm],force [N]\n0.5,0.1\n1,0.2\n", pressed)
            .find("data.csv:3: force of 0.2 (SI) has the other sign") != std::string::npos);
  CHECK(message("displacement [mm],force [N]\n0.5,-0.1\n1,-0.2\n", pressed)
            .find("data.csv:2: displacement of 0.0005 has the other sign") != std::string::npos);
  CHECK(message("displacement [mm],force [N]\n0.5,-0.1\n1,-0.2\n", pulled)
            .find("data.csv:3: force of -0.2 (SI) has the other sign") != std::string::npos);
  CHECK(message("displacement [mm],force [N]\n0,0.01\n0.5,0.1\n1,0.2\n", pulled)
            .find("data.csv:2: force is 0.01 (SI) at rest, where it is 0: zero: found counts") != std::string::npos);
}
