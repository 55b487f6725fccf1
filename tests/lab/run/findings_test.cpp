#include "lab/run/specimen.h"

#include <algorithm>
#include <catch2/catch.hpp>

#include "lab/scene/scene.h"
#include "support/experiments.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;
using namespace elastin::testing;

namespace {

/// How many of a run's warnings contain the words.
int warnings_of(const std::string& scene_text, const std::string& words) {
  static const Catalog catalog = built_in_catalog();
  const TemporaryFolder folder;
  const auto scene = load_scene(folder.write("scene.yaml", scene_text), catalog);
  RunOptions options;
  options.time = scene->time;
  options.statics = scene->statics;
  const Run run = run_strategy(scene->specimen, *scene->experiment, scene->stiffness, options);
  INFO(run.cause);
  REQUIRE(run.suited);
  return static_cast<int>(std::count_if(run.warnings.begin(), run.warnings.end(), [&](const std::string& warning) {
    return warning.find(words) != std::string::npos;
  }));
}

/// A molecule of 1 cm, 5 mm above the floor's top, that comes at `speed` in steps of `step`.
std::string falling(const std::string& height, const std::string& speed, const std::string& obstacle,
                    const std::string& step) {
  return "title: a molecule\nbody: {molecules: [[0 m, 0 m, " + height +
         "]], radius: 5 mm}\nmaterial: {youngs_modulus: 10 kPa, density: 1000 kg/m3}\nstiffness: standard\n"
         "experiment: {kind: drop, speed: " +
         speed + "}\ncontact: {obstacles: [{name: thing, " + obstacle +
         "}]}\ntime: {duration: 50 ms, stepper: velocity_verlet, frames: 25, step: " + step + "}\n";
}
const std::string kPlane = "plane: {point: [0, 0, 0], normal: z}";

std::string indented(const std::string& radius) {
  return "title: a needle\nbody: {tetrahedra: {kind: kuhn, cubes: [3, 3, 3], size: [30 mm, 30 mm, 30 mm]}}\n"
         "material: {youngs_modulus: 10 kPa, poissons_ratio: 0.3}\nstiffness: neo_hookean\n"
         "experiment: {kind: indentation, indenter: needle, depth: 0.5 mm}\n"
         "contact: {obstacles: [{name: needle, capsule: {radius: " +
         radius + ", length: 10 mm}, at: [15 mm, 15 mm, 46 mm]}]}\n";
}

}  // namespace

TEST_CASE("cells that are given twice are said", "[findings]") {
  Specimen specimen = reference_cube(1);
  CHECK(findings_at_start(specimen, Model(specimen.body), true).empty());
  auto cell = specimen.body.tetrahedra[3];
  std::swap(cell[0], cell[1]);
  std::swap(cell[2], cell[3]);  // in another order, of the same orientation
  specimen.body.tetrahedra.push_back(cell);
  const std::vector<std::string> found = findings_at_start(specimen, Model(specimen.body), true);
  REQUIRE(found.size() == 1);
  CHECK(found[0] == "1 cell is given twice: there the body is twice as stiff");
  // Springs that do not use cells join two molecules once.
  CHECK(findings_at_start(specimen, Model(specimen.body), false)[0] == "1 cell is given twice");
}

TEST_CASE("overlap at the start is said", "[findings]") {
  CHECK(warnings_of(falling("4 mm", "0.1 m/s", kPlane, "0.1 ms"), "overlap") == 1);
  CHECK(warnings_of(falling("6 mm", "0.1 m/s", kPlane, "0.1 ms"), "overlap") == 0);
}

TEST_CASE("an obstacle that fits between the surface's points is said", "[findings]") {
  CHECK(warnings_of(indented("1 mm"), "may pass between them") == 1);
  CHECK(warnings_of(indented("8 mm"), "may pass between them") == 0);
}

