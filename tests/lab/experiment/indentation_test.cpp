#include <catch2/catch.hpp>
#include <cmath>

#include "lab/run/specimen.h"
#include "lab/scene/scene.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;

namespace {

const Catalog kCatalog = built_in_catalog();
const char* const kWhole = "tetrahedra: {kind: body_centred, cubes: [8, 8, 4], size: [40 mm, 40 mm, 20 mm]}";
const char* const kQuarter = "tetrahedra: {kind: body_centred, cubes: [4, 4, 4], size: [20 mm, 20 mm, 20 mm]}";

Run run_of(const std::string& body, const std::string& experiment, const std::string& contact = "friction: 0",
           const std::string& more = "") {
  const TemporaryFolder folder;
  const auto scene = load_scene(folder.write("scene.yaml", "body: {" + body +
                                                               "}\nmaterial: {youngs_modulus: 10 kPa, poissons_ratio: "
                                                               "0.3}\nstiffness: neo_hookean\nexperiment: {kind: "
                                                               "indentation, " +
                                                               experiment + "}\ncontact: {" + contact + "}\n" + more),
                                kCatalog);
  Run run = run_strategy(scene->specimen, *scene->experiment, scene->stiffness, {.statics = scene->statics});
  INFO(run.cause);
  REQUIRE(run.outcome == Outcome::converged);
  CHECK(run.measures.get("reaction_balance") < 1e-7);
  return run;
}

}  // namespace

TEST_CASE("a quarter of a block resists as the whole one does", "[indentation][slow]") {
  for (const std::string indenter : {"sphere: {radius: 15 mm}", "flat: {radius: 9 mm}"}) {
    const std::string experiment = "indenter: {" + indenter + "}, depth: 2 mm";
    const Measures whole = run_of(kWhole, experiment).measures;
    const Measures quarter = run_of(kQuarter, experiment + ", symmetry: [x, y], at: [0, 0, 0]").measures;
    // The whole block's cells are no mirror images across the planes.
    for (const char* name : {"force", "indentation_modulus"})
      CHECK(quarter.get(name) == Approx(whole.get(name)).epsilon(0.02));
    for (const char* name : {"contact_area", "energy"})
      CHECK(quarter.get(name) == Approx(whole.get(name)).epsilon(0.15));
    CHECK(whole.get("mean_pressure") == Approx(whole.get("force") / whole.get("contact_area")));
    CHECK(whole.get("force") > 0);
  }
}

TEST_CASE("area and pressure do not depend on the depth that contact allows", "[indentation][slow]") {
  const std::string body = "tetrahedra: {kind: body_centred, cubes: [7, 7, 7], size: [20 mm, 20 mm, 20 mm]}",
                    experiment = "indenter: {sphere: {radius: 15 mm}}, depth: 2 mm, symmetry: [x, y]";
  const auto allowed = [&](const std::string& depth) {
    return run_of(body, experiment, "penetration: " + depth).measures;
  };
  // 20 µm are a hundredth of the way, and the force is known to that.
  const Measures penalty = run_of(body, experiment).measures, near = allowed("20 um");
  CHECK(near.get("contact_area") == Approx(penalty.get("contact_area")).epsilon(0.15));
  CHECK(near.get("largest_pressure") == Approx(penalty.get("largest_pressure")).epsilon(0.15));
  for (const char* depth : {"5 um", "2 um"}) {
    CAPTURE(depth);
    const Measures firm = allowed(depth);
    CHECK(firm.get("contact_area") == Approx(near.get("contact_area")).epsilon(1e-6));
    CHECK(firm.get("force") == Approx(near.get("force")).epsilon(0.02));
    CHECK(firm.get("largest_pressure") == Approx(near.get("largest_pressure")).epsilon(0.02));
  }
}

