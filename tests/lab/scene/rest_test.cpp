// Bodies that are stressed in the shape that they are described in: growth, prestretch, loads that they are seen under.

#include "elastin/core/model/rest.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "lab/export/exported_body.h"
#include "lab/report/files.h"
#include "lab/run/specimen.h"
#include "lab/scene/scene.h"
#include "support/refusal.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;
using namespace elastin::testing;
using Catch::Matchers::Contains;

namespace {

const Catalog kCatalog = built_in_catalog();
const std::string kTetrahedra = "tetrahedra: {kind: kuhn, cubes: [2, 2, 4], size: [1 cm, 1 cm, 2 cm]}",
                  kHexahedra = "lattice: {kind: cubic, molecules: [3, 3, 5], spacing: 5 mm, order: 2}",
                  kLattice = "lattice: {kind: cubic, molecules: [5, 5, 9], spacing: 2.5 mm, connections: [axis, face]}";

std::string bar(const std::string& rest, const std::string& load = "displacement: 0 mm",
                const std::string& body = kTetrahedra, const std::string& stiffness = "neo_hookean",
                const std::string& more = "") {
  return "title: A bar\nbody: {" + body + "}\nmaterial: {youngs_modulus: 10 kPa, poissons_ratio: 0.25" + more +
         "}\nstiffness: " + stiffness + "\n" + (rest.empty() ? "" : "rest: {" + rest + "}\n") +
         "experiment: {kind: tension, axis: z, " + load + "}\nreference: none\n";
}

Run run_of(const std::string& text) {
  TemporaryFolder folder;
  auto scene = load_scene(folder.write("scene.yaml", text), kCatalog);
  prepare(scene->specimen, scene->stiffness.strategy);
  INFO(text);
  Run run = run_strategy(scene->specimen, *scene->experiment, scene->stiffness,
                         {.statics = scene->statics, .time = scene->time});
  INFO(run.cause);
  return run;
}

double force_of(const std::string& text) {
  const Run run = run_of(text);
  INFO(text << run.cause);
  REQUIRE(run.outcome == Outcome::converged);
  return run.measures.get("force");
}

std::string refused(const std::string& text) {
  TemporaryFolder folder;
  return refusal([&] { load_scene(folder.write("scene.yaml", text), kCatalog); });
}

}  // namespace

TEST_CASE("a bar that is held at its length pushes with E A (factor - 1), as springs and as cells",
          "[scene][rest][slow]") {
  for (const auto& [body, stiffness] :
       {std::pair(kTetrahedra, "neo_hookean"), std::pair(kHexahedra, "st_venant_kirchhoff"),
        std::pair(kLattice, "lattice"), std::pair(kTetrahedra, "neo_hookean_log")})
    for (const char* rest :
         {"swelling: 1.0001", "growth: [1, 1, 1.0001]", "growth: 1.0001, along: z",
          "swelling: 1 + 1e-4 * (1 + x / 1 m - x / 1 m)", "prestretch: 0.9999",
          "thermal: {expansion: 1e-5, change: 10}",
          "regions: [{molecules: {box: {from: [-1 m, -1 m, -1 m], to: [1 m, 1 m, 1 m]}}, swelling: 1.0001}]",
          "swelling: 1.0001, factor: [[0, 0], [0.5, 1]]"}) {
      INFO(stiffness << ", " << rest);
      CHECK(force_of(bar(rest, "displacement: 0 mm", body, stiffness)) == Approx(-1e-4).epsilon(1e-3));
    }
  CHECK(force_of(bar("growth: [1.0001, 1, 1]")) == Approx(0).margin(1e-7));
  CHECK(run_of(bar("swelling: 1.1, factor: [[0, 1], [1, 0]]")).measures.get("total_force") ==
        Approx(0).margin(1e-8));                                                    // back to no stress
  CHECK(force_of(bar("swelling: 1.0001, factor: 0.5")) == Approx(0).margin(1e-9));  // acts before the load does
}

