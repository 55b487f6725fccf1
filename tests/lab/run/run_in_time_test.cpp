// Runs through time as scenes write them: against the motion that is known, across a restart, and where they fail.

#include "lab/run/load_path.h"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>

#include "elastin/core/base/error.h"
#include "elastin/core/parallel/threads.h"
#include "lab/report/files.h"
#include "lab/report/records.h"
#include "lab/run/step_control.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;
using Catch::Matchers::Contains;
using Catch::Matchers::EndsWith;

namespace {

const Catalog kCatalog = built_in_catalog();

/// A molecule on a spring of 100 N/m, 1 kg, that hangs on another: 10 rad/s.
const std::string kOscillator =
    "body: {molecules: [[0 m, 0 m, 0 m], [10 cm, 0 m, 0 m]], connections: [[0, 1]]}\n"
    "material: {youngs_modulus: 10 kPa, density: 1000 kg/m3}\n"
    "stiffness: {strategy: uniform, constant: 100 N/m}\n";
const std::string kRelease =
    kOscillator +
    "experiment: {kind: release, fixture: {kind: tension, axis: x, force: 0.1 N, cross_section: 1 cm2}}\n";

Run run_of(const std::string& text, RunOptions options = {}, const std::vector<std::string>& overrides = {}) {
  const TemporaryFolder folder;
  const auto scene = load_scene(folder.write("scene.yaml", "title: A scene\n" + text), kCatalog, overrides);
  options.time = scene->time;
  options.problem = scene->problem;
  options.statics = scene->statics;
  prepare(scene->specimen, scene->stiffness.strategy);
  return run_strategy(scene->specimen, *scene->experiment, scene->stiffness, options);
}

double measured(const Run& run, const std::string& name) {
  INFO(name << ": " << run.cause);
  REQUIRE(run.outcome == Outcome::converged);
  REQUIRE(std::isfinite(run.measures.get(name)));
  return run.measures.get(name);
}

/// All numbers of a run's rows.
std::vector<double> numbers_of(const Run& run) {
  std::vector<double> all;
  for (const CurvePoint& row : run.curve) {
    all.insert(all.end(), {row.time, row.step, static_cast<double>(row.steps)});
    for (const auto& [_, value] : row.measures.all()) all.push_back(value);
  }
  for (const auto& [_, value] : run.measures.all()) all.push_back(value);
  return all;
}

}  // namespace

TEST_CASE("a released oscillator has its frequency and its decrement", "[time][slow]") {
  // b = 2 N s/m: delta = b / 2m = 1 /s, omega = sqrt(100 - 1).
  for (const char* method : {"velocity_verlet", "newmark"}) {
    INFO(method);
    const std::string time = std::string("time: {duration: 3 s, frames: 600, step: 1 ms, stepper: ") + method + "}\n";
    const Run run = run_of(kRelease + "loads: [{damping: 2 N s/m}]\n" + time);
    CHECK(measured(run, "frequency") == Approx(std::sqrt(99.) / (2 * M_PI)).epsilon(1e-4));
    CHECK(measured(run, "logarithmic_decrement") == Approx(2 * M_PI / std::sqrt(99.)).epsilon(1e-3));
    CHECK(measured(run, "damping_ratio") == Approx(0.1).epsilon(1e-3));
    CHECK(measured(run, "energy_drift") < 1e-4);
    CHECK(run.curve.front().measures.get("elongation") == Approx(1e-3).epsilon(1e-8));
    const Run free = run_of(kRelease + time);
    CHECK(measured(free, "frequency") == Approx(10 / (2 * M_PI)).epsilon(1e-4));
    CHECK(measured(free, "logarithmic_decrement") == Approx(0).margin(1e-4));
    CHECK(measured(free, "energy_drift") < 1e-4);
  }
}

TEST_CASE("measures in time come from the steps, however few frames are kept", "[time]") {
  for (const char* method : {"velocity_verlet", "newmark"}) {
    INFO(method);
    const Run run =
        run_of(kRelease +
               "loads: [{damping: 2 N s/m}]\ntime: {duration: 3 s, frames: 2, step: 1 ms, stepper: " + method + "}\n");
    CHECK(run.curve.size() == 3);
    CHECK(measured(run, "frequency") == Approx(std::sqrt(99.) / (2 * M_PI)).epsilon(1e-3));
    CHECK(measured(run, "damping_ratio") == Approx(0.1).epsilon(1e-2));
  }
}

TEST_CASE("a load that jumps, and a body at rest, make no energy from nothing", "[time]") {
  for (const char* method : {"velocity_verlet", "newmark", "backward_euler"})
    for (const char* at : {"0.5 s", "100 s"}) {  // within the second, and never
      INFO(method << " " << at);
      const Run run = run_of(kOscillator + "experiment: {kind: motion, in_time: {step: {at: " + at +
                             "}}, fixture: {kind: tension, axis: x, force: 0.1 N, cross_section: 1 cm2}}\n"
                             "time: {duration: 1 s, frames: 10, step: 10 ms, stepper: " +
                             method + "}\n");
      CHECK(run.cause == "");
      CHECK(run.outcome == Outcome::converged);
    }
}

TEST_CASE("a pulse between two frames is not missed, nor a load that swings at the frames' pace", "[time]") {
  const std::string cube =
      "body: {tetrahedra: {kind: kuhn, cubes: [1, 1, 1], size: [1 cm, 1 cm, 1 cm]}}\n"
      "material: {youngs_modulus: 50 kPa, density: 1000 kg/m3}\nstiffness: neo_hookean\n"
      "experiment: {kind: motion}\nloads: [{gravity: [20 m/s2, 0 m/s2, 0 m/s2], in_time: ";
  const std::string pulse = "{table: [[0.501 s, 0], [0.5011 s, 1], [0.508 s, 1], [0.5081 s, 0]]}}]\n";
  for (const char* stepper : {"newmark", "backward_euler", "velocity_verlet"}) {
    INFO(stepper);
    const Run run = run_of(cube + pulse + "time: {duration: 0.6 s, frames: 6, stepper: " + stepper + "}\n");
    CHECK(measured(run, "speed") == Approx(20 * 7e-3).epsilon(stepper[0] == 'b' ? 0.01 : 1e-6));
    CHECK(run.warnings.empty());
  }
  // x = g / w (t - sin(w t) / w)
  const Run swings = run_of(cube + "{sine: {frequency: 50 Hz}}}]\ntime: {duration: 0.2 s, frames: 10}\n");
  CHECK(measured(swings, "centre_displacement") == Approx(20 / (2 * M_PI * 50) * 0.2).epsilon(3e-3));
  for (const std::string in_time : {"{sine: {frequency: 50 Hz}}}]\n", pulse.c_str()}) {
    const auto at = [&](const char* step) {
      return run_of(cube + in_time + "time: {duration: 0.2 s, frames: 10, step: " + step + "}\n").warnings;
    };
    REQUIRE(at("2.6 ms").size() == 1);
    CHECK_THAT(at("2.6 ms")[0], Contains("too long for a function of time that goes to and fro within"));
    CHECK(at("1 ms").empty());
  }
}

TEST_CASE("a body at rest makes no energy in many short steps", "[time][energy]") {
  const Run run = run_of(
      "body: {tetrahedra: {kind: kuhn, cubes: [1, 1, 1], size: [1 cm, 1 cm, 1 cm]}}\n"
      "material: {youngs_modulus: 50 kPa, poissons_ratio: 0.3, density: 1000 kg/m3, relaxation: {terms: [[1, 0.5 "
      "s]]}}\n"
      "stiffness: prony:neo_hookean\nexperiment: {kind: motion, in_time: {step: {at: 9 s}}, fixture: {kind: tension, "
      "axis: z, strain: 0.0001}}\ntime: {duration: 0.7 s, stepper: newmark, step: 0.2 ms, frames: 7}\n");
  CHECK(run.cause == "");
  CHECK(run.warnings.empty());
}

TEST_CASE("a body whose motion is small has the frequency of one whose motion is large", "[time]") {
  for (const char* force : {"1 uN", "0.1 N"}) {
    INFO(force);
    const Run run = run_of(kOscillator + "experiment: {kind: release, fixture: {kind: tension, axis: x, force: " +
                           std::string(force) + ", cross_section: 1 cm2}}\ntime: {duration: 3 s, stepper: newmark}\n");
    CHECK(measured(run, "frequency") == Approx(10 / (2 * M_PI)).epsilon(0.01));
    CHECK(run.time->steps < 400);
  }
}

// k = 100 N/m, m = 1 kg: u = F / k / (1 - b^2) (sin(b w t) - b sin(w t)) under a force F sin(b w t).
TEST_CASE("a force of a fixture in time meets the body when it acts, as a load of the scene does", "[time]") {
  const double b = 0.63, duration = 1.5;
  const double exact = 1e-3 / (1 - b * b) * (std::sin(b * 10 * duration) - b * std::sin(10 * duration));
  const std::string sine = "{sine: {frequency: " + std::to_string(b * 10 / (2 * M_PI)) + " Hz}}";
  const auto at_end = [&](const std::string& rest, const std::string& stepper, const char* step) {
    const Run run = run_of(kOscillator + rest + "time: {duration: 1.5 s, frames: 15, step: " + step +
                           ", stepper: " + stepper + "}\n");
    CHECK(run.outcome == Outcome::converged);
    CHECK(measured(run, "energy_drift") < 0.02);
    return 2 * run.measures.get("centre_displacement") / std::abs(exact) - 1;  // one of two molecules moves
  };
  const std::string fixture = "experiment: {kind: motion, in_time: " + sine +
                              ", fixture: {kind: tension, axis: x, force: 0.1 N, cross_section: 1 cm2}}\n",
                    rest =
                        "experiment: {kind: motion, fixture: {kind: loads}}\nsupports: [{molecules: [0]}, {molecules: "
                        "[1], fix: [y, z]}]\nrest: {growth: 1.01, along: x, factor: " +
                        sine + "}\n";
  for (const std::string stepper : {"newmark", "generalized_alpha", "energy_momentum", "velocity_verlet"})
    for (const std::string& moved : {fixture, rest}) {
      INFO(stepper << ": " << moved);
      const double coarse = at_end(moved, stepper, "10 ms"), fine = at_end(moved, stepper, "5 ms");
      CHECK(std::abs(coarse) < 0.02);
      CHECK(coarse / fine == Approx(4).epsilon(0.2));
    }
}

