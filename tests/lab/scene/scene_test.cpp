#include "lab/scene/scene.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "config/scene_text.h"
#include "elastin/core/shapes/shapes.h"
#include "lab/scene/identify.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

namespace {

const std::string kScene = R"(title: A scene that is right
body:
  lattice: {kind: cubic, molecules: [3, 3, 3], spacing: 7.5 mm, connections: [axis, face]}
  radius: 3 mm
material: {youngs_modulus: 5 kPa, poissons_ratio: 0.25, density: 1000 kg/m3}
rotate: {axis: [1, 0, 0], angle: 30 deg}
stiffness: standard
strategies: [standard, {strategy: divided, divisor: 3.75, label: halved}]
experiment:
  kind: tension
  axis: z
  force: 1 mN
  fixed_grip: clamped
  load_steps: 2
solver: {tolerance: 1e-9}
loads:
  - gravity: [0, 0, -9.81 m/s2]
  - stokes_drag: {viscosity: 1 mPa s}
  - point: {molecules: [26], force: [0 N, 0 N, 1 uN]}
  - face: {side: z, traction: [1 Pa, 0, 0]}
expect:
  - {strategy: halved, measure: effective_modulus, value: 5 kPa, tolerance: 1 %, source: pen and paper}
reference:
  - {measure: poissons_ratio, value: 0.25, source: pen and paper}
)";

const std::string kLattice = "lattice: {kind: cubic, molecules: [3, 3, 3], spacing: 7.5 mm, connections: [axis, face]}";
const std::string kGravity = "gravity: [0, 0, -9.81 m/s2]";

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  const std::size_t at = text.find(what);
  REQUIRE(at != std::string::npos);
  return text.replace(at, what.size(), by);
}

std::unique_ptr<Scene> load(const std::string& path, const std::vector<std::string>& overrides = {}) {
  return load_scene(path, built_in_catalog(), overrides);
}

