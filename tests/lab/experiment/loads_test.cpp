// Loads and supports of one's own, and what is read off named sets.

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/shapes/orders.h"
#include "lab/scene/scene.h"
#include "support/experiments.h"
#include "support/refusal.h"

using namespace elastin;
using namespace elastin::lab;
using namespace elastin::testing;
using Catch::Matchers::Contains;

namespace {

const Catalog kCatalog = built_in_catalog();

std::unique_ptr<Scene> scene(const std::string& rest) {
  return load_scene(SceneSource::of_text("a.yaml",
                                         "body: {tetrahedra: {kind: kuhn, cubes: [4, 2, 2], size: [20 mm, 5 "
                                         "mm, 5 mm]}}\n"
                                         "material: {youngs_modulus: 10 kPa, poissons_ratio: 0}\n"
                                         "stiffness: neo_hookean\n" +
                                             rest),
                    kCatalog);
}

Measures measured(const std::string& rest) {
  const auto own = scene(rest);
  const Run run = run_strategy(own->specimen, *own->experiment, own->stiffness, {.statics = own->statics});
  INFO(run.cause);
  REQUIRE(run.outcome == Outcome::converged);
  return run.measures;
}

Run run_in_time(const Scene& own) {
  RunOptions options{.statics = own.statics};
  options.time = own.time;
  Run run = run_strategy(own.specimen, *own.experiment, own.stiffness, options);
  INFO(run.cause);
  REQUIRE(run.outcome == Outcome::converged);
  return run;
}

const std::string kLeft = "supports: [{molecules: {side: -x}}]\n";

/// A quarter of a tube of radii 5 and 7 and height 1 on curved hexahedra of second order.
Body quarter_tube() {
  Body body = cubic_lattice({3, 7, 2}, 1, {true, false, false});
  body = with_order(with_order(body, 1), 2);
  for (int molecule = 0; molecule < body.size(); ++molecule) {
    const Vector3 at = body.rest.col(molecule);
    const double radius = 5 + at.x(), angle = at.y() / 6 * M_PI / 2;
    body.rest.col(molecule) << radius * std::cos(angle), radius * std::sin(angle), at.z();
  }
  set_present_lengths(body);
  set_matter(body, 0.5, 1000, 0, 0);
  return body;
}

/// That tube in plane strain under a pressure inside.
Run pressed_tube(const Material& material, double pressure, int load_steps, const std::string& strategy) {
  Specimen specimen;
  specimen.material = material;
  specimen.body = quarter_tube();
  const Body& body = specimen.body;
  Reader map =
      open_scene(SceneSource::of_text("a.yaml", "experiment: {kind: loads, load_steps: " + std::to_string(load_steps) +
                                                    ", read: [{name: inner, "
                                                    "molecules: {nearest: [5, 0, 0]}}]}\n"
                                                    "supports: [{symmetry: x}, {symmetry: y}, {molecules: "
                                                    "{box: {from: [0, 0, 0], to: [7, 7, 1]}}, fix: [z]}]\n"),
                 {}, 1e6);
  std::string lumen;
  for (int molecule = 0; molecule < body.size(); ++molecule)
    if (std::abs(body.rest.col(molecule).head<2>().norm() - 5) < 1e-6)
      lumen += (lumen.empty() ? "[" : ", ") + std::to_string(molecule);
  const std::string text = "load: {pressure: {pressure: " + std::to_string(pressure) + ", on: " + lumen + "]}}\n";
  Reader load = open_scene(SceneSource::of_text("b.yaml", text), {}, 1e6);
  specimen.loads.push_back(
      read_load(load.at("load"), scene_loads(kCatalog), body, specimen.material, Matrix3::Identity()).load);
  const auto experiments = built_in_experiments();
  const ExperimentContext context{body, specimen.material, Matrix3::Identity(), {}, experiments};
  const auto experiment = read_experiment(map.at("experiment"), context);
  dynamic_cast<StaticExperiment&>(*experiment)
      .set_further_supports(read_supports(map.at("supports"), body, Matrix3::Identity()));
  return solve(specimen, *experiment, strategy);
}

}  // namespace