TEST_CASE("fibres that are stretched beforehand pull as if the bar had been drawn out", "[scene][rest]") {
  const std::string fibre = ", fibre: {direction: z, youngs_modulus: 20 kPa}";
  const std::string at_rest =
      bar("prestretch: 1.02, along: fibres", "displacement: 0 mm", kHexahedra, "neo_hookean", fibre);
  if (const std::string why = refused(at_rest); !why.empty()) FAIL(why);
  const double drawn = force_of(bar("", "strain: 2 %", kHexahedra, "neo_hookean", fibre));
  CHECK(force_of(at_rest) == Approx(drawn).epsilon(1e-7));
  CHECK(force_of(at_rest + "rotate: {axis: [1, 2, 3], angle: 70 deg}\n") == Approx(drawn).epsilon(1e-7));
}

TEST_CASE("in time the rest follows its factor, with steppers of all kinds", "[scene][rest][slow]") {
  for (const char* stepper : {"backward_euler", "velocity_verlet", "block_descent"}) {
    const Run run =
        run_of("title: A swelling body\nbody: {" + kLattice +
               "}\nmaterial: {youngs_modulus: 10 kPa, poissons_ratio: 0.25}\nstiffness: lattice\n"
               "rest: {swelling: 1.1, factor: {ramp: {duration: 0.5 s}}}\nloads: [{rayleigh: {mass: 100 1/s}}]\n"
               "experiment: {kind: motion}\ntime: {duration: 1 s, frames: 10, stepper: " +
               std::string(stepper) + "}\n");
    INFO(stepper << ": " << run.cause);
    REQUIRE(run.outcome == Outcome::converged);
    CHECK(run.measures.get("largest_strain") == Approx(0.1).epsilon(0.01));
    CHECK(run.curve[3].measures.get("largest_strain") == Approx(0.1 * 0.6).epsilon(0.1));
  }
}

TEST_CASE("in time the rest begins with its factor at the start", "[scene][rest][slow]") {
  const auto held = [](const std::string& rest, const std::string& stepper, const std::string& more = "",
                       const std::string& stiffness = "neo_hookean") {
    return run_of("title: A bar\nbody: {" + kTetrahedra + "}\nmaterial: {youngs_modulus: 10 kPa, poissons_ratio: 0.25" +
                  more + "}\nstiffness: \"" + stiffness + "\"\nrest: {" + rest +
                  "}\nexperiment: {kind: motion, fixture: {kind: tension, axis: z, displacement: 0 mm}}\n"
                  "time: {duration: 1 s, frames: 20, stepper: " +
                  stepper + "}\n");
  };
  for (const char* stepper : {"velocity_verlet", "newmark"}) {
    INFO(stepper);
    const Run still = held("swelling: 1.001, factor: {table: [[0 s, 0], [1 s, 0]]}", stepper);
    REQUIRE(still.outcome == Outcome::converged);
    for (const CurvePoint& row : still.curve) CHECK(std::abs(row.measures.get("force")) < 1e-12);
    const Run grows = held("swelling: 1.001, factor: {ramp: {duration: 1 s}}", stepper);
    REQUIRE(grows.outcome == Outcome::converged);
    CHECK(grows.curve.front().measures.get("force") == Approx(0).margin(1e-12));
    CHECK(grows.measures.get("force") == Approx(-1e-3).epsilon(0.05));
    CHECK(grows.measures.get("work") == Approx(grows.measures.get("energy")).epsilon(0.05));
    CHECK(grows.measures.get("energy_drift") < 1e-3);
  }
  // What has relaxed at 0.5 s has done so from there on: E A e (1/4 + 3/4 exp(-(t - 0.5 s)/0.5 s)).
  const Run steps =
      held("prestretch: 1.001, along: z, factor: {step: {at: 0.475 s}}", "backward_euler, step: {per_frame: 8}",
           ", density: 0.001 kg/m3, relaxation: {terms: [[0.75, 0.5 s]], moduli: instantaneous}", "prony:neo_hookean");
  INFO(steps.cause);
  REQUIRE(steps.outcome == Outcome::converged);
  for (const CurvePoint& row : steps.curve) {
    const double since = row.time - 0.475;
    INFO(row.time);
    CHECK(row.measures.get("force") ==
          Approx(since < 0 ? 0 : 1e-3 * (0.25 + 0.75 * std::exp(-since / 0.5))).epsilon(0.02).margin(1e-12));
  }
  CHECK(steps.measures.get("energy_drift") < 1e-3);
}

