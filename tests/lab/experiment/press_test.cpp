#include <catch2/catch.hpp>
#include <cmath>

#include "lab/run/contact_measures.h"
#include "lab/run/specimen.h"
#include "lab/scene/scene.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;

namespace {

const Catalog kCatalog = built_in_catalog();

Run run_of(const std::string& bodies, const std::string& experiment, const std::string& friction = "0") {
  const TemporaryFolder folder;
  const auto scene = load_scene(
      folder.write("scene.yaml", "bodies: [" + bodies +
                                     "]\nmaterial: {youngs_modulus: 10 kPa, poissons_ratio: 0.3}\nstiffness: "
                                     "neo_hookean\nexperiment: {kind: press, " +
                                     experiment + "}\ncontact: {stiffness: 1000, friction: " + friction + "}\n"),
      kCatalog);
  Run run = run_strategy(scene->specimen, *scene->experiment, scene->stiffness, {.statics = scene->statics});
  INFO(run.cause);
  REQUIRE(run.outcome == Outcome::converged);
  return run;
}

const char* const kBelow = "{name: below, tetrahedra: {kind: kuhn, cubes: [3, 3, 2], size: [20 mm, 20 mm, 10 mm]}}";
const char* const kAbove =
    "{name: above, at: [0, 0, 10 mm], tetrahedra: {kind: body_centred, cubes: [2, 2, 1], size: [20 mm, 20 mm, 10 mm]}}";
const char* const kBone =
    "{name: bone, rigid: true, at: [0, 0, 10 mm], tetrahedra: {kind: kuhn, cubes: [2, 2, 1], size: "
    "[20 mm, 20 mm, 10 mm]}}";

}  // namespace

TEST_CASE("two blocks that do not match pass a pressure on", "[press]") {
  const Run run = run_of(kBelow + std::string(", ") + kAbove, "displacement: 0.2 mm, grip: sliding");
  // One bar of 20 mm at a stretch of 0.99, neo-Hookean.
  CHECK(run.measures.get("force") == Approx(0.04028966).epsilon(1e-3));
  CHECK(run.measures.get("contact_force") == Approx(run.measures.get("force")).epsilon(1e-6));
  CHECK(run.measures.get("contact_area") == Approx(4e-4).epsilon(1e-6));
  CHECK(run.measures.get("pressure_spread") < 0.01);
}

TEST_CASE("three blocks in a row pass one force on", "[press]") {
  const Run run =
      run_of(kBelow + std::string(", ") + kAbove +
                 ", {name: top, at: [0, 0, 20 mm], tetrahedra: {kind: kuhn, cubes: [3, 3, 2], size: [20 mm, "
                 "20 mm, 10 mm]}}",
             "displacement: 0.3 mm, grip: sliding");
  CHECK(run.measures.get("force") == Approx(0.04028966).epsilon(1e-3));
  CHECK(run.measures.get("contact_force") == Approx(run.measures.get("force")).epsilon(1e-6));
}

TEST_CASE("two blocks are pressed with a force", "[press]") {
  const std::string blocks = kBelow + std::string(", ") + kAbove;
  const Run run = run_of(blocks, "displacement: 0.2 mm");
  const std::string force = std::to_string(run.measures.get("force"));
  const Run by_force = run_of(blocks, "force: " + force + " N, load_steps: 2");
  CHECK(by_force.measures.get("depth") == Approx(0.2e-3).epsilon(1e-4));
  CHECK(by_force.curve[0].measures.get("contact_force") == Approx(run.measures.get("force") / 2).epsilon(1e-5));
  CHECK(by_force.remark == "");
}

TEST_CASE("a force closes a gap first", "[press]") {
  const std::string far =
      "{name: above, at: [0, 0, 25 mm], tetrahedra: {kind: body_centred, cubes: [2, 2, 1], size: [20 mm, 20 mm, 10 "
      "mm]}}";
  const Run near = run_of(kBelow + std::string(", ") + kAbove, "force: 40 mN");
  const Run across = run_of(kBelow + std::string(", ") + far, "force: 40 mN");
  CHECK(across.measures.get("force") == Approx(0.04).epsilon(1e-5));
  CHECK(across.measures.get("depth") == Approx(near.measures.get("depth") + 15e-3).epsilon(1e-6));
  CHECK(across.remark == "");
  CHECK(across.newton_iterations <= near.newton_iterations + 10);
}

TEST_CASE("with friction what is pressed together across a gap is pressed as without the gap", "[press][slow]") {
  const std::string near =
      R"({name: above, at: [5 mm, 5 mm, 10.1 mm], tetrahedra: {kind: kuhn, cubes: [2, 2, 1], size: [10 mm, 10 mm, 5 mm]}})";
  std::string far = near;
  far.replace(far.find("10.1 mm"), 7, "25.1 mm");
  const auto pressed = [](const std::string& above, const std::string& experiment) {
    return run_of(kBelow + std::string(", ") + above, experiment, "0.3").measures;
  };
  const Measures one = pressed(near, "force: 20 mN"), other = pressed(far, "force: 20 mN");
  CHECK(other.get("force") == Approx(0.02).epsilon(1e-6));
  CHECK(other.get("depth") - one.get("depth") == Approx(15e-3).epsilon(1e-6));
  CHECK(other.get("energy") == Approx(one.get("energy")).epsilon(1e-5));
  // Load steps that end in the gap carry nothing, and are no failures.
  CHECK(pressed(far, "displacement: 15.3 mm, load_steps: 3").get("force") > 0);
  CHECK(pressed(far, "displacement: 10 mm").get("contacts") == 0);
}