TEST_CASE("an obstacle that is too soft for its thickness is said", "[findings]") {
  // k A = 10 E/d (2r)² = 1 kN/m, m = 0.52 g: 10 m/s stop within 7.2 mm, of 5 + 0.005; 1 m/s within a tenth of that.
  const std::string foil = "box: {size: [100 mm, 100 mm, 0.01 mm]}";
  CHECK(warnings_of(falling("6 mm", "10 m/s", foil, "0.01 ms"), "passed through") == 1);
  CHECK(warnings_of(falling("6 mm", "1 m/s", foil, "0.01 ms"), "passed through") == 0);
  CHECK(warnings_of(falling("6 mm", "10 m/s", kPlane, "0.01 ms"), "passed through") == 0);
}

TEST_CASE("what is pressed in by a large part of a molecule is said", "[findings]") {
  CHECK(warnings_of(falling("6 mm", "10 m/s", kPlane, "0.01 ms"), "and molecules are 10 mm wide") == 1);
  CHECK(warnings_of(falling("6 mm", "1 m/s", kPlane, "0.01 ms"), "is pressed in by") == 0);
}

TEST_CASE("a rebound that is faster than the impact is said", "[findings]") {
  const Body body;
  const Model model(body);
  Run run;
  run.measures.set("restitution", 1.2);
  const std::vector<std::string> found = findings_at_end({}, {}, model, run);
  REQUIRE(found.size() == 1);
  CHECK(found[0] == "it rebounds 1.2 times as fast as it came: the steps are too long for the contact");
  run.measures.set("restitution", 0.99);
  CHECK(findings_at_end({}, {}, model, run).empty());
}

TEST_CASE("Cells that may lock near nu = 1/2 are said, with what to write", "[findings]") {
  const std::string tetrahedra = "tetrahedra: {kind: kuhn, cubes: [1, 1, 1], size: [5 mm, 5 mm, 5 mm]}",
                    lattice = "lattice: {kind: cubic, molecules: [2, 2, 2], spacing: 5 mm, order: 2}";
  struct Case {
    std::string body, law, nu;
    int locks, remedies;
  };
  for (const Case& c :
       {Case{tetrahedra, "neo_hookean", "0.45", 1, 1}, Case{lattice, "neo_hookean", "0.45", 1, 1},
        Case{tetrahedra, "st_venant_kirchhoff", "0.45", 1, 0}, Case{tetrahedra, "neo_hookean", "0.4", 0, 0},
        Case{tetrahedra, "prony:neo_hookean", "0.45", 1, 1}, Case{lattice, "mullins:neo_hookean", "0.45", 1, 1},
        Case{tetrahedra, "neo_hookean+volume", "0.499", 0, 0}, Case{tetrahedra, "van_gelder", "0.45", 0, 0}}) {
    INFO(c.law << " on " << c.body << ", " << c.nu);
    const std::string scene = "title: a block\nbody: {" + c.body +
                              "}\nmaterial: {youngs_modulus: 5 kPa, poissons_ratio: " + c.nu +
                              ", relaxation: {terms: [[1, 1 s]]}, softening: {r: "
                              "2, beta: 0.1}}\nstiffness: {strategy: " +
                              c.law + (c.nu == "0.499" ? "}" : ", volume: none}") +
                              "\nexperiment: {kind: tension, axis: z, strain: 1 %}\nsolver: {displacements: small}\n";
    CHECK(warnings_of(scene, "may lock") == c.locks);
    CHECK(warnings_of(scene, "write stiffness: " + c.law + "+volume") == c.remedies);
  }
}

