// What a scene says about time: slips named with their place, the scenes of the project as they expect.

#include <catch2/catch.hpp>
#include <string>

#include "lab/report/records.h"
#include "lab/study/study.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

namespace {

const Catalog kCatalog = built_in_catalog();

/// Line 5 is the experiment, line 6 the rest.
std::string scene_with(const std::string& experiment, const std::string& rest) {
  return "title: In time\n"
         "body: {lattice: {kind: cubic, molecules: [2, 2, 4], spacing: 1 cm, connections: [axis, face]}}\n"
         "material: {youngs_modulus: 10 kPa, density: 1000 kg/m3}\n"
         "stiffness: lattice\n"
         "experiment: {" +
         experiment + "}\n" + rest + "\n";
}

const std::string kMotion = "kind: motion", kTime = "time: {duration: 1 s}";
const std::string kFixture = "fixture: {kind: tension, force: 1 mN}";

void check_refusal(const std::string& experiment, const std::string& rest, int line, const std::string& says) {
  INFO(experiment << " | " << rest);
  const TemporaryFolder folder;
  const std::string file = folder.write("slip.yaml", scene_with(experiment, rest));
  std::string message;
  try {
    load_scene(file, kCatalog);
  } catch (const InputError& error) {
    message = error.what();
  }
  CHECK_THAT(message, StartsWith(file + ":" + std::to_string(line) + ":"));
  CHECK_THAT(message, Contains(says));
}

}  // namespace

TEST_CASE("time and the experiments that take it go together", "[scene][time]") {
  check_refusal("kind: tension, force: 1 mN", kTime, 6, "time: a tension experiment is at rest and needs no time");
  check_refusal(kMotion, "", 5, "experiment: a motion experiment runs through time: key 'time' is missing");
  check_refusal("kind: vibration", kTime, 6, "a vibration experiment is at rest");
  check_refusal("kind: relase, " + kFixture, kTime, 5, "did you mean 'release'?");
  check_refusal("kind: release", kTime, 5, "experiment: key 'fixture' is missing");
  check_refusal("kind: release, fixture: {kind: motion}", kTime, 5, "must be an experiment at rest");
  check_refusal("kind: release, load: gone, " + kFixture, kTime, 5, "allowed: removed, applied");
  check_refusal("kind: relaxation, ramp: 1 s, " + kFixture, kTime, 5, "needs a displacement that is given");
  check_refusal("kind: creep, fixture: {kind: tension, displacement: 1 mm}", kTime, 5,
                "must be a force, not a displacement");
  check_refusal("kind: release, fixture: {kind: material}", kTime, 5, "has no displacement to watch");
  check_refusal("kind: motion, in_time: {step: {at: 1 s}}", kTime, 5, "there is no load to change");
  check_refusal("kind: drop, height: 1 cm", kTime, 5, "nothing falls: give a speed, or gravity and a height");
  check_refusal("kind: shake, amplitude: 1 mm", kTime, 5, "key 'frequency' is missing");
}

