// Unknowns that no law has: points of a curve, parameters of spring rules, friction; each found again from data made
// with it.

#include <catch2/catch.hpp>
#include <cmath>

#include "lab/identify/identify.h"
#include "lab/run/run.h"
#include "lab/scene/scene.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;

namespace {

const Catalog kCatalog = built_in_catalog();

/// What a scene shows, as data: a line a load step.
std::string data_of(const std::string& scene, const std::string& head, const std::string& along,
                    const std::string& up) {
  const auto built = load_scene(scene, kCatalog);
  RunOptions options;
  options.statics = built->statics;
  const Run run = run_strategy(built->specimen, *built->experiment, built->stiffness, options);
  REQUIRE(run.outcome == Outcome::converged);
  std::string data = head + "\n";
  for (const CurvePoint& point : run.curve) {
    char line[80];
    std::snprintf(line, sizeof line, "%.12g,%.12g\n", point.measures.get(along), point.measures.get(up));
    data += line;
  }
  return data;
}

}  // namespace

TEST_CASE("points of a curve are found from uniaxial data", "[identify]") {
  const TemporaryFolder folder;
  const StressStrain truth = StressStrain::through({{-0.2, -3e3}, {0, 0}, {0.1, 1e3}, {0.3, 6e3}});
  std::string data = "nominal_strain,nominal_stress [Pa]\n";
  for (int i = -8; i <= 12; ++i)
    if (i != 0) data += std::to_string(0.025 * i) + "," + std::to_string(truth.stress(0.025 * i)) + "\n";
  folder.write("data.csv", data);
  const Answer answer =
      identify(folder.write("scene.yaml",
                            "material: {curve: {points: [[-20 %, -2 kPa], [0, 0 kPa], [10 %, 2 kPa], [30 %, 5 kPa]]}}\n"
                            "identify: {starts: 1, tests: [{kind: uniaxial, file: data.csv}]}\n"),
               kCatalog, {})
          .front();
  INFO(answer.cause);
  REQUIRE(answer.outcome == FitOutcome::converged);
  REQUIRE(answer.numbers.size() == 3);
  CHECK(answer.numbers[0].name == "stress_1");
  const double made_with[] = {-3e3, 1e3, 6e3};
  for (std::size_t i = 0; i < 3; ++i) CHECK(answer.numbers[i].value == Approx(made_with[i]).epsilon(1e-6));
  // The block that comes out states the curve that was found, and is read again.
  const IdentifyTask again = load_identify_task(
      folder.write("found.yaml", answer.material + "identify: {tests: [{kind: uniaxial, file: data.csv}]}\n"),
      kCatalog);
  CHECK(again.material.curve->stress(0.2) == Approx(truth.stress(0.2)).epsilon(1e-6));
}

TEST_CASE("a parameter of a spring rule is found from the force of its specimen", "[identify]") {
  const TemporaryFolder folder;
  const auto scene = [](const std::string& exponent, const std::string& more) {
    return "body: {lattice: {kind: cubic, molecules: [3, 3, 4], spacing: 5 mm, connections: [axis, face]}}\n"
           "material: {youngs_modulus: 10 kPa}\nstiffness: {strategy: angles, exponent: " +
           exponent + "}\nexperiment: {kind: tension, axis: z, displacement: 1 mm, load_steps: 2}\n" + more;
  };
  folder.write("data.csv", data_of(folder.write("made.yaml", scene("-0.5", "")), "displacement [m],force [N]",
                                   "elongation", "force"));
  const std::string unknown = "identify: {unknowns: [exponent], tests: [{kind: specimen, file: data.csv}]}\n";
  const Answer answer = identify(folder.write("scene.yaml", scene("1", unknown)), kCatalog, {}).front();
  INFO(answer.cause);
  REQUIRE(answer.outcome == FitOutcome::converged);
  CHECK(answer.numbers.at(0).value == Approx(-0.5).epsilon(1e-6));
}

TEST_CASE("friction is found from the force of an indenter that slides", "[identify]") {
  const TemporaryFolder folder;
  const auto scene = [](const std::string& friction, const std::string& more) {
    return "body: {tetrahedra: {kind: body_centred, cubes: [3, 3, 2], size: [10 mm, 10 mm, 6 mm]}}\n"
           "material: {youngs_modulus: 10 kPa, poissons_ratio: 0.3}\nstiffness: neo_hookean\n"
           "experiment: {kind: indentation, indenter: {sphere: {radius: 6 mm}}, depth: 1.5 mm, load_steps: 3}\n"
           "contact: {friction: " +
           friction + "}\n" + more;
  };
  folder.write("data.csv",
               data_of(folder.write("made.yaml", scene("0.12", "")), "displacement [m],force [N]", "depth", "force"));
  const std::string unknown =
      "identify: {unknowns: {friction: {low: 0, high: 1}}, tests: [{kind: specimen, file: data.csv}]}\n";
  const Answer answer = identify(folder.write("scene.yaml", scene("0.05", unknown)), kCatalog, {}).front();
  INFO(answer.cause);
  REQUIRE(answer.succeeded());
  CHECK(answer.numbers.at(0).value == Approx(0.12).epsilon(1e-3));
}