TEST_CASE("small displacements about a shape that is not the body's rest are not unstable for turning",
          "[scene][rest][slow]") {
  const Run free = run_of(bar("swelling: 1.00001", "displacement: 0.1 mm") + "solver: {displacements: small}\n");
  CHECK(free.outcome == Outcome::converged);
  CHECK_FALSE(free.unstable);
  // A strip that has grown by 0.8 and by 5 times Euler's strain, under a force across it.
  for (const auto& [growth, unstable] : {std::pair("1.0016", false), std::pair("1.01", true)}) {
    const Run strip =
        run_of(std::string(
                   "body: {lattice: {kind: cubic, molecules: [41, 3, 2], spacing: 1 mm, order: 2}}\n"
                   "material: {youngs_modulus: 100 kPa, poissons_ratio: 0}\nstiffness: neo_hookean\nrest: {growth: [") +
               growth +
               ", 1, 1]}\nsupports: [{molecules: {side: x}}, {molecules: {side: -x}}]\nexperiment: {kind: loads}\n"
               "loads: [{traction: {traction: [0, 0, 0.01 Pa], on: {side: z}}}]\n"
               "solver: {displacements: small, linear_solver: direct}\n");
    INFO(growth << strip.cause);
    CHECK(strip.outcome == Outcome::converged);
    CHECK(strip.unstable == unstable);
  }
}

TEST_CASE("a chain that has grown into its rest is not unstable, though it was compressed in the first iteration",
          "[scene][rest]") {
  const Run chain = run_of(
      "title: A chain\nbody: {molecules: [[0, 0, 0 mm], [0, 0, 1 mm], [0, 0, 2 mm], [0, 0, 3 mm]], connections: "
      "[[0, 1], [1, 2], [2, 3]], radius: 0.2 mm}\nmaterial: {youngs_modulus: 13 kPa, density: 1000 kg/m3}\n"
      "stiffness: {strategy: uniform, constant: 20 N/m}\nrest: {growth: 1.1, factor: 1}\n"
      "experiment: {kind: tension, axis: z, force: 1 mN, cross_section: 1 mm2}\n");
  REQUIRE(chain.outcome == Outcome::converged);
  CHECK_FALSE(chain.unstable);
  CHECK(chain.zero_energy_modes == 4);  // before the load nothing resists them
  CHECK(chain.measures.get("total_elongation") == Approx(0.3e-3 + 3 * 1e-3 / 20).epsilon(1e-6));
}

TEST_CASE("what a prestretched membrane resists by its tension is no zero-energy mode", "[scene][rest][vibration]") {
  for (const char* load : {"removed", "applied"}) {
    const Run drum = run_of(
        "title: A drum\nbody: {disc: {radius: 20 mm, rings: 4}}\nmaterial: {youngs_modulus: 80 kPa, poissons_ratio: "
        "0.3, density: 1100 kg/m3, thickness: 0.2 mm}\nstiffness: st_venant_kirchhoff_membrane\n"
        "supports: [{molecules: {rim: true}, fix: all}]\nrest: {prestretch: 1.02, factor: 1}\n"
        "experiment: {kind: vibration, count: 1, fixture: {kind: loads}, load: " +
        std::string(load) + "}\n");
    INFO(load);
    REQUIRE(drum.outcome == Outcome::converged);
    CHECK(drum.zero_energy_modes == 0);
    CHECK(drum.warnings.empty());
    CHECK(drum.measures.get("frequency_1") == Approx(27.6).epsilon(0.1));
  }
}