TEST_CASE("mistakes in the key time", "[scene][time]") {
  check_refusal(kMotion, "time: {}", 6, "time: key 'duration' is missing");
  check_refusal(kMotion, "time: {duration: 1 s, first_frame: 2 s}", 6, "must be shorter than the duration");
  check_refusal(kMotion, "time: {duration: 1 s, first_frame: 0 s}", 6, "must be above 0 s");
  check_refusal(kMotion, "time: {duration: 1 s, step: {per_frame: 2, error: 1e-3}}", 6, "unknown key 'error'");
  check_refusal(kMotion, "time: {duration: -1 s}", 6, "time.duration: '-1 s' is out of range: must be above 0 s");
  check_refusal(kMotion, "time: {duration: 1 s, stepper: newmarc}", 6, "did you mean 'newmark'?");
  check_refusal(kMotion, "time:\n  duration: 1 s\n  steper: newmark\n  frame: 3\n  chekpoint: 2", 8,
                "unknown key 'steper'; did you mean 'stepper'? (allowed: duration, stepper, step, frames, first_frame, "
                "frame_rate, checkpoint, budget); unknown, too: 'frame' in line 9, 'chekpoint' in line 10");
  check_refusal(kMotion, "time: {duration: 1 s, stepper: {method: backward_euler, beta: 0.3}}", 6,
                "time.stepper.beta: only newmark has this");
  check_refusal(kMotion, "time: {duration: 1 s, stepper: {method: newmark, gamma: 0.4}}", 6, "at least 0.5");
  check_refusal(kMotion, "time: {duration: 1 s, stepper: {method: velocity_verlet, newton_iterations: 1}}", 6,
                "only backward_euler, newmark, generalized_alpha have this");
  check_refusal(kMotion, "time: {duration: 1 s, step: 1 kg}", 6, "time.step: 'kg' cannot be converted to s");
  check_refusal(kMotion, "time: {duration: 1 s, step: {eror: 1e-4}}", 6, "did you mean 'error'?");
  check_refusal(kMotion, "time: {duration: 1 s, step: {smallest: 1 s, largest: 1 ms}}", 6, "must not be below");
  check_refusal(kMotion, "time: {duration: 1 s, frames: 0}", 6, "time.frames: '0' is not a whole number of at least 1");
}

TEST_CASE("the stepper's keys are read by their former names too", "[scene][time]") {
  const TemporaryFolder folder;
  const auto stepper_of = [&](const std::string& time, const std::vector<std::string>& overrides) {
    const auto scene = load_scene(folder.write("former.yaml", scene_with(kMotion, time)), kCatalog, overrides);
    return std::pair((*scene->time->stepper)->name, scene->time->parameters);
  };
  using Stepper = std::pair<std::string, ParameterValues>;
  const Stepper newmark{"newmark", {{"gamma", 0.6}}};
  CHECK(stepper_of("time: {duration: 1 s, integrator: {scheme: newmark, gamma: 0.6}}", {}) == newmark);
  CHECK(stepper_of("time: {duration: 1 s, stepper: {scheme: newmark, gamma: 0.6}}", {}) == newmark);
  for (const char* key : {"integrator", "stepper"}) {
    const std::string time = std::string("time: {duration: 1 s, ") + key + ": velocity_verlet}";
    CHECK(stepper_of(time, {}).first == "velocity_verlet");
    for (const char* other : {"integrator", "stepper"}) {
      CHECK(stepper_of(time, {std::string("time.") + other + "=xpbd"}).first == "xpbd");
      CHECK(stepper_of(time, {std::string("time.") + other + "={scheme: newmark, gamma: 0.6}"}) == newmark);
    }
  }
  CHECK(stepper_of("time: {duration: 1 s, integrator: {scheme: xpbd}}",
                   {"time.integrator.scheme=newmark", "time.stepper.gamma=0.6"}) == newmark);
  check_refusal(kMotion, "time: {duration: 1 s, integrator: newmark, stepper: newmark}", 6,
                "time.integrator is the former name of time.stepper, which stands here too");
  for (const char* misspelt : {"intergrator", "integrater", "Integrator"})
    check_refusal(kMotion, std::string("time: {duration: 1 s, ") + misspelt + ": newmark}", 6,
                  std::string("unknown key '") + misspelt + "'; did you mean 'stepper'? Write stepper: newmark");
  check_refusal(kMotion, "time: {duration: 1 s, stepper: {sheme: newmark}}", 6, "did you mean 'method'?");
  const auto compared = load_scene(
      folder.write("compared.yaml", scene_with("kind: tension, axis: z, strain: 1 %",
                                               "steppers: {schemes: [{scheme: block_descent, chebyshev: 0.9}]}")),
      kCatalog);
  CHECK(compared->steppers->methods.at(0).method->name == "block_descent");
}