TEST_CASE("where the surface adheres the modulus is apparent, and the run says so", "[indentation]") {
  const std::string small = "tetrahedra: {kind: body_centred, cubes: [4, 4, 4], size: [200 mm, 200 mm, 200 mm]}";
  const auto notes = [&](const std::string& indenter, const std::string& contact) {
    const TemporaryFolder folder;
    const auto scene = load_scene(
        folder.write("scene.yaml", "body: {" + small +
                                       "}\nmaterial: {youngs_modulus: 10 kPa, poissons_ratio: 0.3}\nstiffness: "
                                       "neo_hookean\nexperiment: {kind: indentation, indenter: " +
                                       indenter + ", depth: 0.5 mm}\ncontact: {" + contact + "}\n"),
        kCatalog);
    return scene->experiment->notes().size();
  };
  const std::string own = "{sphere: {radius: 15 mm}}", adhesion = "adhesion: 0.01 J/m2, adhesion_range: 1 mm";
  CHECK(notes(own, "friction: 0") == 0);
  CHECK(notes(own, adhesion) == 1);
  CHECK(notes("tool",
              adhesion + ", obstacles: [{name: tool, sphere: {radius: 15 mm}, at: [100 mm, 100 mm, 220 mm]}]") == 0);
}

TEST_CASE("an indenter goes to a strain of the body's height", "[indentation]") {
  const std::string indenter = "indenter: {sphere: {radius: 15 mm}}, symmetry: [x, y], ";
  CHECK(run_of(kQuarter, indenter + "strain: 5 %").measures.get("depth") == Approx(1e-3).epsilon(1e-12));
}

TEST_CASE("an indenter goes as deep as its force requires", "[indentation]") {
  const Run deep = run_of(kQuarter, "indenter: {sphere: {radius: 15 mm}}, depth: 2 mm, symmetry: [x, y]");
  const std::string force = std::to_string(deep.measures.get("force"));
  const Run pressed =
      run_of(kQuarter, "indenter: {sphere: {radius: 15 mm}}, force: " + force + " N, symmetry: [x, y], load_steps: 3");
  CHECK(pressed.measures.get("depth") == Approx(2e-3).epsilon(1e-4));
  CHECK(pressed.curve[0].measures.get("force") == Approx(deep.measures.get("force") / 3).epsilon(1e-5));
  CHECK(pressed.remark == "");
}

TEST_CASE("an indenter that meets few molecules says so, and one beside a plane of symmetry is refused",
          "[indentation]") {
  const Run coarse = run_of("tetrahedra: {kind: body_centred, cubes: [3, 3, 3], size: [60 mm, 60 mm, 60 mm]}",
                            "indenter: {sphere: {radius: 15 mm}}, depth: 0.5 mm");
  CHECK(coarse.measures.get("molecules_in_contact") < 9);
  CHECK_THAT(coarse.remark, Catch::Contains("alone, where some 9 are needed"));
  CHECK_THROWS_WITH(run_of(kQuarter,
                           "indenter: {sphere: {radius: 15 mm}}, depth: 2 mm, symmetry: [x, y], at: [3 mm, "
                           "0, 0]"),
                    Catch::Contains("at: the indenter's axis is 3 mm away from a plane of symmetry"));
  CHECK_THROWS_WITH(run_of(kQuarter, "indenter: {sphere: {radius: 15 mm}}, depth: 2 mm, at: [0, 0, 0]", "friction: 0",
                           "supports: [{symmetry: x}]\n"),
                    Catch::Contains("give them as `symmetry` of the experiment"));
}

TEST_CASE("an obstacle of the scene serves as indenter, and all of it turns with the scene", "[indentation][slow]") {
  const std::string tool = "obstacles: [{name: tool, sphere: {radius: 15 mm}, at: [20 mm, 20 mm, 35 mm]}]";
  const double own = run_of(kWhole, "indenter: {sphere: {radius: 15 mm}}, depth: 2 mm").measures.get("force");
  CHECK(run_of(kWhole, "indenter: tool, depth: 2 mm", tool).measures.get("force") == Approx(own).epsilon(1e-6));
  CHECK(run_of(kWhole, "indenter: {sphere: {radius: 15 mm}}, depth: 2 mm", "friction: 0",
               "rotate: {axis: [1, -2, 0.5], angle: 50 deg}\n")
            .measures.get("force") == Approx(own).epsilon(1e-6));
}

