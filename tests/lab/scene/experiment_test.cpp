// Experiments as a scene writes them: what is read, and mistakes named with their place.

#include <algorithm>
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "lab/report/records.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

namespace {

const Catalog kCatalog = built_in_catalog();

/// A scene whose line 5 is its experiment.
std::string scene_with(const std::string& experiment, const std::string& more = "") {
  return "title: An experiment\n"
         "body: {tetrahedra: {kind: kuhn, cubes: [2, 2, 2], size: [10 mm, 10 mm, 10 mm]}}\n"
         "material: {youngs_modulus: 10 kPa, poissons_ratio: 0.3}\n"
         "stiffness: neo_hookean\n"
         "experiment: {" +
         experiment + "}\n" + more;
}

Record run_of(const std::string& text) {
  const TemporaryFolder folder;
  const auto scene = load_scene(folder.write("scene.yaml", text), kCatalog);
  return make_record(*scene,
                     run_strategy(scene->specimen, *scene->experiment, scene->stiffness, {.statics = scene->statics}));
}

/// Checks the place and the words of a refusal; '@' stands before what the message must point at.
void check_refusal(std::string experiment, const std::string& path, const std::string& says) {
  INFO(experiment);
  std::string text = scene_with(experiment);
  std::size_t column = std::string("experiment: {").size();
  if (const std::size_t at = experiment.find('@'); at != std::string::npos) {
    experiment.erase(at, 1);
    text = scene_with(experiment);
    column += at + 1;
  }
  const TemporaryFolder folder;
  const std::string file = folder.write("slip.yaml", text);
  std::string message;
  try {
    load_scene(file, kCatalog);
  } catch (const InputError& error) {
    message = error.what();
  }
  CHECK_THAT(message, StartsWith(file + ":5:" + std::to_string(column) + ": " + path));
  CHECK_THAT(message, Contains(says));
}

}  // namespace

TEST_CASE("a shear may be given as a displacement, a strain or an angle", "[scene][shear]") {
  std::vector<double> forces;
  for (const char* amount : {"displacement: 2 mm", "strain: 20 %", "strain: 0.2", "angle: 11.309932474 deg"})
    forces.push_back(
        run_of(scene_with("kind: shear, axis: x, direction: -y, " + std::string(amount))).run.measures.get("force"));
  for (const double force : forces) CHECK(force == Approx(forces[0]).epsilon(1e-8));
  CHECK(forces[0] > 0);
  const Record affine = run_of(scene_with("kind: shear, direction: [1, 1, 0], strain: 0.2, sides: affine"));
  CHECK(affine.run.measures.get("shear_modulus") == Approx(1e4 / 2.6).epsilon(1e-8));
  CHECK(std::abs(affine.error("shear_modulus")) < 1e-8);
}

TEST_CASE("experiments turn with their scene", "[scene]") {
  for (const char* experiment :
       {"kind: shear, direction: x, strain: 0.2", "kind: shear, direction: x, strain: 0.2, sides: affine",
        "kind: torsion, angle: 20 deg", "kind: hydrostatic, strain: -5 %", "kind: bending, direction: -z, force: 2 mN",
        "kind: material"}) {
    INFO(experiment);
    const Record straight = run_of(scene_with(experiment)),
                 turned = run_of(scene_with(experiment, "rotate: {axis: [1, -2, 0.5], angle: 50 deg}\n"));
    REQUIRE(straight.run.outcome == Outcome::converged);
    REQUIRE_FALSE(straight.main_measures.empty());
    for (const auto& [name, prescribed, strain] : straight.main_measures) {
      const double value = straight.run.measures.get(name);
      INFO(name);
      CHECK(turned.run.measures.get(name) == Approx(value).epsilon(1e-6).margin(1e-9));
    }
  }
}

TEST_CASE("errors are against the material's own modulus", "[scene]") {
  CHECK(run_of(scene_with("kind: hydrostatic, strain: -0.001 %")).error("bulk_modulus") == Approx(0).margin(1e-4));
  const Record clamped = run_of(scene_with("kind: shear, direction: x, strain: 0.001",
                                           "reference: [{measure: force, value: 1 mN, source: nobody}]\n"));
  CHECK(std::isnan(clamped.error("shear_modulus")));  // it bends too
  CHECK(clamped.error("force_to_reference") == Approx(clamped.run.measures.get("force") / 1e-3 - 1));
  const Record material = run_of(scene_with("kind: material"));
  for (const char* name : {"effective_modulus", "poissons_ratio", "shear_modulus", "bulk_modulus"})
    CHECK(std::abs(material.error(name)) < 1e-9);
  CHECK(std::isnan(material.error("anisotropy_index")));  // nothing is asked of it
}

