// Load steps that stall are bisected, and end where shorter ones do.

#include "lab/run/load_path.h"

#include <algorithm>
#include <cmath>

#include <catch2/catch.hpp>

#include "lab/run/specimen.h"
#include "lab/scene/scene.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;
using Catch::Matchers::Contains;

TEST_CASE("a nearly incompressible bonded cube is stretched in one load step as in many", "[statics][load_path]") {
  const TemporaryFolder folder;
  const Catalog catalog = built_in_catalog();
  std::vector<Run> runs;
  for (const std::string steps : {"1", "6"}) {
    const auto scene = load_scene(
        folder.write("scene.yaml",
                     "title: A bonded cube\n"
                     "body: {tetrahedra: {kind: body_centred, cubes: [2, 2, 2], size: [10 mm, 10 mm, 10 mm]}}\n"
                     "material: {youngs_modulus: 10 kPa, poissons_ratio: 0.49}\nstiffness: neo_hookean+volume\n"
                     "experiment: {kind: tension, axis: z, strain: 150 %, fixed_grip: clamped, loaded_grip: clamped, "
                     "load_steps: " +
                         steps + "}\n"),
        catalog);
    runs.push_back(run_strategy(scene->specimen, *scene->experiment, scene->stiffness, {.statics = scene->statics}));
    INFO(steps << ": " << runs.back().cause);
    REQUIRE(runs.back().outcome == Outcome::converged);
  }
  CHECK(runs[0].bisected_load_steps > 0);
  CHECK(runs[1].bisected_load_steps == 0);
  CHECK(runs[0].newton_iterations < 100);  // halved while it stalls, not after 200 iterations
  for (const char* measure : {"force", "energy"})
    CHECK(runs[0].measures.get(measure) == Approx(runs[1].measures.get(measure)).epsilon(1e-7));
}

namespace {

/// Asks for another solve for ever.
class Insatiable final : public StaticRig {
 public:
  void set_load(double) override {}
  bool adjust(const State&) override { return true; }
  Measures measure(const Start&, const State&, const StaticOptions&, StaticResult&) const override { return {}; }
};

}  // namespace

TEST_CASE("a load that its corrections do not bring to what is prescribed is no equilibrium of it",
          "[statics][load_path]") {
  Body body;
  body.rest = Positions::Identity(3, 2);
  body.mass = body.radius = VectorX::Ones(2);
  Model model(body);
  for (const int molecule : {0, 1}) model.supports.push_back({molecule});
  Insatiable rig;
  State state = state_at_rest(body);
  StaticResult solved = solve_static(model, state, {});
  REQUIRE(solved.outcome == Outcome::converged);
  adjust_load(model, rig, {}, state, solved);
  CHECK(solved.outcome == Outcome::limit_reached);
  CHECK_THAT(solved.cause, Contains("what is prescribed is not reached after 10 corrections of the load"));
}

TEST_CASE("a displacement that nothing resists is a mechanism", "[statics][load_path]") {
  const auto run = [](const std::string& body, const std::string& ends) {
    const auto scene = load_scene(SceneSource::of_text("a.yaml", "title: t\n" + body +
                                                                     "material: {youngs_modulus: 10 kPa}\n"
                                                                     "stiffness: neo_hookean\n"
                                                                     "solver: {displacements: small}\n"
                                                                     "experiment: {kind: tension, axis: x, "
                                                                     "displacement: 0.1 mm" +
                                                                     ends + "}\n"),
                                  built_in_catalog());
    RunOptions options;
    options.statics = scene->statics;
    return run_strategy(scene->specimen, *scene->experiment, scene->stiffness, options);
  };
  const std::string cubes = "tetrahedra: {kind: kuhn, cubes: [4, 2, 2], size: [20 mm, 10 mm, 10 mm]}",
                    one = "body: {" + cubes + "}\n",
                    two = "bodies:\n  - {name: a, " + cubes + "}\n  - {name: b, at: [20 mm, 0, 0], " + cubes + "}\n";
  CHECK(run(one, "").outcome == Outcome::converged);
  for (const Run& free : {run(one, ", fixed: [0], loaded: [44]"), run(two, "")}) {
    CHECK(free.outcome == Outcome::mechanism);
    CHECK_THAT(free.cause, Contains("does not resist this displacement"));
  }
}

TEST_CASE("without any force cells rest where they are, and rounding is no load", "[statics][load_path]") {
  const TemporaryFolder folder;
  for (const std::string loads :
       {"[]", "[{gravity: {acceleration: [0, 0, 0]}}]", "[{point: {molecules: {side: x}, force: [0, 0, 0]}}]"})
    for (const std::string steps : {"1", "3"}) {
      const auto scene = load_scene(
          folder.write("scene.yaml",
                       "body: {tetrahedra: {kind: body_centred, cubes: [4, 2, 2], size: [10 mm, 4 mm, 4 mm]}}\n"
                       "material: {youngs_modulus: 10 kPa, poissons_ratio: 0.3, density: 1000 kg/m3}\n"
                       "stiffness: neo_hookean\nsupports: [{molecules: {side: -x}, fix: [x, y, z]}]\nloads: " +
                           loads +
                           "\nexperiment: {kind: loads, read: [{name: end, molecules: {side: x}}], load_steps: " +
                           steps + "}\n"),
          built_in_catalog());
      const Run run = run_strategy(scene->specimen, *scene->experiment, scene->stiffness, {.statics = scene->statics});
      INFO(loads << ", " << steps << ": " << run.cause);
      CHECK(run.outcome == Outcome::converged);
      CHECK(run.warnings.empty());
      CHECK(run.residual == 0);
      CHECK(run.measures.get("reaction_balance") == 0);
      CHECK(std::abs(run.measures.get("end_displacement")) < 1e-15);  // of 1 cm, rounding
    }
}