TEST_CASE("a tube under a small pressure widens as Lamé says", "[loads][experiment]") {
  const Run run = pressed_tube({.youngs_modulus = 1e5, .poissons_ratio = 0.3}, 10, 2, "neo_hookean");
  // Plane strain: u(a) = (1 + ν) p a ((1 − 2ν) a² + b²) / (E (b² − a²)).        [Timoshenko & Goodier 1970, section 28]
  const double expected = 1.3 * 10 * 5 * (0.4 * 25 + 49) / (1e5 * 24);
  CHECK(run.measures.get("inner_displacement") == Approx(expected).epsilon(2e-3));
  CHECK(run.measures.get("inner_x") == Approx(expected).epsilon(2e-3));
  CHECK(std::abs(run.measures.get("inner_y")) < 1e-6 * expected);
}

TEST_CASE("under small displacements a pressure is linear, however large, and balanced", "[loads][experiment]") {
  for (const double kPa : {-6, -1, 4}) {
    const auto own = scene(kLeft + "loads: [{pressure: {pressure: " + std::to_string(kPa) +
                           " kPa, on: {side: x}}}]\n"
                           "experiment: {kind: loads, read: [{name: end, molecules: {side: x}}]}\n"
                           "solver: {displacements: small}\n");
    const Run run = run_strategy(own->specimen, *own->experiment, own->stiffness, {.statics = own->statics});
    INFO(run.cause);
    REQUIRE(run.outcome == Outcome::converged);
    CHECK(run.measures.get("end_x") == Approx(-kPa / 10 * 20e-3).epsilon(1e-7));
    CHECK(run.measures.get("reaction_balance") < 1e-7);
    CHECK(run.warnings.empty());
  }
}

TEST_CASE("stresses around an axis have the directions of the points, not of the cell's middle",
          "[loads][experiment]") {
  // One cube under uniaxial stress along x, about an axis in the middle of a side: σ_r = σ x²/(x² + y²), at Gauss'
  // points.
  const auto own = load_scene(
      SceneSource::of_text("a.yaml",
                           "body: {lattice: {kind: cubic, molecules: [2, 2, 2], spacing: 10 mm, order: 1}}\n"
                           "material: {youngs_modulus: 10 kPa, poissons_ratio: 0}\nstiffness: neo_hookean\n" +
                               kLeft +
                               "loads: [{traction: {traction: [10 Pa, 0, 0], on: {side: x}}}]\n"
                               "experiment: {kind: loads, read: [{name: all, molecules: {box: {from: [-1 mm, -1 mm, -1 "
                               "mm], to: [11 mm, 11 mm, 11 mm]}}, "
                               "around: {axis: z, through: [0, 5 mm, 0]}}]}\n"),
      kCatalog);
  const Run run = run_strategy(own->specimen, *own->experiment, own->stiffness, {.statics = own->statics});
  REQUIRE(run.outcome == Outcome::converged);
  const double near = (1 - 1 / std::sqrt(3)) / 2, far = 1 - near, across = 1 / std::sqrt(12);
  const auto part = [&](double x) { return x * x / (x * x + across * across); };
  CHECK(run.measures.get("all_radius_stress") == Approx(10 * (part(near) + part(far)) / 2).epsilon(2e-3));
  CHECK(run.measures.get("all_radius_stress") + run.measures.get("all_circumference_stress") ==
        Approx(10).epsilon(2e-3));
}