TEST_CASE("an indenter comes down in the middle of the body as it was before it was turned", "[indentation]") {
  // A plate that is half as wide at one end: hexahedra in a file.
  const TemporaryFolder folder;
  std::string nodes, cells;
  const int n = 8, layers = 3;
  const auto number = [&](int i, int j, int k) { return std::to_string(1 + i + (n + 1) * (j + (n + 1) * k)); };
  for (int k = 0; k <= layers; ++k)
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i)
        nodes += number(i, j, k) + "," + std::to_string(i * (1 - 0.5 * j / n)) + "," + std::to_string(j) + "," +
                 std::to_string(k) + "\n";
  int cell = 0;
  for (int k = 0; k < layers; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        cells += std::to_string(++cell);
        for (const int up : {0, 1})
          for (const auto& [a, b] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}})
            cells += "," + number(i + a, j + b, k + up);
        cells += "\n";
      }
  const std::string file = folder.write("plate.inp", "*NODE\n" + nodes + "*ELEMENT, TYPE=C3D8\n" + cells);
  const auto force = [&](const std::string& turned) {
    return run_of("mesh: {file: '" + file + "', length_unit: mm}", "indenter: {sphere: {radius: 4 mm}}, depth: 0.3 mm",
                  "friction: 0", turned)
        .measures.get("force");
  };
  const double straight = force("");
  for (const char* turn : {"{axis: z, angle: 30 deg}", "{axis: [1, 1, 1], angle: 50 deg}"})
    CHECK(force(std::string("rotate: ") + turn + "\n") == Approx(straight).epsilon(1e-5));
}

TEST_CASE("where preload presses on an obstacle the force is what its motion adds", "[indentation]") {
  // A plate on all of the top: F = E A d / L, whatever weight presses upwards, of which the plate bears half.
  const std::string plate =
      "stiffness: 1000, obstacles: [{name: plate, box: {size: [100 mm, 100 mm, 10 mm]}, at: [0, 0, 25 mm]}]";
  const double weight = 1000 * 1.0 * 4 * 8e-6, added = 10e3 * 1.6e-3 * 0.02 / 20;
  for (const std::string more : {"", ", penetration: 0.1 um"}) {
    const Measures measures = run_of(kQuarter, "indenter: plate, depth: 0.02 mm, symmetry: [x, y], bottom: sliding",
                                     plate + more, "loads: [{gravity: [0, 0, 1 m/s2]}]\n")
                                  .measures;
    CHECK(measures.get("force") == Approx(added).epsilon(0.01));
    CHECK(measures.get("total_force") == Approx(added + weight / 2).epsilon(0.01));
  }
}

TEST_CASE("a tool that is pressed in deeper than its own half in one step meets what it meets in many",
          "[indentation][slow]") {
  for (const std::string shape : {"sphere: {radius: 8 mm}", "box: {size: [15 mm, 15 mm, 16 mm]}"}) {
    const std::string tool = "obstacles: [{name: tool, " + shape + ", at: [20 mm, 20 mm, 28.01 mm]}]";
    const double steps = run_of(kWhole, "indenter: tool, depth: 6 mm, load_steps: 6", tool).measures.get("force");
    INFO(shape);
    CHECK(steps > 0);
    CHECK(run_of(kWhole, "indenter: tool, depth: 6 mm", tool).measures.get("force") == Approx(steps).epsilon(1e-6));
  }
}

TEST_CASE("a sphere on a block converges to the force that finite elements give", "[indentation][slow]") {
  // The block of scenes/contact/indentation-sphere.yaml, coarser.
  double last = 1;
  for (const int cubes : {4, 6, 8}) {
    const std::string n = std::to_string(cubes);
    const auto scene = load_scene(std::string(ELASTIN_SOURCE_DIR) + "/scenes/contact/indentation-sphere.yaml", kCatalog,
                                  {"body.tetrahedra.cubes=[" + n + ", " + n + ", " + n + "]"});
    const Run run = run_strategy(scene->specimen, *scene->experiment, scene->stiffness, {});
    REQUIRE(run.outcome == Outcome::converged);
    const double error = std::abs(run.measures.get("force") / 71.1 - 1);
    INFO(cubes << " cubes: " << error);
    CHECK(error < last);
    last = error;
  }
  CHECK(last < 0.16);
}