TEST_CASE("an unknown that is nowhere is named with its neighbour", "[identify]") {
  const TemporaryFolder folder;
  folder.write("data.csv", "displacement [mm],force [N]\n1,0.1\n2,0.2\n");
  const std::string scene =
      folder.write("scene.yaml",
                   "body: {lattice: {kind: cubic, molecules: [2, 2, 2], spacing: 5 mm}}\nmaterial: {youngs_modulus: 10 "
                   "kPa}\nstiffness: angles\nexperiment: {kind: tension, axis: z, displacement: 2 mm}\nidentify: "
                   "{unknowns: [exponnt], tests: [{kind: specimen, file: data.csv}]}\n");
  CHECK_THROWS_WITH(identify(scene, kCatalog, {}), Catch::Matchers::Contains("no number 'exponnt' here") &&
                                                       Catch::Matchers::Contains("did you mean 'exponent'"));
}

TEST_CASE("E and nu are found from three specimens of one material, each in a machine of its own", "[identify][slow]") {
  const TemporaryFolder folder;
  const auto scene = [&](const std::string& name, const std::string& size, const std::string& experiment) {
    return folder.write(name + ".yaml", "body: {tetrahedra: {kind: body_centred, " + size +
                                            "}}\nmaterial: {youngs_modulus: 12 kPa, poissons_ratio: 0.4}\nstiffness: "
                                            "neo_hookean\nexperiment: " +
                                            experiment + "\n");
  };
  const std::string bar = "cubes: [2, 2, 3], size: [10 mm, 10 mm, 15 mm]",
                    layer = "cubes: [3, 3, 2], size: [15 mm, 15 mm, 10 mm]";
  folder.write("pull.csv", data_of(scene("pull", bar,
                                         "{kind: tension, axis: z, displacement: 2 mm, fixed_grip: clamped, "
                                         "loaded_grip: clamped, load_steps: 3}"),
                                   "displacement [m],force [N]", "elongation", "force"));
  folder.write("twist.csv", data_of(scene("twist", bar, "{kind: torsion, axis: z, angle: 40 deg, load_steps: 3}"),
                                    "angle [rad],torque [N m]", "angle", "torque"));
  folder.write("press.csv", data_of(scene("press", layer,
                                          "{kind: indentation, indenter: {sphere: {radius: 20 mm}}, depth: 1 mm, "
                                          "load_steps: 3}\ncontact: {friction: 0}"),
                                    "displacement [m],force [N]", "depth", "force"));
  std::string tests;
  for (const std::string name : {"pull", "twist", "press"})
    tests += "    - {name: " + name + ", kind: specimen, file: " + name + ".csv, scene: " + name + ".yaml}\n";
  const Answer answer = identify(folder.write("joint.yaml",
                                              "material: {youngs_modulus: 8 kPa, poissons_ratio: 0.3}\nidentify:\n  "
                                              "unknowns: [youngs_modulus, poissons_ratio]\n  tests:\n" +
                                                  tests),
                                 kCatalog, {})
                            .front();
  INFO(answer.cause);
  REQUIRE(answer.outcome == FitOutcome::converged);
  CHECK(answer.numbers[0].value == Approx(12e3).epsilon(1e-5));
  CHECK(answer.numbers[1].value == Approx(0.4).epsilon(1e-5));
  REQUIRE(answer.tests.size() == 3);
}