TEST_CASE("supports that leave a rigid motion free are named where displacements are read", "[statics][load_path]") {
  const TemporaryFolder folder;
  const std::string first = "{molecules: {nearest: [0, 0, 0]}, fix: [x, y, z]}",
                    second = ", {molecules: {nearest: [10 mm, 0, 0]}, fix: [y, z]}",
                    third = ", {molecules: {nearest: [0, 4 mm, 0]}, fix: [z]}";
  for (const auto& [supports, said] : {std::pair{first, "the supports leave 3 rigid motions of the body free"},
                                       {first + second, "the supports leave 1 rigid motion of the body free"},
                                       {first + second + third, ""}}) {
    const auto scene = load_scene(
        folder.write("scene.yaml",
                     "body: {tetrahedra: {kind: body_centred, cubes: [4, 2, 2], size: [10 mm, 4 mm, 4 mm]}}\n"
                     "material: {youngs_modulus: 10 kPa, poissons_ratio: 0.3}\nstiffness: neo_hookean\n"
                     "rest: {swelling: 1.1}\nsupports: [" +
                         supports + "]\nexperiment: {kind: loads, read: [{name: end, molecules: {side: x}}]}\n"),
        built_in_catalog());
    const Run run = run_strategy(scene->specimen, *scene->experiment, scene->stiffness, {.statics = scene->statics});
    REQUIRE(run.outcome == Outcome::converged);
    INFO(supports);
    CHECK(run.warnings.size() == (*said ? 1 : 0));
    if (*said) CHECK_THAT(run.warnings.front(), Contains(said));
    // Where nothing is left free the end goes out by a tenth of the length.
    if (!*said) CHECK(run.measures.get("end_x") == Approx(1e-3).epsilon(1e-6));
  }
}

TEST_CASE("a rigid motion that loads hold is not free", "[statics][load_path]") {
  // A triangle of bars hangs by two of its corners: gravity holds its swing. By one: all but the turn about the
  // vertical.
  const TemporaryFolder folder;
  for (const auto& [held, gravity, said] :
       {std::tuple{"[0, 1]", "-9.81 m/s2", ""},
        {"[0, 1]", "0 m/s2", "the supports leave 1 rigid motion of the body free"},
        {"[2]", "9.81 m/s2", "the supports leave 1 rigid motion of the body free"}}) {
    const auto scene = load_scene(
        folder.write("scene.yaml",
                     "body: {molecules: [[0, 0, 0], [1 cm, 0, 0], [5 mm, 0, -8 mm]], radius: 1 mm, connections: "
                     "[[0, 1], [1, 2], [2, 0]]}\nmaterial: {youngs_modulus: 1 MPa, density: 1000 kg/m3}\n"
                     "stiffness: {strategy: uniform, constant: 10 N/m}\nsupports: [{molecules: " +
                         std::string(held) + "}]\nloads: [{gravity: [0, 0, " + gravity +
                         "]}]\nexperiment: {kind: loads}\n"),
        built_in_catalog());
    const Run run = run_strategy(scene->specimen, *scene->experiment, scene->stiffness, {.statics = scene->statics});
    INFO(held << gravity << run.cause);
    REQUIRE(run.outcome == Outcome::converged);
    CHECK(run.warnings.size() == (*said ? 1 : 0));
    if (*said && !run.warnings.empty()) CHECK_THAT(run.warnings.front(), Contains(said));
  }
}

TEST_CASE("a body that finds no equilibrium says that it is not held, or a mechanism", "[statics][load_path][slow]") {
  const TemporaryFolder folder;
  const auto cause = [&](const std::string& text) {
    const auto scene = load_scene(folder.write("scene.yaml", text), built_in_catalog());
    const Run run = run_strategy(scene->specimen, *scene->experiment, scene->stiffness, {.statics = scene->statics});
    CHECK(run.outcome == Outcome::limit_reached);
    return run.cause;
  };
  const std::string sides =
      "{molecules: {side: -z, body: low}, fix: [z]}, {molecules: [0]}]\n"
      "loads: [{pressure: {pressure: 200 Pa, 'on': {side: -x, body: low}}}, "
      "{pressure: {pressure: 200 Pa, 'on': {side: x, body: low}}}]\nexperiment: {kind: loads}\n";
  CHECK_THAT(
      cause("bodies: [{name: low, tetrahedra: {kind: body_centred, cubes: [2, 2, 2], size: [10 mm, 10 mm, 8 mm]}}, "
            "{name: up, at: [0, 0, 8 mm], lattice: {kind: cubic, molecules: [3, 3, 3], spacing: [5 mm, 5 mm, 4 mm], "
            "order: 2}}]\nties: [{between: [low, up], within: 0.1 mm}]\n"
            "material: {youngs_modulus: 10 kPa, poissons_ratio: 0.3}\nstiffness: neo_hookean\nsupports: [" +
            sides),
      Contains("; the supports leave 1 rigid motion of the bodies free: hold more of them"));
  std::string molecules, connections;
  for (int a = 0; a <= 40; ++a) {
    molecules += (a ? ", [" : "[") + std::to_string(0.0175 * a) + ", 0, " +
                 std::to_string(-0.0178536 * std::min(a, 40 - a)) + "]";
    if (a) connections += (a > 1 ? ", [" : "[") + std::to_string(a - 1) + ", " + std::to_string(a) + "]";
  }
  CHECK_THAT(cause("body: {molecules: [" + molecules + "], connections: [" + connections +
                   "], radius: 0.002}\nmaterial: {youngs_modulus: 5e7, density: 1000}\n"
                   "stiffness: {strategy: uniform, constant: 1e5}\nsupports: [{molecules: [0]}, {molecules: [40]}]\n"
                   "loads: [{gravity: [0, 0, -9.81]}]\nexperiment: {kind: loads}\n"),
             Contains("; `solver.method: implicit` finds where a mechanism comes to rest"));
}

