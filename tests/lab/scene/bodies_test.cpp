#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <tuple>

#include "lab/report/records.h"
#include "lab/scene/scene.h"
#include "lab/study/study.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

namespace {

const std::string kPair = R"(material: {youngs_modulus: 1 kPa, poissons_ratio: 0, density: 1000 kg/m3}
bodies:
  - {name: low, tetrahedra: {kind: body_centred, cubes: [3, 3, 3], size: [30 mm, 30 mm, 30 mm]}}
  - {name: high, at: [0 mm, 0 mm, 30 mm], tetrahedra: {kind: body_centred, cubes: [3, 3, 3], size: [30 mm, 30 mm, 30 mm]}}
ties: [{between: [low, high], within: 0.1 mm}]
stiffness: st_venant_kirchhoff
solver: {displacements: small, tolerance: 1e-11}
experiment: {kind: tension, axis: z, fixed_grip: sliding, loaded_grip: sliding, displacement: 0.1 mm}
)";

const std::string kBall = R"(material: {youngs_modulus: 10 kPa, poissons_ratio: 0.25, density: 1100 kg/m3}
body: {fill: {file: organ.stl, length_unit: mm, spacing: 12 mm}}
stiffness: neo_hookean
solver: {displacements: small}
experiment: {kind: hydrostatic, sides: affine, strain: -1 %}
)";

const std::string kTissue = std::string(ELASTIN_SOURCE_DIR) + "/scenes/tissue/";

std::unique_ptr<Scene> load(const std::string& text, const std::vector<std::string>& overrides = {}) {
  const TemporaryFolder folder;
  for (const char* name : {"organ.stl", "ligament.stl"}) std::filesystem::copy_file(kTissue + name, folder.path(name));
  folder.write("open.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\n");
  return load_scene(folder.write("scene.yaml", text), built_in_catalog(), overrides);
}

Measures measures(const std::string& text, const std::vector<std::string>& overrides = {}) {
  const auto scene = load(text, overrides);
  const Run run = run_strategy(scene->specimen, *scene->experiment, scene->stiffness, {.statics = scene->statics});
  INFO(run.cause);
  REQUIRE(run.outcome == Outcome::converged);
  REQUIRE(run.suited);
  return run.measures;
}

double modulus(const std::string& text, const std::vector<std::string>& overrides = {}) {
  return measures(text, overrides).get("effective_modulus");
}

std::string refusal(const std::string& text, const std::vector<std::string>& overrides = {}) {
  try {
    load(text, overrides);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  const std::size_t at = text.find(what);
  REQUIRE(at != std::string::npos);
  return text.replace(at, what.size(), by);
}

}  // namespace

TEST_CASE("two blocks of one material whose molecules meet are one block, exactly", "[bodies]") {
  const std::vector<std::string> loose{"material.poissons_ratio=0.3"};
  const Measures found = measures(kPair, loose);
  CHECK(found.get("effective_modulus") == Approx(1000).epsilon(1e-9));
  CHECK(found.get("poissons_ratio") == Approx(0.3).epsilon(1e-8));
}

TEST_CASE("two blocks of one material whose molecules do not meet: the error of the tie", "[bodies]") {
  for (const auto& [cubes, error] : {std::pair{"4", 0.012}, std::pair{"5", 0.006}}) {
    const Measures found = measures(
        kPair,
        {"material.poissons_ratio=0.3", std::string("bodies.high.tetrahedra.cubes=[") + cubes + "," + cubes + ",3]"});
    CHECK(found.get("effective_modulus") == Approx(1000).epsilon(error));
    CHECK(found.get("poissons_ratio") == Approx(0.3).margin(0.01));
  }
}