TEST_CASE("the unloaded shape hangs to the given one", "[scene][rest]") {
  for (const auto& [stiffness, nu] : {std::pair("neo_hookean+volume", 0.49), std::pair("neo_hookean+volume", 0.3),
                                      std::pair("st_venant_kirchhoff", 0.3), std::pair("neo_hookean_log", 0.3)}) {
    const Run run = run_of(
        "title: A block\nbody: {lattice: {kind: cubic, molecules: [3, 3, 5], spacing: 2 cm, order: 1}}\n"
        "material: {youngs_modulus: 5 kPa, poissons_ratio: " +
        std::to_string(nu) + "}\nstiffness: " + stiffness +
        "\nrest: {unloaded_from: loads}\nloads: [{gravity: [0, 0, -9.81 m/s2]}]\n"
        "supports: [{molecules: {side: z}}]\nexperiment: {kind: loads}\n");
    INFO(stiffness << ", " << nu << ": " << run.cause);
    REQUIRE(run.outcome == Outcome::converged);
    CHECK(run.measures.get("unloading_error") < 1e-8 * 0.08);
    CHECK(run.measures.get("largest_displacement") < 1e-8 * 0.08);
    CHECK(run.measures.get("unloaded_displacement") > 1e-3);
  }
  // Springs, and an experiment of its own that begins in the given shape.
  const Run springs = run_of(bar("unloaded_from: loads", "force: 1 mN", kLattice, "lattice") +
                             "loads: [{gravity: [0, 0, 9.81 m/s2]}]\n");
  INFO(springs.cause);
  REQUIRE(springs.outcome == Outcome::converged);
  CHECK(springs.measures.get("unloading_error") < 1e-8 * 0.02);
  CHECK(springs.measures.get("elongation") == Approx(2e-2 * 1e-3 / (1e4 * 1e-4)).epsilon(0.05));
}

TEST_CASE("an unloaded shape that a run writes hangs to the given one, and a run begins in a state of another",
          "[scene][rest]") {
  TemporaryFolder folder;
  const std::string pulled = "force: 10 mN";  // which takes no mass: that of the unloaded body is another
  const auto solve = [&](const std::string& text) {
    auto scene = load_scene(folder.write("scene.yaml", text), kCatalog);
    prepare(scene->specimen, scene->stiffness.strategy);
    const Run run = run_strategy(scene->specimen, *scene->experiment, scene->stiffness,
                                 {.statics = scene->statics, .keep_snapshots = true, .time = scene->time});
    INFO(text << run.cause);
    REQUIRE(run.outcome == Outcome::converged);
    return std::pair(std::move(scene), run);
  };
  const auto [given, first] = solve(bar("unloaded_from: loads", pulled));
  write_states(folder.path(""), "block", given->specimen.body, first);
  const std::string unloaded = "mesh: {file: block-unloaded.vtu, length_unit: m}";
  const auto [other, second] = solve(bar("", pulled, unloaded));
  const Positions &wanted = given->specimen.body.rest, &hung = second.snapshots.back().positions;
  CHECK((wanted - other->specimen.body.rest).norm() > 1e-4);
  CHECK((wanted - hung).norm() < 1e-7);  // the force is shared by the areas of each body's own end
  write_states(folder.path(""), "hung", other->specimen.body, second);
  const auto [again, third] =
      solve("body: {" + unloaded +
            "}\nmaterial: {youngs_modulus: 10 kPa, poissons_ratio: 0.25}\nstiffness: neo_hookean\n"
            "initial: {positions: {file: hung-001.vtu, length_unit: m}}\nexperiment: {kind: motion}\n"
            "time: {duration: 1 ms, frames: 1}\n");
  CHECK((third.snapshots.front().positions - hung).norm() < 1e-15);
}

