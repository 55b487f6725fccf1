// Scenes drawn at random from the language: bodies × laws × wrappers × experiments × steppers, each with consequences
// that need no reference. The same scene in other units, turned about any axis, in another numbering, by another
// solver, by a wrapper that does nothing at rest, has the same measures; loads and reactions balance; the force is the
// slope of the energy; what is even has the law's own closed form; no energy comes from nothing. What cannot be solved
// says why.
//
// Some twenty scenes run always, ELASTIN_RANDOM_SCENES=N of them from number ELASTIN_RANDOM_FROM on by
// `elastin_tests [random]`.

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <optional>
#include <random>
#include <set>

#include "elastin/core/base/error.h"
#include "elastin/core/model/renumbered.h"
#include "lab/run/specimen.h"
#include "lab/scene/scene.h"
#include "support/law_constants.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;
using testing::kCatalog;

namespace {

/// The same numbers with every library.
class Draw {
 public:
  explicit Draw(int scene) : generator_(20250u + static_cast<unsigned>(scene)) {}
  int below(int count) { return static_cast<int>(generator_() % static_cast<std::uint64_t>(count)); }
  bool yes() { return below(2) == 1; }
  double between(double low, double high) {
    return low + (high - low) * static_cast<double>(generator_() >> 11) * 0x1p-53;
  }
  std::string pick(std::initializer_list<const char*> choices) {
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
std::string text(const Vector3& v) { return "[" + text(v[0]) + ", " + text(v[1]) + ", " + text(v[2]) + "]"; }

/// Lengths of about `length` [m] and moduli of about `stress` [Pa]; the density is 1000 kg/m³ in all.
struct Units {
  double length = 1, stress = 1e4;
  double time() const { return length * std::sqrt(1000 / stress); }
  double force() const { return stress * length * length; }
  /// [SI] of a measure of this dimension.
  double of(const Dimension& d) const {
    return std::pow(length, d.length) * std::pow(1000 * std::pow(length, 3), d.mass) * std::pow(time(), d.time);
  }
};

enum class Kind { springs, cells, second_order, sheet };

/// The parts of a scene, and what is known of it.
struct Drawn {
  std::string body, material, stiffness, experiment, more, time, rotate, solver = "linear_solver: automatic";
  Kind kind = Kind::cells;
  std::string driven;  ///< key of the displacement that the experiment prescribes; "": another load
  double amount = 0, height = 0, youngs_modulus = 0, poissons_ratio = 0;
  std::string resistance;  ///< the measure that is the slope of the energy in it
  bool even = false;       ///< the strain is the same everywhere
  std::string experiment_text() const {
    return "{" + experiment + (driven.empty() ? "" : ", " + driven + ": " + text(amount)) + "}";
  }
  std::string scene() const {
    return "title: drawn\nbody: " + body + "\nmaterial: {" + material + "}\nstiffness: \"" + stiffness +
           "\"\nexperiment: " + experiment_text() + "\n" + more + time + rotate + "solver: {" + solver + "}\n";
  }
};

std::string cells_text(Draw& draw, const std::array<int, 3>& counts, const Vector3& size, int order) {
  return "{tetrahedra: {kind: " + draw.pick({"kuhn", "alternating", "body_centred"}) + ", cubes: [" +
         std::to_string(counts[0]) + ", " + std::to_string(counts[1]) + ", " + std::to_string(counts[2]) +
         "], size: " + text(size) + ", order: " + std::to_string(order) + "}";
}

void draw_body(Draw& draw, const Units& units, Drawn& drawn) {
  const double h = units.length * draw.between(0.5, 2);
  const std::array<int, 3> counts{2 + draw.below(2), 2 + draw.below(2), 3 + draw.below(2)};
  const std::string molecules = std::to_string(counts[0] + 1) + ", " + std::to_string(counts[1] + 1) + ", " +
                                std::to_string(counts[2] + 1),
                    jitter = draw.yes() ? ", jitter: {amount: " + text(draw.between(0.01, 0.12)) + "}" : "";
  drawn.height = h * counts[2];
  switch (draw.below(6)) {
    case 0:
      drawn.kind = Kind::springs;
      drawn.body = "{lattice: {kind: cubic, molecules: [" + molecules + "], spacing: " + text(h) +
                   ", connections: " + draw.pick({"[axis, face]", "[axis, face, space]"}) + "}" + jitter + "}";
      break;
    case 1:
      drawn.kind = Kind::sheet;
      drawn.height = 4 * h;
      drawn.body = "{sheet: {size: [" + text(3 * h) + ", " + text(4 * h) +
                   "], squares: [3, 4], pattern: " + draw.pick({"alternating", "one_way", "crossed"}) + "}}";
      break;
    case 2:
      drawn.kind = Kind::second_order;
      drawn.body = draw.yes() ? cells_text(draw, {1, 1, 2}, h * Vector3(counts[0], counts[1], counts[2]), 2) + "}"
                              : "{lattice: {kind: cubic, molecules: [2, 3, 3], order: 2, spacing: " +
                                    text(h / 2 * Vector3(counts[0], counts[1], counts[2])) + "}" + jitter + "}";
      break;
    case 3:
      drawn.kind = Kind::second_order;  // by its strategies, the cells are of first order
      drawn.body =
          "{lattice: {kind: cubic, molecules: [" + molecules + "], order: 1, spacing: " + text(h) + "}" + jitter + "}";
      break;
    default:
      drawn.body = cells_text(draw, counts, h * Vector3(counts[0], counts[1], counts[2]), 1) + jitter + "}";
  }
}

/// Plain E and ν, or a law with constants of its own.
void draw_material(Draw& draw, const Units& units, Drawn& drawn) {
  drawn.youngs_modulus = units.stress * draw.between(0.5, 2);
  drawn.poissons_ratio = draw.between(0, 0.45);
  const auto constants = testing::law_constants(units.stress / 1e4);
  auto law = constants.begin();
  std::advance(law, draw.below(static_cast<int>(constants.size())));
  const bool plain = drawn.kind == Kind::springs || drawn.kind == Kind::sheet || draw.yes();
  drawn.material = "density: 1000";
  if (plain || law->second.numbers.empty())
    drawn.material +=
        ", youngs_modulus: " + text(drawn.youngs_modulus) + ", poissons_ratio: " + text(drawn.poissons_ratio);
  if (!plain) {
    const LawConstants& own = law->second;
    drawn.material += ", law: " + own.law;
    for (const auto& [name, value] : own.numbers) drawn.material += ", " + name + ": " + text(value);
    for (const auto& [name, value] : own.directions) drawn.material += ", " + name + ": " + text(value);
    for (const auto& [name, value] : own.words) drawn.material += ", " + name + ": " + value;
    for (std::size_t i = 0; i < own.terms.size(); ++i) {
      drawn.material += (i ? ", " : ", terms: [") +
                        (own.terms[i].size() > 1 ? "[" + text(own.terms[i][0]) + ", " + text(own.terms[i][1]) + "]"
                                                 : text(own.terms[i][0]));
      if (i + 1 == own.terms.size()) drawn.material += "]";
    }
    drawn.stiffness = own.law;
  } else if (drawn.kind == Kind::springs) {
    drawn.stiffness = draw.pick({"standard", "statistical", "calibrated:standard", "lattice", "patch", "divided",
                                 "angles", "angles_update", "voronoi", "lattice+volume", "calibrated:patch"});
  } else if (drawn.kind == Kind::sheet) {
    drawn.material += ", thickness: " + text(0.05 * units.length);
    drawn.stiffness = draw.pick({"st_venant_kirchhoff_membrane", "neo_hookean_membrane", "curve_membrane", "van_gelder",
                                 "hencky_energy_membrane", "hencky_membrane", "two_parameter", "calibrated:lloyd",
                                 "neo_hookean_membrane+wrinkling"});
  } else if (drawn.kind == Kind::second_order) {
    drawn.stiffness = draw.pick({"neo_hookean", "st_venant_kirchhoff", "neo_hookean_log", "neo_hookean+volume"});
  } else {
    drawn.stiffness =
        draw.pick({"neo_hookean", "st_venant_kirchhoff", "neo_hookean_log", "van_gelder", "calibrated:van_gelder",
                   "lloyd", "neo_hookean+volume", "van_gelder+volume", "standard", "curve", "patch"});
  }
  if (!plain && drawn.kind == Kind::second_order && draw.yes() && drawn.stiffness != "neo_hookean_log")
    drawn.stiffness += "+volume";
}

/// What does nothing at rest, or in a load that only grows.
std::string wrapped(const std::string& wrapper, const Units& units, Drawn& drawn) {
  drawn.material += wrapper == "prony:" ? ", relaxation: {terms: [[0.4, " + text(2 * units.time()) + "]]}"
                                        : ", softening: {r: 2, m: " + text(0.01 * units.stress) + "}";
  return wrapper + drawn.stiffness;
}

void draw_at_rest(Draw& draw, const Units& units, Drawn& drawn) {
  const double strain = draw.between(0.002, 0.06) * (draw.yes() ? 1 : -1), force = 0.02 * strain * units.force();
  const bool sheet = drawn.kind == Kind::sheet;
  const auto drive = [&](const char* key, double amount, const char* resistance) {
    drawn.driven = key, drawn.amount = amount, drawn.resistance = resistance;
  };
  switch (draw.below(sheet ? 3 : 11)) {
    case 0: {
      const bool clamped = draw.yes();
      drawn.experiment = std::string("kind: tension, axis: ") + (sheet ? "y" : "z") +
                         (sheet ? ", cross_section: " + text(0.1 * units.length * units.length) : "") +
                         (clamped ? ", fixed_grip: clamped, loaded_grip: clamped" : "");
      drawn.even = !clamped;
      return drive("displacement", (sheet ? std::abs(strain) : strain) * drawn.height, "force");
    }
    case 1:
      drawn.experiment = "kind: biaxial, strain: [" + text(std::abs(strain)) + ", " + text(std::abs(strain) / 2) + "]";
      return;
    case 2:
      drawn.experiment = std::string("kind: planar, strain: ") + text(std::abs(strain));
      return;
    case 3:
      drawn.experiment = "kind: shear, direction: " + draw.pick({"x", "y"}) + draw.pick({"", ", sides: affine"});
      return drive("displacement", strain * drawn.height, "force");
    case 4:
      drawn.experiment = "kind: torsion";
      return drive("angle", draw.between(0.05, 0.4), "torque");
    case 5:
      drawn.experiment = "kind: hydrostatic, sides: " + draw.pick({"sliding", "affine"});
      return drive("strain", strain / 2, "");
    case 6:
      drawn.experiment = "kind: bending, axis: z, direction: x, force: " + text(force / 20);
      return;
    case 7:
      drawn.experiment = "kind: material";
      return;
    case 8:
      drawn.experiment = "kind: compression, fixed_grip: clamped, force: " + text(std::abs(force));
      return;
    case 9:
      drawn.experiment = "kind: vibration, count: 4" +
                         draw.pick({"",
                                    ", fixture: {kind: tension, fixed_grip: clamped, loaded_grip: clamped, strain: "
                                    "0.01}"});
      return;
    default:
      drawn.experiment = "kind: indentation, indenter: {sphere: {radius: " + text(2 * drawn.height) + "}}";
      drawn.more = "contact: {friction: " + draw.pick({"0", "0.4"}) + "}\n";
      drawn.driven = "depth", drawn.amount = std::abs(strain) * drawn.height;
  }
}

void draw_in_time(Draw& draw, const Units& units, Drawn& drawn) {
  const double t = units.time(), duration = draw.between(8, 15) * t, strain = draw.between(0.002, 0.03);
  const std::string pulled =
                        "fixture: {kind: tension, fixed_grip: clamped, displacement: " + text(strain * drawn.height) +
                        "}",
                    loaded =
                        "fixture: {kind: tension, fixed_grip: clamped, force: " + text(0.02 * strain * units.force()) +
                        "}";
  if (drawn.stiffness.starts_with("calibrated:")) drawn.stiffness = drawn.stiffness.substr(11);
  switch (draw.below(8)) {
    case 0:
      drawn.experiment = "kind: release, load: removed, " + pulled;
      break;
    case 1:
      drawn.experiment = "kind: release, load: applied, " + loaded;
      break;
    case 2:
      drawn.experiment = "kind: creep, " + loaded;
      break;
    case 3:
      drawn.experiment = "kind: relaxation, ramp: " + text(t) + ", " + pulled;
      break;
    case 4:
      drawn.experiment = "kind: cyclic, frequency: " + text(3 / duration) + ", " + pulled;
      break;
    case 5:
      drawn.experiment = "kind: shake, axis: z, direction: x, frequency: " + text(0.2 / t) +
                         ", amplitude: " + text(strain * drawn.height);
      break;
    case 6:
      drawn.experiment = "kind: motion, in_time: {ramp: {duration: " + text(4 * t) + "}}, " + pulled;
      break;
    default:
      drawn.experiment = "kind: drop, speed: " + text(draw.between(0.02, 0.08) * units.length / t);
      if (draw.yes()) {
        drawn.more = "contact: {friction: " + draw.pick({"0", "0.3"}) + ", restitution: " + draw.pick({"1", "0.5"}) +
                     ", obstacles: [{plane: {point: [0, 0, " + text(-draw.between(0.6, 0.8) * units.length * 2) +
                     "], normal: [0, 0, 1]}}]}\n";
      }
  }
  if (const int wrapper = draw.below(4); wrapper < 2)
    drawn.stiffness = wrapped(wrapper ? "prony:" : "mullins:", units, drawn);
  if (draw.below(3) == 0) drawn.more += "loads: [{rayleigh: {stiffness: " + text(draw.between(0.01, 0.3) * t) + "}}]\n";
  drawn.time = "time: {duration: " + text(duration) + ", frames: 60, stepper: " +
               draw.pick({"velocity_verlet", "symplectic_euler", "newmark", "backward_euler", "generalized_alpha",
                          "energy_momentum", "block_descent", "projective"}) +
               ", step: {per_frame: " + text(4 + draw.below(8)) + "}}\n";
}

Drawn drawn_scene(int scene, const Units& units) {
  Draw draw(scene);
  Drawn drawn;
  draw_body(draw, units, drawn);
  draw_material(draw, units, drawn);
  if (drawn.kind != Kind::sheet && draw.below(3) == 0)
    draw_in_time(draw, units, drawn);
  else
    draw_at_rest(draw, units, drawn);
  return drawn;
}

/// None where the language or a strategy refuses the scene, with a sentence.
std::optional<Run> run_of(const Drawn& drawn, const std::function<void(Body&)>& change = {},
                          std::shared_ptr<const MeasureList>* measures = nullptr) {
  const TemporaryFolder folder;
  std::optional<Run> run;
  std::string why;
  try {
    const auto scene =
        load_scene_on(folder.write("scene.yaml", drawn.scene()), kCatalog, {}, [&](Body& body, const Material&) {
          if (change) change(body);
        });
    RunOptions options;
    options.time = scene->time;
    options.statics = scene->statics;
    if (measures) *measures = scene->measures;
    prepare(scene->specimen, scene->stiffness.strategy);
    run = run_strategy(scene->specimen, *scene->experiment, scene->stiffness, options);
    why = run->cause;
  } catch (const InputError& error) {
    why = error.what();
  }
  if (!run || !run->suited) {
    CHECK(why.size() > 20);
    return std::nullopt;
  }
  return run;
}

/// Numbers that are rounding, errors, or counts that rounding may change.
bool is_judged(const std::string& name) {
  static const std::set<std::string> others{"energy_balance", "energy_drift",    "reaction_balance", "fit_misfit",
                                            "cycle_change",   "sine_misfit",     "contacts",         "sticking",
                                            "curve_error",    "pressure_spread", "isotropy_error"};
  return !others.contains(name);
}

/// A run that says so may have ended in another equilibrium than the next.
bool at_saddle(const Run& run) {
  return std::any_of(run.warnings.begin(), run.warnings.end(), [](const std::string& warning) {
    return warning.find("the equilibrium is not stable") != std::string::npos;
  });
}

struct Checked {
  Drawn drawn;
  Units units;
  Run run;
  std::shared_ptr<const MeasureList> measures;

  /// Another run has the same measures, in its own units.
  void same(const std::optional<Run>& other, const Units& others, double tolerance,
            const std::string& but_for = "") const {
    REQUIRE(other);
    INFO(other->cause);
    REQUIRE(other->outcome == run.outcome);
    if (run.outcome != Outcome::converged || at_saddle(run) || at_saddle(*other)) return;
    for (const auto& [name, value] : run.measures.all()) {
      const MeasureInfo* info = measures->find(name);
      if (!info || !is_judged(name) || name == but_for) continue;
      const double own = value / units.of(info->unit), theirs = other->measures.get(name) / others.of(info->unit);
      INFO(name << ": " << own << " and " << theirs);
      CHECK(std::abs(own - theirs) <= tolerance * (std::abs(own) + 1e-3));
    }
  }
};

void check_at_rest(const Checked& checked) {
  const auto& [drawn, units, run, measures] = checked;
  CHECK(run.residual < 1e-6);
  if (const double balance = run.measures.get("reaction_balance"); std::isfinite(balance)) CHECK(balance < 1e-6);
  const bool solid = drawn.kind == Kind::cells || drawn.kind == Kind::second_order;
  const bool law_of_material = drawn.stiffness.find("law") == std::string::npos &&
                               (drawn.stiffness == "neo_hookean" || drawn.stiffness == "st_venant_kirchhoff");
  if (!drawn.even || !solid || !law_of_material || drawn.material.find("law:") != std::string::npos) return;
  // A bar at a stretch, its sides free.
  const double stretch = 1 + drawn.amount / drawn.height, E = drawn.youngs_modulus, nu = drawn.poissons_ratio,
               mu = E / (2 * (1 + nu)), lambda = E * nu / ((1 + nu) * (1 - 2 * nu));
  double expected = E / 2 * (stretch * stretch - 1) * stretch;
  if (drawn.stiffness == "neo_hookean") {
    double low = 0.5, high = 2;  // the stretch across: S = λ J (J − 1)/w² + μ (1 − 1/w²) = 0, J = stretch w²
    for (int halving = 0; halving < 80; ++halving) {
      const double w = (low + high) / 2, J = stretch * w * w;
      (lambda * J * (J - 1) + mu * (w * w - 1) < 0 ? low : high) = w;
    }
    const double J = stretch * low * low;
    expected = lambda * J * (J - 1) / stretch + mu * (stretch - 1 / stretch);
  }
  CHECK(run.measures.get("stress") == Approx(expected).epsilon(1e-6));
}

/// Energy is kept, or lost by what may lose it; where the steps make some from nothing, the run says so.
void check_in_time(const Run& run) {
  double most = 0, largest = 0;
  for (const CurvePoint& row : run.curve) {
    const Measures& m = row.measures;
    const double stored = std::isfinite(m.get("energy")) ? m.get("energy") : 0;
    most = std::max(most, m.get("energy_balance"));
    largest =
        std::max({largest, m.get("kinetic_energy") + stored, std::abs(m.get("work")), m.get("dissipated_energy")});
  }
  const bool said = std::any_of(run.warnings.begin(), run.warnings.end(), [](const std::string& warning) {
    return warning.find("the steps make energy from nothing") != std::string::npos;
  });
  if (most > 0.06 * largest) CHECK(said);
  const double restitution = run.measures.get("restitution");
  if (std::isfinite(restitution) && !said) CHECK(restitution < 1.02);
  if (const double damping = run.measures.get("damping_ratio"); std::isfinite(damping) && !said) CHECK(damping > -0.02);
  if (const double loss = run.measures.get("loss_tangent"); std::isfinite(loss) && !said) CHECK(loss > -0.02);
}

void check_scene(int scene) {
  Checked checked{drawn_scene(scene, {}), {}, {}, {}};
  const Drawn& drawn = checked.drawn;
  INFO("scene " << scene << "\n" << drawn.scene());
  const std::optional<Run> run = run_of(drawn, {}, &checked.measures);
  if (!run) return;
  checked.run = *run;
  INFO(run->cause);
  if (run->outcome != Outcome::converged) {
    CHECK(run->cause.size() > 20);
  } else if (drawn.time.empty()) {
    check_at_rest(checked);
  } else {
    check_in_time(*run);
  }
  Drawn other = drawn;
  const bool touches = drawn.more.find("contact") != std::string::npos, timed = !drawn.time.empty();
  // Where something bounces or slips the digits of a path are no digits of the next.
  const double tolerance = touches ? 1e-3 : timed ? 1e-5 : 1e-6;
  switch (scene % 5) {
    case 0: {  // the same scene of a kilometre or a millimetre, of jelly or steel
      const Units units{scene % 2 ? 1e4 : 1e-2, scene % 3 ? 1e10 : 1e2};
      return checked.same(run_of(drawn_scene(scene, units)), units, tolerance);
    }
    case 1:
      other.rotate = "rotate: {axis: [1, 2, -0.5], angle: " + text(0.3 + scene) + "}\n";
      return checked.same(run_of(other), {}, tolerance);
    case 2: {
      bool done = false;
      const auto renumbered = run_of(other, [&](Body& body) {
        if (body.parts.empty() && body.between.empty()) body = numbered_in_space(body).body, done = true;
      });
      // Sweeps over molecules go by their numbers.
      if (done && drawn.time.find("block_descent") == std::string::npos) checked.same(renumbered, {}, tolerance);
      return;
    }
    case 3:
      if (timed || run->outcome != Outcome::converged) return;
      if (scene % 2 == 0 && drawn.stiffness.find("calibrated") == std::string::npos) {  // what does nothing at rest
        other.stiffness = wrapped(scene % 4 ? "prony:" : "mullins:", {}, other);
        // What has softened gives back less than was stored.
        if (const auto same = run_of(other)) checked.same(same, {}, tolerance, scene % 4 ? "" : "energy");
        return;
      }
      for (const char* solver : {"pcg", "direct", "multigrid"}) {
        other.solver = std::string("linear_solver: ") + solver;
        checked.same(run_of(other), {}, tolerance);
      }
      return;
    default:
      if (drawn.resistance.empty() || timed || !std::isfinite(run->measures.get("energy"))) return;
      // The force, or the torque, is the slope of the energy: by central differences.
      const double step = 1e-3 * drawn.amount;
      other.amount = drawn.amount + step;
      const auto above = run_of(other);
      other.amount = drawn.amount - step;
      const auto below = run_of(other);
      REQUIRE((above && below));
      CHECK(run->measures.get(drawn.resistance) ==
            Approx((above->measures.get("energy") - below->measures.get("energy")) / (2 * step)).epsilon(1e-4));
  }
}

int number_from(const char* variable, int usual) {
  const char* value = std::getenv(variable);
  return value ? std::atoi(value) : usual;
}

}  // namespace

TEST_CASE("scenes drawn at random", "[lab][slow]") {
  for (int scene = 10; scene < 30; ++scene) DYNAMIC_SECTION("scene " << scene) {
      check_scene(scene);
    }
}

TEST_CASE("scenes drawn at random: as many as the environment says", "[.][random]") {
  const int from = number_from("ELASTIN_RANDOM_FROM", 0), count = number_from("ELASTIN_RANDOM_SCENES", 200);
  for (int scene = from; scene < from + count; ++scene) DYNAMIC_SECTION("scene " << scene) {
      check_scene(scene);
    }
}