TEST_CASE("rigid motions of several bodies that nothing joins are named, too", "[statics][load_path]") {
  const TemporaryFolder folder;
  const std::string block = "tetrahedra: {kind: body_centred, cubes: [2, 2, 2], size: [4 mm, 4 mm, 4 mm]}";
  for (const auto& [held, said] : {std::pair{"{molecules: {body: a}}, {molecules: {body: b}}", ""},
                                   {"{molecules: {body: a}}", "6 rigid motions of the bodies free"}}) {
    const auto scene = load_scene(
        folder.write("scene.yaml", "bodies: [{name: a, " + block + "}, {name: b, " + block +
                                       ", at: [1 cm, 0, 0]}]\nmaterial: {youngs_modulus: 10 kPa, poissons_ratio: 0.3}\n"
                                       "stiffness: neo_hookean\nrest: {swelling: 1.1}\n"
                                       "supports: [" +
                                       held + "]\nexperiment: {kind: loads}\n"),
        built_in_catalog());
    const Run run = run_strategy(scene->specimen, *scene->experiment, scene->stiffness, {.statics = scene->statics});
    INFO(held << run.cause);
    CHECK(run.warnings.size() == (*said ? 1 : 0));
    if (*said && !run.warnings.empty()) CHECK_THAT(run.warnings.front(), Contains(said));
  }
}

TEST_CASE("a bar near nu = 1/2 is twisted in few Newton iterations a step", "[statics][load_path][slow]") {
  // The torque is that of 40 steps, whose extrapolation is near the path.
  const TemporaryFolder folder;
  const auto twisted = [&](int steps) {
    const auto scene = load_scene(
        folder.write("scene.yaml",
                     "body: {lattice: {kind: cubic, molecules: [3, 3, 4], spacing: 5 mm, order: 2}}\n"
                     "material: {youngs_modulus: 30 kPa, poissons_ratio: 0.4995}\nstiffness: neo_hookean+volume\n"
                     "experiment: {kind: torsion, axis: z, angle: 60 deg, load_steps: " +
                         std::to_string(steps) + "}\n"),
        built_in_catalog());
    const Run run = run_strategy(scene->specimen, *scene->experiment, scene->stiffness, {.statics = scene->statics});
    INFO(steps << ": " << run.cause);
    CHECK(run.outcome == Outcome::converged);
    CHECK(run.newton_iterations <= 8 * steps);
    return run.measures.get("torque");
  };
  CHECK(twisted(10) == Approx(twisted(40)).epsilon(1e-8));
}

TEST_CASE("what one strategy cannot do is its own outcome, and no error of the scene", "[statics][load_path]") {
  const TemporaryFolder folder;
  const auto run_of = [&](const std::string& text, const char* strategy) {
    const auto scene =
        load_scene(folder.write("scene.yaml", text + "stiffness: " + strategy + "\n"), built_in_catalog());
    RunOptions options{.statics = scene->statics};
    options.time = scene->time;
    return run_strategy(scene->specimen, *scene->experiment, scene->stiffness, options);
  };
  const std::string chain =
      "body: {molecules: [[0, 0, 0], [0, 0, 1 cm], [0, 0, 1 cm], [0, 0, 2 cm]], connections: [[0, 1], [1, 2], [2, "
      "3]]}\n"
      "material: {youngs_modulus: 10 kPa}\n"
      "experiment: {kind: tension, axis: z, force: 1 mN, cross_section: 16 mm2}\n";
  for (const char* strategy : {"standard", "calibrated:standard"}) {
    INFO(strategy);
    const Run run = run_of(chain, strategy);
    CHECK(run.outcome == Outcome::diverged);
    CHECK_THAT(run.cause, Contains("it has no length"));
  }
  const std::string damped =
      "body: {lattice: {kind: cubic, molecules: [3, 3, 4], spacing: 1 mm, order: 1}}\n"
      "material: {youngs_modulus: 20 kPa, poissons_ratio: 0.25, density: 1 g/cm^3}\n"
      "loads: [{rayleigh: {stiffness: 20 us}}]\ntime: {duration: 2 ms, frames: 2}\n"
      "experiment: {kind: release, fixture: {kind: tension, axis: z, strain: 2 %}}\n";
  CHECK(run_of(damped, "standard").suited);
  const Run cells = run_of(damped, "neo_hookean");
  CHECK(!cells.suited);
  CHECK_THAT(cells.cause, Contains("`stiffness` of `rayleigh`"));
}

TEST_CASE("a free body that vibrates needs no support", "[statics][load_path]") {
  const TemporaryFolder folder;
  const auto scene =
      load_scene(folder.write("scene.yaml",
                              "body: {tetrahedra: {kind: body_centred, cubes: [4, 2, 2], size: [10 mm, 4 mm, 4 mm]}}\n"
                              "material: {youngs_modulus: 10 kPa, poissons_ratio: 0.3, density: 1 g/cm^3}\n"
                              "stiffness: neo_hookean\nexperiment: {kind: vibration}\n"),
                 built_in_catalog());
  const Run run = run_strategy(scene->specimen, *scene->experiment, scene->stiffness, {.statics = scene->statics});
  CHECK(run.measures.get("rigid_motions") == 6);
  CHECK(run.warnings == std::vector<std::string>{});
}

// Bodies that nothing holds or joins are each what one alone is: none drifts or turns against the others.
TEST_CASE("free balloons under pressure widen as one does", "[statics][load_path][slow]") {
  const auto run = [](const std::string& others, const std::string& load) {
    const auto scene =
        load_scene(SceneSource::of_text(
                       "a.yaml", "bodies: [{name: a, sphere: {radius: 5 cm, divisions: 6}}" + others +
                                     "]\nmaterial: {youngs_modulus: 1 MPa, poissons_ratio: 0.3, thickness: 1 mm}\n"
                                     "stiffness: neo_hookean_membrane\nloads: [" +
                                     load + "]\nexperiment: {kind: loads, read: [{name: a, molecules: {body: a}}]}\n"),
                   built_in_catalog());
    Run found = run_strategy(scene->specimen, *scene->experiment, scene->stiffness, {.statics = scene->statics});
    INFO(found.cause);
    REQUIRE(found.outcome == Outcome::converged);
    return found;
  };
  const std::string second = ", {name: b, sphere: {radius: 5 cm, divisions: 6}, at: [20 cm, 0, 0]}",
                    third = ", {name: c, sphere: {radius: 3 cm, divisions: 4}, at: [0, 20 cm, 1 cm]}";
  for (const std::string load : {"{pressure: 6 kPa}", "{gas: {start_pressure: 111 kPa}}"}) {
    const Run alone = run("", load);
    for (const std::string& others : {second, second + third}) {
      const Run several = run(others, load);
      INFO(load << others);
      CHECK_FALSE(several.unstable);
      CHECK(several.measures.get("a_displacement") == Approx(alone.measures.get("a_displacement")).epsilon(1e-5));
      if (others == second)
        CHECK(several.measures.get("energy") == Approx(2 * alone.measures.get("energy")).epsilon(1e-8));
      CHECK(several.warnings.size() == 1);  // of the rigid motions
    }
  }
}