TEST_CASE("an artery under 120 mmHg needs few Newton iterations near a Poisson's ratio of one half",
          "[loads][experiment][slow]") {
  const double E = 3e5, pressure = 15998.6;
  // Of an incompressible neo-Hookean tube whose inner radius becomes √(25 + c):
  // p = μ (ln(7/5) − ½ ln((49 + c)/(25 + c)) − c/2 (1/(49 + c) − 1/(25 + c))).
  const auto pressure_of = [&](double c) {
    return E / 3 * (std::log(1.4) - std::log((49 + c) / (25 + c)) / 2 - c / 2 * (1 / (49 + c) - 1 / (25 + c)));
  };
  double low = 0, high = 100;
  while (high - low > 1e-9) (pressure_of((low + high) / 2) < pressure ? low : high) = (low + high) / 2;
  for (const double nu : {0.499, 0.4999})
    for (const int load_steps : {1, 4}) {
      const Run run =
          pressed_tube({.youngs_modulus = E, .poissons_ratio = nu}, pressure, load_steps, "neo_hookean+volume");
      CHECK(run.measures.get("inner_displacement") == Approx(std::sqrt(25 + low) - 5).epsilon(0.01));
      CHECK(run.newton_iterations < (nu == 0.499 ? 35 : 100));
    }
}

TEST_CASE("a pressure acts on the group of an artery's mesh that the scene names", "[loads][experiment][brought]") {
  const auto own = load_scene(
      SceneSource::of_text("a.yaml", std::string("body: {mesh: {file: ") + ELASTIN_TEST_DATA +
                                         "/mesh/data/brought/msh_artery_lumen.msh, length_unit: mm}}\n"
                                         "material: {youngs_modulus: 300 kPa, poissons_ratio: 0.499}\n"
                                         "stiffness: neo_hookean+volume\n"
                                         "loads: [{pressure: {pressure: 120 mmHg, on: {set: lumen}}}]\nsupports:\n"
                                         "  - {molecules: {side: -z}, fix: [z]}\n  - {molecules: {side: z}, fix: [z]}\n"
                                         "  - {molecules: {plane: {point: [0, 0, 0], normal: x}}, fix: [x]}\n"
                                         "  - {molecules: {plane: {point: [0, 0, 0], normal: y}}, fix: [y]}\n"
                                         "experiment: {kind: loads, read: [{name: lumen, molecules: {set: lumen}}]}\n"),
      kCatalog);
  const Run run = run_strategy(own->specimen, *own->experiment, own->stiffness, {.statics = own->statics});
  INFO(run.cause);
  REQUIRE(run.outcome == Outcome::converged);  // though the pressures around it have no sum
  // An incompressible neo-Hookean tube of 5 and 7 mm widens by 1.1874 mm; this one has 16 sides.
  CHECK(run.measures.get("lumen_displacement") == Approx(1.1874e-3).epsilon(0.05));
}

TEST_CASE("a traction on picked faces and a moved set show the bar's modulus", "[loads][experiment]") {
  const Measures pulled =
      measured(kLeft +
               "loads: [{traction: {traction: [10 Pa, 0, 0], on: {side: x}}}]\nexperiment: {kind: loads, read: "
               "[{name: tip, molecules: {side: x}}, {name: root, molecules: {side: -x}}]}\n");
  CHECK(pulled.get("tip_x") == Approx(2e-5).epsilon(2e-3));  // σ L / E
  CHECK(pulled.get("tip_displacement") == Approx(2e-5).epsilon(2e-3));
  CHECK(pulled.get("root_reaction_x") == Approx(-10 * 25e-6).epsilon(1e-6));  // − σ A
  CHECK(pulled.get("reaction_x") == Approx(-10 * 25e-6).epsilon(1e-6));
  const Measures moved = measured(
      kLeft +
      "experiment: {kind: loads, moved: [{molecules: {side: x}, displacement: [20 um, 0, 0], fix: [x]}], read: "
      "[{name: tip, molecules: {side: x}}], load_steps: 2}\n");
  CHECK(moved.get("tip_x") == Approx(2e-5).epsilon(1e-9));
  CHECK(moved.get("tip_reaction_x") == Approx(10 * 25e-6).epsilon(2e-3));
  CHECK(std::abs(moved.get("reaction_x")) < 1e-9);
}