TEST_CASE("a pressure of a fixture that grows does work", "[time][energy]") {
  const std::string rest =
      ", thickness: 1 mm, density: 0.01 kg/m3}\nstiffness: neo_hookean_membrane\n"
      "time: {duration: 0.5 s, stepper: newmark, step: 5 ms, frames: 20}\n";
  const std::string material = "material: {youngs_modulus: 1 MPa, poissons_ratio: 0.5";
  for (const std::string filling : {"pressure: 1 Pa", "gas: {start_pressure: 2010 Pa, ambient: 2000 Pa}"}) {
    INFO(filling);
    const Run run = run_of("body: {sphere_octant: {radius: 10 cm, mesh: type_1, divisions: 3}}\n" + material + rest +
                           "experiment: {kind: motion, in_time: {ramp: {duration: 0.5 s}}, fixture: {kind: inflation, "
                           "symmetry: [x, y, z], " +
                           filling + "}}\n");
    CHECK(run.warnings.empty());
    CHECK(measured(run, "energy_drift") < 1e-3);
    CHECK(measured(run, "work") == Approx(run.measures.get("energy")).epsilon(0.01));  // slowly: all is stored
  }
  const Run bubble = run_of("body: {disc: {radius: 5 cm, rings: 4}}\n" + material + rest +
                            "experiment: {kind: motion, in_time: {ramp: {duration: 0.5 s}}, fixture: {kind: bubble, "
                            "pressure: 10 Pa}}\n");
  CHECK(measured(bubble, "energy_drift") < 0.05);
  CHECK(measured(bubble, "work") > 0);
}

TEST_CASE("a body that grows freely needs no work, however long the steps are", "[time][rest][energy]") {
  const std::string text =
      "body: {tetrahedra: {kind: kuhn, cubes: [1, 1, 2], size: [3 mm, 3 mm, 7 mm]}}\n"
      "material: {youngs_modulus: 5 kPa, poissons_ratio: 0.37, density: 1000 kg/m3}\nstiffness: neo_hookean\n"
      "rest: {growth: 1.2, along: z, factor: {ramp: {duration: 1 s}}}\n"
      "experiment: {kind: motion, fixture: {kind: loads, read: [{name: top, molecules: {side: z}}]}}\n"
      "supports: [{molecules: {side: -z}, fix: [z]}, {molecules: {side: -x}, fix: [x]}, {molecules: {side: -y}, fix: "
      "[y]}]\n";
  for (const char* time : {"step: 20 ms, stepper: backward_euler", "step: 10 ms, stepper: backward_euler",
                           "stepper: backward_euler", "frames: 50"}) {
    INFO(time);
    const Run run = run_of(text + "time: {duration: 1.5 s, " + time + "}\n");
    CHECK(run.cause == "");
    for (const std::string& warning : run.warnings)  // the steps may damp what moves
      CHECK_THAT(warning, !Contains("from nothing"));
    CHECK(std::abs(measured(run, "work")) < 1e-10);  // by the trapezoidal rule alone -1.5e-9 J of long steps
  }
}

TEST_CASE("a rigid body counts neither in energies nor in speeds", "[time]") {
  const Run run = run_of(
      "bodies: [{name: bone, rigid: true, tetrahedra: {kind: kuhn, cubes: [1, 1, 1], size: [2 cm, 2 cm, 2 cm]}},\n"
      "  {name: skin, at: [0 cm, 0 cm, 6 cm], tetrahedra: {kind: kuhn, cubes: [1, 1, 1], size: [2 cm, 2 cm, 2 cm]}}]\n"
      "material: {youngs_modulus: 50 kPa, density: 1000 kg/m3}\nstiffness: neo_hookean\n"
      "initial: {velocity: [0 m/s, 0 m/s, 0.5 m/s]}\nexperiment: {kind: motion}\n"
      "time: {duration: 50 ms, stepper: newmark, step: 1 ms, frames: 5}\n");
  CHECK(run.warnings.empty());
  CHECK(measured(run, "speed") == Approx(0.5));
  CHECK(measured(run, "centre_displacement") == Approx(0.025));
  CHECK(measured(run, "kinetic_energy") == Approx(8e-3 * 0.25 / 2));
  CHECK(measured(run, "energy_drift") < 1e-9);
}

// J(t) = (1 - g / (1 + g) e^(-t / (tau (1 + g)))) / E, and after a load for 1 s a strain of sigma (J(t) - J(t - 1 s)).
TEST_CASE("a body that relaxes recovers when nothing loads it any more, in few iterations", "[time][prony]") {
  for (const std::string body : {"tetrahedra: {kind: body_centred, cubes: [1, 1, 3], size: [10 mm, 10 mm, 30 mm]}",
                                 "lattice: {kind: cubic, molecules: [2, 2, 4], spacing: 10 mm, order: 1}"}) {
    INFO(body);
    const Run run =
        run_of("body: {" + body +
               "}\nmaterial: {youngs_modulus: 20 kPa, poissons_ratio: 0.3, density: 0.001 kg/m3, "
               "relaxation: {terms: [[1.5, 0.3 s]]}}\nstiffness: prony:neo_hookean\n"
               "experiment: {kind: motion, in_time: {table: [[0 s, 0], [0.01 s, 1], [1 s, 1], [1.01 s, 0], [3 s, 0]]}, "
               "fixture: {kind: tension, axis: z, force: 1 mN}}\n"
               "time: {duration: 1.5 s, stepper: backward_euler, step: {per_frame: 2}, frames: 150}\n");
    const double strain = 10 / 20e3 * 1.5 / 2.5 * (std::exp(-0.5 / 0.75) - std::exp(-1.5 / 0.75));
    CHECK(measured(run, "elongation") == Approx(0.03 * strain).epsilon(0.02));
    CHECK(run.newton_iterations < 5 * 300);
  }
}

TEST_CASE("supports may jump: the body comes to the equilibrium about where they are", "[time]") {
  for (const std::string stepper : {"newmark", "backward_euler", "generalized_alpha", "energy_momentum"})
    for (const std::string in_time :
         {"", ", in_time: {step: {at: 20 ms}}", ", in_time: {table: [[0 s, 0.5], [9 ms, 1]]}"}) {
      INFO(stepper << in_time);
      const Run run = run_of(
          "body: {tetrahedra: {kind: kuhn, cubes: [2, 1, 2], size: [2 cm, 1 cm, 2 cm]}}\n"
          "material: {youngs_modulus: 10 kPa, poissons_ratio: 0.3, density: 1000 kg/m3}\nstiffness: "
          "st_venant_kirchhoff\n"
          "loads: [{rayleigh: {mass: 100 1/s}}]\n"
          "experiment: {kind: motion, fixture: {kind: tension, axis: z, strain: 0.01 %}" +
          in_time + "}\ntime: {duration: 0.3 s, frames: 3, step: 1 ms, stepper: " + stepper + "}\n");
      CHECK(run.cause == "");
      CHECK(measured(run, "effective_modulus") == Approx(1e4).epsilon(1e-3));
    }
}

TEST_CASE("what is left of a force that relaxes is not of the wave behind the ramp", "[time][slow]") {
  const double ramp = 0.04, tau = 0.1, share = 0.5;
  const Run run = run_of(
      "body: {tetrahedra: {kind: kuhn, cubes: [8, 2, 2], size: [4 cm, 1 cm, 1 cm]}}\n"
      "material: {youngs_modulus: 100 kPa, poissons_ratio: 0.3, density: 1000 kg/m3, relaxation: {terms: [[0.5, 0.1 "
      "s]]}}\n"
      "stiffness: prony:neo_hookean\n"
      "experiment: {kind: relaxation, ramp: 40 ms, fixture: {kind: tension, axis: x, strain: 0.1 %}}\n"
      "time: {duration: 1 s, frames: 100, step: 1 ms}\n");
  const double peak = 1 + share * tau / ramp * (1 - std::exp(-ramp / tau));  // over the force that is left
  CHECK(measured(run, "relaxed_ratio") == Approx(1 / peak).epsilon(0.01));
  CHECK(measured(run, "relaxation_time") == Approx(tau).epsilon(0.01));
}

TEST_CASE("damping is that of the swings that last, not of those that die first", "[time][slow]") {
  // A bar in tension: its first mode has ω = π/2 √(E/ρ)/L, and of damping by the stiffness ζ = β ω/2.
  const double w = M_PI / 2 * std::sqrt(20e3 / 1000) / 0.012;
  const Run run = run_of(
      "body: {tetrahedra: {kind: body_centred, cubes: [1, 1, 12], size: [2 mm, 2 mm, 12 mm]}}\n"
      "material: {youngs_modulus: 20 kPa, poissons_ratio: 0, density: 1000 kg/m3}\nstiffness: neo_hookean\n"
      "loads: [{rayleigh: {stiffness: 0.4 ms}}]\n"
      "experiment: {kind: release, fixture: {kind: tension, axis: z, strain: 0.1 %}}\n"
      "time: {duration: 80 ms, frames: 160, step: 0.05 ms}\n");
  CHECK(measured(run, "damping_ratio") == Approx(0.4e-3 * w / 2).epsilon(0.01));
}

TEST_CASE("what is left of a force of two relaxation times is that of the ramp's end", "[time]") {
  const Run run = run_of(
      "body: {lattice: {kind: cubic, molecules: [2, 2, 3], spacing: 5 mm, order: 2}}\n"
      "material: {youngs_modulus: 20 kPa, poissons_ratio: 0.3, density: 1000 kg/m3, relaxation: {terms: [[0.5, 0.1 s], "
      "[0.3, 1 s]]}}\nstiffness: prony:neo_hookean\n"
      "experiment: {kind: relaxation, ramp: 40 ms, fixture: {kind: tension, axis: z, strain: 0.1 %}}\n"
      "time: {duration: 6 s, frames: 60, first_frame: 40 ms, step: {per_frame: 4}}\n");
  double peak = 1;  // over the force that is left
  for (const auto& [share, tau] : {std::pair{0.5, 0.1}, {0.3, 1.}})
    peak += share * tau / 0.04 * (1 - std::exp(-0.04 / tau));
  CHECK(measured(run, "relaxed_ratio") == Approx(1 / peak).epsilon(0.005));
}

TEST_CASE("a load put on at once swings to twice its displacement at rest", "[time]") {
  const Run run = run_of(kOscillator +
                         "experiment: {kind: release, load: applied, fixture: {kind: tension, axis: x, force: 0.1 N, "
                         "cross_section: 1 cm2}}\n"
                         "time: {duration: 1 s, frames: 200}\n");
  CHECK(measured(run, "first_peak") == Approx(2e-3).epsilon(1e-3));
  CHECK(measured(run, "first_peak_time") == Approx(M_PI / 10).epsilon(1e-3));
  CHECK(measured(run, "return_time") == Approx(2 * M_PI / 10).epsilon(1e-3));
  CHECK(run.time->stepper == std::string("velocity_verlet"));
  CHECK_THAT(run.time->reason, Contains("springs"));
}