// A von Mises truss: two springs of k = 100 N/m from (-+10, 0) to (0, 3) cm bear at most 99.5 mN, and a load beyond
// turns them over.
TEST_CASE("a body that snaps through says so, and where", "[statics][load_path]") {
  const auto run = [](double load, int steps, const std::string& shape = "0, 0, 0.03") {
    const auto scene = load_scene(
        SceneSource::of_text("a.yaml", "body: {molecules: [[-0.1, 0, 0], [" + shape +
                                           "], [0.1, 0, 0]], connections: [[0, 1], [1, 2]], radius: 0.005}\n"
                                           "material: {youngs_modulus: 1e5, density: 1000}\n"
                                           "stiffness: {strategy: uniform, constant: 100}\n"
                                           "supports: [{molecules: [0, 2]}, {molecules: [1], fix: [x, y]}]\n"
                                           "loads: [{point: {molecules: [1], force: [0, 0, " +
                                           std::to_string(load) +
                                           "]}}]\n"
                                           "experiment: {kind: loads, load_steps: " +
                                           std::to_string(steps) + ", read: [{name: top, molecules: [1]}]}\n"),
        built_in_catalog());
    return run_strategy(scene->specimen, *scene->experiment, scene->stiffness, {.statics = scene->statics});
  };
  for (const int steps : {1, 11, 50})
    for (const double load : {-0.11, -0.3, -1.}) {
      const Run snapped = run(load, steps);
      INFO(steps << " steps to " << load << " N");
      REQUIRE(snapped.warnings.size() == 1);
      const std::string& said = snapped.warnings.front();
      CHECK_THAT(said, Contains("the body snaps through at "));
      const double percent = std::stod(said.substr(said.find(" at ") + 4));
      CHECK(percent / 100 * -load == Approx(0.0995).epsilon(0.01));
    }
  CHECK(run(-0.09, 1).warnings.empty());
  CHECK(run(0.8, 1).warnings.empty());
  // Flat, it stiffens with the cube of the displacement.
  for (const std::string& warning : run(-5, 1, "0, 0, 0").warnings) CHECK_THAT(warning, !Contains("snaps"));
}

TEST_CASE("what pushes a body away that nothing holds is named, and what holds it by a spring is solved",
          "[statics][load_path]") {
  const auto run = [](const std::string& more) {
    const auto scene = load_scene(
        SceneSource::of_text("a.yaml",
                             "body: {tetrahedra: {kind: kuhn, cubes: [1, 1, 2], size: [1 cm, 1 cm, 2 cm]}}\n"
                             "material: {youngs_modulus: 10 kPa, poissons_ratio: 0.3}\nstiffness: neo_hookean\n" +
                                 more),
        built_in_catalog());
    return run_strategy(scene->specimen, *scene->experiment, scene->stiffness, {.statics = scene->statics});
  };
  const std::string pulled = "experiment: {kind: tension, axis: z, force: 1 mN}\n";
  for (const std::string load :
       {"{pressure: {pressure: 10 Pa, on: {side: x}}}", "{face: {side: y, traction: [-10 Pa, 0 Pa, 0 Pa]}}"}) {
    const Run away = run(pulled + "loads: [" + load + "]\n");
    CHECK(away.outcome == Outcome::mechanism);
    CHECK_THAT(away.cause, Contains("nothing holds the body against 0.002 N of its loads along (-1, 0, 0)"));
  }
  CHECK(run(pulled + "loads: [{face: {side: z, traction: [0 Pa, 0 Pa, 10 Pa]}}]\n").outcome == Outcome::converged);
  CHECK(run("experiment: {kind: loads}\nloads: [{gravity: {acceleration: [0 m/s2, 0 m/s2, -9.81 m/s2]}}, "
            "{floor: {point: [0 m, 0 m, -1 mm], normal: [0, 0, 1]}}]\n")
            .cause.find("nothing holds") == std::string::npos);
}

// The load steps are halved on the way, and the jump lies in a small part of one.
TEST_CASE("a bar that snaps through as it is twisted says so in long load steps", "[statics][load_path]") {
  for (const int steps : {5, 36}) {
    INFO(steps << " load steps");
    const auto scene = load_scene(
        SceneSource::of_text("a.yaml",
                             "body: {tetrahedra: {kind: body_centred, cubes: [1, 1, 4], size: [1 cm, 1 cm, 6 cm]}}\n"
                             "material: {youngs_modulus: 10 kPa, poissons_ratio: 0.3, density: 1000 kg/m3}\n"
                             "stiffness: neo_hookean\n"
                             "experiment: {kind: torsion, axis: z, angle: 1080 deg, load_steps: " +
                                 std::to_string(steps) + "}\n"),
        built_in_catalog());
    const Run snapped =
        run_strategy(scene->specimen, *scene->experiment, scene->stiffness, {.statics = scene->statics});
    REQUIRE(snapped.warnings.size() == 1);
    CHECK_THAT(snapped.warnings.front(), Contains("the body snaps through at 57.7 %") && !Contains("prescribe"));
  }
}