TEST_CASE("bars of two materials in series and in parallel have the mean modulus", "[bodies]") {
  // Without a Poisson's ratio of its own each part stretches alone: harmonic and arithmetic mean.
  CHECK(modulus(kPair, {"bodies.high.material={youngs_modulus: 3 kPa}"}) == Approx(1500).epsilon(1e-9));
  const std::vector<std::string> parallel{"bodies.high.material={youngs_modulus: 3 kPa}",
                                          "bodies.high.at=[30 mm, 0 mm, 0 mm]"};
  CHECK(modulus(kPair, parallel) == Approx(2000).epsilon(1e-9));
  // Springs: a lattice each, nu = 1/4 in both.
  std::string springs = kPair;
  for (int i = 0; i < 2; ++i)
    springs = replaced(springs, "tetrahedra: {kind: body_centred, cubes: [3, 3, 3], size: [30 mm, 30 mm, 30 mm]}",
                       "lattice: {kind: cubic, molecules: [4, 4, 4], spacing: 10 mm, connections: [axis, face]}");
  for (const char* strategy : {"lattice", "patch", "lattice+volume"}) {
    std::vector<std::string> changes = parallel;
    changes.insert(changes.end(), {std::string("stiffness=") + strategy, "material.poissons_ratio=0.25"});
    CHECK(modulus(springs, changes) == Approx(2000).epsilon(1e-6));
  }
}

TEST_CASE("one factor calibrates bodies of one material, and no others", "[bodies]") {
  const std::vector<std::string> calibrated{"stiffness=calibrated:van_gelder", "material.poissons_ratio=0.25"};
  CHECK(modulus(kPair, calibrated) == Approx(1000).epsilon(1e-6));
  const auto scene = load(kPair, {"stiffness=calibrated:van_gelder", "bodies.high.material={youngs_modulus: 3 kPa}"});
  CHECK_THAT(unsuited(scene->specimen, *scene->experiment, scene->stiffness), Contains("several materials"));
}

TEST_CASE("a body can be placed, turned and given what the scene's material has not", "[bodies]") {
  const auto scene =
      load(kPair, {"ties=[]", "bodies.high.turn={axis: y, angle: 1.5707963267948966}",
                   "bodies.high.material={density: 2000 kg/m3, fibre: {direction: z, youngs_modulus: 1 kPa}}"});
  const Specimen& specimen = scene->specimen;
  const Part& high = specimen.body.parts[1];
  const Positions positions = specimen.body.rest.middleCols(high.first, high.count);
  CHECK(positions.row(0).maxCoeff() == Approx(0.03));  // z became x
  CHECK(positions.row(2).minCoeff() == Approx(0).margin(1e-12));
  const Material& own = specimen.materials.at(static_cast<std::size_t>(high.material));
  CHECK(own.youngs_modulus == 1000);
  CHECK(own.density == 2000);
  CHECK((own.fibre->direction - Vector3::UnitX()).norm() < 1e-12);
  CHECK(!specimen.materials.at(0).fibre);
  CHECK(specimen.body.mass.sum() == Approx(3000 * 27e-6));
  CHECK_THAT(make_record(*scene, {}).prescribed,
             Contains("low: E = 1.0000 kPa, nu = 0; high: E = 1.0000 kPa, nu = 0, fibres"));
}

TEST_CASE("bone holds what is tied to it", "[bodies]") {
  // One block is bone: half of the bar does not give way, whichever half; ν = 0 feels no clamp.
  for (const char* name : {"low", "high"})
    CHECK(modulus(kPair, {std::string("bodies.") + name + ".rigid=true"}) == Approx(2000).epsilon(1e-8));
  CHECK_THAT(refusal(replaced(kPair, "displacement: 0.1 mm", "force: 1 mN"), {"bodies.high.rigid=true"}),
             Contains("body 'high' at the loaded end is rigid"));
  const auto scene = load(kPair, {"bodies.low.rigid=true"});
  CheckReport report = check_scene(*scene, built_in_catalog(), {});
  CHECK_THAT(report.text, Contains("body 'low'") && Contains("16 more by ties, rigid"));
  CHECK(report.sound);
}