TEST_CASE("steps: stable ones by themselves, fixed ones in even parts of a frame, others by their error", "[time]") {
  const Run automatic = run_of(kRelease + "time: {duration: 20 s, frames: 4}\n");
  CHECK(automatic.time->critical_step == Approx(0.2).epsilon(1e-5));
  CHECK(automatic.curve[1].step <= 0.8 * 0.2);
  CHECK(automatic.curve[1].step > 0.8 * 0.2 * 0.95);
  const Run fixed = run_of(kRelease + "time: {duration: 1 s, frames: 3, step: 30 ms, stepper: newmark}\n");
  CHECK(fixed.time->steps == 3 * 12);
  CHECK(fixed.curve[2].step == Approx(1. / 36));
  for (int frame = 0; frame <= 3; ++frame) CHECK(fixed.curve[frame].time == 1. * frame / 3);
  // Ten times less error a step: 10^(1/3) times as many of them.
  const std::string by_error = "time: {duration: 1 s, frames: 2, stepper: newmark, step: {error: ";
  const Run coarse = run_of(kRelease + by_error + "1e-6}}\n"), fine = run_of(kRelease + by_error + "1e-9}}\n");
  const double factor = static_cast<double>(fine.time->steps) / coarse.time->steps;
  CHECK(factor > 7);
  CHECK(factor < 13);
}

TEST_CASE("creep, relaxation and a shaken base follow their formulas", "[time]") {
  const std::string chain =
      "body: {molecules: [[0 m, 0 m, 0 m], [1 cm, 0 m, 0 m], [2 cm, 0 m, 0 m]], connections: [[0, 1], [1, 2]]}\n"
      "material: {youngs_modulus: 10 kPa, density: 1 kg/m3}\nstiffness: {strategy: uniform, constant: 20 N/m}\n";
  const Run creep =
      run_of(chain +
             "experiment: {kind: creep, fixture: {kind: tension, axis: x, force: 0.1 mN, cross_section: 1 cm2}}\n"
             "loads: [{rayleigh: {stiffness: 0.2 s}}]\ntime: {duration: 1 s, stepper: newmark, step: 0.2 ms}\n");
  CHECK(measured(creep, "retardation_time") == Approx(0.2).epsilon(1e-3));
  CHECK(measured(creep, "elongation") == Approx(1e-5 * (1 - std::exp(-5.))).epsilon(1e-3));
  // The middle molecule, drawn by two springs through a liquid: c / 2k.
  const Run relaxation =
      run_of(chain +
             "experiment: {kind: relaxation, ramp: 10 ms, fixture: {kind: tension, axis: x, displacement: 0.1 mm, "
             "cross_section: 1 cm2}}\n"
             "loads: [{stokes_drag: {viscosity: 50 Pa s}}]\n"
             "time: {duration: 1 s, stepper: newmark, step: 1 ms, frames: 200}\n");
  CHECK(measured(relaxation, "relaxation_time") == Approx(6 * M_PI * 50 * 0.005 / 40).epsilon(2e-3));
  CHECK(measured(relaxation, "force") == Approx(1e-3).epsilon(1e-3));
  const Run shake = run_of(kOscillator +
                           "experiment: {kind: shake, axis: x, amplitude: 0.1 mm, frequency: 2 Hz}\n"
                           "loads: [{damping: 4 N s/m}]\ntime: {duration: 8 s, frames: 800, step: 2 ms}\n");
  const double w = 4 * M_PI, k = 100, b = 4;
  CHECK(measured(shake, "amplitude_ratio") ==
        Approx(std::sqrt((k * k + b * b * w * w) / (std::pow(k - w * w, 2) + b * b * w * w))).epsilon(1e-3));
  CHECK(measured(shake, "phase") == Approx(std::atan2(b * w, k - w * w) - std::atan(b * w / k)).epsilon(1e-3));
  CHECK(shake.remark.empty());
}

// A standard linear solid whose force falls from 2 to 1 with the time constant tau; its displacement creeps with 2 tau.
TEST_CASE("a relaxation or creep that ends too early says how much is to come, and when", "[time]") {
  const auto run = [](const std::string& experiment, double duration, const std::string& more = "") {
    return run_of(
        "body: {tetrahedra: {kind: body_centred, cubes: [1, 1, 2], size: [10 mm, 10 mm, 20 mm]}}\n"
        "material: {youngs_modulus: 10 kPa, poissons_ratio: 0.3, density: 1 kg/m3, "
        "relaxation: {model: standard_linear_solid, share: 1, time: 0.1 s}}\n"
        "stiffness: \"prony:neo_hookean\"\nexperiment: {" +
        experiment + "}\n" + more + "time: {duration: " + std::to_string(duration) + " s, step: 1 ms, frames: 100}\n");
  };
  const std::string relaxes = "kind: relaxation, ramp: 2 ms, fixture: {kind: tension, axis: z, strain: 0.1 %}",
                    creeps = "kind: creep, fixture: {kind: tension, axis: z, force: 1 uN}";
  const Run early = run(relaxes, 0.1);
  CHECK(measured(early, "remaining_change") == Approx(std::exp(-0.098 / 0.1) / 2).epsilon(0.02));
  CHECK(measured(early, "settling_time") == Approx(0.002 + 0.1 * std::log(1 / (2 * 0.02))).epsilon(0.02));
  CHECK_THAT(early.remark, Contains("the force still changes when the run ends, by 19 % to come; a duration of 0.32"));
  CHECK(run(relaxes, 0.35).remark.empty());
  const Run slow = run(creeps, 0.2);
  CHECK(measured(slow, "remaining_change") == Approx(std::exp(-0.2 / 0.2) / 2).epsilon(0.02));
  CHECK(measured(slow, "settling_time") == Approx(0.2 * std::log(1 / (2 * 0.02))).epsilon(0.02));
  CHECK_THAT(slow.remark, Contains("the displacement still changes when the run ends, by 18 % to come"));
  CHECK(run(creeps, 0.7).remark.empty());
}

TEST_CASE("what is to come of a relaxation with two times is that of the slow one", "[time]") {
  // Within 2 s a fit sees the fast term alone; 0.5 e^(−t/3 s) of the stress at once is still there.
  const auto run = [](const std::string& experiment, double duration) {
    return run_of(
        "body: {lattice: {kind: cubic, molecules: [2, 2, 3], spacing: 5 mm, order: 1}}\n"
        "material: {youngs_modulus: 80 kPa, poissons_ratio: 0, density: 1 kg/m3, "
        "relaxation: {terms: [[0.2, 0.2 s], [0.5, 3 s]], moduli: instantaneous}}\n"
        "stiffness: \"prony:neo_hookean\"\nexperiment: {" +
        experiment + "}\ntime: {duration: " + std::to_string(duration) + " s, frames: 40, step: {per_frame: 2}}\n");
  };
  const std::string relaxes = "kind: relaxation, ramp: 0.1 s, fixture: {kind: tension, axis: z, strain: 1e-5}",
                    creeps = "kind: creep, fixture: {kind: tension, axis: z, force: 1 uN}";
  const auto grown = [](double share, double time) { return share * (1 - std::exp(-0.1 / time)) * time / 0.1; };
  const double force = 0.3 + grown(0.2, 0.2) + grown(0.5, 3), slow = grown(0.5, 3) / force;
  for (const double duration : {2., 2.1}) {
    const Run early = run(relaxes, duration);
    CHECK(measured(early, "remaining_change") == Approx(slow * std::exp(-(duration - 0.1) / 3)).epsilon(0.01));
    CHECK(measured(early, "settling_time") == Approx(0.1 + 3 * std::log(slow / 0.02)).epsilon(0.01));
    CHECK_THAT(early.remark, Contains("the force still changes when the run ends"));
  }
  const Run late = run(relaxes, 11);
  CHECK(measured(late, "remaining_change") < 0.025);
  CHECK(late.remark.empty());
  // Retardation times are λ where 0.3 + 0.2 s/(s + 5/s) + 0.5 s/(s + 1/3 s) is 0 at s = −1/λ.
  const double b = 0.3 * (5 + 1. / 3) + 0.2 / 3 + 0.5 * 5, c = 0.3 * 5 / 3, s = (-b + std::sqrt(b * b - 4 * c)) / 2;
  const Run creep = run(creeps, 2);
  const double share = -0.3 / (s * (1 / std::pow(s + 5, 2) + 0.5 / 3 / std::pow(s + 1. / 3, 2)));
  CHECK(measured(creep, "remaining_change") == Approx(share * std::exp(2 * s)).epsilon(0.02));
  CHECK(measured(creep, "settling_time") == Approx(std::log(share / 0.02) / -s).epsilon(0.02));
}

TEST_CASE("drag that is read as the material's is said", "[time]") {
  const auto warned = [](const std::string& experiment, const std::string& load) {
    const Run run = run_of(
        "body: {tetrahedra: {kind: kuhn, cubes: [1, 1, 4], size: [5 mm, 5 mm, 20 mm]}}\n"
        "material: {youngs_modulus: 5 kPa, poissons_ratio: 0.3, density: 1 kg/m3}\n"
        "stiffness: neo_hookean\nloads: [" +
        load + "]\nexperiment: {" + experiment + "}\n");
    CHECK(run.outcome == Outcome::converged);
    return std::count_if(run.warnings.begin(), run.warnings.end(), [](const std::string& one) {
      return one.find("of the body in its medium") != std::string::npos;
    });
  };
  const std::string drag = "{stokes_drag: {viscosity: 1 Pa s}}",
                    fixture = "fixture: {kind: tension, axis: z, strain: 1 %}",
                    cyclic = "kind: cyclic, frequency: 1 /s, " + fixture,
                    relaxation = "kind: relaxation, ramp: 0.2 s, " + fixture,
                    // Ends where the driven end stands still.
      two_and_a_quarter = "}\ntime: {duration: 2.25 s, stepper: backward_euler, step: 5 ms, frames: 225",
                    half = "}\ntime: {duration: 0.5 s, frames: 50";
  CHECK(warned(cyclic + two_and_a_quarter, drag) == 1);
  CHECK(warned(cyclic + two_and_a_quarter, "{rayleigh: {stiffness: 50 ms}}") == 0);
  CHECK(warned(relaxation + half, drag) == 1);
  CHECK(warned("kind: release, " + fixture + "}\ntime: {duration: 0.1 s", drag) == 0);
}