// With nu = 0 nothing moves across: the nominal stress is mu (l - 1/l), and that of the fibres T f(l)/l, f = 1 - 4 (1 -
// l)^2.
TEST_CASE("a muscle at work bears stress before the load, and the modulus is of what the load adds",
          "[statics][load_path][muscle]") {
  const TemporaryFolder folder;
  const std::string scene =
      "body: {tetrahedra: {kind: body_centred, cubes: [2, 2, 4], size: [5 mm, 5 mm, 10 mm]}}\n"
      "material: {youngs_modulus: 20 kPa, poissons_ratio: 0, density: 1 kg/m3, active: {direction: z, stress: 8 kPa";
  const auto run = [&](const std::string& rest) {
    const auto loaded = load_scene(folder.write("scene.yaml", scene + rest), built_in_catalog());
    return run_strategy(loaded->specimen, *loaded->experiment, loaded->stiffness,
                        {.statics = loaded->statics, .time = loaded->time});
  };
  const auto stress = [](double l) { return 10e3 * (l - 1 / l) + 8e3 * (1 - 4 * (1 - l) * (1 - l)) / l; };
  const double area = 25e-6;
  SECTION("held: from its isometric force") {
    const Run pulled = run("}}\nstiffness: neo_hookean_log\nexperiment: {kind: tension, axis: z, strain: 2 %}\n");
    REQUIRE(pulled.outcome == Outcome::converged);
    CHECK(pulled.measures.get("effective_modulus") == Approx((stress(1.02) - stress(1)) / 0.02).epsilon(1e-8));
    CHECK(pulled.measures.get("total_force") == Approx(area * stress(1.02)).epsilon(1e-8));
  }
  SECTION("loaded: from the length to which it has contracted") {
    const Run pulled = run("}}\nstiffness: neo_hookean_log\nexperiment: {kind: tension, axis: z, force: 10 mN}\n");
    REQUIRE(pulled.outcome == Outcome::converged);
    const auto length_at = [&](double force) {
      double low = 0.5, high = 1.5;
      while (high - low > 1e-14) ((stress((low + high) / 2) < force / area ? low : high) = (low + high) / 2);
      return low;
    };
    CHECK(pulled.measures.get("elongation") == Approx(0.01 * (length_at(0.01) - length_at(0))).epsilon(1e-7));
  }
  SECTION("in time the activation comes with the load, which is said") {
    for (const std::string fixture :
         {"tension, axis: z, displacement: 0.1 mm", "shear, axis: z, direction: x, displacement: 0.1 mm"}) {
      const Run moved =
          run(", activation: {ramp: {duration: 10 ms}}}}\nstiffness: neo_hookean_log\n"
              "experiment: {kind: motion, fixture: {kind: " +
              fixture +
              "}}\n"
              "time: {duration: 20 ms, stepper: backward_euler, step: 5 ms}\n");
      REQUIRE(moved.outcome == Outcome::converged);
      REQUIRE(moved.warnings.size() == 1);
      CHECK_THAT(moved.warnings[0], Contains("those of the active fibres too"));
    }
  }
}

TEST_CASE("supports that bear part of the load along the axis are said", "[statics][load_path]") {
  const TemporaryFolder folder;
  const auto said = [&](const std::string& load, const std::string& supports) {
    const auto scene =
        load_scene(folder.write("scene.yaml",
                                "body: {lattice: {kind: cubic, molecules: [3, 3, 5], spacing: 2 mm, "
                                "connections: [axis, face]}}\n"
                                "material: {youngs_modulus: 20 kPa, poissons_ratio: 0.25}\nstiffness: lattice\n"
                                "experiment: {kind: tension, axis: z, " +
                                    load + "}\nsupports: [" + supports + "]\n"),
                   built_in_catalog());
    const Run run = run_strategy(scene->specimen, *scene->experiment, scene->stiffness, {.statics = scene->statics});
    CHECK(run.outcome == Outcome::converged);
    return std::count_if(run.warnings.begin(), run.warnings.end(), [](const std::string& one) {
      return one.find("bear 100 % of the load:") != std::string::npos;
    });
  };
  const std::string middle = "{molecules: {box: {from: [0, 0, 3 mm], to: [4 mm, 4 mm, 5 mm]}}, fix: ";
  for (const std::string load : {"strain: 1 %", "force: 1 mN"}) {
    INFO(load);
    CHECK(said(load, middle + "[z]}") == 1);  // the lower half bears nothing
    CHECK(said(load, middle + "[x]}") == 0);
    CHECK(said(load, "{molecules: {side: -x}, fix: [x]}, {molecules: {side: -y}, fix: [y]}") == 0);
  }
}