// Half of the bar is bone: twisted, sheared and bent is what is left of it, held as it would be alone.
TEST_CASE("bone turns, moves and holds as a whole", "[bodies]") {
  const std::string alone =
      "material: {youngs_modulus: 1 kPa, poissons_ratio: 0}\nstiffness: st_venant_kirchhoff\n"
      "solver: {displacements: small, tolerance: 1e-11}\n"
      "body: {tetrahedra: {kind: body_centred, cubes: [3, 3, 3], size: [30 mm, 30 mm, 30 mm]}}\n";
  for (const auto& [experiment, measure] : {std::pair{"{kind: torsion, axis: z, angle: 0.01 rad}", "torque"},
                                            {"{kind: shear, axis: z, direction: x, displacement: 0.1 mm}", "force"}}) {
    INFO(experiment);
    const double half = measures(alone + "experiment: " + experiment + "\n").get(measure);
    for (const std::string name : {"low", "high"})
      CHECK(measures(kPair, {"bodies." + name + ".rigid=true", std::string("experiment=") + experiment}).get(measure) ==
            Approx(half).epsilon(1e-8));
  }
  const std::string bending = "{kind: bending, axis: z, direction: x, force: 1 uN}";
  CHECK(measures(kPair, {"bodies.low.rigid=true", "experiment=" + bending}).get("tip_deflection") ==
        Approx(measures(alone + "experiment: " + bending + "\n").get("tip_deflection")).epsilon(1e-8));
  CHECK_THAT(refusal(kPair, {"bodies.high.rigid=true", "experiment=" + bending}), Contains("the tip is rigid"));
  CHECK_THAT(refusal(kPair, {"bodies.low.rigid=true",
                             "experiment={kind: torsion, axis: z, angle: 0.01 rad, loaded: "
                             "{box: {from: [0, 0, 29 mm], to: [30 mm, 30 mm, 30 mm]}}}"}),
             Contains("one rigid body reaches from the fixed end to the loaded one"));
  for (const char* all : {"{kind: shear, axis: z, direction: x, strain: 1 %, sides: affine}",
                          "{kind: hydrostatic, strain: 1 %, sides: affine}", "{kind: material}"})
    CHECK_THAT(refusal(kPair, {"bodies.high.rigid=true", std::string("experiment=") + all}),
               Contains("which the rigid body 'high' cannot"));
}

TEST_CASE("wrong bodies and ties are refused with their place", "[bodies]") {
  const auto change = [](const std::string& what, const std::string& by) { return refusal(replaced(kPair, what, by)); };
  CHECK_THAT(change("name: high", "name: low"),
             Contains("scene.yaml:4:12: bodies.1.name: there is a body 'low' already") ||
                 Contains("there is a body 'low' already"));
  CHECK_THAT(change("[low, high]", "[low, hgh]"),
             Contains("scene.yaml:5:") && Contains("there is no body 'hgh'; did you mean 'high'?"));
  CHECK_THAT(change("[low, high]", "[low, low]"), Contains("cannot be tied to itself"));
  CHECK_THAT(
      change("at: [0 mm, 0 mm, 30 mm]", "at: [0 mm, 0 mm, 31 mm]"),
      Contains("scene.yaml:5:") && Contains("no molecules lie within 0.1 mm of each other; the nearest are 1 mm"));
  CHECK_THAT(change("within", "wihtin"), Contains("within"));
  CHECK_THAT(change("{name: high, at", "{name: high, materiel: {density: 2 kg/m3}, at"),
             Contains("did you mean 'material'?"));
  CHECK_THAT(change("{name: high, ", "{"), Contains("key 'name' is missing"));
  CHECK_THAT(change("bodies:", "body: {lattice: {kind: cubic, molecules: [2, 2, 2], spacing: 1 mm}}\nbodies:"),
             Contains("there are `bodies` already"));
  CHECK_THAT(
      refusal("material: {youngs_modulus: 1 kPa}\nbody: {lattice: {kind: cubic, molecules: [2, 2, 2], spacing: 1 mm}}\n"
              "ties: []\nstiffness: standard\nexperiment: {kind: material}\n"),
      Contains("joins several `bodies`"));
  CHECK_THAT(refusal(kPair, {"bodies.higher.rigid=true"}), Contains("did you mean 'high'?"));
}

TEST_CASE("bodies of cells of any shape meet in their molecules, with regions and without", "[bodies]") {
  const auto pair = [](const std::string& cells, const std::string& regions) {
    std::string text = kPair;
    const std::string from = "tetrahedra: {kind: body_centred, cubes: [3, 3, 3], size: [30 mm, 30 mm, 30 mm]}";
    for (std::size_t at = 0; (at = text.find(from)) != std::string::npos;)
      text.replace(at, from.size(), cells + regions);
    return text;
  };
  for (const char* order : {"1", "2"}) {
    const std::string cells =
        "lattice: {kind: cubic, molecules: [4, 4, 4], spacing: 10 mm, order: " + std::string(order) + "}";
    CAPTURE(order);
    CHECK(modulus(pair(cells, "")) == Approx(1000).epsilon(1e-9));
    const std::string stiff = ", regions: [{from: [0 mm, 0 mm, 0 mm], to: [30 mm, 30 mm, 10 mm], stiffness: 2}]";
    CHECK(modulus(pair(cells, stiff)) == Approx(1000 / (2. / 3 + 1. / 3 / 2)).epsilon(1e-9));
  }
}