TEST_CASE("engines get the lengths of springs without stress, and where the body begins", "[scene][rest][export]") {
  TemporaryFolder folder;
  const auto exported = [&](const std::string& text) {
    const auto scene = load_scene(folder.write("scene.yaml", text), kCatalog);
    return exported_body(*scene, scene->stiffness);
  };
  for (const ExportedBody::Connection& one :
       exported(bar("swelling: 1.1", "displacement: 0 mm", kLattice, "lattice")).connections) {
    const double rest = one.rest_length / 2.5e-3;
    CHECK((rest == Approx(1.1) || rest == Approx(1.1 * std::sqrt(2))));
  }
  const std::string weight = "loads: [{gravity: [0, 0, 9.81 m/s2]}]\n";
  const ExportedBody hanging = exported(bar("unloaded_from: loads", "force: 1 mN", kLattice, "lattice") + weight);
  CHECK(hanging.start.row(2).maxCoeff() == Approx(0.02));
  CHECK(hanging.positions.row(2).maxCoeff() < 0.02 - 1e-5);
  CHECK_THAT(refusal([&] { exported(bar("swelling: 1.1")); }), Contains("`rest` of cells is not exported"));
}

TEST_CASE("a shape is kept in place by what its supports bear of a prestrain", "[scene][rest]") {
  // Along the bar a force is the same everywhere: of strains e(z) its mean remains. Across it is free.
  for (const auto& [body, stiffness] : {std::pair(kTetrahedra, "neo_hookean"), std::pair(kHexahedra, "neo_hookean_log"),
                                        std::pair(kLattice, "lattice")}) {
    const Run run = run_of(
        bar("prestrain_in_place: {prestretch: 1 + 1e-4 * z / 1 cm, along: z}", "displacement: 0 mm", body, stiffness));
    INFO(stiffness << ": " << run.cause);
    REQUIRE(run.outcome == Outcome::converged);
    CHECK(run.measures.get("total_force") == Approx(1e-4).epsilon(2e-3));  // before the test, a preload
    CHECK(run.measures.get("prestrain_error") < 1e-10 * 0.03);
    CHECK(run.measures.get("prestrain_remaining") < 0.95);
  }
  // Of any size: without a lateral strain the bar pulls as one that was drawn out.
  const std::string none = "poissons_ratio: 0", quarter = "poissons_ratio: 0.25";
  const auto with = [&](std::string text) { return text.replace(text.find(quarter), quarter.size(), none); };
  CHECK(run_of(with(bar("prestrain_in_place: {prestretch: 1.2, along: z}"))).measures.get("total_force") ==
        Approx(force_of(with(bar("", "strain: 20 %")))).epsilon(1e-7));
  const Run free = run_of(bar("prestrain_in_place: 1.1"));
  CHECK(free.measures.get("prestrain_remaining") > 0.1);  // along the bar alone
  REQUIRE(free.warnings.size() == 1);
  CHECK_THAT(free.warnings.front(), Contains("% of the prestrain remain"));
  CHECK_THAT(refused(bar("prestrain_in_place: 1.1, swelling: 2")), Contains("stands alone"));
  CHECK_THAT(refused(bar("prestrain_in_place: -1")), Contains("prestrain_in_place") && Contains("above 0"));
  CHECK_THAT(refused(bar("prestrain_in_place: {along: z}")), Contains("states nothing"));
  CHECK_THAT(refused(bar("prestrain_in_place: {}")), Contains("states nothing"));
  const Run torn = run_of(bar("prestrain_in_place: {growth: [1, 1 + 0.9 * sin(3000 * x / 1 m), 1]}"));
  CHECK(torn.outcome != Outcome::converged);
  CHECK_THAT(torn.cause, Contains("prestrain in place: "));
}