TEST_CASE("a press by strain goes by the height of all bodies", "[press]") {
  const std::string blocks = kBelow + std::string(", ") + kAbove;
  CHECK(run_of(blocks, "strain: 1 %").measures.get("depth") == Approx(0.2e-3).epsilon(1e-12));
  CHECK_THROWS_WITH(run_of(blocks, "strain: 1 %, displacement: 1 mm"),
                    Catch::Matchers::Contains("give one of displacement, strain and force"));
  CHECK_THROWS_WITH(run_of(blocks, "displacement: 1 %"),
                    Catch::Matchers::Contains("'1 %' is no length; write strain: 1 %"));
}

TEST_CASE("a rigid part is pressed by its name", "[press]") {
  const Run run = run_of(kBelow + std::string(", ") + kBone, "displacement: 0.1 mm, move: bone");
  // The lower block alone at a stretch of 0.99: clamped below, so above that of a free bar, below that of one whose
  // width is kept, which is 1.346 times as stiff with a Poisson's ratio of 0.3.
  CHECK(run.measures.get("force") > 0.04029);
  CHECK(run.measures.get("force") < 0.054);
  CHECK(run.measures.get("contact_force") == Approx(run.measures.get("force")).epsilon(1e-6));
  CHECK_THROWS_WITH(run_of(kBelow + std::string(", ") + kBone, "displacement: 0.1 mm"),
                    Catch::Matchers::Contains("'bone' is rigid and only its end would be moved: say move: bone"));
}

TEST_CASE("force control follows a stiffening resistance", "[press]") {
  ForceControl control(8, 0.1);
  const auto resistance = [](double displacement) {
    return displacement < 0.5 ? 0 : 4 * std::pow(displacement - 0.5, 2);
  };  // 8 N at 0.5 + √2
  for (const double part : {0.25, 0.5, 1.}) {
    control.aim(part);
    int solves = 1;
    while (control.adjust(resistance(control.displacement()))) REQUIRE(++solves <= 12);
    CHECK(resistance(control.displacement()) == Approx(8 * part).epsilon(1e-6));
  }
}

TEST_CASE("a plate that goes further in one load step than it is thick does not pass through the block", "[press]") {
  const auto run = [](const std::string& load_steps) {
    return run_of(
        "{name: soft, tetrahedra: {kind: body_centred, cubes: [3, 3, 3], size: [2 cm, 2 cm, 2 cm]}}, {name: top, "
        "rigid: true, at: [-1 cm, -1 cm, 2.01 cm], tetrahedra: {kind: body_centred, cubes: [1, 1, 1], size: [4 cm, 4 "
        "cm, 3 mm]}}",
        "move: top, fix: {side: -z, body: soft}, displacement: 6 mm, load_steps: " + load_steps);
  };
  const Run once = run("1"), often = run("8");
  CHECK(once.bisected_load_steps > 0);
  CHECK(once.measures.get("force") == Approx(often.measures.get("force")).epsilon(1e-5));
}

TEST_CASE("a block between two plates that touches one of them alone is said to be free", "[press]") {
  const TemporaryFolder folder;
  const auto scene = load_scene(
      folder.write(
          "scene.yaml",
          "bodies: [{name: soft, tetrahedra: {kind: body_centred, cubes: [4, 4, 4], size: [2 cm, 2 cm, 2 "
          "cm]}}, {name: top, rigid: true, at: [-1 cm, -1 cm, 2.01 cm], tetrahedra: {kind: body_centred, cubes: [1, "
          "1, 1], size: [4 cm, 4 cm, 1 cm]}}, {name: low, rigid: true, at: [-1 cm, -1 cm, -1.01 cm], "
          "tetrahedra: {kind: body_centred, cubes: [1, 1, 1], size: [4 cm, 4 cm, 1 cm]}}]\n"
          "material: {youngs_modulus: 10 kPa, poissons_ratio: 0.3}\nstiffness: neo_hookean\n"
          "experiment: {kind: press, move: top, fix: low, displacement: 2.2 mm, load_steps: 12}\n"
          "contact: {friction: 0}\n"),
      kCatalog);
  const Run run = run_strategy(scene->specimen, *scene->experiment, scene->stiffness, {.statics = scene->statics});
  CHECK(run.outcome != Outcome::converged);
  CHECK_THAT(run.cause, Catch::Matchers::Contains("the supports and what touches leave 6 rigid motions"));
  for (const std::string& warning : run.warnings)
    CHECK_THAT(warning, !Catch::Matchers::Contains("rounding allows no less"));
}