TEST_CASE("a filled organ: its volume is reported, its mass is that of the surface, its material exact",
          "[bodies][fill]") {
  const auto scene = load(kBall);
  REQUIRE(scene->notes.size() == 1);
  CHECK_THAT(scene->notes[0], StartsWith("organ.stl filled: ") && Contains("% of the surface's 359.32 cm3"));
  const Body& body = scene->specimen.body;
  CHECK(body.mass.sum() == Approx(1100 * 359.3199e-6).epsilon(1e-6));  // of tools/make_surface
  CHECK(inspect(body).pieces == 1);
  const double bulk = 1e4 / (3 * (1 - 2 * 0.25));
  CHECK(measures(kBall).get("bulk_modulus") == Approx(bulk).epsilon(1e-8));
  CHECK(measures(kBall, {"stiffness=calibrated:patch", "body.fill.connections={within: 19 mm}"}).get("bulk_modulus") ==
        Approx(bulk).epsilon(1e-6));
  CHECK_THAT(make_record(*scene, {}).notes.at(0), Contains("organ.stl"));
  const auto bare = load(kBall, {"body.fill.cells=none", "body.fill.packing=blue_noise",
                                 "experiment={kind: tension, axis: z, force: 1 mN, grip_depth: 8 mm}"});
  CHECK(bare->specimen.body.tetrahedra.empty());
  CHECK(bare->specimen.body.mass.sum() == Approx(1100 * 359.3199e-6).epsilon(1e-6));
  CHECK_THAT(unsuited(bare->specimen, *bare->experiment, choose_strategy(built_in_catalog(), "patch")),
             Contains("leave the filled body its cells"));
}

TEST_CASE("surfaces with faults are filled, with a note of their repair, or refused if it is not wanted",
          "[bodies][fill]") {
  const auto brought = [](const std::string& file) {
    return replaced(kBall, "organ.stl, length_unit: mm, spacing: 12 mm",
                    ELASTIN_TEST_DATA "/mesh/data/brought/" + file + ", length_unit: mm, spacing: 2 mm");
  };
  const std::string no_repair = "body.fill.repair=none";
  for (const auto& [file, volume, repair, fault] :
       std::vector<std::tuple<std::string, double, std::string, std::string>>{
           {"surf_inside_out.stl", 1, "1 shell that was inside out turned", "it is inside out"},
           {"surf_zero_area.stl", 1, "1 triangle without area dropped", "needs its repair: 1 triangle without area"},
           {"surf_one_triangle_missing.stl", 1, "1 hole closed, the widest 14.1 mm across", "it has holes"},
           {"surf_cavity_same_normals.stl", 0.936, "1 inner shell turned to bound a cavity",
            "needs its repair: 1 inner"}}) {
    INFO(file);
    const auto scene = load(brought(file));
    CHECK(scene->specimen.body.mass.sum() == Approx(1100e-6 * volume).epsilon(1e-6));
    CHECK_THAT(scene->notes.at(0), Contains(file + " repaired: " + repair));
    CHECK(scene->warnings.size() == (volume < 1 ? 1 : 0));  // of the cavity, whose walls `material` moves
    CHECK_THAT(refusal(brought(file), {no_repair}), Contains("body.fill.file: ") && Contains(fault));
  }
  CHECK(load(brought("surf_cavity.stl"), {no_repair})->notes.size() == 1);
  const auto both = load(brought("surf_two_overlapping.stl"));  // 2 cm³, less the 0.125 that they share
  CHECK(both->specimen.body.mass.sum() == Approx(1100e-6 * 1.875).epsilon(0.02));
  CHECK_THAT(both->warnings.at(0), Contains("it crosses itself") && Contains("winding number"));
}