TEST_CASE("loads on faces and sets that are read are checked", "[loads][experiment]") {
  const auto answer = [](const std::string& rest) { return refusal([&] { scene(rest); }); };
  const std::string plain = "experiment: {kind: loads}\n";
  CHECK_THAT(answer(plain + "loads: [{pressure: 10 Pa}]\n"), Contains("a.yaml:5") && Contains("give `on`"));
  CHECK_THAT(answer(plain + "loads: [{pressure: {pressure: 10 Pa, on: {nearest: [0, 0, 0]}}}]\n"),
             Contains("no outer face of a cell has all its nodes among"));
  CHECK_THAT(answer("experiment: {kind: loads, read: [{name: a b, molecules: [0]}]}\n"),
             Contains("no name of a measure"));
  CHECK_THAT(answer("experiment: {kind: loads, read: [{name: a, molecules: [0]}, {name: a, molecules: [1]}]}\n"),
             Contains("already"));
  for (const std::string turned : {"", "rotate: {axis: [1, 2, 3], angle: 1 rad}\n"})
    CHECK_THAT(
        answer(turned + "experiment: {kind: loads, moved: [{molecules: [0], displacement: [1 mm, 0, 0], fix: [x]}, "
                        "{molecules: [0], displacement: [2 mm, 0, 0]}]}\n"),
        Contains("experiment.moved[1]") && Contains("molecule 0 is moved twice along one direction"));
  CHECK_THAT(
      answer("experiment: {kind: loads, moved: [{molecules: [0], displacement: [1 mm, 0, 0.3 mm], fix: [x]}]}\n"),
      Contains("experiment.moved[0].displacement") && Contains("0.3 mm along directions that `fix` leaves free"));
}

TEST_CASE("planes of symmetry meet in a corner, at rest and in time, in a turned scene too", "[loads][experiment]") {
  const std::string pull = "loads: [{traction: {traction: [10 Pa, 0, 0], on: {side: x}}}]\n",
                    tip = "read: [{name: tip, molecules: {side: x}}]",
                    moved =
                        ", moved: [{molecules: {side: -x}, displacement: [0, 0, 0], fix: [x]}, {molecules: {side: "
                        "-y}, displacement: [0, 0, 0], fix: [y]}, {molecules: {side: -z}, displacement: [0, 0, 0], "
                        "fix: [z]}]",
                    supports =
                        "supports: [{molecules: {side: -x}, fix: [x]}, {molecules: {side: -y}, fix: [y]}, {molecules: "
                        "{side: -z}, fix: [z]}]\n",
                    slowly =
                        "time: {duration: 400 s, step: 100 s, stepper: backward_euler, frames: 4}\n"
                        "experiment: {kind: motion, in_time: {ramp: {duration: 200 s}}, fixture: {kind: loads, ";
  for (const std::string turned : {"", "rotate: {axis: [1, 2, 3], angle: 1 rad}\n"})
    for (const auto& [held, further] : {std::pair(moved, std::string()), std::pair(std::string(), supports)}) {
      INFO(turned << held << further);
      const Measures rest = measured(turned + pull + further + "experiment: {kind: loads, " + tip + held + "}\n");
      CHECK(rest.get("tip_displacement") == Approx(2e-5).epsilon(2e-3));  // σ L / E, without a lateral strain
      const auto own = scene(turned + pull + further + slowly + tip + held + "}}\n");
      CHECK(run_in_time(*own).measures.get("tip_displacement") == Approx(2e-5).epsilon(2e-3));
    }
}

