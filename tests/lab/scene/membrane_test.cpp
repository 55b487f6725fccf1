// Scenes of surfaces and of what blows them up.

#include <catch2/catch.hpp>
#include <cmath>

#include "lab/scene/scene.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;
using Catch::Matchers::Contains;

namespace {

std::string scene_of(const std::string& body, const std::string& experiment = "{kind: inflation, pressure: 10 kPa}",
                     const std::string& more = "") {
  return "title: A surface\nbody: {" + body +
         "}\nmaterial: {youngs_modulus: 50 MPa, poissons_ratio: 0.3, thickness: 1 mm}\nstiffness: two_parameter\n"
         "experiment: " +
         experiment + "\n" + more;
}

std::string refusal(const std::string& text) {
  const TemporaryFolder folder;
  try {
    load_scene(folder.write("surface.yaml", text), built_in_catalog());
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

Run run_of(const std::string& text) {
  const TemporaryFolder folder;
  const auto scene = load_scene(folder.write("surface.yaml", text), built_in_catalog());
  return run_strategy(scene->specimen, *scene->experiment, scene->stiffness, {.statics = scene->statics});
}

const std::string kBall = "sphere: {radius: 1 m, divisions: 4}";

}  // namespace

TEST_CASE("surfaces of scenes have the cells of their kind", "[scene]") {
  const TemporaryFolder folder;
  folder.write("corner.obj", "v 0 0 0\nv 3 0 0\nv 0 3 0\nv 0 0 3\nf 2 3 4\nf 1 3 2\nf 1 4 3\nf 1 2 4\n");
  const std::string tension = "{kind: tension, axis: x, displacement: 1 mm, cross_section: 1 cm2}";
  for (const auto& [body, cells] : std::vector<std::pair<std::string, std::size_t>>{
           {"sphere: {radius: 1 m, divisions: 3}", 180},
           {"sphere: {radius: 1 m, mesh: type_2, divisions: 3}", 72},
           {"disc: {radius: 1 m, rings: 3}", 54},
           {"sheet: {size: [1 m, 2 m], squares: [2, 3]}", 12},
           {"sheet: {size: [1 m, 2 m], squares: [2, 3], pattern: crossed}", 24},
           {"canopy: {width: 1 m, span: 3 m, squares: 2}", 40},
           {"mesh: {file: corner.obj, length_unit: mm}", 4},
           {"molecules: [[0 m, 0 m, 0 m], [1 m, 0 m, 0 m], [0 m, 1 m, 0 m]], triangles: [[0, 1, 2]]", 1}}) {
    INFO(body);
    const auto scene = load_scene(folder.write("one.yaml", scene_of(body, tension)), built_in_catalog());
    CHECK(scene->specimen.body.triangles.size() == cells);
    CHECK(scene->specimen.body.mass.sum() > 0);
  }
}

TEST_CASE("what is wrong with a surface or its pressure is reported at its key", "[scene]") {
  const std::vector<std::pair<std::string, std::string>> slips{
      {scene_of("sphere: {radius: 1 m, mesh: type_3, divisions: 3}"),
       "surface.yaml:2:36: body.sphere.mesh: 'type_3' is not known here; did you mean 'type_1'?"},
      {scene_of("sphere: {radius: 1 m, mesh: type_2, divisions: 2}"), "body.sphere.divisions: "},
      {scene_of("sphere_octant: {radius: 1 m, mesh: icosahedron, divisions: 2}"), "'icosahedron' is not known here"},
      {scene_of("sheet: {size: [1 m, 0 m], squares: [2, 3]}"), "body.sheet.size[1]: "},
      {scene_of("canopy: {width: 2 m, span: 1 m, squares: 2}"), "the span of a cross must be more than its width"},
      {scene_of("disc: {radius: 1 m, rings: 2}"), "inflation needs a closed surface: 12 sides"},
      {scene_of("molecules: [[0 m, 0 m, 0 m], [1 m, 0 m, 0 m], [0 m, 1 m, 0 m]], triangles: [[0, 1, 1]]"),
       "body.triangles[0]: a triangle needs three different molecules"},
      {scene_of(kBall, "{kind: inflation}"), "give one of pressure, volume_ratio"},
      {scene_of(kBall, "{kind: inflation, pressure: 1 kPa, volume_ratio: 2}"), "give one of pressure, volume_ratio"},
      {scene_of(kBall, "{kind: inflation, presure: 1 kPa}"), "did you mean 'pressure'?"},
      {scene_of(kBall, "{kind: inflation, pressure: 1 kPa, symmetry: [x, x]}"), "must be perpendicular"},
      {scene_of(kBall, "{kind: inflation, gas: {exponent: 1.4}}"), "experiment.gas: give one of amount"},
      {scene_of(kBall, "{kind: inflation, gas: {amount: 1 kJ, exponent: 3}}"), "experiment.gas.exponent: "},
      {scene_of("disc: {radius: 1 m, rings: 2}", "{kind: tension, axis: x, force: 1 N, cross_section: 1 cm2}",
                "loads: [{gas: {amount: 1 kJ}}]\n"),
       "loads[0].gas: gas needs a closed surface"},
      {scene_of("lattice: {kind: cubic, molecules: [2, 2, 2], spacing: 1 m}",
                "{kind: tension, axis: x, force: 1 N, cross_section: 1 cm2}", "loads: [{pressure: 1 kPa}]\n"),
       "loads[0].pressure: a pressure needs a body with triangles"}};
  for (const auto& [text, wanted] : slips) CHECK_THAT(refusal(text), Contains(wanted));
}

TEST_CASE("a gas below the pressure outside is said to press the surface in", "[scene]") {
  const auto warned = [](const std::string& gas) {
    const auto scene =
        load_scene(SceneSource::of_text("a.yaml",
                                        "body: {sphere: {radius: 10 cm, divisions: 2}}\nmaterial: {youngs_modulus: 1 "
                                        "MPa, poissons_ratio: 0.5, thickness: 1 mm}\nstiffness: "
                                        "neo_hookean_membrane\nloads: [{gas: {" +
                                            gas + "}}]\nexperiment: {kind: loads}\n"),
                   built_in_catalog());
    return scene->warnings.empty() ? std::string() : scene->warnings.front();
  };
  CHECK_THAT(
      warned("start_pressure: 1.675 kPa"),
      Contains("start_pressure is absolute, and 1675 Pa is below `ambient`, 101325 Pa") && Contains("write 103000 Pa"));
  CHECK(warned("start_pressure: 103 kPa").empty());
  CHECK(warned("start_pressure: 1 kPa, ambient: 0 Pa").empty());
}

TEST_CASE("a scene turned about is inflated alike, and its own pressure adds to the experiment's", "[scene]") {
  const std::string octant = "sphere_octant: {radius: 1 m, mesh: type_1, divisions: 5}";
  const std::string inflation = "{kind: inflation, pressure: 10 kPa, symmetry: [x, y, z]}";
  const Run straight = run_of(scene_of(octant, inflation)),
            turned = run_of(scene_of(octant, inflation, "rotate: {axis: [1, 2, 3], angle: 40 deg}\n"));
  REQUIRE(straight.outcome == Outcome::converged);
  REQUIRE(turned.outcome == Outcome::converged);
  for (const char* measure : {"radius", "corner_radius", "enclosed_volume"})
    CHECK(turned.measures.get(measure) == Approx(straight.measures.get(measure)).epsilon(1e-9));
  const Run whole = run_of(scene_of(kBall)),
            parts = run_of(scene_of(kBall, "{kind: inflation, pressure: 6 kPa}", "loads: [{pressure: 4 kPa}]\n"));
  REQUIRE(parts.outcome == Outcome::converged);
  CHECK(parts.measures.get("radius") == Approx(whole.measures.get("radius")).epsilon(1e-8));
}

TEST_CASE("a sheet has its material's modulus under a force as under a displacement, on any triangles", "[membrane]") {
  const auto pattern = GENERATE(as<std::string>(), "one_way", "alternating", "crossed");
  const auto squares = GENERATE(as<std::string>(), "3, 4", "3, 2", "7, 5");
  const std::string sheet = "title: A sheet\nbody: {sheet: {size: [30 mm, 20 mm], squares: [" + squares +
                            "], pattern: " + pattern +
                            "}}\nmaterial: {youngs_modulus: 100 kPa, poissons_ratio: 0.25, thickness: 1 mm}\n"
                            "stiffness: neo_hookean_membrane\nrotate: {axis: [1, 1, 0], angle: 40 deg}\n";
  INFO(pattern << ' ' << squares);
  const Run small =
      run_of(sheet + "experiment: {kind: tension, axis: x, force: 10 mN}\nsolver: {displacements: small}\n");
  CHECK(small.measures.get("effective_modulus") == Approx(100e3).epsilon(1e-8));
  CHECK(small.measures.get("poissons_ratio") == Approx(0.25).epsilon(1e-7));
  // F = E t w e in small displacements: 10 mN is 0.5 %. In large ones the strain is what the same force comes from.
  const Run pulled = run_of(sheet + "experiment: {kind: tension, axis: x, force: 10 mN}\n");
  const Run moved = run_of(sheet + "experiment: {kind: tension, axis: x, displacement: " +
                           std::to_string(1e6 * pulled.measures.get("elongation")) + " um}\n");
  CHECK(moved.measures.get("force") == Approx(10e-3).epsilon(1e-5));
}

TEST_CASE("sheets that are bodies with a thickness of their own have its section", "[membrane]") {
  const auto bodies = [](const std::string& first, const std::string& second, const std::string& at) {
    const std::string sheet = "sheet: {size: [30 mm, 20 mm], squares: [6, 4]}, ";
    return "title: Two sheets\nmaterial: {youngs_modulus: 100 kPa, poissons_ratio: 0, thickness: 1 mm}\n"
           "stiffness: neo_hookean_membrane\nbodies:\n  - {name: a, " +
           sheet + "material: {thickness: " + first + "}}\n  - {name: b, " + sheet + "at: " + at +
           ", material: {thickness: " + second +
           "}}\nties: [{between: [a, b], within: 0.1 mm}]\nsolver: {displacements: small}\n";
  };
  // End to end, both of 3 mm; side by side of 1 and 3 mm, whose mean section is 20 mm * 4 mm.
  for (const auto& [text, section] : {std::pair(bodies("3 mm", "3 mm", "[30 mm, 0, 0]"), 60e-6),
                                      std::pair(bodies("1 mm", "3 mm", "[0, 20 mm, 0]"), 80e-6)})
    for (const std::string load : {"strain: 0.1 %", "force: 6 mN"}) {
      INFO(text << load);
      const Run run = run_of(text + "experiment: {kind: tension, axis: x, " + load + "}\n");
      CHECK(run.outcome == Outcome::converged);
      CHECK(run.measures.get("effective_modulus") == Approx(100e3).epsilon(1e-6));
      CHECK(run.measures.get("stress") == Approx(run.measures.get("force") / section).epsilon(1e-6));
    }
}

TEST_CASE("the edge of a sheet bears a traction, and a sheet is sheared over its own section", "[membrane]") {
  const std::string sheet =
      "title: A sheet\nbody: {sheet: {size: [30 mm, 20 mm], squares: [5, 3], pattern: crossed}}\n"
      "material: {youngs_modulus: 100 kPa, poissons_ratio: 0.3, thickness: 2 mm}\nstiffness: neo_hookean_membrane\n"
      "solver: {displacements: small}\n";
  const Run pulled = run_of(sheet +
                            "supports: [{molecules: {side: -x}, fix: [x]}, {molecules: [0], fix: [y]}]\n"
                            "loads: [{face: {side: x, traction: [100 Pa, 0, 0]}}]\n"
                            "experiment: {kind: loads, read: [{name: end, molecules: {side: x}}, "
                            "{name: held, molecules: {side: -x}}]}\n");
  // 100 Pa of 100 kPa on 30 mm, uniform over the edge.
  CHECK(pulled.measures.get("end_x") == Approx(30e-6).epsilon(1e-8));
  CHECK(pulled.measures.get("held_reaction_x") == Approx(-100 * 20e-3 * 2e-3).epsilon(1e-8));
  const Run sheared = run_of(sheet + "experiment: {kind: shear, axis: y, direction: x, strain: 0.1 %}\n");
  CHECK(sheared.measures.get("stress") == Approx(sheared.measures.get("force") / (30e-3 * 2e-3)).epsilon(1e-9));
}
