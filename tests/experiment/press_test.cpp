#include "experiment/press.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "experiment/specimen.h"
#include "experiment/touching.h"
#include "scene/scene.h"
#include "temporary_folder.h"

using namespace elastin;

namespace {

const Catalog kCatalog = built_in_catalog();

Run run_of(const std::string& bodies, const std::string& experiment) {
  const TemporaryFolder folder;
  const auto scene = load_scene(
      folder.write("scene.yaml", "bodies: [" + bodies +
                                     "]\nmaterial: {youngs_modulus: 10 kPa, poissons_ratio: 0.3}\nstiffness: "
                                     "neo_hookean\nexperiment: {kind: press, " +
                                     experiment + "}\ncontact: {penetration: 1 nm}\n"),
      kCatalog);
  Run run = run_strategy(scene->specimen, *scene->experiment, scene->stiffness, {.statics = scene->statics});
  INFO(run.cause);
  REQUIRE(run.outcome == Outcome::converged);
  return run;
}

const char* const kBelow = "{name: below, tetrahedra: {kind: kuhn, cubes: [3, 3, 2], size: [20 mm, 20 mm, 10 mm]}}";
const char* const kAbove =
    "{name: above, at: [0, 0, 10 mm], tetrahedra: {kind: body_centred, cubes: [2, 2, 1], size: [20 mm, 20 mm, 10 mm]}}";
const char* const kBone = "{name: bone, rigid: true, at: [0, 0, 10 mm], tetrahedra: {kind: kuhn, cubes: [2, 2, 1], size: "
                          "[20 mm, 20 mm, 10 mm]}}";

}  // namespace

TEST_CASE("two blocks that do not match pass a pressure on", "[press]") {
  const Run run = run_of(kBelow + std::string(", ") + kAbove, "displacement: 0.2 mm, grip: sliding");
  // One bar of 20 mm at a strain of 1 %; neo-Hookean, so not quite E A d / L.
  CHECK(run.measures.get("force") == Approx(0.04).epsilon(0.02));
  CHECK(run.measures.get("contact_force") == Approx(run.measures.get("force")).epsilon(1e-6));
  CHECK(run.measures.get("contact_area") == Approx(4e-4).epsilon(1e-6));
  CHECK(run.measures.get("largest_penetration") <= 1e-9);
  const std::string force = std::to_string(run.measures.get("force"));
  const Run by_force = run_of(kBelow + std::string(", ") + kAbove, "force: " + force + " N, grip: sliding");
  CHECK(by_force.measures.get("depth") == Approx(0.2e-3).epsilon(1e-4));
}

TEST_CASE("a rigid part is pressed by its name", "[press]") {
  const Run run = run_of(kBelow + std::string(", ") + kBone, "displacement: 0.1 mm, move: bone, hold: below");
  CHECK(run.measures.get("force") > 0);
  const Run free = run_of(kBelow + std::string(", ") + kBone, "displacement: 0.1 mm, move: bone, grip: sliding");
  CHECK(free.measures.get("force") == Approx(0.04).epsilon(0.03));  // the lower block alone, 1 %
}

TEST_CASE("force control follows a stiffening resistance", "[press]") {
  ForceControl control(8, 1e-3);
  const auto resistance = [](double way) { return way < 0.5 ? 0 : 4 * std::pow(way - 0.5, 2); };  // 8 N at 0.5 + √2
  for (const double part : {0.25, 0.5, 1.}) {
    control.aim(part);
    int solves = 1;
    while (control.adjust(resistance(control.way()))) REQUIRE(++solves < 25);
    CHECK(resistance(control.way()) == Approx(8 * part).epsilon(1e-6));
  }
}