TEST_CASE("A law with a history keeps its volume near nu = 1/2 as it does without", "[findings]") {
  const auto scene_of = [](const std::string& stiffness) {
    return load_scene(
        SceneSource::of_text("a.yaml",
                             "body: {lattice: {kind: cubic, molecules: [2, 2, 2], spacing: 5 mm, order: 2}}\n"
                             "material: {youngs_modulus: 5 kPa, poissons_ratio: 0.45, softening: {r: 2, "
                             "beta: 0.1}}\nstiffness: " +
                                 stiffness + "\nexperiment: {kind: tension, axis: z, strain: 1 %}\n"),
        built_in_catalog());
  };
  CHECK(scene_of("neo_hookean")->stiffness.strategy.name == "neo_hookean+volume");
  CHECK(scene_of("mullins:neo_hookean")->stiffness.strategy.name == "mullins:neo_hookean+volume");
  CHECK(scene_of("{strategy: mullins:neo_hookean, volume: none}")->stiffness.strategy.name == "mullins:neo_hookean");
}

TEST_CASE("a body that goes through itself says so, one that is held off itself does not", "[findings][contact]") {
  // A U that lies: two legs of 14 x 2 x 1 mm, 1 mm apart, joined at one end; the upper one is pressed down.
  constexpr int long_side = 7, across = 1, high = 3;
  std::string points, cells;
  int count = 0;
  for (int z = 0; z <= high; ++z)
    for (int y = 0; y <= across; ++y)
      for (int x = 0; x <= long_side; ++x)
        points += std::to_string(2 * x) + " " + std::to_string(2 * y) + " " + std::to_string(z) + "\n";
  const auto at = [&](int x, int y, int z) {
    return " " + std::to_string(x + (long_side + 1) * (y + (across + 1) * z));
  };
  for (int z = 0; z < high; ++z)
    for (int x = 0; x < (z == 1 ? 1 : long_side); ++x, ++count)
      cells += "8" + at(x, 0, z) + at(x + 1, 0, z) + at(x + 1, 1, z) + at(x, 1, z) + at(x, 0, z + 1) +
               at(x + 1, 0, z + 1) + at(x + 1, 1, z + 1) + at(x, 1, z + 1) + "\n";
  std::string kinds;
  for (int cell = 0; cell < count; ++cell) kinds += "12\n";
  const TemporaryFolder folder;
  const std::string mesh =
      folder.write("u.vtk", "# vtk DataFile Version 3.0\nu\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS " +
                                std::to_string((long_side + 1) * (across + 1) * (high + 1)) + " double\n" + points +
                                "CELLS " + std::to_string(count) + " " + std::to_string(9 * count) + "\n" + cells +
                                "CELL_TYPES " + std::to_string(count) + "\n" + kinds);
  const auto crossings = [&](const std::string& traction, const std::string& contact) {
    return warnings_of("title: u\nbody: {mesh: {file: " + mesh +
                           ", length_unit: mm}}\nmaterial: {youngs_modulus: 50 kPa, poissons_ratio: 0.3}\n"
                           "stiffness: neo_hookean\nexperiment: {kind: loads, load_steps: 5}\n"
                           "supports: [{molecules: {side: [0, 0, -1]}}]\n"
                           "loads: [{traction: {traction: [0, 0, -" +
                           traction + "], on: {side: [0, 0, 1]}}}]\n" + contact,
                       "goes through itself");
  };
  CHECK(crossings("100 Pa", "") == 1);
  CHECK(crossings("100 Pa", "contact: {self: true}\n") == 0);
  CHECK(crossings("1 Pa", "") == 0);
}

TEST_CASE("a loaded molecule that moves far further than the rest of its end is named", "[findings][slow]") {
  const auto weak = [](int seed, const std::string& load) {
    return warnings_of("title: a packing\nbody: {packing: {size: [20 mm, 10 mm, 10 mm], distance: 2 mm, seed: " +
                           std::to_string(seed) +
                           "}}\nmaterial: {youngs_modulus: 10 kPa, poissons_ratio: 0.3}\nstiffness: standard\n"
                           "experiment: {kind: tension, axis: x, " +
                           load + "}\n",
                       "which the body holds weakly");
  };
  CHECK(weak(4, "force: 1 mN") == 1);  // its elongation is four times that of other packings
  CHECK(weak(1, "force: 1 mN") == 0);
  CHECK(weak(4, "strain: 0.1 %") == 0);
}