TEST_CASE("a time history that is no such curve gives no such measure, and the run says why", "[time][slow]") {
  const auto check_absent = [](const std::string& text, std::initializer_list<const char*> names, const char* why) {
    INFO(text);
    const Run run = run_of(text);
    REQUIRE(run.outcome == Outcome::converged);
    for (const char* name : names) {
      INFO(name);
      CHECK_FALSE(std::isfinite(run.measures.get(name)));
    }
    CHECK_THAT(run.remark, Contains(why));
  };
  const std::string held = "fixture: {kind: tension, axis: x, force: 0.1 N, cross_section: 1 cm2}}\n",
                    moved = "fixture: {kind: tension, axis: x, displacement: 1 mm, cross_section: 1 cm2}}\n",
                    bar =
                        "body: {tetrahedra: {kind: body_centred, cubes: [1, 1, 3], size: [10 mm, 10 mm, 30 mm]}}\n"
                        "material: {youngs_modulus: 10 kPa, poissons_ratio: 0.3, density: 1000 kg/m3}\n"
                        "stiffness: neo_hookean\n",
                    pulled = "fixture: {kind: tension, axis: z, force: 1 mN}}\n",
                    drawn = "fixture: {kind: tension, axis: z, displacement: 0.1 mm}}\n";
  // An elastic body swings for ever, or jumps at once where the stepper lets nothing swing: neither is creep.
  check_absent(kOscillator + "experiment: {kind: creep, " + held + "time: {duration: 3 s, step: 5 ms}\n",
               {"retardation_time"}, "no retardation time");
  check_absent(bar + "experiment: {kind: creep, " + pulled +
                   "time: {duration: 10 s, step: 0.5 s, frames: 20, stepper: backward_euler}\n",
               {"retardation_time"}, "no retardation time");
  check_absent(bar + "experiment: {kind: relaxation, ramp: 0.01 s, " + drawn +
                   "time: {duration: 0.3 s, step: 1 ms, frames: 50, stepper: newmark}\n",
               {"relaxation_time", "relaxed_ratio"}, "no relaxation time");
  // In its first period a body still vibrates: its resistance is not that of a cycle.
  check_absent(bar + "experiment: {kind: cyclic, frequency: 20 /s, " + drawn +
                   "time: {duration: 50 ms, step: 0.5 ms, frames: 100, stepper: newmark}\n",
               {"storage_modulus", "loss_modulus", "loss_tangent"}, "no moduli");
  check_absent(bar + "experiment: {kind: cyclic, frequency: 20 /s, " + drawn +
                   "time: {duration: 110 ms, step: 0.5 ms, frames: 220, stepper: newmark}\n",
               {"storage_modulus", "loss_modulus", "loss_tangent"}, "no moduli: the cycle is not steady yet");
  check_absent(kRelease + "loads: [{damping: 30 N s/m}]\ntime: {duration: 3 s, step: 5 ms}\n",
               {"frequency", "damping_ratio", "logarithmic_decrement"},
               "no frequency: the body is overdamped or nearly so");
  // Two exponentials, of which the slower one stays: 15 - sqrt(15² - 10²) /s, and none of 0.3 periods.
  CHECK(measured(run_of(kRelease + "loads: [{damping: 30 N s/m}]\ntime: {duration: 3 s, step: 5 ms}\n"),
                 "retardation_time") == Approx(1 / (15 - std::sqrt(125.))).epsilon(0.15));
  check_absent(kRelease + "time: {duration: 0.3 s, step: 5 ms}\n", {"frequency", "retardation_time"},
               "no frequency and no damping: the time history shows no damped cosine");
  // The elastic jump of a standard linear solid is no part of its creep: τ = τ_r (1 + share).
  const Run creep = run_of(
      "body: {tetrahedra: {kind: body_centred, cubes: [1, 1, 3], size: [10 mm, 10 mm, 30 mm]}}\n"
      "material: {youngs_modulus: 10 kPa, poissons_ratio: 0.3, density: 1 kg/m3, "
      "relaxation: {model: standard_linear_solid, share: 1, time: 0.1 s}}\nstiffness: \"prony:neo_hookean\"\n"
      "experiment: {kind: creep, " +
      pulled + "time: {duration: 1 s, step: 5 ms, frames: 100, stepper: backward_euler}\n");
  CHECK(measured(creep, "retardation_time") == Approx(0.2).epsilon(0.02));
  CHECK(measured(creep, "fit_misfit") < 0.01);
  CHECK(creep.remark.empty());
  // With steps by error the jump of a body with mass takes many rows, and in 2 s it still swings behind the first ones.
  for (const auto& [time, duration] : {std::pair{1., 10.}, {0.35, 2.}}) {
    const Run heavy = run_of(
        "body: {tetrahedra: {kind: body_centred, cubes: [1, 1, 3], size: [10 mm, 10 mm, 30 mm]}}\n"
        "material: {youngs_modulus: 10 kPa, poissons_ratio: 0.3, density: 1000 kg/m3, "
        "relaxation: {model: standard_linear_solid, share: 1, time: " +
        std::to_string(time) + " s}}\nstiffness: \"prony:neo_hookean\"\nexperiment: {kind: creep, " + pulled +
        "time: {duration: " + std::to_string(duration) + " s}\n");
    INFO(heavy.remark);
    CHECK(measured(heavy, "retardation_time") == Approx(2 * time).epsilon(0.005));
    const double left = std::exp(-duration / (2 * time)) / 2;
    CHECK(measured(heavy, "remaining_change") == Approx(left).margin(3e-3));
    CHECK(heavy.remark.empty() == (left < 0.02));
  }
}

// An elastic bar under a force that is put on at once swings at first, however the steps are chosen: no part of its
// creep, which goes on with τ = 0.1 s · 1.5.
TEST_CASE("the retardation time of a body with mass is its material's", "[time][slow]") {
  for (const std::string force : {"1 mN", "10 mN", "100 mN"})
    for (const std::string step : {"", ", step: {error: 1e-6}", ", frames: 10"}) {
      const Run creep = run_of(
          "body: {tetrahedra: {kind: kuhn, cubes: [4, 1, 1], size: [4 cm, 1 cm, 1 cm]}}\n"
          "material: {youngs_modulus: 100 kPa, poissons_ratio: 0.3, density: 1000 kg/m3, "
          "relaxation: {terms: [[0.5, 0.1 s]]}}\nstiffness: \"prony:neo_hookean\"\n"
          "experiment: {kind: creep, fixture: {kind: tension, axis: x, force: " +
          force + "}}\ntime: {duration: 1 s" + (step.find("frames") == std::string::npos ? ", frames: 50" : "") + step +
          "}\n");
      INFO(force << step << ": " << creep.remark);
      CHECK(measured(creep, "retardation_time") == Approx(0.15).epsilon(0.005));
    }
}

TEST_CASE("experiments at rest see what has relaxed alone, in energy and tangents too", "[time]") {
  for (const char* body : {"{tetrahedra: {kind: kuhn, cubes: [2, 2, 2], size: [1, 1, 1]}}",
                           "{lattice: {kind: cubic, molecules: [3, 3, 3], order: 2, spacing: 0.5}}"})
    for (const char* experiment : {"{kind: material}", "{kind: tension, strain: 0.1, load_steps: 2}"}) {
      const auto of = [&](const std::string& stiffness) {
        return run_of("body: " + std::string(body) +
                      "\nmaterial: {youngs_modulus: 1000, poissons_ratio: 0.3, relaxation: {terms: [[0.4, 1]]}}\n"
                      "stiffness: \"" +
                      stiffness + "\"\nexperiment: " + experiment + "\n");
      };
      const Run relaxed = of("prony:neo_hookean"), elastic = of("neo_hookean");
      for (const char* name : {"effective_modulus", "shear_modulus", "tangent_modulus", "energy", "force"})
        if (const double expected = elastic.measures.get(name); std::isfinite(expected)) {
          INFO(body << experiment << name);
          CHECK(relaxed.measures.get(name) == Approx(expected).epsilon(1e-7));
        }
    }
}

TEST_CASE("what relaxes vibrates with the storage modulus at its own frequency", "[time][vibration][slow]") {
  // All of the stress relaxes, so that f² is in proportion to the storage modulus: with the plain law's frequency f₀
  // and x = 2π f τ it is (f / f₀)² = 1 + Σ gᵢ xᵢ² / (1 + xᵢ²).
  const auto frequency = [](const std::string& body, const std::string& stiffness, const std::string& relaxation) {
    return measured(
        run_of("body: {" + body + "}\nmaterial: {youngs_modulus: 100 kPa, poissons_ratio: 0.25, density: 1000 kg/m3" +
               relaxation + "}\nstiffness: \"" + stiffness +
               "\"\nexperiment: {kind: vibration, count: 1, fixture: {kind: tension, axis: z, force: 1 mN, fixed_grip: "
               "clamped}}\n"),
        "frequency_1");
  };
  for (const auto& [body, law] :
       {std::pair<std::string, std::string>{
            "lattice: {kind: cubic, molecules: [3, 3, 9], spacing: 1 cm, connections: [axis, face]}", "lattice"},
        {"tetrahedra: {kind: body_centred, cubes: [2, 2, 6], size: [2 cm, 2 cm, 6 cm]}", "neo_hookean"}}) {
    const double plain = frequency(body, law, "");
    for (const double time : {1e-6, 0.3 / (2 * M_PI * plain), 2 / (2 * M_PI * plain), 1e6}) {
      INFO(law << " " << time);
      const std::string relaxation = ", relaxation: {terms: [[0.6, " + std::to_string(1e6 * time) + " us], [0.4, " +
                                     std::to_string(3e6 * time) + " us]]}";
      const double found = frequency(body, "prony:" + law, relaxation);
      double stored = 1;
      for (const auto& [share, own] : {std::pair{0.6, time}, {0.4, 3 * time}}) {
        const double square = std::pow(2 * M_PI * found * own, 2);
        stored += share * square / (1 + square);
      }
      CHECK(found / plain == Approx(std::sqrt(stored)).epsilon(1e-4));
      CHECK(frequency(body, law, relaxation) == Approx(plain).epsilon(1e-6));
    }
  }
}

TEST_CASE("both drag laws reach their speeds, at the order of the stepper", "[time][drag]") {
  const std::string ball =
      "body: {molecules: [[0 m, 0 m, 0 m]], radius: 1 cm}\nmaterial: {youngs_modulus: 1 kPa, density: 1000 kg/m3}\n"
      "stiffness: {strategy: uniform, constant: 1 N/m}\nexperiment: {kind: motion}\n";
  const double m = 8e-3, g = 9.81, c = 6 * M_PI * 0.2 * 0.01, tau = m / c;
  const double sink = std::sqrt(m * g / (0.5 * 1000 * 0.47 * M_PI * 1e-4));
  const auto speed = [&](const std::string& drag, const std::string& method, double duration, int frames) {
    const std::string time = "time: {duration: " + std::to_string(duration) + " s, frames: " + std::to_string(frames) +
                             ", step: 1 s, stepper: " + method + "}\n";
    return measured(run_of(ball + "loads: [{gravity: [0, 0, -9.81 m/s2]}, {" + drag + "}}]\n" + time), "speed");
  };
  const std::string stokes = "stokes_drag: {viscosity: 0.2 Pa s",
                    quadratic = "quadratic_drag: {density: 1000 kg/m3, drag_coefficient: 0.47";
  CHECK(speed(stokes, "newmark", 4, 200) == Approx(g * tau).epsilon(1e-7));
  CHECK(speed(quadratic, "newmark", 2, 200) == Approx(sink).epsilon(1e-7));
  for (const auto& [method, order] : {std::pair{"backward_euler", 1.}, {"newmark", 2.}, {"symplectic_euler", 1.}}) {
    INFO(method);
    const double at = 0.2;
    const auto shown = [&, &method = method](const std::string& drag, double exact) {
      const double coarse = speed(drag, method, at, 20) - exact, fine = speed(drag, method, at, 40) - exact;
      return std::log2(std::abs(coarse / fine));
    };
    CHECK(shown(stokes, g * tau * (1 - std::exp(-at / tau))) > order - 0.1);
    CHECK(shown(quadratic, sink * std::tanh(g * at / sink)) > order - 0.1);
  }
}