// What is held half way up leaves nothing to the lower half, which the other end holds.
TEST_CASE("supports that bear part of any load are said, and those that hold what is moved", "[statics][load_path]") {
  const TemporaryFolder folder;
  const auto said = [&](const std::string& experiment, const std::string& supports, const std::string& words,
                        const std::string& more = "") {
    const auto scene =
        load_scene(folder.write("scene.yaml",
                                "body: {lattice: {kind: cubic, molecules: [3, 3, 5], spacing: 2 mm, "
                                "connections: [axis, face]}}\n"
                                "material: {youngs_modulus: 20 kPa, poissons_ratio: 0.25}\nstiffness: lattice\n"
                                "experiment: {" +
                                    experiment + "}\nsupports: [" + supports + "]\n" + more),
                   built_in_catalog());
    const Run run = run_strategy(scene->specimen, *scene->experiment, scene->stiffness, {.statics = scene->statics});
    INFO(experiment << ", " << supports);
    CHECK(run.outcome == Outcome::converged);
    return std::count_if(run.warnings.begin(), run.warnings.end(),
                         [&](const std::string& one) { return one.find(words) != std::string::npos; });
  };
  const std::string middle = "{molecules: {box: {from: [0, 0, 3 mm], to: [4 mm, 4 mm, 5 mm]}}, fix: ",
                    low = "{molecules: {box: {from: [0, 0, 1 mm], to: [4 mm, 4 mm, 3 mm]}}, fix: ",
                    shear = "kind: shear, axis: z, direction: x, strain: 1 %",
                    torsion = "kind: torsion, axis: z, angle: 1 deg",
                    bending = "kind: bending, axis: z, direction: x, force: 10 uN",
                    biaxial = "kind: biaxial, axis: x, across: y, strain: 1 %",
                    hydrostatic = "kind: hydrostatic, strain: 1 %",
                    along = "{molecules: {box: {from: [1 mm, 0, 0], to: [3 mm, 4 mm, 8 mm]}}, fix: [x]}";
  for (const std::string linear : {"", "solver: {displacements: small}\n"}) {
    INFO(linear);
    CHECK(said(shear, middle + "[x, y, z]}", "bear 100 % of the load", linear) == 1);
    CHECK(said(shear, middle + "[y]}", "of the load", linear) == 0);
    CHECK(said(torsion, middle + "[x, y, z]}", "bear 100 % of the load", linear) == 1);
    CHECK(said(torsion, "{molecules: {side: -x}, fix: [z]}", "of the load", linear) == 0);
    CHECK(said(bending, middle + "[x, y, z]}", "of the load", linear) == 1);
    CHECK(said(bending, "{molecules: {side: -y}, fix: [y]}", "of the load", linear) == 0);
    CHECK(said(bending, "{molecules: {side: z}, fix: [x]}", "of the load", linear) == 1);  // all of it
    CHECK(said(biaxial, along, "of the load", linear) == 1);
    CHECK(said(biaxial, "{molecules: {side: -z}, fix: [z]}", "of the load", linear) == 0);
    CHECK(said(hydrostatic, low + "[z]}", "of the load", linear) == 1);
    CHECK(said(hydrostatic, middle + "[z]}", "of the load", linear) == 0);  // stays there anyway
    CHECK(said("kind: material", along, "of the body alone", linear) == 1);
    CHECK(said("kind: material", "", "of the body alone", linear) == 0);
  }
  const std::string side = "{molecules: {side: -y}, fix: [x]}", moved = "hold 3 molecules that the experiment moves";
  CHECK(said(shear, side, moved + ", the first at (0, 0, 8) mm") == 1);
  CHECK(said("kind: tension, axis: z, strain: 1 %", side, "that the experiment moves") == 0);
  CHECK(said("kind: tension, axis: z, strain: 1 %", "{molecules: {side: -y}, fix: [y, z]}", moved) == 1);
  CHECK(said(hydrostatic, "{molecules: {side: -x}, fix: [x]}", "that the experiment moves") == 0);
  // A ceiling over the spheres of 1 mm at the pulled end bears what would stretch the body.
  CHECK(said("kind: tension, axis: z, force: 1 mN", "", "of the load",
             "contact: {obstacles: [{name: ceiling, plane: {point: [0, 0, 9 mm], normal: [0, 0, -1]}}]}\n") == 1);
}

// A lattice of five layers whose grips are two layers deep, and one of the three layers that are free: what is held or
// moved as a whole takes no part in a strain, with cells and without.
TEST_CASE("grips of several layers strain what is free between them", "[statics][load_path][ends]") {
  const TemporaryFolder folder;
  const auto run = [&](const std::string& layers, const std::string& kind, const std::string& law,
                       const std::string& experiment) {
    const auto scene = load_scene(
        folder.write("scene.yaml", "body: {lattice: {kind: cubic, molecules: [4, 4, " + layers + "], spacing: 5 mm, " +
                                       kind + "}}\nmaterial: {youngs_modulus: 5 kPa, poissons_ratio: 0.25}\n" +
                                       "stiffness: " + law + "\nexperiment: {" + experiment + "}\n"),
        built_in_catalog());
    const Run made = run_strategy(scene->specimen, *scene->experiment, scene->stiffness, {.statics = scene->statics});
    CHECK(made.outcome == Outcome::converged);
    return made.measures;
  };
  const std::string held = ", grip_depth: 6 mm", clamped = ", fixed_grip: clamped, loaded_grip: clamped";
  for (const auto& [kind, law] :
       {std::pair<std::string, std::string>{"connections: [axis, face]", "lattice"}, {"order: 1", "neo_hookean"}}) {
    INFO(law);
    const auto alike = [&, kind = kind, law = law](const std::string& experiment, const std::string& measure) {
      INFO(experiment);
      CHECK(run("5", kind, law, experiment + held).get(measure) ==
            Approx(run("3", kind, law, experiment).get(measure)).epsilon(1e-8));
    };
    alike("kind: tension, axis: z, displacement: 10 um" + clamped, "effective_modulus");
    alike("kind: tension, axis: z, displacement: 10 um" + clamped, "elongation");
    alike("kind: tension, axis: z, strain: 1 %" + clamped, "force");
    alike("kind: shear, axis: z, direction: x, displacement: 10 um", "shear_modulus");
    alike("kind: shear, axis: z, direction: x, strain: 1 %", "force");
    alike("kind: torsion, axis: z, angle: 1 deg", "shear_modulus");
  }
}

// A plate of 20 x 4 x 1 mm between sliding plates, which may turn nowhere: by Euler and Engesser it buckles at a strain
// of pi^2/12 (h/L)^2 = 0.2 %, its rows of molecules being one cell high at some 0.3 %.
TEST_CASE("a plate that buckles within the first load step says so", "[statics][load_path][slow]") {
  const TemporaryFolder folder;
  const auto buckles = [&](const std::string& experiment, const std::string& molecules = "[21, 5, 2]") {
    const auto scene =
        load_scene(folder.write("scene.yaml", "body: {lattice: {kind: cubic, molecules: " + molecules +
                                                  ", spacing: 1 mm, order: 1}}\n"
                                                  "material: {youngs_modulus: 5 kPa, poissons_ratio: 0.3}\n"
                                                  "stiffness: neo_hookean\nexperiment: {" +
                                                  experiment + "}\n"),
                   built_in_catalog());
    const Run run = run_strategy(scene->specimen, *scene->experiment, scene->stiffness, {.statics = scene->statics});
    REQUIRE(run.outcome == Outcome::converged);
    return std::count_if(run.warnings.begin(), run.warnings.end(), [](const std::string& one) {
      return one.find("buckling") != std::string::npos || one.find("is not stable") != std::string::npos;
    });
  };
  CHECK(buckles("kind: compression, axis: x, strain: 0.1 %") == 0);
  for (const std::string strain : {"1 %", "2 %", "5 %"}) {
    INFO(strain);
    CHECK(buckles("kind: compression, axis: x, strain: " + strain) > 0);
    CHECK(buckles("kind: compression, axis: x, load_steps: 2, strain: " + strain) > 0);
  }
  CHECK(buckles("kind: biaxial, axis: x, across: y, strain: [-2 %, 0.1 %]") > 0);
  CHECK(buckles("kind: tension, axis: x, strain: 20 %") == 0);
  CHECK(buckles("kind: compression, axis: x, strain: 30 %", "[5, 5, 5]") == 0);
}