TEST_CASE("what is wrong with a rest is said where it stands", "[scene][rest]") {
  CHECK_THAT(refused(bar("swelling: -1")), Contains("rest.swelling") && Contains("above 0") && Contains(":5:"));
  CHECK_THAT(refused(bar("swelling: -1.02")), Contains("'-1.02' is out of range: must be above 0"));
  CHECK_THAT(refused(bar("swelling: 0")), Contains("rest.swelling"));
  CHECK_THAT(refused(bar("swelling: 1 - z / 1 cm")), Contains("rest.swelling"));
  CHECK_THAT(refused(bar("growth: [1, 2]")), Contains("rest.growth"));
  CHECK_THAT(refused(bar("growth: [1, 2, -3]")), Contains("rest.growth[2]"));
  CHECK_THAT(refused(bar("thermal: {expansion: 0.1, change: -20}")), Contains("must be above 0"));
  CHECK_THAT(refused(bar("thermal: {expansion: 0.1}")), Contains("change"));
  CHECK_THAT(refused(bar("thermal: {expansion: 0.1, change: 10 K}")), Contains("temperatures are plain numbers"));
  CHECK_THAT(refused(bar("sweling: 1.1")), Contains("did you mean 'swelling'"));
  CHECK_THAT(refused(bar("factor: 1")), Contains("states nothing"));
  CHECK_THAT(refused(bar("prestretch: 1.1, along: fibres")), Contains("rest.along") && Contains("no `fibre`"));
  CHECK_THAT(refused(bar("swelling: 1.1, along: z")), Contains("rest.along"));
  CHECK_THAT(refused(bar("growth: [1.1, 1, 1], along: z")), Contains("rest.along") && Contains("one factor"));
  CHECK_THAT(refused(bar("swelling: 1.1, factor: {ramp: {duration: 1 s}}")), Contains("has no time"));
  CHECK_THAT(refused(bar("swelling: 1.1, factor: [[0, 1], [2, 1]]")), Contains("rest.factor"));
  CHECK_THAT(refused(bar("swelling: 1.1, unloaded_from: loads")), Contains("stands alone"));
  CHECK_THAT(refused(bar("unloaded_from: weight")), Contains("loads"));
  CHECK_THAT(refused(bar("regions: [{molecules: {nearest: [0, 0, 0]}, swelling: 2}]")), Contains("no cell"));
  CHECK_THAT(refused(bar("")), Contains("a load of zero stretches nothing"));
}

TEST_CASE("loads that no unloaded shape has, or only another one, end with the cause", "[scene][rest][slow]") {
  const auto hanging = [](const std::string& gravity) {
    return run_of(
        "body: {lattice: {kind: cubic, molecules: [3, 3, 9], spacing: 1 cm, order: 1}}\n"
        "material: {youngs_modulus: 1 kPa, poissons_ratio: 0.3}\nstiffness: neo_hookean\nrest: {unloaded_from: loads}\n"
        "loads: [{gravity: [0, 0, " +
        gravity + " m/s2]}]\nsupports: [{molecules: {side: z}}]\nexperiment: {kind: loads}\n");
  };
  const Run heavy = hanging("-1000");
  CHECK(heavy.outcome != Outcome::converged);
  CHECK_THAT(heavy.cause, Contains("unloading: "));
  const Run none = hanging("0");
  CHECK_THAT(none.cause, Contains("no load acts"));
}

TEST_CASE("Newton's method finds unloaded shapes where mixing does not, or says up to which load there is one",
          "[scene][rest][slow]") {
  const auto balloon = [](const std::string& divisions, const std::string& stiffness) {
    return run_of(
        "body: {sphere_octant: {radius: 10 mm, divisions: " + divisions +
        "}}\nmaterial: {youngs_modulus: 1 MPa, poissons_ratio: 0.5, thickness: 0.2 mm}\nstiffness: " + stiffness +
        "\nrest: {unloaded_from: loads}\nloads: [{pressure: 4 kPa}]\n"
        "supports: [{symmetry: x}, {symmetry: y}, {symmetry: z}]\nexperiment: {kind: loads}\n");
  };
  for (const char* stiffness : {"neo_hookean_membrane", "standard", "lloyd", "divided"}) {
    const Run run = balloon("4", stiffness);
    INFO(stiffness << ": " << run.cause);
    REQUIRE(run.outcome == Outcome::converged);
    CHECK(run.measures.get("unloading_error") < 1e-8 * 0.01);
    CHECK(run.measures.get("unloaded_displacement") > 5e-5);
  }
  // The height of a molecule amid triangles of size l changes their lengths by some (l/r)²/8: too little at 16
  // divisions.
  const Run none = balloon("16", "lloyd");
  CHECK(none.outcome == Outcome::diverged);
  CHECK_THAT(none.cause, Contains("% of the loads, and none close to it under more") && Contains("prestrain_in_place"));
  for (const char* stiffness : {"standard", "neo_hookean_log"}) {  // which hangs sideways, bent by more than its height
    const Run bent = run_of(
        "body: {lattice: {kind: cubic, molecules: [4, 4, 7], spacing: 15 mm, order: 1}}\n"
        "material: {youngs_modulus: 5 kPa, poissons_ratio: 0.3, density: 1060 kg/m3}\nstiffness: " +
        std::string(stiffness) +
        "\nrest: {unloaded_from: loads}\nloads: [{gravity: [0, -9.81 m/s2, 0]}]\n"
        "supports: [{molecules: {side: z}}]\nexperiment: {kind: loads}\n");
    INFO(stiffness << ": " << bent.cause);
    REQUIRE(bent.outcome == Outcome::converged);
    CHECK(bent.measures.get("largest_displacement") < 1e-8 * 0.1);
    CHECK(bent.measures.get("unloaded_displacement") > 0.05);
  }
}