TEST_CASE("a load without an energy does work: what it pushes from rest goes on", "[time][energy]") {
  // A follower pressure on one face: x = p A t² / 2 m of the centre, and work of at least p A x, for the face is ahead.
  const double push = 10 * 4e-4, mass = 1000 * 16e-6, way = push / mass * 0.1 * 0.1 / 2;
  for (const char* stepper : {"newmark", "velocity_verlet", "backward_euler"}) {
    INFO(stepper);
    const Run run =
        run_of(std::string("body: {tetrahedra: {kind: kuhn, size: [2 cm, 2 cm, 4 cm], cubes: [2, 2, 4]}}\n"
                           "material: {youngs_modulus: 50 kPa, poissons_ratio: 0.3, density: 1000 kg/m3}\n"
                           "experiment: {kind: motion}\nstiffness: neo_hookean\n"
                           "loads: [{pressure: {pressure: 10 Pa, on: {plane: {point: [0 m, 0 m, 0 m], normal: z}}}}]\n"
                           "time: {duration: 0.1 s, step: 0.5 ms, stepper: ") +
               stepper + "}\n");
    INFO(run.cause);
    REQUIRE(run.outcome == Outcome::converged);
    CHECK(measured(run, "centre_displacement") == Approx(way).epsilon(6e-3));  // backward Euler is a step ahead
    CHECK(measured(run, "work") == Approx(push * way).epsilon(0.02));
    CHECK(std::abs(measured(run, "energy_balance")) <
          (std::string(stepper) == "backward_euler" ? 0.02 : 2e-4) * push * way);
    CHECK(measured(run, "kinetic_energy") == Approx(push * way).epsilon(0.02));
  }
}

TEST_CASE("a drop without damping gives back its speed; with damping less", "[time][drop]") {
  const std::string cube =
      "body: {molecules: [[0 m, 0 m, 5 cm]], radius: 1 cm}\nmaterial: {youngs_modulus: 10 kPa, density: 1000 kg/m3}\n"
      "stiffness: {strategy: uniform, constant: 1 N/m}\n";
  const std::string time = "time: {duration: 60 ms, frames: 600, step: 50 us, stepper: velocity_verlet}\n";
  const Run elastic = run_of(cube + "experiment: {kind: drop, speed: 0.1 m/s, stiffness: 80 N/m}\n" + time);
  CHECK(measured(elastic, "restitution") == Approx(1).epsilon(1e-4));
  // Half a period of 8 g on 80 N/m, the soft first millimetre aside: 31.4 ms and somewhat more.
  CHECK(measured(elastic, "contact_duration") > 31.4e-3);
  CHECK(measured(elastic, "contact_duration") < 50e-3);
  const Run damped =
      run_of(cube + "experiment: {kind: drop, speed: 0.1 m/s, stiffness: 80 N/m, damping: 0.2 N s/m}\n" + time);
  CHECK(measured(damped, "restitution") < 0.8);
  const Run fallen = run_of(cube +
                            "experiment: {kind: drop, gravity: 9.81 m/s2, height: 5 mm, stiffness: 800 N/m}\n"
                            "time: {duration: 0.1 s, frames: 500}\n");
  CHECK(measured(fallen, "impact_speed") == Approx(std::sqrt(2 * 9.81 * 5e-3)).epsilon(1e-4));
}

TEST_CASE("restitution is that of the whole impact, however its molecules bounce meanwhile", "[time][drop][slow]") {
  const std::string block =
      "body: {lattice: {kind: cubic, molecules: [6, 6, 6], spacing: 1 cm, connections: [axis, face]}}\n"
      "material: {youngs_modulus: 100 kPa, density: 1000 kg/m3}\nstiffness: lattice\n";
  const std::string fine = ", step: 20 us, stepper: velocity_verlet}\n";
  for (const std::string floor : {"2 kN/m", "100 kN/m"}) {
    INFO(floor);
    const std::string thrown = block + "experiment: {kind: drop, speed: 1 m/s, stiffness: " + floor + "}\n";
    // Without weight the centre goes as fast before the impact as at first, and after it as in the end.
    const Run run = run_of(thrown + "time: {duration: 60 ms, frames: 200}\n"),
              exact = run_of(thrown + "time: {duration: 60 ms, frames: 200" + fine);
    CHECK(measured(run, "impact_speed") == Approx(1).epsilon(1e-9));
    CHECK(measured(run, "restitution") == Approx(-run.curve.back().measures.get("fall_speed")).epsilon(1e-9));
    CHECK(measured(run, "restitution") ==
          Approx(-exact.curve.back().measures.get("fall_speed")).epsilon(0.01));  // of steps near the stable one
    CHECK(measured(exact, "contact_duration") > 0.01);
    CHECK(measured(run, "contact_duration") == Approx(measured(exact, "contact_duration")).epsilon(0.1));
    CHECK(run.remark.empty());
    // With weight it falls again: what counts is the speed with which it rose, g t until its centre stands still.
    const Run fallen = run_of(block + "experiment: {kind: drop, gravity: 9.81 m/s2, height: 5 cm, stiffness: " + floor +
                              "}\ntime: {duration: 0.4 s, frames: 400" + fine);
    CHECK(measured(fallen, "impact_speed") == Approx(std::sqrt(2 * 9.81 * 0.05)).epsilon(1e-3));
    const double left = std::sqrt(2 * 0.05 / 9.81) + measured(fallen, "contact_duration");
    double highest = 0;
    for (const CurvePoint& row : fallen.curve)
      if (row.time > left && row.measures.get("fall_speed") < 0)
        highest = row.time;
      else if (row.time > left)
        break;
    CHECK(measured(fallen, "rebound_speed") == Approx(9.81 * (highest - left)).margin(9.81 * 1.5e-3));
  }
  const auto drop = [&](const std::string& duration) {
    return run_of(block + "experiment: {kind: drop, gravity: 9.81 m/s2, height: 5 cm}\ntime: {frames: 50, duration: " +
                  duration + "}\n");
  };
  const Run above = drop("50 ms"), pressed = drop("105 ms");
  CHECK_THAT(above.remark, Contains("has not reached the floor within the duration, at whose end it is 37.7 mm away"));
  CHECK_THAT(pressed.remark, Contains("has not left the floor for good"));
  for (const char* name : {"impact_speed", "rebound_speed", "restitution", "contact_duration"})
    CHECK_FALSE(std::isfinite(above.measures.get(name)));
  CHECK(measured(pressed, "impact_speed") > 0);
  for (const char* name : {"rebound_speed", "restitution", "contact_duration"})
    CHECK_FALSE(std::isfinite(pressed.measures.get(name)));
}

TEST_CASE("a released twisted bar turns back and forth; a sheared one, too", "[time][slow]") {
  const std::string bar =
      "body: {lattice: {kind: cubic, molecules: [2, 2, 7], spacing: 1 cm, connections: [axis, face]}}\n"
      "material: {youngs_modulus: 100 kPa, density: 1000 kg/m3}\nstiffness: lattice\n";
  const std::string time = "time: {duration: 0.6 s, frames: 600}\n";
  for (const auto& [hold, start] : {std::pair{"kind: torsion, axis: z, angle: 5 deg", 5 * M_PI / 180},
                                    {"kind: shear, axis: z, direction: x, strain: 2 %", 0.02}}) {
    INFO(hold);
    const Run run = run_of(bar + "experiment: {kind: release, fixture: {" + hold + "}}\n" + time);
    const bool torsion = std::string(hold).find("torsion") != std::string::npos;
    CHECK(run.curve.front().measures.get(torsion ? "angle" : "strain") == Approx(start).epsilon(1e-6));
    CHECK(measured(run, "frequency") > 1);
    CHECK(measured(run, "energy_drift") < 0.05);                    // of steps near the longest stable one
    CHECK_FALSE(std::isfinite(run.measures.get("shear_modulus")));  // there is no load any more
  }
}

TEST_CASE("a cycle shows no modulus where it passes through no strain", "[time]") {
  const std::string bar =
      "body: {lattice: {kind: cubic, molecules: [3, 3, 4], spacing: 1 cm, connections: [axis, face]}}\n"
      "material: {youngs_modulus: 10 kPa, density: 1 kg/m3, relaxation: {model: kelvin_voigt, time: 50 ms}}\n"
      "stiffness: prony:lattice\ntime: {duration: 1 s, frames: 8, step: {per_frame: 4}, stepper: backward_euler}\n";
  for (const auto& [fixture, strain, modulus] :
       {std::array<std::string, 3>{"kind: torsion, axis: z, angle: 0.01 rad", "angle", "torsional_stiffness"},
        {"kind: torsion, axis: z, angle: 0.01 rad", "angle", "shear_modulus"},
        {"kind: shear, axis: z, direction: x, strain: 1 %", "strain", "shear_modulus"},
        {"kind: hydrostatic, strain: 1 %", "volume_strain", "bulk_modulus"},
        {"kind: biaxial, axis: x, across: y, strain: 1 %", "strain", "effective_modulus"},
        {"kind: tension, axis: z, strain: 1 %", "strain", "effective_modulus"}}) {
    INFO(fixture << ": " << modulus);
    const Run run = run_of(bar + "experiment: {kind: cyclic, frequency: 1 Hz, fixture: {" + fixture + "}}\n");
    REQUIRE(run.outcome == Outcome::converged);
    const Measures &quarter = run.curve.at(2).measures, &whole = run.curve.back().measures;
    CHECK(std::abs(quarter.get(strain)) > 5e-3);
    CHECK(std::isfinite(quarter.get(modulus)));
    CHECK(std::abs(whole.get(strain)) < 1e-12);  // rounding of the sine
    CHECK_FALSE(std::isfinite(whole.get(modulus)));
    CHECK_FALSE(std::isfinite(run.measures.get(modulus)));
  }
}