TEST_CASE("a sheet of springs that is pulled by a force has its flat equilibrium, which is not stable",
          "[statics][load_path]") {
  const std::string
      sheet = "body: {sheet: {size: [30 mm, 20 mm], squares: [6, 4], pattern: crossed}}\n",
      net = "body: {lattice: {kind: cubic, molecules: [9, 7, 1], spacing: 1 cm, connections: [axis, face]}}\n";
  for (const std::string& body : {sheet, net, net + "rotate: {axis: [1, 2, 3], angle: 40 deg}\n"}) {
    // Small displacements know no buckling.
    const auto run = [&](const std::string& displacements) {
      const auto scene =
          load_scene(SceneSource::of_text("a.yaml", body +
                                                        "material: {youngs_modulus: 100 kPa, thickness: 1 mm}\n"
                                                        "stiffness: {strategy: uniform, constant: 100 N/m}\n"
                                                        "solver: {displacements: " +
                                                        displacements +
                                                        "}\nexperiment: {kind: tension, axis: x, force: 2 mN, "
                                                        "cross_section: 20 mm2}\n"),
                     built_in_catalog());
      return run_strategy(scene->specimen, *scene->experiment, scene->stiffness, {.statics = scene->statics});
    };
    const Run flat = run("large"), small = run("small");
    INFO(body << flat.cause);
    REQUIRE(flat.outcome == Outcome::converged);
    CHECK(flat.unstable);
    CHECK(flat.newton_iterations < 200);
    for (const std::string& warning : flat.warnings) CHECK_THAT(warning, !Contains("buckling"));
    CHECK(flat.measures.get("effective_modulus") == Approx(small.measures.get("effective_modulus")).epsilon(1e-3));
  }
}

TEST_CASE("a body buckles as it does, whatever makes its stiffness unsymmetric", "[statics][load_path][slow]") {
  const auto run = [](const std::string& body, const std::string& rest) {
    const auto scene = load_scene(SceneSource::of_text("a.yaml", body + rest), built_in_catalog());
    return run_strategy(scene->specimen, *scene->experiment, scene->stiffness, {.statics = scene->statics});
  };
  const auto column = [&](const std::string& more) {
    return run(
        "body: {lattice: {kind: cubic, molecules: [21, 3, 3], spacing: 5 mm, order: 1}}\n"
        "material: {youngs_modulus: 1 MPa, poissons_ratio: 0.3}\nstiffness: neo_hookean\n"
        "supports: [{molecules: {side: -x}}, {molecules: {side: x}, fix: [y, z]}]\n"
        "experiment: {kind: loads, load_steps: 4, read: [{name: mid, molecules: {nearest: [50 mm, 5 mm, 5 mm]}}]}\n",
        more);
  };
  const auto sideways = [](const Run& of) {
    INFO(of.cause);
    REQUIRE(of.outcome == Outcome::converged);
    return std::hypot(of.measures.get("mid_y"), of.measures.get("mid_z"));
  };
  const std::string push = "{traction: {traction: [-25 kPa, 0, 0], 'on': {side: x}}}",
                    pressure = "{pressure: {pressure: 1e-3 Pa, 'on': {side: x}}}",
                    wall =
                        "contact: {friction: 0.3, obstacles: [{name: far, plane: {point: [0, 0, -50 mm], normal: "
                        "z}}]}\n";
  const double dead = sideways(column("loads: [" + push + "]\n"));
  CHECK(dead > 10e-3);
  for (const std::string& more : {"loads: [" + push + ", " + pressure + "]\n", "loads: [" + push + "]\n" + wall}) {
    CAPTURE(more);
    const Run found = column(more);
    CHECK(sideways(found) == Approx(dead).epsilon(0.02));
    CHECK(std::any_of(found.warnings.begin(), found.warnings.end(),
                      [](const std::string& warning) { return warning.find("buckling") != std::string::npos; }));
  }
  // Below its load it stays straight, and says nothing.
  const Run below = column("loads: [{traction: {traction: [-5 kPa, 0, 0], 'on': {side: x}}}, " + pressure + "]\n");
  CHECK(sideways(below) < 1e-9);
  CHECK(below.warnings.empty());

  const auto sheet = [&](const std::string& law) {
    return run(
        "body: {sheet: {size: [10 cm, 5 cm], pattern: one_way, squares: [12, 6]}}\n"
        "material: {youngs_modulus: 1 MPa, poissons_ratio: 0.3, thickness: 1 mm, bending: plate}\n"
        "supports: [{molecules: {side: -x}}]\nexperiment: {kind: loads, load_steps: 2, moved: [{molecules: "
        "{side: x}, displacement: [-5 mm, 0, 0]}]}\n",
        "stiffness: " + law + "\n");
  };
  const double energy = sheet("neo_hookean_membrane").measures.get("energy");
  for (const char* law : {"hencky_membrane", "two_parameter"}) {
    CAPTURE(law);
    const Run found = sheet(law);
    INFO(found.cause);
    REQUIRE(found.outcome == Outcome::converged);
    CHECK(found.measures.get("largest_displacement") > 0.01);
    CHECK(std::isfinite(energy));
  }
}

