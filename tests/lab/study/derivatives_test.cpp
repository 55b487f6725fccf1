#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <string>

#include "elastin/core/base/error.h"
#include "elastin/lab/study/laboratory.h"
#include "lab/report/records.h"
#include "lab/scene/scene.h"

using namespace elastin;
using namespace elastin::lab;
using Catch::Matchers::Contains;

namespace {

using Settings = std::vector<std::string>;
const Settings kExact{"solver.tolerance=1e-13"};

const std::string kLattice =
    "body: {lattice: {kind: cubic, molecules: [3, 3, 4], spacing: 10 mm, connections: [axis, face]}}\n";
const std::string kRough =
    "body: {tetrahedra: {kind: kuhn, cubes: [2, 2, 3], size: [20 mm, 21 mm, 33 mm]}, jitter: {amount: 8 %, seed: 2}}\n";
const std::string kSecondOrder =
    "body: {tetrahedra: {kind: kuhn, cubes: [1, 1, 2], size: [20 mm, 20 mm, 30 mm], order: 2}}\n";
const std::string kSoft = "material: {youngs_modulus: 9 kPa, poissons_ratio: 0.3, density: 1000 kg/m3}\n";

LaboratoryResult run(const std::string& scene, Settings settings, const Settings& derivatives_by = {}) {
  settings.insert(settings.end(), kExact.begin(), kExact.end());
  RunWatch watch;
  watch.derivatives_by = derivatives_by;
  return Laboratory(SceneSource::of_text("scene", scene), settings).run("", watch);
}

double gradient_of(const LaboratoryResult& result, const std::string& measure, const std::string& key) {
  for (const auto& [name, slopes] : result.gradients)
    for (const auto& [by, slope] : slopes)
      if (name == measure && by == key) return slope;
  return std::nan("");
}

std::string refusal(const std::string& scene, const std::string& key, const Settings& settings = {}) {
  try {
    run(scene, settings, {key});
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

struct Number {
  std::string key;
  double value;
  std::string unit = "";  ///< where a plain number would not do
};

/// Differences of fourth order of whole runs, over `part` of the number.
double difference(const std::string& scene, const std::string& measure, const Number& by, double part) {
  const auto at = [&](double times) {
    char text[60];
    std::snprintf(text, sizeof text, "=%.17g", by.value * (1 + times * part));
    return run(scene, {by.key + text + by.unit}).get(measure);
  };
  return (8 * (at(1) - at(-1)) - (at(2) - at(-2))) / (12 * part * by.value);
}

/// What is left of a change along the derivative falls with its square, over five decades or to rounding.
void check_taylor(const std::string& scene, const std::string& measure, const Number& by) {
  const LaboratoryResult base = run(scene, {}, {by.key});
  const double slope = gradient_of(base, measure, by.key), value = std::abs(base.get(measure));
  double before = 0;
  for (double part = 1e-1; part > 1e-6; part /= 10) {
    char text[80];
    std::snprintf(text, sizeof text, "=%.17g", by.value * (1 + part));
    const double remainder =
        std::abs(run(scene, {by.key + text + by.unit}).get(measure) - base.get(measure) - by.value * part * slope);
    if (remainder < 1e-10 * value) break;  // solutions have 1e-12
    if (before > 0 && part < 5e-3) CHECK(std::log10(before / remainder) == Approx(2).margin(0.15));
    before = remainder;
  }
}

}  // namespace

TEST_CASE(
    "derivatives of every measure are differences of whole runs, for laws, shapes, experiments and kinds of number",
    "[derivatives][slow]") {
  struct Case {
    std::string name, scene;
    std::vector<Number> numbers;
  };
  const std::string gravity = "loads: [{gravity: {acceleration: [0, 0, -9.81 m/s2]}}]\n";
  const Case cases[] = {
      {"springs under force",
       kLattice + kSoft + "stiffness: lattice\nexperiment: {kind: tension, axis: z, force: 0.4 N}\n",
       {{"material.youngs_modulus", 9000}, {"experiment.force", 0.4}, {"body.lattice.spacing", 0.01}}},
      {"a calibrated rule",
       kLattice + kSoft + "stiffness: calibrated:angles\nexperiment: {kind: tension, axis: z, strain: 5 %}\n",
       {{"material.youngs_modulus", 9000}, {"experiment.strain", 0.05}}},
      {"a calibrated rule that is pressed under its weight",
       "body: {packing: {size: [40 mm, 30 mm, 30 mm], distance: 10 mm}}\n" + kSoft + gravity +
           "stiffness: calibrated:standard\nexperiment: {kind: hydrostatic, strain: -3 %}\n",
       {{"experiment.strain", -0.03}}},
      {"a calibrated rule that is twisted",
       kLattice + kSoft + "stiffness: calibrated:standard\nexperiment: {kind: torsion, axis: z, angle: 0.2 rad}\n",
       {{"experiment.angle", 0.2, " rad"}}},
      {"cells that are twisted under their weight",
       kRough + kSoft + gravity + "stiffness: neo_hookean\nexperiment: {kind: torsion, axis: z, angle: 20 deg}\n",
       {{"material.poissons_ratio", 0.3}, {"experiment.angle", M_PI / 9}, {"loads.0.gravity.acceleration.2", -9.81}}},
      {"cells of second order in clamps, in two steps",
       kSecondOrder + kSoft +
           "stiffness: st_venant_kirchhoff\nexperiment: {kind: tension, axis: z, displacement: 3 mm, fixed_grip: "
           "clamped, loaded_grip: clamped, load_steps: 2}\n",
       {{"material.poissons_ratio", 0.3}, {"experiment.displacement", 3e-3}, {"body.tetrahedra.size.2", 0.03}}},
      {"volume kept by pressures near incompressibility",
       kSecondOrder + kSoft +
           "stiffness: neo_hookean+volume\nexperiment: {kind: bending, axis: z, force: 5 mN, direction: x}\n",
       {{"material.poissons_ratio", 0.3}, {"experiment.force", 5e-3}}},
      {"constants of a law",
       kRough + "material: {law: yeoh, terms: [2 kPa, 300 Pa], bulk_modulus: 40 kPa}\nstiffness: yeoh\n"
                "experiment: {kind: compression, axis: z, displacement: 3 mm}\n",
       {{"material.terms.0", 2000}, {"material.terms.1", 300}, {"material.bulk_modulus", 4e4}}},
      {"small displacements",
       kRough + kSoft +
           "stiffness: van_gelder\nsolver: {displacements: small}\n"
           "experiment: {kind: shear, axis: z, direction: x, strain: 1 %}\n",
       {{"material.youngs_modulus", 9000}, {"experiment.strain", 0.01}}},
      {"a value that formulas use",
       "values: {side: 20 mm}\nbody: {tetrahedra: {kind: kuhn, cubes: [1, 1, 2], size: [= side, = side, = 2 * "
       "side]}}\n" +
           kSoft + "stiffness: neo_hookean\nexperiment: {kind: tension, axis: z, force: 0.3 N}\n",
       {{"values.side", 0.02, " m"}}}};
  for (const Case& one : cases) {
    INFO(one.name);
    Settings keys;
    for (const Number& number : one.numbers) keys.push_back(number.key);
    const LaboratoryResult result = run(one.scene, {}, keys);
    REQUIRE(result.outcome == Outcome::converged);
    REQUIRE(result.gradients.size() >= 5);
    for (const auto& [measure, slopes] : result.gradients) {
      REQUIRE(slopes.size() == keys.size());
      for (const Number& number : one.numbers) {
        if (measure == "tangent_modulus" || measure == "average_modulus")
          continue;  // their differences have few digits
        INFO(measure << " by " << number.key);
        const double slope = gradient_of(result, measure, number.key),
                     size = std::abs(result.get(measure) / number.value),
                     expected = difference(one.scene, measure, number, 1e-3);
        // What calibrates has some 8 digits itself.
        const double most = one.name.starts_with("a calibrated rule") ? 1e-5 : 1e-8;
        CHECK(std::abs(slope - expected) < most * (std::abs(expected) + 0.2 * size));
      }
    }
  }
}

TEST_CASE("derivatives of springs whose constants change with the shape are those of whole runs", "[derivatives]") {
  const std::string scene =
      kLattice + kSoft + "stiffness: angles_update\nexperiment: {kind: tension, axis: z, force: 0.4 N}\n";
  const Number numbers[] = {
      {"experiment.force", 0.4}, {"material.youngs_modulus", 9000}, {"body.lattice.spacing", 0.01}};
  const LaboratoryResult result = run(scene, {}, {numbers[0].key, numbers[1].key, numbers[2].key});
  for (const Number& number : numbers) {
    INFO(number.key);
    CHECK(gradient_of(result, "elongation", number.key) ==
          Approx(difference(scene, "elongation", number, 1e-3)).epsilon(1e-6));
  }
}

TEST_CASE("derivatives of what is pressed in hardly at all are differences of whole runs", "[derivatives][slow]") {
  // From as stiff as the command takes it to a penetration of 1e-8 of the depth.
  for (const std::string stiffness : {"1e8", "1e10", "1e12"}) {
    const std::string scene =
        "body: {tetrahedra: {kind: kuhn, cubes: [4, 4, 3], size: [20 mm, 20 mm, 15 mm]}}\n" + kSoft +
        "stiffness: neo_hookean\nexperiment: {kind: indentation, axis: z, indenter: {sphere: {radius: 8 mm}}, depth: "
        "0.5 mm}\ncontact: {friction: 0, stiffness: " +
        stiffness + " Pa/m}\n";
    const Number depth{"experiment.depth", 0.5e-3, " m"}, modulus{"material.youngs_modulus", 9000};
    const LaboratoryResult result = run(scene, {}, {depth.key, modulus.key});
    for (const Number& number : {depth, modulus})
      for (const char* measure : {"force", "energy", "indentation_modulus", "largest_pressure"}) {
        INFO(measure << " by " << number.key << " at " << stiffness << " Pa/m");
        const double expected = difference(scene, measure, number, 1e-3);
        CHECK(gradient_of(result, measure, number.key) == Approx(expected).epsilon(stiffness == "1e12" ? 2e-3 : 1e-5));
      }
  }
}

TEST_CASE("what is left of a change along a derivative is of second order", "[derivatives]") {
  check_taylor(
      kRough + kSoft + "stiffness: neo_hookean\nexperiment: {kind: bending, axis: z, force: 20 mN, direction: x}\n",
      "tip_deflection", {"material.youngs_modulus", 9000});
}

// elastin_tests "[derivatives_drawn]": every law on every shape, with a number of every kind; 20 minutes.
TEST_CASE("derivatives of laws, shapes and numbers drawn at random", "[.][derivatives_drawn][random]") {
  struct Law {
    std::string material, strategy;
    Number constant;
  };
  const Law laws[] = {
      {"youngs_modulus: 9 kPa, poissons_ratio: 0.3", "neo_hookean", {"material.poissons_ratio", 0.3}},
      {"youngs_modulus: 9 kPa, poissons_ratio: 0.3", "st_venant_kirchhoff", {"material.youngs_modulus", 9000}},
      {"law: neo_hookean_log, youngs_modulus: 9 kPa, poissons_ratio: 0.3",
       "neo_hookean_log",
       {"material.poissons_ratio", 0.3}},
      {"law: mooney_rivlin, c1: 1.5 kPa, c2: 400 Pa, bulk_modulus: 40 kPa", "mooney_rivlin", {"material.c2", 400}},
      {"law: yeoh, terms: [2 kPa, 300 Pa], bulk_modulus: 40 kPa", "yeoh", {"material.terms.1", 300}},
      {"law: ogden, terms: [[4 kPa, 1.3], [8 Pa, 5]], bulk_modulus: 40 kPa", "ogden", {"material.terms.0.1", 1.3}},
      {"law: veronda_westmann, c1: 1.4 kPa, c2: 2.5, bulk_modulus: 40 kPa", "veronda_westmann", {"material.c2", 2.5}},
      {"law: arruda_boyce, mu: 3 kPa, N: 4, bulk_modulus: 40 kPa", "arruda_boyce", {"material.N", 4}},
      {"law: transversely_isotropic, c1: 1.2 kPa, c3: 900 Pa, c4: 12, c5: 40 kPa, lambda_max: 1.12, bulk_modulus: 40 "
       "kPa, direction: [0.3, 0, 1]",
       "transversely_isotropic",
       {"material.c4", 12}},
      {"law: holzapfel_gasser_ogden, c: 3 kPa, k1: 5 kPa, k2: 0.8, kappa: 0.1, angle: 40 deg, bulk_modulus: 40 kPa, "
       "direction: [0, 0.3, 1], across: [1, 0, 0]",
       "holzapfel_gasser_ogden",
       {"material.k2", 0.8}},
      {"youngs_modulus: 9 kPa, poissons_ratio: 0.3", "van_gelder", {"material.youngs_modulus", 9000}},
      {"youngs_modulus: 9 kPa, poissons_ratio: 0.3", "standard+volume", {"material.poissons_ratio", 0.3}}};
  struct Shape {
    std::string body;
    Number number;
  };
  const Shape shapes[] = {{kRough, {"body.tetrahedra.size.2", 0.033}},
                          {kSecondOrder, {"body.tetrahedra.size.0", 0.02}},
                          {"body: {tetrahedra: {kind: body_centred, cubes: [2, 2, 2], size: [20 mm, 20 mm, 20 mm]}}\n",
                           {"body.tetrahedra.size.1", 0.02}}};
  const std::pair<std::string, Number> experiments[] = {
      {"{kind: bending, axis: z, force: 3 mN, direction: x}", {"experiment.force", 3e-3}},
      {"{kind: shear, axis: z, direction: x, strain: 5 %}", {"experiment.strain", 0.05}},
      {"{kind: tension, axis: z, displacement: 1 mm}", {"experiment.displacement", 1e-3}},
      {"{kind: torsion, axis: z, angle: 10 deg}", {"experiment.angle", M_PI / 18}}};
  std::mt19937_64 generator(11);
  for (const Law& law : laws)
    for (const Shape& shape : shapes) {
      const auto& [experiment, load] = experiments[generator() % std::size(experiments)];
      const std::string scene = shape.body + "material: {" + law.material + "}\nstiffness: " + law.strategy +
                                "\nexperiment: " + experiment + "\n";
      INFO(scene);
      LaboratoryResult result;
      try {
        result = run(scene, {}, {law.constant.key, shape.number.key, load.key});
      } catch (const InputError& refused) {
        WARN(refused.what());  // by name, where there is no derivative
        continue;
      }
      if (!result.suited) continue;
      REQUIRE(result.outcome == Outcome::converged);
      const std::string measure = result.gradients.front().first;
      for (const Number& number : {law.constant, shape.number, load}) {
        INFO(measure << " by " << number.key);
        const double size = std::abs(result.get(measure) / number.value),
                     expected = difference(scene, measure, number, 1e-3);
        CHECK(std::abs(gradient_of(result, measure, number.key) - expected) < 1e-8 * (std::abs(expected) + 0.2 * size));
        check_taylor(scene, measure, number);
      }
    }
}

TEST_CASE("derivatives are refused by name where they would not be those of the run", "[derivatives]") {
  const std::string scene =
      kLattice + kSoft + "stiffness: lattice\nexperiment: {kind: tension, axis: z, force: 0.1 N}\n";
  CHECK_THAT(refusal(scene + "expect: [{measure: effective_modulus, value: 9 kPa, tolerance: 1 %, source: x}]\n",
                     "material.young_modulus"),
             Contains("scene: the scene states no 'material.young_modulus'") &&
                 Contains("did you mean 'material.youngs_modulus'?") && !Contains("expect"));
  CHECK_THAT(refusal(scene, "stiffness"), Contains("'stiffness' is 'lattice', and no number"));
  CHECK_THAT(refusal(scene, "material"), Contains("those in it are material.youngs_modulus, material.poissons_ratio"));
  CHECK_THAT(refusal(scene, "body.lattice.molecules.0"), Contains("is not a whole number"));
  const std::string pressed =
      kRough + kSoft +
      "stiffness: neo_hookean\nexperiment: {kind: indentation, axis: z, indenter: {sphere: {radius: "
      "8 mm}}, depth: 0.5 mm}\ncontact: {friction: 0.3}\n";
  CHECK_THAT(refusal(pressed, "material.youngs_modulus"), Contains("contact.friction"));
}

TEST_CASE("derivatives of a history are those of its closed forms", "[derivatives][slow]") {
  const std::string block = "body: {tetrahedra: {kind: body_centred, cubes: [2, 2, 3], size: [10 mm, 10 mm, 15 mm]}}\n";
  SECTION("a relaxing force") {
    const LaboratoryResult result =
        run(block +
                "material: {youngs_modulus: 10 kPa, poissons_ratio: 0.3, density: 1e-3 kg/m3, relaxation: {terms: [[1, "
                "0.5 s]]}}\nstiffness: prony:neo_hookean\nexperiment: {kind: relaxation, ramp: 0.2 s, fixture: {kind: "
                "tension, axis: z, displacement: 0.3 um}}\ntime: {duration: 1 s, stepper: backward_euler, step: "
                "5 ms, frames: 10}\n",
            {}, {"material.relaxation.terms.0.1", "material.youngs_modulus"});
    // F = E A e (1 + tau/T (exp(T/tau) - 1) exp(-t/tau)) behind the ramp T, of small strain e.
    const auto force = [](double tau, double t) {
      return 10e3 * 1e-4 * 2e-5 * (1 + tau / 0.2 * (std::exp(0.2 / tau) - 1) * std::exp(-t / tau));
    };
    const double closed = (force(0.501, 1) - force(0.499, 1)) / 0.002;
    CHECK(gradient_of(result, "force", "material.relaxation.terms.0.1") == Approx(closed).epsilon(0.02));
    CHECK(gradient_of(result, "force", "material.youngs_modulus") == Approx(force(0.5, 1) / 10e3).epsilon(2e-3));
  }
  SECTION("a free motion, that only E over density and time moves on") {
    const Settings by{"material.youngs_modulus", "material.density"};
    for (const std::string steps : {"stepper: newmark, step: 2 ms", "stepper: velocity_verlet"}) {
      INFO(steps);
      const LaboratoryResult result = run(
          block + kSoft +
              "stiffness: neo_hookean\nexperiment: {kind: release, fixture: {kind: tension, axis: z, strain: 1 %}}\n"
              "time: {duration: 40 ms, frames: 8, " +
              steps + "}\n",
          {}, by);
      const double own = 9e3 * gradient_of(result, "elongation", by[0]),
                   other = 1e3 * gradient_of(result, "elongation", by[1]);
      CHECK(std::abs(own) > 1e-6);
      CHECK(own == Approx(-other).epsilon(1e-6));
    }
  }
  SECTION("a load that is sought") {
    const Settings by{"material.youngs_modulus", "experiment.force"};
    const LaboratoryResult result =
        run(block + kSoft +
                "stiffness: neo_hookean\nexperiment: {kind: indentation, axis: z, indenter: {sphere: {radius: 8 mm}}, "
                "force: 5 mN}\ncontact: {friction: 0}\n",
            {}, by);
    const double own = 9e3 * gradient_of(result, "depth", by[0]), other = 5e-3 * gradient_of(result, "depth", by[1]);
    CHECK(own < -1e-5);
    CHECK(own == Approx(-other).epsilon(1e-6));
  }
  SECTION("what softens: its force is of first degree in E and m, and m counts on the way back alone") {
    const Settings by{"material.youngs_modulus", "material.softening.m"};
    for (const bool back : {false, true}) {
      INFO((back ? "on the way back" : "on the way up"));
      const LaboratoryResult result =
          run(block +
                  "material: {youngs_modulus: 9 kPa, poissons_ratio: 0.3, softening: {r: 1.6, m: 50 Pa, beta: 0.1}}\n"
                  "stiffness: mullins:neo_hookean\nexperiment: {kind: tension, axis: z, strain: 20 %, load_steps: 2, "
                  "cycle: " +
                  (back ? "[1, 0.5]" : "[0.5, 1]") + "}\n",
              {}, by);
      const double own = 9e3 * gradient_of(result, "effective_modulus", by[0]),
                   other = 50 * gradient_of(result, "effective_modulus", by[1]),
                   modulus = result.get("effective_modulus");
      CHECK(own + other == Approx(modulus).epsilon(1e-6));
      CHECK(std::abs(other) < (back ? 1 : 1e-6) * modulus);
      CHECK(std::abs(other) > (back ? 1e-3 : -1) * modulus);
    }
  }
}

TEST_CASE("a run that is stopped anywhere is interrupted, and has the derivatives of none", "[derivatives]") {
  const std::string steps =
      kLattice + kSoft + "stiffness: lattice\nexperiment: {kind: tension, axis: z, force: 0.1 N, load_steps: 2}\n";
  const std::string unloaded = kLattice + kSoft +
                               "stiffness: lattice\nrest: {unloaded_from: loads}\n"
                               "loads: [{gravity: {acceleration: [0, 0, 9.81 m/s2]}}]\n"
                               "experiment: {kind: tension, axis: z, force: 50 mN}\n";
  for (const std::string& scene : {steps, unloaded, steps + "uncertainty: {material.youngs_modulus: 5 %}\n"}) {
    INFO(scene);
    const LaboratoryResult whole = run(scene, {}, {"material.youngs_modulus"});
    REQUIRE(whole.gradients.size() >= 5);
    int asked = 0, last = 1;
    const auto stopped_at = [&](int question) {
      RunWatch watch;
      watch.derivatives_by = {"material.youngs_modulus"};
      watch.stop = [&] { return ++asked >= question; };
      asked = 0;
      return Laboratory(SceneSource::of_text("scene", scene), kExact).run("", watch);
    };
    REQUIRE(stopped_at(1 << 30).gradients == whole.gradients);
    last = asked;
    REQUIRE(last > 10);
    const int stride = 1 + last / 8;
    for (int question = last; question >= 1; question -= stride) {
      INFO("stopped at question " << question << " of " << last);
      const LaboratoryResult result = stopped_at(question);
      CHECK(result.outcome == Outcome::interrupted);
      CHECK(result.suited);
      CHECK_FALSE(result.cause.empty());
      CHECK(result.gradients.empty());
    }
  }
}

TEST_CASE("derivatives beyond preload are those of whole runs, where a number acts on the preload alone, too",
          "[derivatives][rest]") {
  struct Case {
    std::string what, scene, measure;
    Number number;
    double most;  ///< over the derivative: what it is off
  };
  const std::string jittered =
                        "body: {lattice: {kind: cubic, molecules: [3, 3, 4], spacing: [0.01, 0.008, 0.009], order: "
                        "1}, jitter: {amount: 0.15, seed: 3}}\n",
                    weight = "experiment: {kind: tension, axis: z, load_steps: 2, gravity: 9.81}\n";
  const auto curve = [](const std::string& compression) {
    return "material: {poissons_ratio: 0.35, curve: {points: [" + compression +
           ", [0, 0], [0.1, 1000], [0.3, 4000], [0.6, 12000]]}}\nstiffness: curve\n";
  };
  const Case cases[] = {
      {"fibres that are taut under the preload, and slack at the end",
       "body: {lattice: {kind: cubic, molecules: [2, 2, 2], spacing: 10 mm, order: 1}}\n"
       "material: {law: transversely_isotropic, c1: 1.5 kPa, c3: 300 Pa, c4: 12, c5: 20 kPa, lambda_max: 1.06, "
       "direction: z, bulk_modulus: 200 kPa}\nstiffness: transversely_isotropic\n"
       "rest: {growth: 0.97, along: z, factor: 1}\nexperiment: {kind: compression, axis: z, strain: 0.1}\n",
       "effective_modulus",
       {"material.c3", 300},
       1e-6},
      {"a body that turns between sliding grips as it swells",
       "body: {tetrahedra: {kind: alternating, cubes: [2, 2, 3], size: [0.0238, 0.0113, 0.0208]}, jitter: {amount: "
       "0.15, seed: 3}}\nmaterial: {youngs_modulus: 10000, poissons_ratio: 0.48}\nstiffness: neo_hookean\n"
       "rest: {swelling: 1.02, factor: 1}\n" +
           weight,
       "poissons_ratio",
       {"rest.swelling", 1.02},
       1e-6},
      {"a ratio that a number hardly changes, under a small load",
       "body: {lattice: {kind: cubic, molecules: [3, 3, 3], spacing: 0.01, order: 1}, jitter: {amount: 0.15, seed: "
       "3}}\n"
       "material: {youngs_modulus: 10000, poissons_ratio: 0.3}\nstiffness: neo_hookean\n"
       "rest: {swelling: 1.02, factor: 1}\nexperiment: {kind: tension, axis: z, force: 0.0003}\n",
       "poissons_ratio",
       {"rest.swelling", 1.02},
       0.05},
      {"a free body that swells, whose energy is of a small load alone",
       "body: {lattice: {kind: cubic, molecules: [3, 3, 3], spacing: 0.01, order: 1}, jitter: {amount: 0.15, seed: "
       "3}}\n"
       "material: {youngs_modulus: 10000, poissons_ratio: 0.3}\nstiffness: neo_hookean\n"
       "rest: {swelling: 1.02, factor: 1}\nexperiment: {kind: tension, axis: z, force: 0.0003}\n",
       "energy",
       {"rest.swelling", 1.02},
       1e-4},
      {"free growth, where the springs' curve has a corner",
       jittered + curve("[-0.5, -10000], [-0.2, -2000]") + "rest: {growth: [1.02, 0.99, 1.03], factor: 1}\n" + weight,
       "poissons_ratio",
       {"rest.growth.0", 1.02},
       1e-5},
      {"a tangent next to the corner of a curve",
       jittered + curve("[-0.5, -9000], [-0.2, -2500]") + weight,
       "tangent_modulus",
       {"body.lattice.spacing.1", 8e-3},
       1e-6}};
  for (const Case& one : cases) {
    INFO(one.what);
    const LaboratoryResult result = run(one.scene, {}, {one.number.key});
    REQUIRE(result.outcome == Outcome::converged);
    const double expected = difference(one.scene, one.measure, one.number, 1e-4);
    CHECK(gradient_of(result, one.measure, one.number.key) == Approx(expected).epsilon(one.most));
  }
}

TEST_CASE("the deviation from a material's curve has derivatives", "[derivatives]") {
  const std::string scene =
      "body: {tetrahedra: {kind: kuhn, cubes: [1, 1, 2], size: [15 mm, 25 mm, 26 mm]}}\n"
      "material: {law: mooney_rivlin, c1: 1.2 kPa, c2: 500 Pa, bulk_modulus: 165 kPa}\nstiffness: mooney_rivlin\n"
      "experiment: {kind: compression, axis: z, displacement: 2 mm, load_steps: 2, fixed_grip: clamped}\n";
  for (const Number& number : {Number{"experiment.displacement", 2e-3}, Number{"material.c2", 500}})
    CHECK(gradient_of(run(scene, {}, {number.key}), "curve_error", number.key) ==
          Approx(difference(scene, "curve_error", number, 1e-4)).epsilon(1e-6));
}

TEST_CASE("a number that is uncertain by more than first order holds for is a warning", "[derivatives]") {
  const std::string scene =
      kLattice + kSoft + "stiffness: lattice\nexperiment: {kind: tension, axis: z, force: 0.01 N}\nuncertainty: ";
  CHECK(run(scene + "{material.youngs_modulus: 5 %}\n", {}).warnings.empty());
  // Elongation is as 1/E: -20 and +33.3 % where E is a quarter more and less.
  const auto warned = run(scene + "{material.youngs_modulus: 25 %}\n", {}).warnings;
  REQUIRE(warned.size() == 1);
  CHECK_THAT(warned[0], Contains("material.youngs_modulus is uncertain by more") && Contains("changes by 33") &&
                            Contains("and -20 %"));
}

TEST_CASE("the deviation of a measure is that of runs with normally distributed numbers", "[derivatives]") {
  // Gauss and Hermite's rule of five points: exact where a measure is a polynomial of the fourth degree. 10 000 random
  // draws in its place gave the same within 2 %.
  const std::string scene =
      kLattice + kSoft + "stiffness: lattice\nexperiment: {kind: tension, axis: z, force: 0.1 N}\n";
  const std::string uncertainty =
      "uncertainty:\n  material.youngs_modulus: 3 %\n  experiment.force: [98 mN, 102 mN]\n"
      "  correlation: [[material.youngs_modulus, experiment.force, 0.5]]\n";
  const LaboratoryResult result = run(scene + uncertainty, {});
  REQUIRE(result.spreads.size() >= 5);
  const double of_modulus = 0.03 * 9000, of_force = 2e-3 / 1.959964;
  constexpr double inner = 1.355626179974266, outer = 2.856970013872806;
  constexpr double of_inner = 0.2220759220056126, of_outer = 0.01125741132772069;
  constexpr std::pair<double, double> rule[] = {
      {0, 8. / 15}, {inner, of_inner}, {-inner, of_inner}, {outer, of_outer}, {-outer, of_outer}};
  double sum = 0, squares = 0;
  for (const auto& [one, of_one] : rule)
    for (const auto& [other, of_other] : rule) {
      char modulus[80], force[80];
      std::snprintf(modulus, sizeof modulus, "material.youngs_modulus=%.12g", 9000 + of_modulus * one);
      std::snprintf(force, sizeof force, "experiment.force=%.12g",
                    0.1 + of_force * (0.5 * one + std::sqrt(0.75) * other));
      const double value = run(scene, {modulus, force}).get("elongation");
      sum += of_one * of_other * value, squares += of_one * of_other * value * value;
    }
  const double integrated = std::sqrt(squares - sum * sum);
  for (const auto& [measure, parts] : result.spreads) {
    if (measure != "elongation") continue;
    CHECK(parts[0].second == Approx(integrated).epsilon(0.005));
    CHECK(parts[1].second + parts[2].second == Approx(1).epsilon(1e-12));
  }
  // A plain number of --set is in SI units, and keeps the unit of the scene's number.
  const LaboratoryResult plain = run(scene + uncertainty, {"experiment.force=0.1", "material.youngs_modulus=9000"});
  REQUIRE(plain.spreads.size() == result.spreads.size());
  for (std::size_t i = 0; i < plain.spreads.size(); ++i) CHECK(plain.spreads[i].second == result.spreads[i].second);
  CHECK_THAT(refusal(scene + "uncertainty: {material.youngs_moduls: 3 %}\n", "experiment.force"),
             Contains("did you mean 'material.youngs_modulus'?"));
  for (const std::string interval : {"[20 kPa, 30 kPa]", "[0.8 kPa, 1 kPa]"})
    CHECK_THAT(refusal(scene + "uncertainty: {material.youngs_modulus: " + interval + "}\n", "experiment.force"),
               Contains("the interval does not hold the number itself, which the scene states as 9000 Pa: write"));
}

TEST_CASE("gradients and deviations are read back from JSON as they were", "[derivatives]") {
  Record record;
  record.run.gradients = {{"force", {{"material.youngs_modulus", 0.25}, {"experiment.strain", 3}}}};
  record.spreads = {{"force", {{"deviation", 2}, {"material.youngs_modulus", 1}}}};
  record.run.curve.push_back({1, {}, 1, 1, 0});
  record.run.curve.back().gradients = record.run.gradients;
  const Record back = record_of_json(json_line(record));
  CHECK(back.run.gradients == record.run.gradients);
  CHECK(back.spreads == record.spreads);
  CHECK(back.run.curve.back().gradients == record.run.gradients);
  CHECK_THAT(json_text({record}),
             Contains("\"gradients\": {\n    \"force\": {\n     \"material.youngs_modulus\": 0.25"));
}

TEST_CASE("derivatives of a run that first finds its unloaded shape", "[derivatives][rest]") {
  // Pulled by a force on top of its weight: the elongation beyond the given shape is that of the force.
  const std::string scene = kLattice + kSoft +
                            "stiffness: lattice\nrest: {unloaded_from: loads}\n"
                            "loads: [{gravity: {acceleration: [0, 0, 9.81 m/s2]}}]\n"
                            "experiment: {kind: tension, axis: z, force: 50 mN}\n";
  for (const Number& by : {Number{"material.youngs_modulus", 9000}, Number{"experiment.force", 0.05}}) {
    const LaboratoryResult result = run(scene, {}, {by.key});
    REQUIRE(result.outcome == Outcome::converged);
    for (const char* measure : {"elongation", "unloaded_displacement"}) {
      INFO(measure << " by " << by.key);
      const double slope = gradient_of(result, measure, by.key);
      CHECK(slope == Approx(difference(scene, measure, by, 1e-3)).epsilon(1e-4).margin(1e-12));
    }
    CHECK(std::isnan(gradient_of(result, "unloading_error", by.key)));
    CHECK(result.warnings.empty());
  }
}