TEST_CASE("a run that stops and goes on has bitwise the same results as one that does not", "[time][restart][slow]") {
  const std::string block =
      "body: {tetrahedra: {kind: kuhn, cubes: [1, 1, 2], size: [10 mm, 10 mm, 20 mm]}}\n"
      "material: {youngs_modulus: 10 kPa, poissons_ratio: 0.3}\nstiffness: neo_hookean\n"
      "experiment: {kind: motion, fixture: {kind: shear, axis: z, direction: x, strain: 0.3}, "
      "in_time: {sine: {frequency: 30 Hz}}}\n"
      "loads: [{cell_damping: {bulk: 0.1 Pa s, shear: 0.1 Pa s}}, {gravity: [0, 0, -9.81 m/s2], "
      "in_time: {ramp: {duration: 20 ms}}}]\n";
  for (const char* time : {"stepper: newmark, step: {error: 1e-4}", "stepper: backward_euler, step: 0.7 ms",
                           "stepper: {method: newmark, newton_iterations: 1}, step: 1 ms", "stepper: velocity_verlet",
                           "stepper: symplectic_euler"}) {
    INFO(time);
    const std::string text = block + "time: {duration: 20 ms, frames: 10, checkpoint: 4, " + time + "}\n";
    std::vector<std::string> kept;
    RunOptions options;
    options.checkpoint = [&](const std::string& restart) { kept.push_back(restart); };
    const Run whole = run_of(text, options);
    REQUIRE(whole.outcome == Outcome::converged);
    REQUIRE(kept.size() == 2);
    for (const std::string& restart : kept) {
      RunOptions later;
      later.restart = restart;
      const Run resumed = run_of(text, later);
      CHECK(resumed.time->resumed);
      CHECK(resumed.time->steps < whole.time->steps);
      CHECK(numbers_of(resumed) == numbers_of(whole));
    }
    // Asked to stop after eight steps, it leaves a restart file of the last frame behind.
    int asked = 0;
    std::string left;
    RunOptions stopped;
    stopped.stop = [&] { return ++asked == 8; };
    stopped.checkpoint = [&](const std::string& restart) { left = restart; };
    const Run part = run_of(text, stopped, {"time.checkpoint=100"});
    CHECK(part.outcome == Outcome::interrupted);
    CHECK_THAT(part.cause, Contains("after frame " + std::to_string(part.curve.size() - 1) + " of 10"));
    CHECK(part.curve.size() < 6);
    RunOptions later;
    later.restart = left;
    CHECK(numbers_of(run_of(text, later)) == numbers_of(whole));
  }
}

TEST_CASE("a run that grows, relaxes and touches goes on with bitwise the same results", "[time][restart][rest]") {
  const std::string text =
      "body: {lattice: {kind: cubic, molecules: [3, 3, 5], spacing: 5 mm, order: 1}}\n"
      "material: {youngs_modulus: 20 kPa, poissons_ratio: 0.3, density: 1000 kg/m3, "
      "relaxation: {terms: [[0.3, 0.05 s], [0.2, 0.5 s]]}}\nstiffness: 'prony:neo_hookean'\n"
      "rest: {growth: 1.2, along: z, factor: {ramp: {duration: 0.3 s}}}\n"
      "contact: {friction: 0.2, obstacles: [{name: wall, plane: {point: [0, 0, 22 mm], normal: -z}, motion: "
      "{by: [0, 0, -4 mm], in_time: {ramp: {duration: 0.2 s}}}}]}\n"
      "experiment: {kind: motion, fixture: {kind: loads, read: [{name: t, molecules: {side: z}}]}}\n"
      "supports: [{molecules: {side: -z}}]\n"
      "time: {duration: 0.36 s, stepper: backward_euler, step: 5 ms, frames: 36, checkpoint: 25}\n";
  std::string restart;
  RunOptions options;
  options.checkpoint = [&](const std::string& saved) { restart = saved; };
  const Run whole = run_of(text, options);
  REQUIRE(whole.outcome == Outcome::converged);
  RunOptions later;
  later.restart = restart;
  CHECK(numbers_of(run_of(text, later)) == numbers_of(whole));
}

TEST_CASE("a run at rest that is stopped ends between two load steps", "[statics]") {
  int asked = 0;
  RunOptions options;
  options.stop = [&] { return ++asked == 4; };  // before each solve, and before each step but the first
  const Run run = run_of(
      "body: {tetrahedra: {kind: kuhn, cubes: [1, 1, 2], size: [10 mm, 10 mm, 20 mm]}}\n"
      "material: {youngs_modulus: 10 kPa, poissons_ratio: 0.3}\nstiffness: neo_hookean\n"
      "experiment: {kind: tension, strain: 10 %, load_steps: 5}\nsolver: {displacements: small}\n",
      options);
  CHECK(run.outcome == Outcome::interrupted);
  CHECK(run.cause == "stopped before load step 3 of 5");
  CHECK(run.curve.size() == 2);
}

TEST_CASE("a run at rest is stopped in the middle of a solve, by Newton's method or by relaxation", "[statics]") {
  const std::string scene =
      "body: {tetrahedra: {kind: kuhn, cubes: [1, 1, 2], size: [10 mm, 10 mm, 20 mm]}}\n"
      "material: {youngs_modulus: 10 kPa, poissons_ratio: 0.3}\nstiffness: neo_hookean\n"
      "experiment: {kind: tension, strain: 30 %}\n";
  const Run whole = run_of(scene);
  REQUIRE(whole.newton_iterations > 2);
  RunOptions options;
  int asked = 0;
  options.stop = [&] { return ++asked > 3; };  // once before the first guess, then before each iteration
  const Run newton = run_of(scene, options);
  CHECK(newton.outcome == Outcome::interrupted);
  CHECK(newton.cause == "stopped after 2 Newton iterations");
  CHECK(newton.newton_iterations == 2);
  CHECK(newton.curve.empty());
  options.stop = [&] { return true; };
  for (const char* method : {"explicit", "implicit"}) {
    const Run relaxed = run_of(scene, options, {std::string("solver.method=") + method});
    CHECK(relaxed.outcome == Outcome::interrupted);
  }
  options.stop = [&] { return false; };
  CHECK(run_of(scene, options).measures.get("force") == whole.measures.get("force"));
}

TEST_CASE("a restart file of another run, or a damaged one, is refused", "[time][restart]") {
  std::string kept;
  RunOptions options;
  options.checkpoint = [&](const std::string& restart) { kept = restart; };
  const std::string time = "time: {duration: 1 s, frames: 4, checkpoint: 1}\n";
  run_of(kRelease + time, options);
  const auto refuse = [&](const std::string& restart, const std::string& scene, const std::string& says) {
    RunOptions later;
    later.restart = restart;
    CHECK_THROWS_WITH(run_of(scene, later), Contains(says));
  };
  refuse("nothing of the kind", kRelease + time, "this is no restart file");
  std::string older = kept;
  REQUIRE(older.starts_with("elastin-restart-10 "));
  older.replace(std::string("elastin-restart-").size(), 2, "6");
  refuse(older, kRelease + time, "of another version of the program ('elastin-restart-6', here 'elastin-restart-10')");
  refuse(kept.substr(0, kept.size() / 2), kRelease + time, "cut off");
  refuse(kept, kRelease + "time: {duration: 2 s, frames: 4}\n", "of another run");
  refuse(kept, kRelease + "time: {duration: 2 s, frames: 4}\n",
         "it has a frame every 0.25 s, and this run every 0.5 s: change `time.frames` together with `time.duration`");
  refuse(kept, kRelease + "time: {duration: 0.5 s, frames: 2}\n",
         "is of frame 4, at t = 1 s, and this run ends with frame 2, at t = 0.5 s");
  refuse(kept, kRelease + "time: {duration: 1 s, frames: 4, stepper: newmark}\n",
         "its stepper is velocity_verlet, here newmark; of the scene");
  refuse(kept, kRelease + time + "loads: [{damping: 2 N s/m}]\n", "of another run: its loads is not there, here ");
  std::string stiffer = kRelease;
  stiffer.replace(stiffer.find("10 kPa"), 6, "20 kPa");
  refuse(kept, stiffer + time, "another run: its material is ");
  refuse(kept, stiffer + time, "10 kPa");
  std::string longer = kRelease;
  longer.replace(longer.find("10 cm"), 5, "11 cm");
  refuse(kept, longer + time, "its body is another one");
  std::string bad = kept;
  bad.replace(bad.find("0x1"), 3, "0y1");
  refuse(bad, kRelease + time, "is damaged: its checksum does not hold");
  // With its path it says where.
  const auto says_where = [&](const std::string& text, const std::string& where) {
    const std::size_t begin = kept.find(' ') + 1;
    const std::string identity = kept.substr(begin, kept.find(' ', begin) - begin);
    CHECK_THROWS_WITH(parse_restart(text, identity, "a.restart"), Catch::Matchers::StartsWith("a.restart:" + where));
  };
  says_where("nothing of the kind", "1:1: this is no restart file");
  says_where(older, "1:1: this restart file is of another version");
  says_where(bad, "1:" + std::to_string(kept.find(' ', kept.find(' ') + 1) + 2) + ": the restart file is damaged");
  const std::string cut = kept.substr(0, kept.find('\n') + 1) + "12 0x1p+0\n 13";
  says_where(cut, "3:4: the restart file is cut off");
}

TEST_CASE("steps that lose energy are named, implicit ones too, and what contact takes is not theirs", "[time][slow]") {
  const std::string bar =
                        "body: {lattice: {kind: cubic, molecules: [3, 3, 9], spacing: 1 cm, connections: [axis, "
                        "face]}}\nmaterial: {youngs_modulus: 10 kPa, density: 1000 kg/m3}\nstiffness: lattice\n",
                    swings = bar + "experiment: {kind: release, fixture: {kind: tension, axis: z, strain: 5 %}}\n";
  const auto warnings = [](const Run& run) {
    std::string all;
    for (const std::string& warning : run.warnings) all += warning + "\n";
    return all;
  };
  CHECK_THAT(warnings(run_of(swings + "time: {duration: 0.3 s, frames: 30, stepper: backward_euler, step: 2 ms}\n")),
             Contains("the steps lose energy") && EndsWith("take shorter steps\n"));  // they take as many as it needs
  // Where a step takes a number of iterations, more of them may help as well.
  for (const auto& [stepper, effort] : {std::pair{"xpbd", "iterations"}, {"block_descent", "sweeps"}})
    CHECK_THAT(warnings(run_of(swings + "time: {duration: 0.3 s, frames: 30, step: 2 ms, stepper: " + stepper + "}\n")),
               Contains(std::string("take shorter steps, or more ") + effort + " in each: time.stepper." + effort));
  CHECK(warnings(run_of(swings + "time: {duration: 0.3 s, frames: 30, stepper: newmark, step: 2 ms}\n")).empty());
  const Run bounced = run_of(
      "body: {lattice: {kind: cubic, molecules: [5, 5, 5], spacing: 1 cm, connections: [axis, face]}}\n"
      "material: {youngs_modulus: 100 kPa, density: 1000 kg/m3}\nstiffness: lattice\n"
      "experiment: {kind: drop, speed: 1 m/s}\ncontact: {restitution: 0.5, obstacles: [{name: floor, plane: {point: "
      "[0, 0, -6 mm], normal: z}}]}\ntime: {duration: 60 ms, frames: 100}\n");
  CHECK(measured(bounced, "energy_drift") > 0.05);
  CHECK(warnings(bounced).empty());
  CHECK_THAT(bounced.remark, Contains("in no account: contact with a restitution below 1"));
}

