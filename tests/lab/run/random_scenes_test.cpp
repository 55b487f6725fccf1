// Scenes drawn at random from the language, each with a consequence that needs no reference: balance of the reactions,
// the same answer in other units, turned about any axis or by another solver, twice the answer to twice the load, the
// force as the slope of the energy, the law's own closed form, no energy from nothing. A fifth of them runs always,
// all of them by `elastin_tests [random]`.

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "lab/run/specimen.h"
#include "lab/scene/scene.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;

namespace {

constexpr int kScenes = 100;

/// The same numbers with every library.
class Draw {
 public:
  explicit Draw(int scene) : generator_(20250u + static_cast<unsigned>(scene)) {}
  int below(int count) { return static_cast<int>(generator_() % static_cast<std::uint64_t>(count)); }
  bool yes() { return below(2) == 1; }
  double between(double low, double high) {
    return low + (high - low) * static_cast<double>(generator_() >> 11) * 0x1p-53;
  }
  const char* pick(std::initializer_list<const char*> choices) {
    return choices.begin()[below(static_cast<int>(choices.size()))];
  }

 private:
  std::mt19937_64 generator_;
};

std::string text(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.17g", value);
  return buffer;
}
std::string vector_text(const Vector3& v) { return "[" + text(v[0]) + ", " + text(v[1]) + ", " + text(v[2]) + "]"; }

/// A measure that counts, with its dimension: lengthᵃ stressᵇ.
struct Judged {
  std::string name;
  double length, stress;
};

/// A scene and what is known of it.
struct Drawn {
  std::string body, material, stiffness, experiment, loads, contact, time, rotate, solver;
  std::vector<Judged> measures;  ///< of the experiment
  std::string driven;            ///< key of the experiment's load, as "displacement"
  double amount = 0;             ///< its value
  bool cells = false, at_rest = true, touches = false, loaded = false;
  std::string law;  ///< whose closed form the scene meets; "" where there is none
  double youngs_modulus = 0, poissons_ratio = 0, height = 0;