TEST_CASE("a mass on a spring swings at its own frequency when loads of the scene are released",
          "[loads][experiment][slow]") {
  const std::string load = "loads: [{point: {molecules: [1], force: [1 mN, 0, 0]}}]\n",
                    away = ", {molecules: [1], displacement: [10 um, 0, 0]}";
  for (const auto& [force, moved] : {std::pair(load, std::string()), std::pair(std::string(), away)})
    for (const std::string turned : {"", "rotate: {axis: z, angle: 2 rad}\n"}) {
      const auto own = load_scene(
          SceneSource::of_text(
              "a.yaml",
              "body: {molecules: [[0 m, 0 m, 0 m], [10 cm, 0 m, 0 m]], connections: [[0, 1]], radius: 1 cm}\n"
              "material: {youngs_modulus: 10 kPa, density: 1000 kg/m3}\n"
              "stiffness: {strategy: uniform, constant: 100 N/m}\n" +
                  turned + force +
                  "experiment: {kind: release, fixture: {kind: loads, moved: [{molecules: [0], displacement: [0, 0, "
                  "0]}" +
                  moved + "]}}\ntime: {duration: 0.3 s, stepper: newmark, step: 0.2 ms, frames: 600}\n"),
          kCatalog);
      const Measures measures = run_in_time(*own).measures;
      const double frequency = std::sqrt(100 / own->specimen.body.mass[1]) / (2 * M_PI);
      CHECK(measures.get("frequency") == Approx(frequency).epsilon(1e-3));  // of steps of a 280th of the period
      CHECK(measures.get("period") == Approx(1 / frequency).epsilon(1e-3));
      CHECK(measures.get("first_peak") == Approx(-10e-6).epsilon(1e-3));
      CHECK(measures.get("return_time") == Approx(1 / frequency).epsilon(1e-2));
      CHECK(std::abs(measures.get("damping_ratio")) < 1e-4);
    }
}

TEST_CASE("what is fixed in all directions stays so in a turned scene", "[loads][experiment]") {
  const std::string text =
      "experiment: {kind: loads, read: [{name: end, molecules: {side: x}}, {name: held, molecules: {side: -x}}]}\n"
      "loads: [{traction: {traction: [0, 0, -10 Pa], on: {side: z}}}]\n";
  const std::string fixes[] = {"supports: [{molecules: {side: -x}}]\n",
                               "supports: [{molecules: {side: -x}, fix: [x, y, z]}]\n"};
  const Measures straight = measured(text + fixes[0]);
  for (const std::string& fix : fixes)
    for (const std::string axis : {"x", "y", "z", "[1, 2, 3]"})
      for (const std::string angle : {"0.3 rad", "0.7 rad", "1 rad", "2 rad"}) {
        INFO(fix << axis << ' ' << angle);
        const Measures turned = measured(text + fix + "rotate: {axis: " + axis + ", angle: " + angle + "}\n");
        CHECK(turned.get("end_displacement") == Approx(straight.get("end_displacement")).epsilon(1e-6));
        CHECK(std::abs(turned.get("held_displacement")) < 1e-12);
      }
}

TEST_CASE("damping stays as it is while a motion in time scales what moves", "[loads][experiment]") {
  // The end of a spring moves as U sin(w0 t); a mass with damping a m of its own velocity follows by U w0/a.
  const auto own =
      load_scene(SceneSource::of_text(
                     "a.yaml",
                     "body: {molecules: [[0 m, 0 m, 0 m], [10 cm, 0 m, 0 m]], connections: [[0, 1]], radius: 1 cm}\n"
                     "material: {youngs_modulus: 10 kPa, density: 1000 kg/m3}\n"
                     "stiffness: {strategy: uniform, constant: 100 N/m}\n"
                     "loads: [{rayleigh: {mass: 20 1/s}}]\n"
                     "experiment:\n  kind: motion\n  in_time: {sine: {frequency: 17.794 Hz}}\n"
                     "  fixture: {kind: loads, read: [{name: end, molecules: [1]}], "
                     "moved: [{molecules: [0], displacement: [0.1 mm, 0, 0]}]}\n"
                     "time: {duration: 0.8 s, stepper: newmark, step: 0.5 ms, frames: 800}\n"),
                 kCatalog);
  const double w0 = std::sqrt(100 / own->specimen.body.mass[1]);
  REQUIRE(w0 == Approx(2 * M_PI * 17.794).epsilon(1e-3));
  const Run run = run_in_time(*own);
  double most = 0;
  for (const CurvePoint& row : run.curve)
    if (row.time > 0.7) most = std::max(most, std::abs(row.measures.get("end_x")));
  CHECK(most == Approx(0.1e-3 * w0 / 20).epsilon(0.02));
}