TEST_CASE("a slack sheet that is sheared stays in its plane, however that is turned", "[statics][load_path]") {
  const auto energy = [](const std::string& turn) {
    const auto scene = load_scene(
        SceneSource::of_text("a.yaml",
                             "body: {sheet: {size: [10 cm, 5 cm], pattern: crossed, squares: [6, 3]}}\n"
                             "material: {youngs_modulus: 1 MPa, poissons_ratio: 0.3, thickness: 0.1 mm}\n"
                             "stiffness: neo_hookean_membrane+wrinkling\nsupports: [{molecules: {side: -y}}]\n"
                             "experiment: {kind: loads, load_steps: 4, moved: [{molecules: {side: y}, displacement: "
                             "[1 cm, 0, 0]}]}\n" +
                                 turn),
        built_in_catalog());
    const Run run = run_strategy(scene->specimen, *scene->experiment, scene->stiffness, {.statics = scene->statics});
    INFO(turn << run.cause);
    CHECK(run.outcome == Outcome::converged);
    return run.measures.get("energy");
  };
  const double straight = energy("");
  for (const std::string turn : {"{axis: x, angle: 30 deg}", "{axis: [1, 1, 0], angle: 50 deg}"})
    CHECK(energy("rotate: " + turn + "\n") == Approx(straight).epsilon(1e-6));
}

TEST_CASE("what is crushed between plates is not said to be free", "[statics][load_path]") {
  // The plates hold the block along z once they touch it; and go on until it has no room.
  const auto scene = load_scene(
      SceneSource::of_text("a.yaml",
                           "body: {tetrahedra: {kind: body_centred, cubes: [2, 2, 2], size: [4 mm, 4 mm, 4 mm]}}\n"
                           "material: {youngs_modulus: 10 kPa, poissons_ratio: 0.3}\nstiffness: neo_hookean\n"
                           "supports: [{molecules: {nearest: [2 mm, 2 mm, 2 mm]}, fix: [x, y]}, "
                           "{molecules: {nearest: [2 mm, 2 mm, 4 mm]}, fix: [x, y]}, "
                           "{molecules: {nearest: [0, 2 mm, 2 mm]}, fix: [y]}]\n"
                           "solver: {newton_limit: 4}\n"
                           "contact: {obstacles: [{name: top, plane: {point: [0, 0, 4.1 mm], normal: -z}, motion: "
                           "{by: [0, 0, -3.9 mm]}}, {name: low, plane: {point: [0, 0, -0.1 mm], normal: z}}]}\n"
                           "experiment: {kind: loads, load_steps: 4}\n"),
      built_in_catalog());
  const Run run = run_strategy(scene->specimen, *scene->experiment, scene->stiffness, {.statics = scene->statics});
  INFO(run.cause);
  REQUIRE(run.outcome != Outcome::converged);
  REQUIRE(!run.curve.empty());
  CHECK_THAT(run.cause, !Contains("free"));
}

TEST_CASE("a curve whose modulus jumps at rest names the ways past that where no equilibrium is found",
          "[statics][load_path][slow]") {
  const auto run = [](const std::string& curve, const std::string& steps) {
    const auto scene = load_scene(
        SceneSource::of_text("a.yaml",
                             "body: {tetrahedra: {kind: body_centred, cubes: [2, 1, 2], size: [2 cm, 1 cm, 2 "
                             "cm], order: 2}}\nmaterial: {curve: {tension: 10 kPa, compression: 5 kPa" +
                                 curve +
                                 "}, poissons_ratio: 0.3, density: 1000 kg/m3}\nstiffness: curve\n"
                                 "experiment: {kind: bending, axis: x, direction: z, "
                                 "gravity: 1 m/s2" +
                                 steps + "}\n"),
        built_in_catalog());
    return run_strategy(scene->specimen, *scene->experiment, scene->stiffness, {.statics = scene->statics});
  };
  const Run stuck = run("", "");
  CHECK(stuck.outcome != Outcome::converged);
  CHECK_THAT(stuck.cause, Contains("a larger `curve.smoothing`, such as 1e-3, or more `load_steps` help"));
  CHECK(run(", smoothing: 1e-3", "").outcome == Outcome::converged);
}

TEST_CASE("a flat membrane bulges under pressures however small", "[statics][load_path]") {
  // w ~ a (p a / (E t))^(1/3) where the slopes are small: an eighth of the pressure, half of the bulge.
  const Catalog catalog = built_in_catalog();
  const auto bulge = [&](const std::string& pressure, const std::string& angle) {
    const auto scene =
        load_scene(SceneSource::of_text("a.yaml",
                                        "title: t\n"
                                        "body: {sheet: {size: [10 mm, 10 mm], squares: [6, 6], pattern: crossed}}\n"
                                        "material: {youngs_modulus: 1 MPa, poissons_ratio: 0.3, thickness: 0.2 mm}\n"
                                        "stiffness: neo_hookean_membrane\nrotate: {axis: x, angle: " +
                                            angle +
                                            "}\nexperiment: {kind: loads, read: [{name: mid, molecules: {nearest: "
                                            "[5 mm, 5 mm, 0]}}]}\n"
                                            "supports: [{molecules: {rim: true}}]\nloads: [{pressure: " +
                                            pressure + "}]\n"),
                   catalog);
    RunOptions options;
    options.statics = scene->statics;
    const Run run = run_strategy(scene->specimen, *scene->experiment, scene->stiffness, options);
    INFO(run.cause);
    CHECK(run.outcome == Outcome::converged);
    return run.measures.get("mid_displacement");
  };
  for (const std::string angle : {"0 deg", "90 deg", "37 deg"}) {
    CAPTURE(angle);
    const double small = bulge("1.25 Pa", angle);
    CHECK(small > 50e-6);
    CHECK(bulge("10 Pa", angle) == Approx(2 * small).epsilon(0.005));
    CHECK(bulge("80 Pa", angle) == Approx(4 * small).epsilon(0.01));
  }
}