TEST_CASE("a strip between clamps buckles where it has grown by Euler's strain, and not before",
          "[scene][rest][slow]") {
  // π² h²/(3 L²) of h = 1 mm, L = 40 mm; behind it the height (2 L/π) √(e − e_c) of the middle.
  const double critical = std::pow(3.14159265358979 / 40, 2) / 3;
  for (const double times : {0.95, 2.0}) {
    const Run run = run_of(
        "body: {lattice: {kind: cubic, molecules: [41, 3, 2], spacing: 1 mm, order: 2}}\n"
        "material: {youngs_modulus: 100 kPa, poissons_ratio: 0}\nstiffness: neo_hookean\nrest: {growth: [" +
        std::to_string(1 + times * critical) +
        ", 1, 1]}\nsupports: [{molecules: {side: x}}, {molecules: {side: -x}}]\nexperiment: {kind: loads}\n");
    INFO(times << ": " << run.cause);
    REQUIRE(run.outcome == Outcome::converged);
    CHECK(run.measures.get("largest_displacement") ==
          Approx(times < 1 ? 0 : 80e-3 / 3.14159265358979 * std::sqrt((times - 1) * critical))
              .epsilon(0.02)
              .margin(1e-9));
  }
}

TEST_CASE("what supports bear alone is no load, in a turned scene either", "[rest][linear]") {
  const std::string block =
      "title: A bar\nbody: {tetrahedra: {kind: kuhn, cubes: [2, 1, 2], size: [2 cm, 1 cm, 2 cm]}}\nstiffness: "
      "neo_hookean\n"
      "experiment: {kind: tension, axis: z, strain: 5 %}\nsolver: {displacements: small}\n";
  for (const std::string load :
       {"material: {youngs_modulus: 10 kPa, poissons_ratio: 0}\nloads: [{face: {side: z, traction: [0, 0, 10 Pa]}}]\n",
        "material: {youngs_modulus: 10 kPa, poissons_ratio: 0.3, active: {direction: z, stress: 1 kPa}}\n"}) {
    INFO(load);
    const Run plain = run_of(block + load),
              turned = run_of(block + load + "rotate: {axis: [1, 2, 3], angle: 33 deg}\n");
    CHECK(turned.cause == "");
    CHECK(turned.measures.get("effective_modulus") == Approx(plain.measures.get("effective_modulus")).epsilon(1e-8));
  }
}