TEST_CASE("what is towed at a constant speed feels no damping between its molecules", "[loads][experiment]") {
  const auto own =
      load_scene(SceneSource::of_text(
                     "a.yaml",
                     "body: {molecules: [[0 m, 0 m, 0 m], [10 cm, 0 m, 0 m]], connections: [[0, 1]], radius: 1 cm}\n"
                     "material: {youngs_modulus: 10 kPa, density: 1000 kg/m3}\n"
                     "stiffness: {strategy: uniform, constant: 100 N/m}\n"
                     "loads: [{rayleigh: {stiffness: 4 ms}}]\n"
                     "experiment:\n  kind: motion\n  in_time: {table: [[0 s, 0], [2 s, 1]]}\n"
                     "  fixture: {kind: loads, read: [{name: end, molecules: [1]}, {name: base, molecules: [0]}], "
                     "moved: [{molecules: [0], displacement: [20 mm, 0, 0]}]}\n"
                     "time: {duration: 1 s, stepper: newmark, step: 1 ms, frames: 100}\n"),
                 kCatalog);
  const Run run = run_in_time(*own);
  const Measures& end = run.curve.back().measures;
  CHECK(end.get("base_x") == Approx(10e-3).epsilon(1e-6));
  // With the damping of its own velocity it would lag by 4 ms * 10 mm/s = 40 um.
  CHECK(std::abs(end.get("end_x") - end.get("base_x")) < 0.1e-6);
}

TEST_CASE("a rigid body stays and moves as a whole, whatever else holds some of its molecules", "[loads][experiment]") {
  const std::string block = "tetrahedra: {kind: kuhn, cubes: [1, 1, ", parts = "stiffness: st_venant_kirchhoff\n";
  const auto read = [&](const std::string& rest) {
    const std::string text = "bodies: [{name: rod, " + block +
                             "4], size: [10 mm, 10 mm, 40 mm]}}, {name: bone, rigid: true, at: [0, 0, 40 mm], " +
                             block + "1], size: [10 mm, 10 mm, 10 mm]}}]\n" +
                             "ties: [{between: [rod, bone], within: 0.1 mm}]\n"
                             "material: {youngs_modulus: 10 kPa, poissons_ratio: 0, density: 1000 kg/m3}\n" +
                             parts + rest;
    const auto own = load_scene(SceneSource::of_text("a.yaml", text), kCatalog);
    const Run run = run_strategy(own->specimen, *own->experiment, own->stiffness, {.statics = own->statics});
    INFO(run.cause);
    REQUIRE(run.outcome == Outcome::converged);
    return run.measures;
  };
  const std::string weight = "loads: [{gravity: [0, 0, 0.3 m/s2]}]\n", foot = "{molecules: {side: -z}}",
                    sets =
                        "experiment: {kind: loads, read: [{name: bone, molecules: {body: bone}}, {name: rod, "
                        "molecules: {body: rod}}]";
  const Measures alone = read(weight + "supports: [" + foot + "]\n" + sets + "}\n");
  CHECK(alone.get("bone_displacement") == 0);
  CHECK(alone.get("rod_displacement") > 0);
  for (const char* more :
       {"{molecules: {body: rod}, fix: [x, y]}", "{molecules: {body: bone}, fix: [x]}", "{symmetry: x}"}) {
    CAPTURE(more);
    const Measures held = read(weight + "supports: [" + foot + ", " + more + "]\n" + sets + "}\n");
    CHECK(held.get("bone_displacement") == 0);
    CHECK(held.get("rod_z") == Approx(alone.get("rod_z")).epsilon(1e-6));
  }
  const std::string top = ", moved: [{molecules: {body: bone, side: z}, displacement: [0, 0, 1 mm], fix: [z]}";
  const Measures moved = read("supports: [" + foot + "]\n" + sets + top + "]}\n");
  CHECK(moved.get("bone_z") == Approx(1e-3));
  CHECK(moved.get("rod_displacement") == Approx(1e-3));
  CHECK_THROWS_WITH(read("supports: [" + foot + "]\n" + sets + top +
                         ", {molecules: {body: bone, side: -z}, displacement: [0, 0, 2 mm]}]}\n"),
                    Contains("'bone' is rigid, and its molecules are moved by different displacements"));
}