TEST_CASE("a body shows the material's modulus under a tool where it is much larger than the contact",
          "[indentation]") {
  const TemporaryFolder folder;
  const auto reference_of = [&](const std::string& indenter) {
    const auto scene = load_scene(folder.write("scene.yaml", "body: {" + std::string(kQuarter) +
                                                                 "}\nmaterial: {youngs_modulus: 10 kPa}\nstiffness: "
                                                                 "neo_hookean\nexperiment: {kind: indentation, "
                                                                 "symmetry: [x, y], indenter: " +
                                                                 indenter + "}\ncontact: {friction: 0}\n"),
                                  kCatalog);
    const double target = scene->experiment->main_measures(scene->specimen.material, {}).front().prescribed;
    CHECK(std::isfinite(target) == scene->experiment->no_reference().empty());
    CHECK(scene->experiment->notes().empty() == scene->experiment->no_reference().empty());
    return scene->experiment->no_reference();
  };
  // Radius of contact by Hertz: sqrt(15 mm · 2 mm) is a quarter of the 20 mm, sqrt(5 mm · 0.1 mm) a thirtieth.
  CHECK_THAT(reference_of("{sphere: {radius: 15 mm}}, depth: 2 mm"), Catch::Contains("no half-space"));
  CHECK_THAT(reference_of("{sphere: {radius: 5 mm}}, depth: 0.1 mm"), Catch::Equals(""));
  CHECK_THAT(reference_of("{flat: {radius: 3 mm}}, depth: 0.1 mm"), Catch::Contains("no half-space"));
}

// A block that has swollen freely is a larger one without stress: all forces grow with its area.
TEST_CASE("the depth begins where the surface is under preload", "[indentation]") {
  const auto pressed = [](const std::string& radius, const std::string& depth, const std::string& rest) {
    return run_of(kQuarter,
                  "indenter: {sphere: {radius: " + radius + "}}, depth: " + depth +
                      ", symmetry: [x, y], at: [0, 0, 0], bottom: sliding",
                  "stiffness: 1e8 Pa/m", rest)
        .measures;
  };
  const Measures small = pressed("15 mm", "2 mm", "");
  for (const auto& [factor, radius, depth] : {std::tuple{1.1, "16.5 mm", "2.2 mm"}, {0.9, "13.5 mm", "1.8 mm"}}) {
    const Measures other = pressed(radius, depth, "rest: {swelling: " + std::to_string(factor) + ", factor: 1}\n");
    INFO(factor);
    CHECK(other.get("force") == Approx(factor * factor * small.get("force")).epsilon(0.01));
    CHECK(other.get("indentation_modulus") == Approx(small.get("indentation_modulus")).epsilon(0.01));
  }
  // Its own weight presses the block down by 0.2 mm, twice as far as the indenter goes.
  const auto under = [&](const std::vector<std::string>& overrides) {
    const TemporaryFolder folder;
    const auto scene =
        load_scene(folder.write("scene.yaml",
                                "body: {" + std::string(kQuarter) +
                                    "}\nmaterial: {youngs_modulus: 10 kPa, poissons_ratio: 0.3, density: 1000 kg/m3}\n"
                                    "stiffness: neo_hookean\ncontact: {}\n"
                                    "experiment: {kind: indentation, indenter: {flat: {radius: 9 mm}}, depth: 0.1 mm, "
                                    "symmetry: [x, y], at: [0, 0, 0], bottom: sliding}\n"),
                   kCatalog, overrides);
    return run_strategy(scene->specimen, *scene->experiment, scene->stiffness, {.statics = scene->statics}).measures;
  };
  const Measures light = under({}), heavy = under({"loads=[{gravity: [0, 0, -9.81 m/s2]}]"});
  CHECK(heavy.get("depth") == Approx(1e-4).epsilon(1e-9));
  CHECK(heavy.get("indentation_modulus") == Approx(light.get("indentation_modulus")).epsilon(0.05));
}