TEST_CASE("a plane angle has its unit where other values have one", "[scene]") {
  check_refusal("kind: torsion, angle: @30", "experiment.angle: '30' has no unit; write for example 30 deg, 0.5 rad",
                "plain SI numbers are allowed only where no value has a unit");
  check_refusal("kind: shear, direction: x, angle: @0.1", "experiment.angle: '0.1' has no unit", "30 deg");
  check_refusal("kind: torsion, angle: @30 %", "experiment.angle: '30 %' is a ratio, no angle", "30 deg");
  const TemporaryFolder folder;
  const auto height = [&](const std::string& size, const std::string& angle) {
    const std::string text = "body: {tetrahedra: {kind: kuhn, cubes: [1, 1, 2], size: " + size +
                             "}}\nmaterial: {youngs_modulus: " + (size.find("mm") < size.size() ? "1 kPa" : "1000") +
                             "}\nstiffness: neo_hookean\nrotate: {axis: x, angle: " + angle +
                             "}\nexperiment: {kind: material}\n";
    const auto scene = load_scene(folder.write("turned.yaml", text), kCatalog);
    return (scene->specimen.body.rest.row(2).maxCoeff() - scene->specimen.body.rest.row(2).minCoeff());
  };
  const std::string plain = "[0.01, 0.01, 0.02]", units = "[10 mm, 10 mm, 20 mm]";
  const double turned = 0.02 * std::cos(M_PI / 6) + 0.01 * std::sin(M_PI / 6);
  CHECK(height(units, "30 deg") == Approx(turned));
  CHECK(height(plain, "30 deg") == Approx(turned));
  CHECK(height(plain, "0.5235987755982988") == Approx(turned));
  CHECK(height(units, "0") == Approx(0.02));
  CHECK_THROWS_WITH(height(units, "30"), Contains(":4:26: rotate.angle: '30' has no unit"));
}

TEST_CASE("mistakes in an experiment are named with their place", "[scene]") {
  check_refusal("kind: @shaer, strain: 0.1", "experiment.kind: 'shaer' is not known here",
                "did you mean 'shear'? (allowed: tension, compression, biaxial, planar, shear, torsion, ");
  check_refusal("kind: shear, axis: x, direction: @x, strain: 0.1",
                "experiment.direction: must be perpendicular to the axis", "");
  check_refusal("kind: shear, axis: x, direction: @[1, 1, 0], strain: 0.1", "experiment.direction: ", "perpendicular");
  check_refusal("kind: shear, strain: 0.1", "experiment: key 'direction' is missing", "");
  check_refusal("kind: shear, direction: x", "experiment: give one of displacement, strain", "angle");
  check_refusal("kind: shear, direction: x, strain: 0.1, angle: 1 deg", "experiment: give one of displacement", "");
  check_refusal("kind: shear, direction: x, strain: @0", "experiment.strain: a load of zero",
                "nothing can be measured");
  check_refusal("kind: shear, direction: x, angle: @90 deg", "experiment.angle: '90 deg' is out of range",
                "at most 1.57");
  check_refusal("kind: shear, direction: x, displacement: @0.1 Pa", "experiment.displacement: 'Pa' cannot be", "15 mm");
  check_refusal("kind: shear, direction: x, strain: 0.1, sides: @affin", "experiment.sides: 'affin' is not known here",
                "did you mean 'affine'? (allowed: free, affine)");
  check_refusal("kind: shear, direction: x, strain: 0.1, @cross_sectoin: 1 cm2",
                "experiment: unknown key 'cross_sectoin'", "did you mean 'cross_section'?");
  check_refusal("kind: shear, direction: x, strain: 0.1, grip_depth: 6 mm", "experiment: ", "beyond its grips");
  check_refusal("kind: shear, direction: x, strain: 0.1, sides: affine, grip_depth: 1 mm",
                "experiment: grip_depth: ", "cells say what its surface is");
  check_refusal("kind: torsion, @angel: 30 deg", "experiment: unknown key 'angel'", "did you mean 'angle'?");
  check_refusal("kind: torsion", "experiment: key 'angle' is missing", "");
  check_refusal("kind: torsion, angle: 30 deg, load_steps: @0", "experiment.load_steps: '0' is not a whole number", "");
  check_refusal("kind: torsion, angle: 30 deg, @direction: x", "experiment: unknown key 'direction'", "axis, angle");
  check_refusal("kind: compression, axis: z, displacement: @-1 mm", "experiment.displacement: '-1 mm' would pull",
                "write 1 mm, or kind: tension");
  check_refusal("kind: compression, axis: z, force: @-2 N", "experiment.force: '-2 N' would pull", "write 2 N");
  check_refusal("kind: hydrostatic, strain: @-100 %", "experiment.strain: '-100 %' is out of range", "above -1");
  check_refusal("kind: hydrostatic, strain: 1 %, sides: @free", "experiment.sides: 'free' is not known here",
                "sliding, affine");
  check_refusal("kind: bending, direction: -z", "experiment: give gravity, a force on the tip, or both", "");
  check_refusal("kind: bending, direction: @x, force: 1 N", "experiment.direction: must be perpendicular", "");
  check_refusal("kind: bending, direction: z, gravity: @9.81 m/s", "experiment.gravity: 'm/s' cannot be", "9.81 m/s2");
  check_refusal("kind: material, @strain: 1 %", "experiment: unknown key 'strain'", "allowed: kind, grip_depth");
}