TEST_CASE("implicit steps that make more energy than there is end with that as the cause", "[time][slow]") {
  // Springs that are stretched by 40 % and released: the trapezoidal rule gains energy from their turns.
  const Run run = run_of(
      "body: {lattice: {kind: cubic, molecules: [4, 4, 6], spacing: 10 mm, connections: [axis, face]}}\n"
      "material: {youngs_modulus: 10 kPa, poissons_ratio: 0.25, density: 1000 kg/m3}\nstiffness: lattice\n"
      "experiment: {kind: release, load: removed, fixture: {kind: tension, displacement: 20 mm}}\n"
      "time: {duration: 1 s, frames: 10, stepper: newmark, step: 20 ms}\n");
  CHECK(run.outcome == Outcome::diverged);
  CHECK_THAT(run.cause, Contains("the steps make energy from nothing"));
}

TEST_CASE("laws with a history and laws without an energy keep an account, and a run that explodes ends",
          "[time][slow]") {
  const std::string creep =
      "body: {lattice: {kind: cubic, molecules: [3, 3, 4], spacing: 10 mm, connections: [axis, face]}}\n"
      "material: {youngs_modulus: 10 kPa, density: 1000 kg/m3, relaxation: {terms: [[0.5, 2 s]]},"
      " softening: {r: 1.5, m: 50 Pa, beta: 0.1}}\n"
      "experiment: {kind: creep, fixture: {kind: tension, axis: z, force: 80 mN}}\n";
  const std::string coarse = "time: {duration: 36 s, frames: 30, stepper: newmark, step: 20 ms}\n",
                    fine = "time: {duration: 0.2 s, frames: 10, stepper: newmark, step: 1 ms}\n";
  const Run exploded = run_of(creep + "stiffness: \"prony:lattice\"\n" + coarse);
  CHECK(exploded.outcome == Outcome::diverged);
  CHECK_THAT(exploded.cause, Contains("the steps make energy from nothing"));
  for (const std::string strategy : {"lattice", "\"prony:lattice\"", "\"mullins:lattice\"", "angles_update"}) {
    INFO(strategy);
    const Run run = run_of(creep + "stiffness: " + strategy + "\n" + fine);
    CHECK(measured(run, "energy_drift") < 0.03);
    CHECK(std::isfinite(run.measures.get("energy")) == (strategy != "angles_update"));
    for (const CurvePoint& row : run.curve) CHECK(row.measures.get("dissipated_energy") > -1e-7);
  }
  // A step to 0.1 % that is held: of the work half the force times the displacement is stored in the end.
  const Run relaxed = run_of(
      "body: {tetrahedra: {kind: body_centred, cubes: [2, 2, 6], size: [10 mm, 10 mm, 30 mm]}}\n"
      "material: {youngs_modulus: 10 kPa, density: 1 kg/m3, relaxation: {terms: [[1, 0.5 s]]}}\n"
      "stiffness: \"prony:neo_hookean\"\n"
      "experiment: {kind: relaxation, ramp: 0.2 s, fixture: {kind: tension, axis: z, displacement: 0.03 mm}}\n"
      "time: {duration: 4 s, stepper: newmark, step: 10 ms, frames: 100}\n");
  const double stored = measured(relaxed, "force") * 0.03e-3 / 2, work = measured(relaxed, "work");
  CHECK(measured(relaxed, "energy") == Approx(stored).epsilon(0.01));
  CHECK(work > 1.5 * stored);
  CHECK(measured(relaxed, "dissipated_energy") == Approx(work - stored).epsilon(0.02));
  CHECK(measured(relaxed, "energy_drift") < 0.01);
}

TEST_CASE("a budget gives each step the sweeps that it leaves time for", "[time][budget][slow]") {
  const auto swung = [](const std::string& stepper, const std::string& budget) {
    return run_of(
        "body: {lattice: {kind: cubic, molecules: [2, 2, 5], spacing: 1 cm, connections: [axis, face]}}\n"
        "material: {youngs_modulus: 10 kPa, density: 1000 kg/m3}\n"
        "stiffness: lattice\n"
        "experiment: {kind: release, fixture: {kind: bending, axis: z, direction: x, force: 1 mN}}\n"
        "time: {duration: 0.2 s, frames: 10, step: 2 ms, stepper: " +
        stepper + budget + "}\n");
  };
  // None is in time: each step keeps its one sweep, and looking what it leaves changes nothing.
  const Run late = swung("{method: block_descent, sweeps: 1}", ", budget: 1 ns");
  const Run one = swung("{method: block_descent, sweeps: 1}", "");
  REQUIRE(late.time->budget);
  CHECK(late.time->budget->median == 1);
  CHECK(late.time->budget->late == 1);
  CHECK(late.curve.back().measures.get("tip_deflection") == one.curve.back().measures.get("tip_deflection"));
  CHECK_FALSE(one.time->budget);
  REQUIRE(late.warnings.size() == 2);
  CHECK_THAT(late.warnings[0], Contains("100 % of the steps took longer than their budget"));
  CHECK_THAT(late.warnings[1], Contains("the steps lose energy"));  // of one sweep a step
  // More time, more sweeps, less left to do.
  const Run more = swung("{method: block_descent, sweeps: 9}", ", budget: 20 ms");
  REQUIRE(more.time->budget);
  const BudgetReport& found = *more.time->budget;
  CHECK(found.effort == "sweeps");
  CHECK(found.median > 9);
  CHECK(found.least <= found.median);
  CHECK(found.median <= found.most);
  CHECK(found.iteration_error < 0.1 * late.time->budget->iteration_error);
  CHECK(late.time->budget->iteration_error < late.time->budget->motion);
}

TEST_CASE("a step far above the stable one ends with its cause and keeps the frames before", "[time]") {
  const Run run = run_of(kRelease + "time: {duration: 200 s, frames: 100, step: 2 s, stepper: velocity_verlet}\n");
  CHECK(run.outcome == Outcome::diverged);
  CHECK_THAT(run.cause, Contains("energy from nothing") && Contains("longest stable one was 0.2 s"));
  CHECK(run.curve.size() < 20);
  REQUIRE_FALSE(run.warnings.empty());
  CHECK_THAT(run.warnings.back(), Contains("a step of 2 s is longer than the longest stable one, 0.2 s"));
  for (const CurvePoint& row : run.curve)
    for (const auto& [name, value] : row.measures.all()) CHECK(std::abs(value) < 1e6);
}

TEST_CASE("the first step that fails is named by its length", "[time]") {
  const Run run = run_of(kRelease + "time: {duration: 2e5 s, frames: 1, step: 2e5 s, stepper: velocity_verlet}\n");
  CHECK(run.outcome == Outcome::diverged);
  CHECK_THAT(run.cause, Contains("(at t = 0 s, after 0 steps, in one of 2e+05 s; the longest stable one was 0.2 s)"));
}

TEST_CASE("St Venant-Kirchhoff inverts where neo_hookean holds", "[time]") {
  const std::string text =
      "body: {tetrahedra: {kind: body_centred, cubes: [2, 2, 2], size: [10 cm, 10 cm, 10 cm]}}\n"
      "material: {youngs_modulus: 5 kPa, poissons_ratio: 0.3}\nstiffness: neo_hookean\n"
      "experiment: {kind: motion, fixture: {kind: compression, axis: z, displacement: 75 mm, fixed_grip: clamped, "
      "loaded_grip: clamped}, in_time: {ramp: {duration: 0.5 s}}}\n"
      "loads: [{cell_damping: {bulk: 10 Pa s, shear: 10 Pa s}}]\n"
      "time: {duration: 0.6 s, stepper: {method: backward_euler, newton_iterations: 1}, step: 10 ms, frames: 60}\n";
  const Run holds = run_of(text);
  CHECK(holds.outcome == Outcome::converged);
  const Run fails = run_of(text, {}, {"stiffness=st_venant_kirchhoff"});
  CHECK(fails.outcome == Outcome::inverted);
  CHECK_THAT(fails.cause, Contains("cell"));
  CHECK(fails.curve.size() > 10);
}

TEST_CASE("a state to start from: velocity, spin, turned, scattered", "[time][initial]") {
  const std::string text =
      "body: {lattice: {kind: cubic, molecules: [3, 3, 3], spacing: 1 cm, connections: [axis, face]}}\n"
      "material: {youngs_modulus: 100 kPa, density: 1000 kg/m3}\nstiffness: lattice\nexperiment: {kind: motion}\n"
      "time: {duration: 10 ms, frames: 4}\n";
  const Run moving = run_of(text + "initial: {velocity: [3 m/s, 0 m/s, 4 m/s]}\n");
  CHECK(measured(moving, "speed") == Approx(5));
  CHECK(measured(moving, "centre_displacement") == Approx(0.05));
  CHECK(measured(moving, "largest_strain") < 1e-12);
  const Run spinning = run_of(text + "initial: {spin: [0 /s, 0 /s, 10 /s]}\n");
  CHECK(measured(spinning, "speed") < 1e-12);
  CHECK(measured(spinning, "angular_momentum") ==
        Approx(spinning.curve.front().measures.get("angular_momentum")).epsilon(1e-12));
  const Run turned = run_of(text + "initial: {turn: {axis: [1, 2, 3], angle: 77 deg}}\n");
  CHECK(measured(turned, "largest_strain") < 1e-12);
  const Run scattered = run_of(text + "initial: {scatter: {amount: 1 mm, seed: 3}}\n");
  CHECK(measured(scattered, "largest_strain") > 0.01);
  const Run moved = run_of(text + "initial: {move: {molecules: [13], by: [1 mm, 0 m, 0 m]}}\n");
  CHECK(moved.curve.front().measures.get("largest_strain") > 0.05);
}

TEST_CASE("every kind of strategy can be compared in time", "[time]") {
  const std::string text =
      "body: {lattice: {kind: cubic, molecules: [3, 3, 4], spacing: 1 cm, connections: [axis, face]}}\n"
      "material: {youngs_modulus: 10 kPa, density: 1000 kg/m3}\nstiffness: lattice\n"
      "experiment: {kind: release, fixture: {kind: tension, axis: z, force: 1 mN}}\ntime: {duration: 0.2 s}\n";
  const double exact = measured(run_of(text), "frequency");
  const Run calibrated = run_of(text, {}, {"stiffness=calibrated:standard"});
  CHECK(calibrated.calibration_factor != 1);
  CHECK(measured(calibrated, "frequency") == Approx(exact).epsilon(0.1));
  CHECK(measured(run_of(text, {}, {"stiffness=standard"}), "frequency") > 1.2 * exact);  // far too stiff
  const Run updated = run_of(text, {}, {"stiffness=angles_update"});  // has no energy: the work of its forces counts
  CHECK(measured(updated, "frequency") > 0);
  CHECK(measured(updated, "energy_drift") < 0.1);
}

TEST_CASE("the file of a run in time has a row a frame", "[time][files]") {
  const TemporaryFolder folder;
  const auto scene =
      load_scene(folder.write("scene.yaml", "title: x\n" + kRelease + "time: {duration: 1 s, frames: 5}\n"), kCatalog);
  RunOptions options;
  options.time = scene->time;
  const Record record =
      make_record(*scene, run_strategy(scene->specimen, *scene->experiment, scene->stiffness, options));
  const std::string csv = curve_csv_text(record);
  CHECK(std::count(csv.begin(), csv.end(), '\n') == 7);
  for (const char* column : {"time [s],", "elongation [m]", "kinetic_energy [J]", "energy_balance [J]", "work [J]",
                             "momentum [kg m/s]", "angular_momentum [kg m^2/s]", "step [s],steps,"})
    CHECK_THAT(csv, Contains(column));
  CHECK_THAT(json_text({record}), Contains("\"stepper\": \"velocity_verlet\"") && Contains("\"real_time_factor\""));
}