TEST_CASE("surfaces that cannot be filled are refused with their fault and place", "[bodies][fill]") {
  const auto change = [](const std::string& what, const std::string& by) { return refusal(replaced(kBall, what, by)); };
  CHECK_THAT(change("organ.stl", "open.obj"),
             Contains("scene.yaml:2:21: body.fill.file: 'open.obj' encloses no volume that could be filled: "));
  CHECK_THAT(change("organ.stl", "orgn.stl"), Contains("did you mean 'organ.stl'?"));
  CHECK_THAT(change("spacing: 12 mm", "spacing: 1 um"),
             Contains("scene.yaml:2:") && Contains("body.fill.spacing: that is ") && Contains("5e+06"));
  CHECK_THAT(change("spacing: 12 mm", "spacing: 1 m, boundary: none"), Contains("too wide"));
  CHECK_THAT(change("12 mm}", "12 mm, packing: latice}"), Contains("did you mean 'lattice'?"));
  CHECK_THAT(change("12 mm}}", "12 mm}, jitter: {amount: 0.1}}"), Contains("body.jitter"));
  CHECK_THAT(change("12 mm}}", "12 mm}, cells: delaunay}"), Contains("inside `fill`"));
}

TEST_CASE("cells of a mesh that are reoriented are counted in a warning", "[bodies]") {
  const TemporaryFolder folder;
  const std::string head =
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 0 0 -1\n"
      "$EndNodes\n$Elements\n2\n1 4 2 0 0 1 2 3 4\n";
  const auto warnings = [&](const std::string& second) {
    folder.write("two.msh", head + "2 4 2 0 0 " + second + "\n$EndElements\n");
    return load_scene(folder.write("scene.yaml",
                                   "body: {mesh: {file: two.msh, length_unit: mm}}\nmaterial: {youngs_modulus: 5 kPa, "
                                   "poissons_ratio: 0.25}\nstiffness: neo_hookean\nexperiment: {kind: motion}\ntime: "
                                   "{duration: 1 ms}\n"),
                      built_in_catalog())
        ->warnings;
  };
  CHECK(warnings("1 3 2 5").empty());
  REQUIRE(warnings("1 2 3 5").size() == 1);
  CHECK_THAT(warnings("1 2 3 5")[0], Contains("body.mesh: 1 of 2 cells had their corners in the mirrored order"));
}

TEST_CASE("skins of triangles on a solid core run by one law of cells, and their stiffnesses add", "[bodies][scene]") {
  const std::string skins =
      R"(material: {youngs_modulus: 1 MPa, poissons_ratio: 0, thickness: 1 mm, density: 1000 kg/m3}
bodies:
  - {name: core, tetrahedra: {kind: kuhn, cubes: [6, 4, 2], size: [30 mm, 20 mm, 10 mm]}, material: {youngs_modulus: 10 kPa}}
  - {name: low, sheet: {size: [30 mm, 20 mm], squares: [6, 4], pattern: one_way}}
  - {name: high, at: [0, 0, 10 mm], sheet: {size: [30 mm, 20 mm], squares: [6, 4], pattern: one_way}}
ties: [{between: [core, low], within: 0.1 mm}, {between: [core, high], within: 0.1 mm}]
stiffness: neo_hookean
experiment: {kind: tension, axis: x, strain: 0.01 %}
)";
  const double force = 1e-4 * (10e3 * 20e-3 * 10e-3 + 2 * 1e6 * 20e-3 * 1e-3);
  for (const char* law :
       {"neo_hookean", "neo_hookean_membrane", "neo_hookean+volume", "neo_hookean_membrane+wrinkling"})
    CHECK(measures(skins, {std::string("stiffness=") + law}).get("force") == Approx(force).epsilon(1e-3));
  const auto scene = load(skins);
  CHECK(run_strategy(scene->specimen, *scene->experiment, scene->stiffness, {.statics = scene->statics})
            .warnings.empty());
  // A body's own law is that of its kind of cells, too: an incompressible skin of the same E is not softer.
  std::string own = skins;
  own.insert(own.find("}\n  - {name: high"), ", material: {law: mooney_rivlin, c1: 166.667 kPa}");
  CHECK(measures(own).get("force") == Approx(force).epsilon(0.1));
}