// Connections within a cell of second order have their middle where the cell has it.
TEST_CASE("what grows in a region are the cells all of whose molecules are in it", "[scene][rest]") {
  const double radius = 10.1e-3;
  const std::string text =
      bar("regions: [{molecules: {sphere: {centre: [0, 0, 0], radius: 10.1 mm}}, growth: 0.97}]", "displacement: 0 mm",
          "tetrahedra: {kind: body_centred, cubes: [2, 2, 2], size: [16 mm, 12 mm, 16 mm], order: 2}");
  const TemporaryFolder folder;
  const auto scene = load_scene(folder.write("scene.yaml", text), kCatalog);
  const Body& body = scene->specimen.body;
  int grown = 0;
  for (int cell = 0; cell < body.blocks.at(0).size(); ++cell) {
    Vector3 middle = Vector3::Zero();
    bool within = true;
    for (const int node : body.blocks[0].cell(cell)) {
      middle += body.rest.col(node) / 10;
      within &= body.rest.col(node).norm() <= radius;
    }
    CHECK(body.unstressed->metric(middle, middle)(0, 0) == (within ? 0.97 : 1));
    grown += within;
  }
  CHECK(grown > 0);
  for (int c = 0; c < body.connections.size(); ++c) {
    const auto& [a, b] = body.connections.ends[c];
    const Vector3 first = body.rest.col(a), second = body.rest.col(b);
    const bool within = first.norm() <= radius && second.norm() <= radius;
    CHECK(body.unstressed->length(first, second) == Approx(within ? 0.97 : 1).epsilon(1e-12));
  }
  CHECK(force_of(text + "rotate: {axis: [1, 2, 0], angle: 20 deg}\n") == Approx(force_of(text)).epsilon(1e-7));
}

TEST_CASE("under a rest that was there before, an experiment's measures are what it adds", "[scene][rest]") {
  const auto measures = [](const std::string& experiment, const std::string& rest, const std::string& more = "") {
    const Run run =
        run_of("title: A bar\nbody: {" + kTetrahedra +
               "}\nmaterial: {youngs_modulus: 10 kPa, poissons_ratio: 0.25}\nstiffness: neo_hookean\nrest: {" + rest +
               "}\nexperiment: {" + experiment + "}\nreference: none\n" + more);
    INFO(experiment << ", " << rest << ": " << run.cause);
    REQUIRE(run.outcome == Outcome::converged);
    return run.measures;
  };
  const std::string before = "growth: 1.2, factor: 1", with = "growth: 1.2";

  const Measures turned = measures("kind: torsion, axis: z, angle: 0.01 rad", before);
  const double torque = turned.get("torque");
  CHECK(torque == Approx(turned.get("total_torque")).epsilon(1e-4));  // symmetry: before the turn there was none
  CHECK(torque == Approx(measures("kind: torsion, axis: z, angle: 0.01 rad", with).get("torque")).epsilon(1e-4));
  CHECK(torque == Approx(2 * turned.get("energy_increase") / 0.01).epsilon(1e-2));

  const auto pressure = [&](const std::string& strain, const std::string& rest) {
    return measures("kind: hydrostatic, strain: " + strain, rest).get("pressure");
  };
  CHECK(pressure("0.1", before) == Approx(pressure("0.1", with) - pressure("1e-9", with)).epsilon(1e-6));

  const Measures pulled = measures("kind: tension, axis: z, strain: 0.1", with);  // the rest comes with the load
  if (const double added = pulled.get("energy_increase"); std::isfinite(added))
    CHECK(added == Approx(pulled.get("energy")).epsilon(1e-9));

  const Measures pressed =
      measures("kind: press, axis: -z, displacement: 1 nm, grip: sliding", "growth: 1.1, along: z, factor: 1",
               "contact: {obstacles: [{plane: {point: [0, 0, -10 mm], normal: z}}]}\n");
  CHECK(pressed.get("total_force") > 0.05);
  CHECK(std::abs(pressed.get("force")) < 1e-4 * pressed.get("total_force"));
}

TEST_CASE("where a field has another Poisson's ratio, the material's is no target", "[scene][fields]") {
  const auto target = [](const std::string& field) {
    const std::string text = bar("", "strain: 1 %", kTetrahedra, "neo_hookean", ", fields: {" + field + "}");
    TemporaryFolder folder;
    return no_one_modulus(load_scene(folder.write("scene.yaml", text), kCatalog)->specimen);
  };
  CHECK_THAT(target("poissons_ratio: {expression: '0.37 + 0 * x / 1 mm'}"), Contains("not everywhere as stiff"));
  CHECK(target("poissons_ratio: {expression: '0.25 + 0 * x / 1 mm'}").empty());
}