TEST_CASE("mistakes in a budget", "[scene][time][budget]") {
  const auto budget = [](const std::string& rest) { return "time: {duration: 1 s, budget: 1 ms" + rest + "}"; };
  check_refusal(kMotion, budget(""), 6,
                "one of backward_euler, newmark, generalized_alpha, block_descent, xpbd, projective");
  check_refusal(kMotion, budget(", step: 1 ms, stepper: velocity_verlet"), 6, "chooses how many sweeps");
  check_refusal(kMotion, budget(", stepper: xpbd"), 6, "needs steps of one length");
  check_refusal(kMotion, budget(", stepper: xpbd, step: 1 ms, checkpoint: 1"), 6, "would take other steps");
}

TEST_CASE("steps see every function of time that a scene has", "[scene][time]") {
  const TemporaryFolder folder;
  const auto follows = [&](const std::string& text) {
    return load_scene(folder.write("scene.yaml", text), kCatalog)->time->follows.size();
  };
  const std::string pulse = "{table: [[1 s, 0], [1.1 s, 1], [1.2 s, 0]]}",
                    body = "body: {tetrahedra: {kind: kuhn, cubes: [1, 1, 1], size: [1 cm, 1 cm, 1 cm]}}\n" + kTime +
                           "\nmaterial: {youngs_modulus: 10 kPa, density: 1000 kg/m3";
  CHECK(follows(body + ", active: {direction: z, stress: 2 kPa, activation: " + pulse +
                "}}\nstiffness: neo_hookean\nloads: [{gravity: [0, 0, -1 m/s2], in_time: " + pulse +
                "}]\nrest: {growth: 1.1, factor: " + pulse +
                "}\ncontact: {obstacles: [{plane: {point: [0 mm, 0 mm, -1 mm], normal: z}, motion: {by: [0 mm, 0 mm, "
                "3 mm], in_time: " +
                pulse + "}}]}\nexperiment: {kind: motion, in_time: " + pulse +
                ", fixture: {kind: tension, axis: z, strain: 1 %}}\n") == 5);
  for (const char* experiment : {"shake, axis: z, strain: 1 %, frequency: 3 Hz",
                                 "cyclic, frequency: 3 Hz, fixture: {kind: tension, strain: 1 %}",
                                 "relaxation, ramp: 0.1 s, fixture: {kind: tension, strain: 1 %}"})
    CHECK(follows(body + "}\nstiffness: neo_hookean\nexperiment: {kind: " + experiment + "}\n") == 1);
}