/// The message with which a scene is refused; "" if it is not.
std::string refusal(const std::string& path, const std::vector<std::string>& overrides = {}) {
  try {
    load(path, overrides);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

/// Takes the '@' out of a text; returns ":line:column" of what stood behind it, counted from 1. Without one, the start.
std::string take_location(std::string& text) {
  const std::size_t at = text.find('@');
  if (at == std::string::npos) return ":1:1";
  text.erase(at, 1);
  const auto line = std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n') + 1;
  const std::size_t line_start = at == 0 ? 0 : text.rfind('\n', at - 1) + 1;
  return ":" + std::to_string(line) + ":" + std::to_string(at - line_start + 1);
}

std::size_t occurrences(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

/// One mistake: what stands in kScene, what somebody wrote instead ('@' before the place that the message must name),
/// the path of keys that the message starts with, and what else it must say.
struct Slip {
  std::string right, wrong, path;
  std::vector<std::string> says;
};

void check_slips(const std::vector<Slip>& slips) {
  const TemporaryFolder folder;
  for (const Slip& slip : slips) {
    INFO(slip.wrong);
    std::string text = replaced(kScene, slip.right, slip.wrong);
    const std::string location = take_location(text), path = folder.write("slip.yaml", text);
    const std::string message = refusal(path);
    CHECK_THAT(message, StartsWith(path + location + ": " + slip.path));
    for (const std::string& part : slip.says) CHECK_THAT(message, Contains(part));
    CHECK(occurrences(message, path + location) == 1);
    const std::string keys = slip.path.substr(0, slip.path.find(':'));
    if (keys.find_first_of(".[") != std::string::npos) CHECK(occurrences(message, keys) == 1);
  }
}

}  // namespace

TEST_CASE("a scene is read as it is written", "[scene]") {
  const TemporaryFolder folder;
  const auto scene = load(folder.write("right.yaml", kScene));
  CHECK(scene->name == "right");
  CHECK(scene->title == "A scene that is right");
  CHECK(scene->specimen.body.size() == 27);
  CHECK(scene->specimen.body.radius.minCoeff() == Approx(3e-3));
  CHECK(scene->specimen.body.radius.maxCoeff() == Approx(3e-3));
  CHECK(scene->specimen.material.youngs_modulus == Approx(5000));
  CHECK(scene->stiffness.label == "standard");
  REQUIRE(scene->strategies.size() == 2);
  CHECK(scene->strategies[1].label == "halved");
  CHECK(scene->strategies[1].strategy.name == "divided");
  CHECK(scene->strategies[1].values.at("divisor") == 3.75);
  CHECK(scene->experiment->at_rest()->load_steps() == 2);
  CHECK(scene->statics.tolerance == 1e-9);
  CHECK(scene->specimen.loads.size() == 4);
  REQUIRE(scene->expectations.size() == 1);
  CHECK(scene->expectations[0].strategy == "halved");
  CHECK(scene->expectations[0].relative == Approx(0.01));
  CHECK(scene->references.size() == 1);
  REQUIRE(scene->warnings.size() == 1);
  CHECK_THAT(scene->warnings[0], StartsWith("loads[1]: acts on moving bodies only"));
  // 30° about x take z to (0, −1/2, √3/2): the body is turned with everything else.
  const Vector3 size = scene->specimen.body.rest.rowwise().maxCoeff() - scene->specimen.body.rest.rowwise().minCoeff();
  CHECK(size.x() == Approx(0.015));
  CHECK(size.z() == Approx(0.015 * (0.5 + std::sqrt(3) / 2)));
}

TEST_CASE("a volume term is requested by key or in short, and named so", "[scene]") {
  const TemporaryFolder folder;
  const auto stiffness = [&](const std::string& value) {
    return load(folder.write("volume.yaml", replaced(kScene, "stiffness: standard", "stiffness: " + value)))->stiffness;
  };
  for (const std::string value : {"standard+volume", "{strategy: standard, volume: true}"}) {
    CHECK(stiffness(value).label == "standard+volume");
    CHECK(stiffness(value).strategy.volume_modulus);
  }
  CHECK(stiffness("{strategy: neo_hookean, volume: averaged}").label == "neo_hookean+volume");
  CHECK(stiffness("{strategy: 'calibrated:patch', volume: true}").label == "calibrated:patch+volume");
  CHECK(stiffness("{strategy: standard, volume: true, label: any}").label == "any");
  CHECK_FALSE(stiffness("{strategy: standard, volume: false}").strategy.volume_modulus);
}

TEST_CASE("a body may be stretched, graded and filled with tetrahedra", "[scene]") {
  const TemporaryFolder folder;
  std::string text = replaced(kScene, "spacing: 7.5 mm", "spacing: [1 mm, 2 mm, 3 mm]");
  text = replaced(text, "  radius: 3 mm\n", "  grade: {axis: x, ratio: 2}\n  cells: delaunay\n");
  text = replaced(text, "rotate: {axis: [1, 0, 0], angle: 30 deg}\n", "");
  const auto scene = load(folder.write("stretched.yaml", text));
  const Body& body = scene->specimen.body;
  const Vector3 size = body.rest.rowwise().maxCoeff() - body.rest.rowwise().minCoeff();
  CHECK((size - Vector3(2e-3, 4e-3, 6e-3)).norm() < 1e-15);
  // Two spacings in the ratio 2^(1/2), together 2 mm; half of the first is the radius.
  CHECK(body.radius[0] == Approx(1e-3 / (1 + std::sqrt(2.))));
  // 54 axis and 72 face connections; every other side of a cell is one of the 8 space diagonals.
  CHECK(body.connections.proper() == 126);
  CHECK(body.connections.cell_sides <= 8);
  double volume = 0;
  for (const auto& cell : body.tetrahedra) volume += signed_volume(body.rest, cell);
  CHECK(volume == Approx(48e-9));
  CHECK(body.mass.sum() == Approx(48e-6));
}

TEST_CASE("every scene of the project loads", "[scene][slow]") {
  int count = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(std::string(ELASTIN_SOURCE_DIR) + "/scenes")) {
    if (entry.path().extension() != ".yaml") continue;
    INFO(entry.path());
    if (entry.path().parent_path().filename() == "identify") {
      REQUIRE_NOTHROW(load_identify_task(entry.path().string(), built_in_catalog()));
      if (text_of_file(entry.path().string()).find("\nbody:") == std::string::npos)
        continue;  // homogeneous tests alone
    }
    std::unique_ptr<Scene> scene;
    REQUIRE_NOTHROW(scene = load(entry.path().string()));
    CHECK(scene->title != scene->name);
    const bool hard = entry.path().parent_path().filename() == "hard";  // bodies in pieces and the like
    CHECK((scene->warnings.empty() || hard));
    // An expectation of a strategy that `compare` does not run would never be judged.
    for (const Expectation& expectation : scene->expectations)
      CHECK((expectation.strategy.empty() || find_strategy(scene->strategies, expectation.strategy)));
    ++count;
  }
  CHECK(count >= 12);
}

TEST_CASE("a misspelt key is named with the nearest one and all that are known", "[scene]") {
  check_slips({
      {"title:",
       "@titel:",
       "unknown key 'titel'",
       {"did you mean 'title'?", "(allowed: extends, values, model, title, material, solver, ties, bodies, body, "}},
      {"material:", "@materiel:", "unknown key 'materiel'", {"did you mean 'material'?", "strategies, experiment"}},
      {"stiffness:", "@stifness:", "unknown key 'stifness'", {"did you mean 'stiffness'?", "loads, expect"}},
      {"lattice:",
       "@latice:",
       "body: unknown key 'latice'",
       {"did you mean 'lattice'?", "packing, tetrahedra, sphere"}},
      {"radius:", "@raduis:", "body: unknown key 'raduis'", {"did you mean 'radius'?", "jitter"}},
      {"kind: cubic", "@knid: cubic", "body.lattice: unknown key 'knid'", {"did you mean 'kind'?", "spacing, conn"}},
      {"spacing:", "@spacng:", "body.lattice: unknown key 'spacng'", {"did you mean 'spacing'?", "molecules"}},
      {"connections:", "@connection:", "body.lattice: unknown key 'connection'", {"did you mean 'connections'?"}},
      {"youngs_modulus:",
       "@young_modulus:",
       "material: unknown key 'young_modulus'",
       {"did you mean 'youngs_modulus'?", "(allowed: file, name, law, youngs_modulus, curve, "}},
      {"poissons_ratio: 0.25, d",
       "@poisson_ratio: 0.25, d",
       "material: unknown key 'poisson_ratio'",
       {"did you mean 'poissons_ratio'?"}},
      {"angle:", "@angel:", "rotate: unknown key 'angel'", {"did you mean 'angle'?"}},
      {"divisor:",
       "@divizor:",
       "strategies[1]: unknown key 'divizor'",
       {"did you mean 'divisor'?", "(allowed: strategy, volume, wrinkling, label, divisor)"}},
      {"divisor: 3.75",
       "@exponent: 3",
       "strategies[1]: unknown key 'exponent'",
       {"allowed: strategy, volume, wrinkling, label, divisor"}},
      {"axis: z", "@axes: z", "experiment: unknown key 'axes'", {"did you mean 'axis'?"}},
      {"load_steps:",
       "@load_step:",
       "experiment: unknown key 'load_step'",
       {"did you mean 'load_steps'?",
        "load_sharing, reading, cross_section, gauge_length, gauge, fixed, loaded, grip_depth"}},
      {"tolerance: 1e-9",
       "@tolerence: 1e-9",
       "solver: unknown key 'tolerence'",
       {"did you mean 'tolerance'?", "(allowed: displacements, engine, linear_solver, method, tolerance, "}},
      {"gravity:",
       "@gravty:",
       "loads[0]: unknown key 'gravty'",
       {"did you mean 'gravity'?", "(allowed: gravity, point, "}},
      {"stokes_drag: {",
       "{kind: @stokes_drag, ",
       "loads[1].kind: a load is named by the key before its own",
       {"write stokes_drag: {…}, without 'kind'"}},
      {"viscosity:", "@viscousity:", "loads[1].stokes_drag: unknown key 'viscousity'", {"did you mean 'viscosity'?"}},
      {"traction:", "@tracton:", "loads[3].face: unknown key 'tracton'", {"did you mean 'traction'?"}},
      {"measure: eff",
       "@mesure: eff",
       "expect[0]: unknown key 'mesure'",
       {"did you mean 'measure'?", "(allowed: strategy, source, outcome, measure, value, "}},
      {"source: pen and paper}\n",
       "@sorce: pen and paper}\n",
       "expect[0]: unknown key 'sorce'",
       {"did you mean 'source'?"}},
      {"- {measure: poi", "- {@messure: poi", "reference[0]: unknown key 'messure'", {"did you mean 'measure'?"}},
  });
}

TEST_CASE("a key under the name of older scenes is refused with its new name", "[scene]") {
  const TemporaryFolder folder;
  const std::string body =
      "body: {lattice: {kind: cubic, molecules: [3, 3, 3], spacing: 1 mm}}\n"
      "material: {youngs_modulus: 5 kPa}\nstiffness: uniform\n";
  struct Row {
    std::string text, message;
  };
  for (const Row& row : {
           Row{"experiment: {kind: tension, axis: z, displacement: 0.1 mm}\nsolver: {way: implicit}\n",
               ":5:10: solver: unknown key 'way'; did you mean 'method'? Write method: implicit (allowed: "},
           {"experiment: {kind: release, hold: {kind: tension, axis: z, force: 1 mN}}\ntime: {duration: 1 s}\n",
            ":4:29: experiment: unknown key 'hold'; did you mean 'fixture'? Write fixture: … (allowed: "},
           {"experiment: {kind: vibration, count: 2, hold: {kind: tension, axis: z, force: 1 mN}}\n",
            ":4:41: experiment: unknown key 'hold'; did you mean 'fixture'? Write fixture: … (allowed: "},
       }) {
    INFO(row.text);
    const std::string path = folder.write("old.yaml", body + row.text);
    CHECK_THAT(refusal(path), StartsWith(path + row.message));
  }
  const std::string path =
      folder.write("new.yaml", body + "experiment: {kind: tension, axis: z, displacement: 0.1 mm}\n");
  CHECK_THAT(refusal(path, {"solver.way=implicit"}), Contains("solver: unknown key 'way'; did you mean 'method'?"));
  CHECK(refusal(path, {"solver.method=implicit"}).empty());
  CHECK(config::meant_key("hold", {"kind", "move", "fix"}) == "fix");  // of a press
}

TEST_CASE("a load without its name, or under the experiment, is said to have a place of its own", "[scene]") {
  const TemporaryFolder folder;
  const std::string body =
                        "body: {lattice: {kind: cubic, molecules: [3, 3, 3], spacing: 1 mm}}\n"
                        "material: {youngs_modulus: 5 kPa}\nstiffness: uniform\n",
                    test = "experiment: {kind: tension, axis: z, displacement: 0.1 mm}\nloads: [{";
  for (const auto& [text, message] : std::vector<std::pair<std::string, std::string>>{
           {test + "molecules: [1], force: [1 mN, 0, 0]}]\n",
            "loads[0]: a load is named before its own keys: write point: {molecules: …, force: …}"},
           {test + "force: [1 mN, 0, 0], in_time: {step: {}}, molecules: {side: z}}]\n",
            "write point: {force: …, molecules: …}"},
           {test + "acceleration: [0, 0, -9.81 m/s2]}]\n", "write gravity: {acceleration: …}"},
           {test + "weight: 3 N}]\n", "loads[0]: unknown key 'weight'"},
           {"experiment: {kind: motion, gravity: [0, 0, -9.81 m/s2]}\ntime: {duration: 1 s}\n",
            "unknown key 'gravity'; weight is a load at the top level: loads: [{gravity: "}}) {
    INFO(text);
    CHECK_THAT(refusal(folder.write("slip.yaml", body + text)), Contains(message));
  }
}

TEST_CASE("a value that cannot be is named with what can", "[scene]") {
  check_slips({
      // Missing and wrong units. Plain numbers are taken only where no value of the file has a unit.
      {"force: 1 mN",
       "force: @1",
       "experiment.force: '1' has no unit",
       {"write for example 1 N, 5 kN", ":5:28 has one"}},
      {"radius: 3 mm", "radius: @0.003", "body.radius: '0.003' has no unit", {"15 mm, 2 cm, 0.1 m"}},
      {"spacing: 7.5 mm", "spacing: @7.5", "body.lattice.spacing: '7.5' has no unit", {}},
      {"-9.81 m/s2", "@-9.81", "loads[0].gravity[2]: '-9.81' has no unit", {"9.81 m/s2"}},
      {"youngs_modulus: 5 kPa",
       "youngs_modulus: @5000",
       "material.youngs_modulus: '5000' has no unit",
       {":5:65 has one"}},
      {"force: 1 mN", "force: @1 mm", "experiment.force: 'mm' cannot be converted to N", {"1 N, 5 kN"}},
      {"force: 1 mN", "force: @1 newton", "experiment.force: unknown unit 'newton'", {"1 N, 5 kN"}},
      {"force: 1 mN", "force: @weak", "experiment.force: 'weak' does not start with a finite number", {"1 N, 5 kN"}},
      {"force: 1 mN", "force: @.nan", "experiment.force: '.nan' does not start with a finite number", {}},
      {"force: 1 mN", "force: @inf N", "experiment.force: 'inf N' does not start with a finite number", {}},
      {"force: 1 mN", "@force:", "experiment.force: has no value", {}},
      {"force: 1 mN", "force: @[1 mN]", "experiment.force: expected a single value, found a list", {}},
      {"value: 5 kPa", "value: @5 mm", "expect[0].value: 'mm' cannot be converted to Pa", {}},
      {"poissons_ratio: 0.25, d", "poissons_ratio: @1 mm, d", "material.poissons_ratio: 'mm' cannot be converted", {}},
      // Out of range.
      {"radius: 3 mm", "radius: @-3 mm", "body.radius: '-3 mm' is out of range: must be above 0 m", {}},
      {"radius: 3 mm",
       "radius: 3 mm\n  jitter: {amount: @0.9}",
       "body.jitter.amount: '0.9' is out of range",
       {"must be at least 0 and at most 0.5"}},
      {"spacing: 7.5 mm", "spacing: @0 mm", "body.lattice.spacing: '0 mm' is out of range: must be above 0 m", {}},
      {"youngs_modulus: 5 kPa", "youngs_modulus: @-5 kPa", "material.youngs_modulus: '-5 kPa' is out of range", {}},
      {"poissons_ratio: 0.25, d",
       "poissons_ratio: @0.5, d",
       "material.poissons_ratio: '0.5' is out of range: above 0.4999 only membranes",
       {}},
      {"divisor: 3.75",
       "divisor: @-1",
       "strategies[1].divisor: '-1' is out of range",
       {"must be at least 1e-06 and at most 1e+06"}},
      {"tolerance: 1e-9", "tolerance: @1", "solver.tolerance: '1' is out of range", {"at least 1e-14 and at most 0.1"}},
      {"load_steps: 2", "load_steps: @0", "experiment.load_steps: '0' is not a whole number of at least 1", {"100000"}},
      {"load_steps: 2", "load_steps: @2.5", "experiment.load_steps: '2.5' is not a whole number", {}},
      {"[3, 3, 3]", "[3, 3, @0]", "body.lattice.molecules[2]: '0' is not a whole number of at least 1", {}},
      {"[3, 3, 3]", "@[3000, 3000, 3000]", "body.lattice.molecules: that is 2.7e+10 molecules; at most 5e+07", {}},
      {"molecules: [26]",
       "molecules: [@27]",
       "loads[2].point.molecules[0]: '27' is not a whole number",
       {"at most 26"}},
      {"tolerance: 1 %", "tolerance: @0 %", "expect[0].tolerance: '0 %' is out of range: must be above 0", {}},
      // Not a word that is known.
      {"stiffness: standard",
       "stiffness: @standart",
       "stiffness: unknown strategy 'standart'",
       {"did you mean 'standard'?", "(allowed: standard, divided, "}},
      {"stiffness: standard", "stiffness: @'calibrated:standart'", "stiffness: unknown strategy 'standart'", {}},
      {"stiffness: standard",
       "stiffness: {strategy: standard, volume: @averaged}",
       "stiffness.volume: 'averaged' is not known here",
       {"allowed: true, false"}},
      {"stiffness: standard",
       "stiffness: {strategy: neo_hookean, volume: @true}",
       "stiffness.volume: 'true' is not known here",
       {"allowed: averaged, cells"}},
      {"stiffness: standard",
       "stiffness: {strategy: st_venant_kirchhoff, volume: @averaged}",
       "stiffness.volume: 'st_venant_kirchhoff': a volume term goes with",
       {"neo_hookean"}},
      {"stiffness: standard",
       "stiffness: {strategy: standard+volume, volume: @true}",
       "stiffness.volume: 'standard+volume' has a volume term already",
       {}},
      {"stiffness: standard",
       "stiffness: @standard+volum",
       "stiffness: 'standard+volum': unknown ending '+volum'",
       {"did you mean '+volume'?"}},
      {"stiffness: standard",
       "stiffness: @'calibratd:standard'",
       "stiffness: 'calibratd:standard': unknown beginning 'calibratd:'",
       {"did you mean 'calibrated:'?"}},
      {"0.25, density: 1000 kg/m3}\nrotate: {axis: [1, 0, 0], angle: 30 deg}\nstiffness: standard",
       "@-0.1, density: 1000 kg/m3}\nrotate: {axis: [1, 0, 0], angle: 30 deg}\nstiffness: standard+volume",
       "material.poissons_ratio: poissons_ratio -0.1 is out of range",
       {"0 to 0.4999"}},
      {"- gravity: [0, 0, -9.81 m/s2]",
       "- cell_damping: @{bulk: 1 Pa s, shear: 2 Pa s}",
       "loads[0].cell_damping: needs a body with tetrahedra",
       {"damping"}},
      {"- gravity: [0, 0, -9.81 m/s2]",
       "- cell_damping: {bulk: @-1 Pa s, shear: 2 Pa s}",
       "loads[0].cell_damping.bulk: '-1 Pa s' is out of range",
       {}},
      {"strategy: divided",
       "strategy: @dividd",
       "strategies[1].strategy: unknown strategy 'dividd'",
       {"did you mean 'divided'?"}},
      {"strategy: halved", "strategy: @halvd", "expect[0].strategy: unknown strategy 'halvd'", {}},
      {"kind: cubic",
       "kind: @cubik",
       "body.lattice.kind: 'cubik' is not known here",
       {"did you mean 'cubic'? (allowed: cubic, body_centred, face_centred)"}},
      {"[axis, face]",
       "[axis, @faces]",
       "body.lattice.connections[1]: 'faces' is not known here",
       {"did you mean 'face'? (allowed: axis, face, space)"}},
      {"kind: tension",
       "kind: @torison",
       "experiment.kind: 'torison' is not known here",
       {"did you mean 'torsion'? (allowed: tension, compression, biaxial, planar, shear, torsion, "}},
      {"axis: z", "axis: @w", "experiment.axis: 'w' is not known here; allowed: x, y, z, -x, -y, -z", {}},
      {"axis: z", "axis: @[0, 0, 0]", "experiment.axis: a direction must not be zero", {}},
      {"clamped", "@stuck", "experiment.fixed_grip: 'stuck' is not known here; allowed: clamped, sliding", {}},
      {"clamped", "@glued", "experiment.fixed_grip: 'glued' is not known here; did you mean 'clamped'?", {}},
      {"effective_modulus",
       "@efective_modulus",
       "expect[0].measure: unknown measure 'efective_modulus'",
       {"did you mean 'effective_modulus'?", "poissons_ratio, elongation, "}},
      // Of a wrong shape.
      {"[3, 3, 3]", "@[3, 3]", "body.lattice.molecules: expected 3 values, found 2", {}},
      {"[3, 3, 3]", "@3", "body.lattice.molecules: expected a list, found a single value", {}},
      {"{tolerance: 1e-9}", "@3", "solver: expected a map of keys, found a single value", {}},
      {"gravity: [0, 0, -9.81 m/s2]", "gravity: @-9.81 m/s2", "loads[0].gravity: expected a list", {}},
      {"strategies: [", "strategies: @standard\nnotes: [", "strategies: write a list of strategies, or all", {}},
      {"[standard, {", "[standard, @standard, {", "strategies[1]: 'standard' is in the list already", {"label"}},
  });
}

TEST_CASE("a material's curve and fibres are read, and their mistakes named", "[scene][material]") {
  const TemporaryFolder folder;
  const std::string plain = "material: {youngs_modulus: 5 kPa, poissons_ratio: 0.25, density: 1000 kg/m3}";
  const auto with = [&](const std::string& material) {
    return replaced(kScene, plain, "material: {" + material + "}");
  };
  const auto material = [&](const std::string& text) {
    return load(folder.write("right.yaml", with(text)))->specimen.material;
  };
  const Material toe = material("curve: {toe_strain: 3 %, toe_modulus: 10 kPa, modulus: 100 kPa}");
  CHECK(toe.youngs_modulus == Approx(1e4));
  CHECK(toe.curve->stress(0.04) == Approx(0.03 * 55e3 + 0.01 * 1e5));
  CHECK_FALSE(toe.fibre);
  const Material table =
      material("youngs_modulus: 50 kPa, curve: {points: [[-10 %, -5 kPa], [0, 0 Pa], [2 %, 1 kPa]]}");
  CHECK(table.curve->stress(-0.1) == Approx(-5e3));
  CHECK(material("curve: {tension: 1 kPa, compression: 3 kPa}").youngs_modulus == Approx(2e3));
  // 30° about x take z to (0, −1/2, √3/2): the fibres are turned with the body.
  const Material fibres = material("youngs_modulus: 5 kPa, fibre: {direction: [0, 0, 2], youngs_modulus: 1 MPa}");
  CHECK((fibres.fibre->direction - Vector3(0, -0.5, std::sqrt(3.) / 2)).norm() < 1e-14);
  CHECK(fibres.fibre->curve.stress(-0.1) == Approx(-1e5));
  CHECK(material("youngs_modulus: 5 kPa, fibre: {direction: x, compression: false, curve: {toe_strain: 3 %, "
                 "toe_modulus: 1 kPa, modulus: 9 kPa}}")
            .fibre->curve.stress(-0.1) == 0);

  const auto slip = [&](const std::string& wrong, const std::string& path, const std::vector<std::string>& says) {
    check_slips({{plain, "material: {" + wrong + "}", path, says}});
  };
  slip("youngs_modulus: @40 kPa, curve: {toe_strain: 3 %, toe_modulus: 10 kPa, modulus: 1 MPa}",
       "material.youngs_modulus: the curve begins with a slope of 10000 Pa", {"leave this out"});
  slip("curve: {points: [[0, 0 Pa], [2 %, 2 kPa], @[3 %, 2 kPa]]}", "material.curve.points",
       {"the stress must be greater"});
  slip("curve: {points: [[0, 0 Pa], [2 %, 2 kPa], @[2 %, 3 kPa]]}", "material.curve.points",
       {"the strain must be greater"});
  slip("curve: {points: [@[1 %, 1 kPa], [2 %, 2 kPa]]}", "material.curve.points", {"the origin"});
  slip("curve: {points: [[0, 0 Pa], @[2 %, 1 kPa, 3 kPa]]}", "material.curve.points", {});
  slip("curve: {points: [[0, 0 Pa], [2 %, @1 mm]]}", "material.curve.points", {"Pa"});
  slip("curve: {@toe_strian: 3 %, toe_modulus: 1 kPa, modulus: 2 kPa}", "material.curve: unknown key 'toe_strian'",
       {"did you mean 'toe_strain'"});
  slip("curve: {tension: 3 kPa, @compresion: 1 kPa}", "material.curve: unknown key 'compresion'",
       {"did you mean 'compression'"});
  slip("curve: {tension: @-3 kPa, compression: 1 kPa}", "material.curve.tension", {"out of range"});
  slip("curve: @10 kPa", "material.curve", {"points", "toe_strain", "tension"});
  slip("curve: @{file: curve.csv}", "material.curve",
       {"points", "tension", "values of a file are copied into `points`"});
  slip("youngs_modulus: 5 kPa, fibre: @{direction: z}", "material.fibre: key 'youngs_modulus' is missing", {});
  slip("youngs_modulus: 5 kPa, fibre: @{youngs_modulus: 1 MPa}", "material.fibre: key 'direction' is missing", {});
  slip("youngs_modulus: 5 kPa, fibre: {direction: @[0, 0, 0], youngs_modulus: 1 MPa}", "material.fibre.direction",
       {"must not be zero"});
  slip("youngs_modulus: 5 kPa, fibre: {direction: z, youngs_modulus: 1 MPa, compression: @no}",
       "material.fibre.compression", {"true", "false"});
  slip(
      "youngs_modulus: 5 kPa, fibre: {direction: z, youngs_modulus: 1 MPa, curve: @{tension: 1 kPa, compression: 1 "
      "kPa}}",
      "material.fibre.curve", {"give one of them"});
}

TEST_CASE("without `stiffness` a scene runs the first of its strategies", "[scene]") {
  const TemporaryFolder folder;
  const std::string shorter = replaced(kScene, "stiffness: standard\nstrategies: [standard, ", "strategies: [");
  const auto scene = load(folder.write("scene.yaml", shorter));
  CHECK(scene->stiffness.label == "halved");
  CHECK(scene->stiffness.values.at("divisor") == 3.75);
  CHECK(scene->strategies.size() == 1);
}

TEST_CASE("a missing key is named with the unknown one that stands in its map", "[scene]") {
  const TemporaryFolder folder;
  CHECK_THAT(refusal(folder.write("scene.yaml", replaced(kScene, "molecules: [3, 3, 3]", "count: [3, 3, 3]"))),
             Contains("key 'molecules' is missing; unknown key 'count' (allowed: kind, molecules, cells, spacing, "));
}

TEST_CASE("keys that are missing or do not go together are named", "[scene]") {
  const std::string expectation = "{strategy: halved, measure: effective_modulus, value: 5 kPa, ";
  check_slips({
      {"stiffness: standard\nstrategies: [standard, {strategy: divided, divisor: 3.75, label: halved}]",
       "strategies: all",
       "key 'stiffness' is missing, or a list of `strategies`",
       {}},
      {"material: {youngs_modulus: 5 kPa, ", "material: @{", "material: key 'youngs_modulus' is missing", {}},
      {"{kind: cubic, molecules: [3, 3, 3], spacing: 7.5 mm, ",
       "@{kind: cubic, molecules: [3, 3, 3], ",
       "body.lattice: key 'spacing' is missing",
       {}},
      {"kind: tension\n  axis: z", "@axis: z", "experiment: key 'kind' is missing", {}},
      {expectation + "tolerance: 1 %, source: pen and paper}",
       "@" + expectation + "tolerance: 1 %}",
       "expect[0]: key 'source' is missing",
       {}},
      {expectation + "tolerance: 1 %, ",
       "@" + expectation,
       "expect[0]: an expectation needs a tolerance",
       {"not_reproduced"}},
      {expectation + "tolerance: 1 %, source: pen and paper}",
       "@{outcome: inverted, source: me}",
       "expect[0]: key 'cause' is missing",
       {}},
      {expectation + "tolerance: 1 %, source: pen and paper}",
       "{outcome: @invertd, cause: flat, source: me}",
       "expect[0].outcome: 'invertd' is not known here",
       {"did you mean 'inverted'?", "unsuited, limit_reached"}},
      {expectation + "tolerance: 1 %, source: pen and paper}",
       "{outcome: inverted, cause: flat, source: me, @measure: strain}",
       "expect[0]: unknown key 'measure'",
       {}},
      // A key that exists is never taken for the misspelling of a missing one.
      {"rotate: {axis: [1, 0, 0], angle: 30 deg}", "rotate: @{axis: z}", "rotate: key 'angle' is missing", {}},
      {"force: 1 mN", "force: 1 mN\n  displacement: @1 mm", "experiment.displacement: there is a force already", {}},
      {"kind: tension\n  axis: z\n  force: 1 mN",
       "@kind: tension\n  axis: z",
       "experiment: give a force or a displacement",
       {}},
      {"force: 1 mN", "force: @0 N", "experiment.force: a load of zero stretches nothing", {}},
      {kLattice, kLattice + "\n  packing: @{}", "body.packing: the body has a shape already: body.lattice", {}},
      {kLattice + "\n  radius",
       "@radius",
       "body: needs a shape: lattice, packing, tetrahedra, sphere, sphere_octant, disc, sheet, canopy, mesh, fill, "
       "image or molecules",
       {}},
      {kLattice + "\n  radius: 3 mm", "@molecules: [[0, 0, 0], [0, 0, 1 mm]]", "body: give a radius", {}},
      {kLattice, "molecules: @[]", "body.molecules: a body needs at least one molecule", {}},
      {kLattice,
       "molecules: [[0, 0, 0], [0, 0, 1 mm]]\n  connections: [[0, 1], @[1, 1]]",
       "body.connections[1]: a connection needs two different molecules",
       {}},
      {kLattice,
       "molecules: [[0, 0, 0], [0, 0, 1 mm]]\n  connections: [[0, @2]]",
       "body.connections[0][1]: '2' is not a whole number of at least 0 and at most 1",
       {}},
      {kLattice,
       "packing: @{size: [1 m, 1 m, 1 m], distance: 0.1 mm}",
       "body.packing: a box of this size has too many molecules",
       {}},
      {kGravity, "@" + kGravity + "\n    damping: 1 N s/m", "loads[0]: a load is one of gravity, point", {"an item"}},
      {kGravity, "@{}", "loads[0]: a load is one of gravity, point, ", {}},
      {"[standard, {strategy: divided, divisor: 3.75, label: halved}]",
       "@[]",
       "strategies: names no strategy",
       {"all"}},
      {"radius: 3 mm", "grade: @{axis: z}\n  radius: 3 mm", "body.grade: key 'ratio' is missing", {}},
      {"radius: 3 mm", "grade: {axis: z, ratio: @0}\n  radius: 3 mm", "body.grade.ratio: '0' is out of range", {"100"}},
      {"radius: 3 mm", "grade: {axis: @w, ratio: 2}\n  radius: 3 mm", "body.grade.axis: 'w' is not known here", {}},
      {"radius: 3 mm", "cells: @delauny\n  radius: 3 mm", "body.cells: 'delauny' is not known here", {"'delaunay'"}},
      {kLattice,
       "tetrahedra: {kind: kuhn, cubes: [1, 1, 1], size: [1 m, 1 m, 1 m]}\n  cells: @delaunay",
       "body.cells: the body has cells already",
       {}},
      {kLattice,
       "lattice: {kind: cubic, molecules: [3, 3, 1], spacing: 1 mm}\n  cells: @delaunay",
       "body.cells: no tetrahedra fit between the molecules",
       {}},
      {"spacing: 7.5 mm", "spacing: [1 mm, @0 mm, 2 mm]", "body.lattice.spacing[1]: '0 mm' is out of range", {}},
      {"radius: 3 mm", "radius: 3 mm\n  @radius: 4 mm", "key 'radius' stands here twice", {}},
  });
}

TEST_CASE("all in a list of strategies stands for those that the list does not name before", "[scene]") {
  const TemporaryFolder folder;
  const auto scene =
      load(folder.write("all.yaml", replaced(kScene, "[standard, {", "[{strategy: uniform, constant: 2 N/m}, all, {")));
  CHECK(scene->strategies.size() == all_strategies(built_in_catalog(), scene->specimen).size() + 1);  // and halved
  CHECK(scene->strategies.front().values.at("constant") == 2);
  CHECK(scene->strategies.back().label == "halved");
  const auto has = [](const Scene& a_scene, const std::string& label) {
    return find_strategy(a_scene.strategies, label) != nullptr;
  };
  // A volume term stands among them where the body has the cells and the material the Poisson's ratio.
  const std::string all = "strategies: [standard+volume, all, \"calibrated:patch+volume\"]";
  const auto cells = load(folder.write("cells.yaml",
                                       "body: {tetrahedra: {kind: kuhn, cubes: [1, 1, 1], size: [1, 1, 1]}}\n"
                                       "material: {youngs_modulus: 1}\nstiffness: standard\n" +
                                           all + "\nexperiment: {kind: tension, force: 1}\n"));
  for (const char* label : {"patch+volume", "neo_hookean+volume", "calibrated:van_gelder+volume"})
    CHECK(has(*cells, label));
  CHECK_FALSE(has(*cells, "st_venant_kirchhoff+volume"));
  CHECK(cells->strategies.front().label == "standard+volume");
  CHECK(cells->strategies.back().label == "calibrated:patch+volume");
  std::set<std::string> labels;
  for (const StrategyChoice& choice : cells->strategies) CHECK(labels.insert(choice.label).second);
  Material auxetic;
  auxetic.poissons_ratio = -0.2;
  const auto negative = all_strategies(built_in_catalog(), cells->specimen.body, {auxetic});
  CHECK_FALSE(find_strategy(negative, "patch+volume"));
  const auto graph = all_strategies(built_in_catalog(), body_centred_lattice({2, 2, 2}, 1, false), {Material{}});
  CHECK_FALSE(find_strategy(graph, "standard+volume"));
  for (std::size_t i = 1; i < negative.size(); ++i) CHECK(negative[i - 1].order < negative[i].order);
}

TEST_CASE("a mesh file that is missing or broken is named with the place that names it", "[scene]") {
  const TemporaryFolder folder;
  const auto refused = [&](const std::string& mesh) {
    return refusal(folder.write("mesh.yaml", replaced(kScene, kLattice, "mesh: " + mesh)));
  };
  const std::string file = folder.path("mesh.yaml") + ":3:16: body.mesh.file: ";
  CHECK(refused("{file: bone.msh, length_unit: mm}") == file + "'bone.msh': no such file");
  const std::string mesh =
      folder.write("bone.msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n2\n1 0 0 0\n2 0 O 0\n$EndNodes\n");
  CHECK(refused("{file: bome.msh, length_unit: mm}") == file + "'bome.msh': no such file; did you mean 'bone.msh'?");
  CHECK(refused("{file: bone.msh, length_unit: mm}") ==
        file + mesh + ":7:5: expected a coordinate, a finite number; found 'O'");
  CHECK_THAT(refused("{file: mesh.yaml, length_unit: mm}"), Contains("unknown ending '.yaml'") && Contains(".vtu"));
  CHECK(refused("{file: bone.msh, length_unit: mmm}") ==
        folder.path("mesh.yaml") +
            ":3:39: body.mesh.length_unit: 'mmm' is not known here; did you mean 'mm'? (allowed: "
            "m, cm, mm, um, nm)");
}

TEST_CASE("an expectation that no run of the scene meets is a warning", "[scene]") {
  const TemporaryFolder folder;
  const auto named = load(folder.write("named.yaml", kScene));
  for (const std::string& warning : named->warnings) CHECK_THAT(warning, !Contains("expect"));
  const auto scene = load(folder.write("scene.yaml", replaced(kScene, "strategy: halved", "strategy: patch")));
  REQUIRE_FALSE(scene->warnings.empty());
  CHECK_THAT(scene->warnings.back(),
             Contains("expect[0]: no run of this scene is with patch") && Contains("strategies"));
}

TEST_CASE("an invalid scene file is refused", "[scene]") {
  const TemporaryFolder folder;
  CHECK(refusal(folder.path("cube.yaml")) == folder.path("cube.yaml") + ": no such file");
  const std::string path = folder.write("cube.yaml", "");
  CHECK(refusal(path) == path + ":1:1: the scene is empty");
  CHECK(refusal(folder.path("cub.yaml")) == folder.path("cub.yaml") + ": no such file; did you mean 'cube.yaml'?");
  const std::string inside = folder.path("");
  CHECK(refusal(inside) == inside + ": is a folder; name a scene file in it");

  struct Row {
    std::string text, message;
  };
  for (Row row : std::vector<Row>{
           {"@# only a comment\n", "a scene is a map of keys"},
           {"@- a\n- list\n", "a scene is a map of keys"},
           {"@one word", "a scene is a map of keys"},
           {"body: {}\n@---\nbody: {}\n", "a scene is one YAML document; a second one begins here"},
           {"body: {}\n...\n@material: {}\n", "a scene is one YAML document; a second one begins here"},
           {"{body: {}}\n@material: {}\n", "a scene is one YAML document; a second one begins here"},
           {"  body: {}\n@material: {}\n", "a scene is one YAML document; a second one begins here"},
           {"title: a\nbody: @{lattice: 3\nmaterial: {}\n",
            "not valid YAML: this { is not closed; write body: {lattice: 3}"},
           {"title: @a: b\n", "not valid YAML: a text that has a colon stands in quotes; write title: \"a: b\""},
           {"title: a\n@\tbody: {}\n", "not valid YAML: a tab indents this line"},
           {"title: a\n@title: b\n", "key 'title' stands here twice"},
           {"title: a\n@[1, 2]: b\n", "a key must be a word"},
           {"title: @&a\n  x: *a\n", "nested too deeply; does an alias stand inside its own anchor?"}}) {
    const std::string location = take_location(row.text);
    INFO(row.text);
    CHECK_THAT(refusal(folder.write("cube.yaml", row.text)), StartsWith(path + location + ": " + row.message));
  }
}

TEST_CASE("what is too large is refused before anybody makes room for it", "[scene]") {
  const TemporaryFolder folder;
  const auto said = [&](const std::string& body) {
    return refusal(folder.write("large.yaml", "body: " + body +
                                                  "\nmaterial: {youngs_modulus: 5 kPa, thickness: 1 mm}\n"
                                                  "stiffness: standard\nexperiment: {kind: material}\n"));
  };
  struct Row {
    std::string body, message;
  };
  for (const auto& [body, message] : std::vector<Row>{
           {"{sphere: {radius: 1 m, divisions: 4000}}",
            "body.sphere.divisions: that is 1.6e+08 molecules; at most 5e+07"},
           {"{canopy: {width: 1 mm, span: 1e6 m, squares: 10}}", "body.canopy.squares: that is 1e+11 molecules"},
           {"{packing: {size: [1 m, 1 m, 1 um], distance: 0.1 mm}}",
            "body.packing: a box of this size has too many molecules"},
           {"{lattice: {kind: cubic, molecules: [20, 20, 20], spacing: 1 mm, connections: {within: 1 m}}}",
            "body: the reach is too wide: that is more than 4000000 connections between 8000 molecules"}}) {
    INFO(body);
    CHECK_THAT(said(body), Contains(message));
  }
  // Aliases of aliases: nine to the ninth values in ten lines.
  std::string bomb = "title: a\na: &a [x, x, x, x, x, x, x, x, x]\n";
  for (char c = 'b'; c < 'j'; ++c) {
    const std::string one(1, static_cast<char>(c - 1));
    bomb += std::string(1, c) + ": &" + c + " [*" + one;
    for (int i = 1; i < 9; ++i) bomb += ", *" + one;
    bomb += "]\n";
  }
  CHECK_THAT(refusal(folder.write("bomb.yaml", bomb)),
             Contains("too many values; do aliases stand in what aliases name?"));
  CHECK_THROWS_WITH(load_scene(folder.write("right.yaml", kScene), built_in_catalog(), {}, 10),
                    Contains("molecules; at most 10 are allowed"));
  const StudyAxis wide{std::vector<std::vector<std::pair<std::string, std::string>>>(1000)};
  CHECK_THROWS_WITH(combinations({wide, wide}), Contains("that is 1e+06 combinations; at most 100000 are allowed"));
}

TEST_CASE("a scene may be in plain SI numbers throughout, but not in both", "[scene]") {
  const TemporaryFolder folder;
  const std::string plain =
      "body:\n  lattice: {kind: cubic, molecules: [2, 2, 3], spacing: 0.01}\nmaterial: {youngs_modulus: 5000, "
      "poissons_ratio: 25 %}\nstiffness: standard\nexperiment: {kind: tension, axis: [0, 0, 1], force: 0.001}\n";
  std::unique_ptr<Scene> scene;
  REQUIRE_NOTHROW(scene = load(folder.write("plain.yaml", plain)));
  CHECK(scene->title == "plain");
  CHECK(scene->specimen.body.radius[0] == Approx(0.005));
  // The unit comes after the plain numbers: the first of these is named, for they are read before.
  const std::string path = folder.write("mixed.yaml", replaced(plain, "0.001", "1 mN"));
  CHECK_THAT(refusal(path), StartsWith(path + ":3:28: material.youngs_modulus: '5000' has no unit") &&
                                Contains(path + ":5:53 has one"));
}

TEST_CASE("the option --set changes keys, and its slips are named", "[scene]") {
  const TemporaryFolder folder;
  const std::string path = folder.write("right.yaml", kScene);
  SECTION("values") {
    const auto scene = load(path, {"material.youngs_modulus=6000", "material.poissons_ratio=0.3", "body.radius=1 mm",
                                   "stiffness={strategy: uniform, constant: 7}", "body.lattice.molecules=[3,3,5]",
                                   "solver.displacements=small", "title=Other", "title=Last", "experiment.axis=x"});
    CHECK(scene->specimen.material.youngs_modulus == 6000);  // plain numbers are SI, in any scene
    CHECK(scene->specimen.material.poissons_ratio == 0.3);
    CHECK(scene->specimen.body.radius[0] == Approx(1e-3));
    CHECK(scene->specimen.body.size() == 45);
    CHECK(scene->stiffness.label == "uniform");
    CHECK(scene->stiffness.values.at("constant") == 7);
    CHECK(scene->statics.linear);
    CHECK(scene->title == "Last");
  }
  SECTION("a whole map, and a map that the scene does not have") {
    const auto scene = load(path, {"experiment={kind: compression, axis: z, force: 3}", "body.jitter.amount=0"});
    CHECK(scene->experiment->at_rest()->load_steps() == 1);
    CHECK(scene->specimen.body.size() == 27);
  }
  SECTION("slips") {
    struct Row {
      std::string assignment, message;
    };
    for (const Row& row : std::vector<Row>{
             {"experiment.forse=1", "--set: experiment: unknown key 'forse'; did you mean 'force'?"},
             {"experiment.force=abc", "--set: experiment.force: 'abc' does not start with a finite number"},
             {"experiment.force=1 mm", "--set: experiment.force: 'mm' cannot be converted to N"},
             {"experiment.force=", "--set: experiment.force: has no value"},
             {"body.radius=-1", "--set: body.radius: '-1' is out of range: must be above 0 m"},
             {"body.lattice.molecules=[1,2]", "--set: body.lattice.molecules: expected 3 values, found 2"},
             {"body.lattice.molecules=[1,2,0]", "--set: body.lattice.molecules[2]: '0' is not a whole number"},
             {"experiment={kind: tension, forse: 1}", "--set: experiment: unknown key 'forse'"},
             {"stiffness=latice", "--set: stiffness: unknown strategy 'latice'; did you mean 'lattice'?"},
             {"bodi.radius=1", "--set: unknown key 'bodi'; did you mean 'body'?"},
             {"strategies[0]=angles", "--set: unknown key 'strategies[0]'; did you mean 'strategies'?"},
             {"strategies.5=angles", "--set strategies.5=angles: '5' is no item of the list"},
             {"stiffness.strategy=angles", "--set stiffness.strategy=angles: 'stiffness' is a single value in the"},
             {"title=[1", "--set title=[1: the value is not valid YAML: "},
             {"solver={tolerance: 1e-3, tolerance: 1e-4}",
              "--set solver={tolerance: 1e-3, tolerance: 1e-4}: key 'tole"},
             {"title=&a [*a]", "--set title=&a [*a]: nested too deeply"},
             {"title", "--set title: write key=value, for example --set material.youngs_modulus='10 kPa'"},
             {"=1", "--set =1: write key=value"},
             {"body..radius=1", "--set body..radius=1: write key=value"},
             {"body.=1", "--set body.=1: write key=value"}}) {
      INFO(row.assignment);
      CHECK_THAT(refusal(path, {row.assignment}), StartsWith(row.message));
    }
  }
}