  std::string scene() const {
    return "title: drawn\nbody: " + body + "\nmaterial: " + material + "\nstiffness: " + stiffness + "\nexperiment: {" +
           experiment + ", " + driven + ": " + text(amount) + "}\n" + loads + contact + time + rotate + "solver: {" +
           solver + "}\n";
  }
};

void draw_body(Draw& draw, double length, Drawn& drawn) {
  const double h = length * draw.between(0.5, 2);
  const std::array<int, 3> counts{2 + draw.below(2), 2 + draw.below(2), 3 + draw.below(3)};
  drawn.cells = draw.below(3) > 0;
  const std::string jitter = draw.yes() ? ", jitter: {amount: " + text(draw.between(0.01, 0.12)) + "}" : "";
  const std::string list =
      std::to_string(counts[0]) + ", " + std::to_string(counts[1]) + ", " + std::to_string(counts[2]);
  if (drawn.cells) {
    const Vector3 size(h * counts[0], h * counts[1], h * counts[2]);
    const bool second = jitter.empty() && draw.below(4) == 0;
    drawn.height = size.z();
    drawn.body = std::string("{tetrahedra: {kind: ") + draw.pick({"kuhn", "alternating", "body_centred"}) +
                 ", cubes: [" + list + "], size: " + vector_text(size) + (second ? ", order: 2" : "") + "}" + jitter +
                 "}";
    drawn.stiffness =
        second ? draw.pick({"neo_hookean", "st_venant_kirchhoff", "neo_hookean_log"})
               : draw.pick({"neo_hookean", "st_venant_kirchhoff", "neo_hookean_log", "neo_hookean", "van_gelder",
                            "calibrated:van_gelder", "lloyd", "neo_hookean+volume", "van_gelder+volume"});
  } else {
    drawn.height = h * (counts[2] - 1);
    drawn.body = "{lattice: {kind: cubic, molecules: [" + list + "], spacing: " + text(h) +
                 ", connections: " + draw.pick({"[axis, face]", "[axis, face, space]"}) + "}" + jitter + "}";
    drawn.stiffness = jitter.empty() ? draw.pick({"lattice", "standard", "statistical", "patch", "calibrated:standard"})
                                     : draw.pick({"standard", "statistical", "calibrated:standard"});
  }
}

void draw_at_rest(Draw& draw, Drawn& drawn) {
  const double strain = draw.between(0.002, 0.08) * (draw.yes() ? 1 : -1), height = drawn.height;
  const bool cell_law = drawn.stiffness == "neo_hookean" || drawn.stiffness == "st_venant_kirchhoff";
  switch (draw.below(drawn.cells ? 6 : 5)) {
    case 0: {
      const bool clamped = draw.yes();
      drawn.experiment = std::string("kind: tension") + (clamped ? ", fixed_grip: clamped, loaded_grip: clamped" : "");
      drawn.driven = "displacement", drawn.amount = strain * height;
      drawn.measures = {{"force", 2, 1}, {"effective_modulus", 0, 1}};
      if (!clamped && cell_law) drawn.law = drawn.stiffness;
      break;
    }
    case 1:
      drawn.experiment =
          std::string("kind: shear, direction: ") + draw.pick({"x", "y"}) + (cell_law ? ", sides: affine" : "");
      drawn.driven = "displacement", drawn.amount = strain * height;
      drawn.measures = {{"shear_modulus", 0, 1}, {"force", 2, 1}};
      if (drawn.stiffness == "neo_hookean") drawn.law = "shear";
      break;
    case 2:
      drawn.experiment = "kind: torsion";
      drawn.driven = "angle", drawn.amount = draw.between(0.05, 0.6);
      drawn.measures = {{"torque", 3, 1}};
      break;
    case 3:
      drawn.experiment = "kind: hydrostatic, sides: affine";
      drawn.driven = "strain", drawn.amount = strain / 2;
      drawn.measures = {{"bulk_modulus", 0, 1}};
      break;
    case 4:
      drawn.experiment = std::string("kind: tension, fixed_grip: ") + draw.pick({"clamped", "sliding"});
      drawn.driven = "force", drawn.amount = 0;  // set with the units
      drawn.measures = {{"elongation", 1, 0}};
      break;
    default:
      drawn.experiment = std::string("kind: indentation, indenter: {sphere: {radius: ") + text(2 * height) + "}}";
      drawn.driven = "depth", drawn.amount = draw.between(0.01, 0.06) * height;
      drawn.contact = draw.yes() ? "contact: {friction: 0.4}\n" : "contact: {friction: 0}\n";
      drawn.touches = true;
      if (drawn.stiffness.starts_with("calibrated:")) drawn.stiffness = drawn.stiffness.substr(11);
      drawn.measures = {{"force", 2, 1}, {"depth", 1, 0}};
  }
}

void draw_in_time(Draw& draw, double length, double stress, Drawn& drawn) {
  const double speed = std::sqrt(stress / 1000), while_passing = length / speed;  // of density 1000 kg/m³
  drawn.at_rest = false;
  if (drawn.stiffness.starts_with("calibrated:")) drawn.stiffness = drawn.stiffness.substr(11);
  if (const auto second = drawn.body.find(", order: 2"); second != std::string::npos) drawn.body.erase(second, 10);
  if (draw.yes()) {
    drawn.experiment = "kind: release, load: removed, fixture: {kind: tension, displacement: " +
                       text(draw.between(0.005, 0.05) * drawn.height) + "}";
    drawn.measures = {{"energy_drift", 0, 0}};
  } else {
    drawn.experiment = "kind: drop, speed: " + text(draw.between(0.02, 0.08) * speed);
    drawn.touches = draw.yes();
    if (drawn.touches)
      drawn.contact = "contact: {friction: " + std::string(draw.pick({"0", "0.3"})) +
                      ", restitution: " + draw.pick({"1", "0.5"}) + ", obstacles: [{plane: {point: [0, 0, " +
                      text(-draw.between(0.6, 0.8) * length * 2) + "], normal: [0, 0, 1]}}]}\n";
    drawn.measures = {{"restitution", 0, 0}};
  }
  const double duration = draw.between(20, 40) * while_passing;
  const std::string scheme = draw.pick({"velocity_verlet", "newmark", "backward_euler"});
  drawn.time = "time: {duration: " + text(duration) + ", frames: 20, integrator: " + scheme +
               (scheme == "velocity_verlet" ? "" : ", step: " + text(duration / 400)) + "}\n";
}

/// Scene number `scene`, lengths of about `length` [m] and moduli of about `stress` [Pa].
Drawn drawn_scene(int scene, double length, double stress) {
  Draw draw(scene);
  Drawn drawn;
  draw_body(draw, length, drawn);
  drawn.youngs_modulus = stress * draw.between(0.5, 2);
  drawn.poissons_ratio = draw.between(0, 0.45);
  drawn.material = "{youngs_modulus: " + text(drawn.youngs_modulus) +
                   ", poissons_ratio: " + text(drawn.poissons_ratio) + ", density: 1000}";
  if (draw.below(5) == 0) {
    draw_in_time(draw, length, stress, drawn);
  } else {
    draw_at_rest(draw, drawn);
    const double weight = 0.02 * stress / 1000 / drawn.height;
    drawn.loaded = !drawn.touches && draw.below(4) == 0;
    if (drawn.loaded)
      drawn.loads =
          "loads: [{gravity: {acceleration: " + vector_text(Vector3(0, 0, weight * draw.between(-1, 1))) + "}}]\n";
    if (drawn.driven == "force") drawn.amount = draw.between(-0.03, 0.06) * drawn.youngs_modulus * std::pow(length, 2);
  }
  drawn.solver = std::string("linear_solver: ") +
                 (drawn.at_rest ? draw.pick({"automatic", "pcg", "direct", "multigrid"}) : "automatic");
  return drawn;
}

Run run_of(const Drawn& drawn, const std::vector<std::string>& overrides = {}) {
  static const Catalog catalog = built_in_catalog();
  const TemporaryFolder folder;
  const std::string whole = drawn.at_rest
                                ? drawn.scene()
                                : "title: drawn\nbody: " + drawn.body + "\nmaterial: " + drawn.material +
                                      "\nstiffness: " + drawn.stiffness + "\nexperiment: {" + drawn.experiment + "}\n" +
                                      drawn.contact + drawn.time + drawn.rotate + "solver: {" + drawn.solver + "}\n";
  INFO(whole);
  const auto scene = load_scene(folder.write("scene.yaml", whole), catalog, overrides);
  RunOptions options;
  options.time = scene->time;
  options.statics = scene->statics;
  prepare(scene->specimen, scene->stiffness.strategy);
  return run_strategy(scene->specimen, *scene->experiment, scene->stiffness, options);
}

/// The same measures, each times lengthᵃ stressᵇ.
void check_same(const Drawn& drawn, const Run& run, const Run& other, double length, double stress, double tolerance) {
  INFO(other.cause);
  REQUIRE(other.outcome == run.outcome);
  for (const Judged& judged : drawn.measures) {
    const double scale = std::pow(length, judged.length) * std::pow(stress, judged.stress);
    INFO(judged.name);
    CHECK(other.measures.get(judged.name) == Approx(scale * run.measures.get(judged.name)).epsilon(tolerance));
  }
}

/// Nominal stress of a bar at a stretch, its sides free.
double uniaxial(const Drawn& drawn, double stretch) {
  const double E = drawn.youngs_modulus, nu = drawn.poissons_ratio;
  if (drawn.law == "st_venant_kirchhoff") return E / 2 * (stretch * stretch - 1) * stretch;
  const double mu = E / (2 * (1 + nu)), lambda = E * nu / ((1 + nu) * (1 - 2 * nu));
  double low = 0.5, high = 2;  // the stretch across: S = λ J (J − 1)/w² + μ (1 − 1/w²) = 0, J = stretch w²
  for (int halving = 0; halving < 80; ++halving) {
    const double w = (low + high) / 2, J = stretch * w * w;
    (lambda * J * (J - 1) + mu * (w * w - 1) < 0 ? low : high) = w;
  }
  const double J = stretch * low * low;
  return lambda * J * (J - 1) / stretch + mu * (stretch - 1 / stretch);
}

void check_at_rest(const Drawn& drawn, int scene, const Run& run) {
  CHECK(run.residual < 1e-8);
  const double balance = run.measures.get("reaction_balance");
  if (std::isfinite(balance)) CHECK(balance < 1e-6);
  if (!drawn.law.empty() && !drawn.loaded) {
    if (drawn.law == "shear")
      CHECK(run.measures.get("shear_modulus") ==
            Approx(drawn.youngs_modulus / (2 * (1 + drawn.poissons_ratio))).epsilon(1e-7));
    else
      CHECK(run.measures.get("stress") == Approx(uniaxial(drawn, 1 + drawn.amount / drawn.height)).epsilon(1e-7));
  }
  Drawn other = drawn;
  switch (scene % 4) {
    case 0: {  // the same scene of a kilometre or a millimetre, of jelly or steel
      const double length = scene % 8 ? 1e4 : 1e-2, stress = scene % 3 ? 1e6 : 1e-2;
      const Drawn scaled = drawn_scene(scene, length, 1e4 * stress);
      return check_same(drawn, run, run_of(scaled), length, stress, 1e-6);
    }
    case 1:
      other.rotate = "rotate: {axis: [1, 2, -0.5], angle: " + text(0.3 + scene) + "}\n";
      return check_same(drawn, run, run_of(other), 1, 1, 1e-6);
    case 2:
      for (const char* solver : {"pcg", "direct", "multigrid"}) {
        other.solver = std::string("linear_solver: ") + solver;
        check_same(drawn, run, run_of(other), 1, 1, 1e-6);
      }
      return;
    default:
      if (drawn.touches || drawn.loaded) return;
      if (drawn.driven == "displacement" && drawn.experiment.find("tension") != std::string::npos) {
        // F = dE/du, by central differences.
        const double step = 1e-3 * drawn.amount;
        other.amount = drawn.amount + step;
        const double above = run_of(other).measures.get("energy");
        other.amount = drawn.amount - step;
        const double below = run_of(other).measures.get("energy");
        CHECK(run.measures.get("force") == Approx((above - below) / (2 * step)).epsilon(1e-4));
        return;
      }
      // Small displacements: twice the load, twice the answer.
      other.solver += ", displacements: small";
      const Run one = run_of(other);
      other.amount *= 2;
      const Run two = run_of(other);
      REQUIRE(one.outcome == Outcome::converged);
      for (const Judged& judged : drawn.measures) {
        const bool a_modulus = judged.name.find("modulus") != std::string::npos;
        INFO(judged.name);
        CHECK(two.measures.get(judged.name) ==
              Approx((a_modulus ? 1 : 2) * one.measures.get(judged.name)).epsilon(1e-6));
      }
  }
}

void check_in_time(const Drawn& drawn, const Run& run) {
  // Energy is kept, or lost by what may lose it; where the steps make some from nothing, the run says so.
  double most = 0, largest = 0;
  for (const CurvePoint& row : run.curve) {
    const Measures& m = row.measures;
    most = std::max(most, m.get("energy_balance"));
    largest = std::max(largest, m.get("kinetic_energy") + m.get("energy"));
  }
  const bool said = std::any_of(run.warnings.begin(), run.warnings.end(), [](const std::string& warning) {
    return warning.find("the steps make energy from nothing") != std::string::npos;
  });
  CHECK(said == (most > 0.05 * largest));
  const bool loses =
      drawn.time.find("backward_euler") != std::string::npos ||
      (std::isfinite(run.measures.get("restitution")) && drawn.time.find("newmark") != std::string::npos);
  if (!loses && !said) CHECK(run.measures.get("energy_drift") < 0.05);
  const double restitution = run.measures.get("restitution");
  if (std::isfinite(restitution)) CHECK(restitution < 1.02);
}

void check_scene(int scene) {
  const Drawn drawn = drawn_scene(scene, 1, 1e4);
  const Run run = run_of(drawn);
  INFO("scene " << scene << "\n" << drawn.scene() << run.cause);
  REQUIRE(run.suited);
  REQUIRE(run.outcome == Outcome::converged);
  if (drawn.at_rest)
    check_at_rest(drawn, scene, run);
  else
    check_in_time(drawn, run);
}

}  // namespace

TEST_CASE("scenes drawn at random: every fifth of a hundred", "[lab][slow]") {
  for (int scene = 0; scene < kScenes; scene += 5) DYNAMIC_SECTION("scene " << scene) {
      check_scene(scene);
    }
}

TEST_CASE("scenes drawn at random: all hundred", "[.][random]") {
  for (int scene = 0; scene < kScenes; ++scene) DYNAMIC_SECTION("scene " << scene) {
      check_scene(scene);
    }
}