TEST_CASE("mistakes in functions of time, starts and loads", "[scene][time]") {
  const auto in_time = [](const std::string& function) {
    return kTime + "\nloads: [{gravity: [0, 0, -1 m/s2], in_time: " + function + "}]";
  };
  check_refusal("kind: tension, force: 1 mN", "loads: [{gravity: [0, 0, -1 m/s2], in_time: {step: {at: 1 s}}}]", 6,
                "an experiment at rest has no time");
  check_refusal(kMotion, in_time("ramp"), 7, "in_time: write {ramp: …}");
  check_refusal(kMotion, in_time("{rampe: {duration: 1 s}}"), 7, "did you mean 'ramp'?");
  check_refusal(kMotion, in_time("{ramp: {duration: 0 s}}"), 7, "above 0 s");
  check_refusal(kMotion, in_time("{ramp: {duration: 1 s}, step: {at: 1 s}}"), 7, "one of ramp, step, sine, table");
  check_refusal(kMotion, in_time("{table: [[1 s, 0], [0 s, 1]]}"), 7, "must not fall");
  check_refusal(kMotion, in_time("{table: []}"), 7, "needs at least one point");
  check_refusal(kMotion, in_time("{sine: {phase: 1}}"), 7, "key 'frequency' is missing");
  check_refusal(kMotion, kTime + "\nloads: [{damping: 1 N s/m, in_time: {step: {at: 1 s}}}]", 7,
                "damping and drag do not change in time");
  check_refusal(kMotion, kTime + "\nloads: [{rayleigh: {}}]", 7, "give mass (a rate), stiffness (a time), or both");
  check_refusal(kMotion, kTime + "\nloads: [{floor: {normal: z}}]", 7, "key 'point' is missing");
  check_refusal(kMotion, kTime + "\nloads: [{flor: {normal: z}}]", 7, "did you mean 'floor'?");
  check_refusal(kMotion, kTime + "\ninitial: {velocty: [1 m/s, 0 m/s, 0 m/s]}", 7, "did you mean 'velocity'?");
  check_refusal("kind: tension, force: 1 mN", "initial: {velocity: [1 m/s, 0 m/s, 0 m/s]}", 6,
                "an experiment at rest has no velocities");
  check_refusal(kMotion, kTime + "\ninitial: {move: {molecules: [99], by: [1 mm, 0 m, 0 m]}}", 7, "at most 15");

  const std::string bone = "{name: bone, rigid: true, lattice: {kind: cubic, molecules: [2, 2, 2], spacing: 1 cm}}",
                    skin =
                        "{name: skin, at: [0 m, 0 m, 5 cm], lattice: {kind: cubic, molecules: [2, 2, 2], spacing: "
                        "1 cm}}";
  const auto refused = [](const std::string& bodies, const std::string& initial) {
    const TemporaryFolder folder;
    std::string text = scene_with(kMotion, kTime + "\ninitial: {" + initial + "}");
    const std::size_t body = text.find("body:");
    text.replace(body, text.find('\n', body) - body, "bodies: [" + bodies + "]");
    try {
      load_scene(folder.write("bones.yaml", text), kCatalog);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const std::string spin = "spin: [0 /s, 0 /s, 1 /s]",
                    thrown = "throw: [{molecules: [3], velocity: [1 m/s, 0 m/s, 0 m/s]}]";
  CHECK_THAT(refused(bone, spin), Contains("initial.spin: a rigid body stays where it is"));
  CHECK_THAT(refused(bone + ", " + skin, thrown), Contains("the rigid body 'bone' stays where it is"));
  CHECK(refused(bone + ", " + skin, spin) == "");
  CHECK(refused(skin, thrown) == "");
}

TEST_CASE("check says how long an explicit step may be and what sets it", "[scene][time][check]") {
  const TemporaryFolder folder;
  const auto scene = load_scene(folder.write("scene.yaml", scene_with(kMotion, kTime)), kCatalog);
  const std::string text = check_scene(*scene, kCatalog, {}).text;
  CHECK_THAT(text, Contains("in time, lattice") && Contains("velocity_verlet by default") && Contains("dt_crit ") &&
                       Contains("ω_max ") && Contains("set by connection "));
}

TEST_CASE("the scenes in time hold what they expect", "[scene][time][vibrations][slow]") {
  for (const std::string name : {"creep", "drag-quadratic", "drag-stokes", "relaxation", "shake", "drop",
                                 "torsion-released", "vibration-bar-axial"}) {
    INFO(name);
    const auto scene = load_scene(std::string(ELASTIN_SOURCE_DIR) + "/scenes/dynamics/" + name + ".yaml", kCatalog);
    RunOptions options;
    options.time = scene->time;
    options.statics = scene->statics;
    const Record record =
        make_record(*scene, run_strategy(scene->specimen, *scene->experiment, scene->stiffness, options));
    CHECK(record.run.cause == "");
    CHECK(record.run.outcome == Outcome::converged);
    CHECK_FALSE(record.verdicts.empty());
    for (const Verdict& verdict : record.verdicts) {
      INFO(verdict.expectation.measure << ": " << verdict.measured);
      CHECK((verdict.passed || !verdict.judged));
    }
  }
}