TEST_CASE("relaxation of a clamped bar gives E and its Prony term from the force of a run in time",
          "[identify][slow]") {
  const TemporaryFolder folder;
  const auto scene = [&](const std::string& material, const std::string& more) {
    return folder.write("scene.yaml",
                        "body: {tetrahedra: {kind: body_centred, cubes: [2, 2, 2], size: [10 mm, 10 mm, 10 mm]}}\n"
                        "material: {poissons_ratio: 0.4, density: 1 kg/m3, " +
                            material + "}\n" + more);
  };
  const std::string pulled = "kind: tension, axis: z, displacement: 2 mm, fixed_grip: clamped, loaded_grip: clamped";
  const auto built =
      load_scene(scene("youngs_modulus: 12 kPa, relaxation: {terms: [[0.5, 0.5 s]]}",
                       "stiffness: prony:neo_hookean\nexperiment: {kind: relaxation, ramp: 0.1 s, fixture: {" + pulled +
                           "}}\ntime: {duration: 2 s, stepper: newmark, step: 5 ms, frames: 20}\n"),
                 kCatalog);
  RunOptions options;
  options.statics = built->statics, options.time = *built->time;
  const Run run = run_strategy(built->specimen, *built->experiment, built->stiffness, options);
  REQUIRE(run.outcome == Outcome::converged);
  std::string data = "time [s],force [N]\n";
  for (const CurvePoint& point : run.curve)
    if (point.time > 0.15)
      data += std::to_string(point.time) + "," + std::to_string(point.measures.get("force")) + "\n";
  folder.write("data.csv", data);
  const std::string path =
      scene("youngs_modulus: 9 kPa, relaxation: {terms: [[0.3, 0.2 s]]}",
            "stiffness: neo_hookean\nexperiment: {" + pulled +
                "}\nidentify: {tests: [{kind: relaxation, file: data.csv, scene: scene.yaml, ramp: 0.1 s}]}\n");
  const Answer answer = identify(path, kCatalog, {}).front();
  INFO(answer.cause);
  REQUIRE(answer.outcome == FitOutcome::converged);
  REQUIRE(answer.numbers.size() == 3);
  CHECK(answer.numbers[0].value == Approx(12e3).epsilon(2e-3));
  CHECK(answer.numbers[1].value == Approx(0.5).epsilon(1e-2));
  CHECK(answer.numbers[2].value == Approx(0.5).epsilon(2e-2));
  CHECK(answer.tests.front().relative_rms < 1e-3);
}

// E′ = E∞ + E₁ x²/(1 + x²), E″ = E₁ x/(1 + x²) with x = ωτ: the standard linear solid [Ferry 1980, ch. 3].
TEST_CASE("storage and loss moduli over the frequency give the law and its Prony term", "[identify]") {
  const TemporaryFolder folder;
  constexpr double in_the_end = 12e3, relaxing = 18e3, tau = 0.05;
  const auto data_over = [&](const std::string& head, const std::string& modulus, double per_hertz) {
    std::string data = head + "," + modulus + "' (kPa)," + modulus + "'' (kPa),tan delta\n";
    for (const double hertz : {30., 10., 5., 3., 2., 1., 0.3, 0.1}) {
      const double x = 2 * 3.14159265358979 * hertz * tau, storage = in_the_end + relaxing * x * x / (1 + x * x),
                   loss = relaxing * x / (1 + x * x);
      char line[120];
      std::snprintf(line, sizeof line, "%.12g,%.12g,%.12g,%.12g\n", hertz * per_hertz, storage / 1e3, loss / 1e3,
                    loss / storage);
      data += line;
    }
    return data;
  };
  const auto fitted = [&](const std::string& held) {
    std::string tests;
    for (const std::string kind : {"storage_modulus", "loss_modulus", "loss_tangent"})
      tests += "    - {file: data.csv, held: " + held + ", kind: " + kind + "}\n";
    return identify(folder.write("scene.yaml",
                                 "material: {law: yeoh, terms: [3 kPa], relaxation: {terms: [[0.3, 0.2 s]], moduli: "
                                 "instantaneous}}\nidentify:\n  tests:\n" +
                                     tests),
                    kCatalog, {})
        .front();
  };
  // E of an incompressible law of c₁ is 6 c₁, G is 2 c₁. Machines write Hz, or ω by its unit or its name.
  struct Case {
    std::string head, held;
    double per_hertz, modulus_over_c;
  };
  for (const Case& c :
       {Case{"frequency [Hz]", "uniaxial", 1, 6}, Case{"Angular frequency (rad/s)", "shear", 6.28318530717959, 2},
        Case{"Angular frequency (1/s)", "uniaxial", 6.28318530717959, 6},
        Case{"kreisfrequenz [1/s]", "uniaxial", 6.28318530717959, 6},
        Case{"Pulsation (1/s)", "uniaxial", 6.28318530717959, 6}, Case{"角频率 (1/s)", "uniaxial", 6.28318530717959, 6},
        Case{"ω [1/s]", "uniaxial", 6.28318530717959, 6}, Case{"Frequenz [1/s]", "uniaxial", 1, 6},
        Case{"Frequency (rad/s)", "uniaxial", 6.28318530717959, 6}}) {
    INFO(c.head);
    folder.write("data.csv", data_over(c.head, c.held == "shear" ? "G" : "E", c.per_hertz));
    const Answer answer = fitted(c.held);
    INFO(answer.cause);
    REQUIRE(answer.outcome == FitOutcome::converged);
    REQUIRE(answer.numbers.size() == 3);
    CHECK(answer.numbers[0].value == Approx((in_the_end + relaxing) / c.modulus_over_c).epsilon(1e-5));
    CHECK(answer.numbers[1].value == Approx(0.6).epsilon(1e-5));
    CHECK(answer.numbers[2].value == Approx(tau).epsilon(1e-5));
    REQUIRE(answer.tests.size() == 3);
    for (const TestAnswer& test : answer.tests) CHECK(test.relative_rms < 1e-6);
  }
}