namespace {

/// A bar of springs whose stress relaxes over four decades, and what is left of that of a ramp of its force densities.
std::string decades(const std::string& strategy, const std::string& experiment, const std::string& time) {
  return "body: {lattice: {kind: cubic, molecules: [3, 3, 5], spacing: 5 mm, connections: [axis, face]}}\n"
         "material: {youngs_modulus: 10 kPa, density: 1e-9 kg/m3, relaxation: {terms: [[0.4, 10 ms], [0.3, 1 s], "
         "[0.2, 100 s]]}}\nstiffness: \"" +
         strategy + "\"\nexperiment: {" + experiment + "}\ntime: {stepper: backward_euler, " + time + "}\n";
}

double left_of_ramp(double time, double ramp) {
  double sum = 1;
  for (const auto& [g, tau] : {std::pair{0.4, 0.01}, {0.3, 1.}, {0.2, 100.}})
    sum += g * tau / ramp * (std::exp(ramp / tau) - 1) * std::exp(-time / tau);
  return sum;
}

}  // namespace

TEST_CASE("frames whose lengths grow by a factor: relaxation over decades of time", "[time]") {
  const std::string held = "kind: relaxation, ramp: 1 ms, fixture: {kind: tension, axis: z, displacement: 1 mm}",
                    time = "duration: 1000 s, frames: 61, first_frame: 1 ms, step: {per_frame: 1}";
  const Run run = run_of(decades("prony:lattice", held, time)), elastic = run_of(decades("lattice", held, time));
  REQUIRE(run.outcome == Outcome::converged);
  REQUIRE(run.curve.size() == 62);
  CHECK(run.time->steps == 61);
  const double end = elastic.curve.back().measures.get("force");
  for (std::size_t frame = 1; frame < run.curve.size(); ++frame) {
    const CurvePoint& row = run.curve[frame];
    CHECK(row.time == Approx(1e-3 * std::pow(10, (static_cast<double>(frame) - 1) / 10)).epsilon(1e-12));
    CHECK(row.measures.get("force") == Approx(end * left_of_ramp(row.time, 1e-3)).epsilon(1e-9));
  }
  CHECK(measured(run, "relaxation_time") == Approx(100).epsilon(0.02));

  std::string kept;  // from the fortieth frame on it is the same run
  RunOptions options, later;
  options.checkpoint = [&](const std::string& restart) { kept = restart; };
  const std::string text = decades("prony:lattice", held, time + ", checkpoint: 40");
  const Run whole = run_of(text, options);
  later.restart = kept;
  const Run rest = run_of(text, later);
  CHECK(numbers_of(rest) == numbers_of(whole));
}

TEST_CASE("creep over decades of time is of order 2 in the steps of a frame", "[time]") {
  // At constant stress a standard linear solid has the strain σ/E (1 − g/(1 + g) e^(−t/((1 + g) τ))).
  const auto creep = [](int steps) {
    std::string text =
        decades("prony:lattice", "kind: creep, fixture: {kind: tension, axis: z, force: 1 uN}",
                "duration: 3 s, frames: 30, first_frame: 10 us, step: {per_frame: " + std::to_string(steps) + "}");
    const std::string terms = "[[0.4, 10 ms], [0.3, 1 s], [0.2, 100 s]]";
    text.replace(text.find(terms), terms.size(), "[[1, 1 s]]");
    return run_of(text + "solver: {displacements: small}\n").curve.back().measures.get("elongation");
  };
  const double elastic = 1e-6 / 1e-4 / 1e4 * 0.02;
  std::vector<double> errors;
  for (const int steps : {2, 4, 8}) errors.push_back(creep(steps) / elastic - (1 - 0.5 * std::exp(-1.5)));
  INFO(errors[0] << " " << errors[1] << " " << errors[2]);
  CHECK(errors[0] / errors[1] == Approx(4).epsilon(0.1));
  CHECK(errors[1] / errors[2] == Approx(4).epsilon(0.1));
}

// Three molecules in a row, both springs of k = 100 N/m: the far one is displaced by u at once, which takes k u^2/2,
// and the middle one of m = 1 kg swings about u/2.
TEST_CASE("a displacement that is there at once does work, and a modulus read in motion is said", "[time]") {
  const std::string row =
      "body: {molecules: [[0 m, 0 m, 0 m], [10 cm, 0 m, 0 m], [20 cm, 0 m, 0 m]], connections: [[0, 1], [1, 2]]}\n"
      "material: {youngs_modulus: 10 kPa, density: 1000 kg/m3}\n"
      "stiffness: {strategy: uniform, constant: 100 N/m}\n"
      "experiment: {kind: motion, fixture: {kind: tension, axis: x, displacement: 1 mm, cross_section: 1 cm2}}\n";
  const double energy = 100 * 1e-6 / 2;
  for (const std::string stepper : {"velocity_verlet", "backward_euler", "newmark", "energy_momentum"}) {
    INFO(stepper);
    const Run run = run_of(row + "time: {duration: 20 ms, step: 0.1 ms, frames: 10, stepper: " + stepper + "}\n");
    INFO(run.cause);
    REQUIRE(run.outcome == Outcome::converged);
    CHECK(run.measures.get("work") == Approx(energy).epsilon(1e-3));
    CHECK(std::abs(run.measures.get("energy_balance")) < (stepper == "backward_euler" ? 0.01 : 1e-3) * energy);
    REQUIRE(!run.warnings.empty());  // another of the row's mechanisms before it
    CHECK_THAT(run.warnings.back(), Contains("the modulus includes forces of inertia"));
  }
}

// A spring of k = 100 N/m with a damper of c = 3 N s/m is drawn out within T: at the end F = k x (1 + c / (k T)).
TEST_CASE("what damping adds to a modulus is said", "[time]") {
  const auto drawn = [](const std::string& ramp, const std::string& loads) {
    return run_of(kOscillator + "experiment: {kind: motion, in_time: {ramp: {duration: " + ramp +
                  "}}, fixture: {kind: tension, axis: x, displacement: 1 mm, cross_section: 1 cm2}}\nloads: [" + loads +
                  "]\ntime: {duration: 1 s, step: 1 ms, frames: 500, stepper: newmark}\n");
  };
  const auto said = [](const Run& run) {
    return std::count_if(run.warnings.begin(), run.warnings.end(), [](const std::string& one) {
      return one.find("damping bears about 3 %") != std::string::npos;
    });
  };
  const std::string damper = "{damping: 3 N s/m}";
  const Run all = drawn("1 s", damper), held = drawn("0.5 s", damper), none = drawn("1 s", "");
  CHECK(all.measures.get("effective_modulus") == Approx(103e3).epsilon(1e-3));
  CHECK(said(all) == 1);
  CHECK(held.measures.get("effective_modulus") == Approx(100e3).epsilon(1e-6));
  CHECK(said(held) == 0);
  CHECK(said(none) == 0);
}

TEST_CASE("a law without an energy that is drawn slowly is not said to move", "[time]") {
  const Run run = run_of(
      "body: {lattice: {kind: cubic, molecules: [3, 3, 4], spacing: 2 mm, connections: [axis, face]}}\n"
      "material: {youngs_modulus: 20 kPa, density: 1000 kg/m3}\nstiffness: angles_update\n"
      "experiment: {kind: motion, in_time: {ramp: {duration: 1 s}}, fixture: {kind: tension, axis: z, "
      "displacement: 0.1 mm}}\ntime: {duration: 1 s, stepper: newmark, step: 50 ms, frames: 10}\n");
  REQUIRE(run.outcome == Outcome::converged);
  CHECK(run.warnings.empty());
}

TEST_CASE("a block that sticks to a turning table takes few iterations a step", "[time][contact]") {
  // It turns with the table from the start: speed 0.1 m/s at a radius of 10 cm and 1 rad/s.
  for (const std::string stepper : {"backward_euler", "newmark"}) {
    const Run run = run_of(
        "body: {tetrahedra: {kind: body_centred, cubes: [2, 2, 1], size: [20 mm, 20 mm, 10 mm]}}\n"
        "material: {youngs_modulus: 100 kPa, poissons_ratio: 0.25, density: 1000 kg/m3}\nstiffness: neo_hookean\n"
        "experiment: {kind: motion}\ncontact: {friction: 0.5, obstacles: [{name: table, box: {size: [600 mm, 600 mm, "
        "20 mm]}, at: [-90 mm, 10 mm, -10 mm], spin: [0, 0, 1 1/s]}]}\n"
        "loads: [{gravity: {acceleration: [0, 0, -9.81 m/s2]}}]\n"
        "initial: {velocity: [0, 0.1 m/s, 0], spin: [0, 0, 1 1/s]}\n"
        "time: {duration: 50 ms, step: 1 ms, frames: 5, stepper: " +
        stepper + "}\n");
    INFO(stepper << ": " << run.newton_iterations << " iterations");
    CHECK(measured(run, "sticking") == 24);
    CHECK(run.newton_iterations <= 6 * 50);
  }
}

TEST_CASE("a flat sheet that is pressed in its plane is not stable in time either, which is said once",
          "[run_in_time]") {
  const auto run = [](const std::string& law, const std::string& strain, const std::string& more = "") {
    return run_of(
        "body: {sheet: {size: [6 mm, 4 mm], squares: [3, 2], pattern: one_way}}\n"
        "material: {youngs_modulus: 20 kPa, poissons_ratio: 0, density: 1 g/cm3, thickness: 0.1 mm}\n"
        "stiffness: " +
        law + "\nexperiment: {kind: motion, fixture: {kind: tension, axis: x, strain: " + strain +
        "}}\n"
        "time: {duration: 0.1 s, frames: 20, stepper: backward_euler, step: {per_frame: 1}}\n" +
        more);
  };
  const auto said = [](const Run& done) {
    INFO(done.cause);
    CHECK(done.outcome == Outcome::converged);
    return std::count_if(done.warnings.begin(), done.warnings.end(), [](const std::string& warning) {
      return warning.starts_with("the flat sheet is not stable from t = ") &&
             warning.find("a membrane would wrinkle there") != std::string::npos;
    });
  };
  CHECK(said(run("st_venant_kirchhoff_membrane", "-2 %")) == 1);
  CHECK(said(run("st_venant_kirchhoff_membrane", "2 %")) == 0);
  CHECK(said(run("st_venant_kirchhoff_membrane+wrinkling", "-2 %")) == 0);
  CHECK(said(run("st_venant_kirchhoff_membrane", "-2 %", "initial: {scatter: {amount: 1 um}}\n")) == 0);
}
