// The key reference says what the readers do: every key that they ask for while scenes are read, and no other.

#include "lab/run/config_names.h"
#include "lab/scene/key_reference.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "lab/scene/identify.h"
#include "lab/scene/scene.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;
namespace fs = std::filesystem;

namespace {

const std::string kScenes = std::string(ELASTIN_SOURCE_DIR) + "/scenes";

const std::string kSolid = "material: {youngs_modulus: 1000}\nstiffness: neo_hookean\n",
                  kInTime =
                      "experiment: {kind: motion, fixture: {kind: tension, force: 1}, in_time: {step: {at: 0.5}}}\n",
                  kMembrane = "material: {youngs_modulus: 1000, thickness: 0.1}\nstiffness: hencky_membrane\n",
                  kBlock = "body: {tetrahedra: {kind: kuhn, cubes: [1, 1, 2], size: [1, 1, 2]}}\n" + kSolid,
                  kFree = "experiment: {kind: motion}\ntime: {duration: 1}\n";

/// A block with a law of such constants.
std::string block_of(const std::string& law, const std::string& constants) {
  return "body: {tetrahedra: {kind: kuhn, cubes: [1, 1, 2], size: [1, 1, 2]}}\nmaterial: {law: " + law + ", " +
         constants + "}\nstiffness: " + law + "\n" + kFree;
}
const std::string kBulk = ", bulk_modulus: 1e5, volumetric: quadratic";

/// Scenes with the keys that no scene of the tree has.
const std::vector<std::string> kRest{
    block_of("neo_hookean_log", "youngs_modulus: 1000"),
    block_of("mooney_rivlin", "c1: 100, c2: 10" + kBulk),
    block_of("yeoh", "terms: [100, 10]" + kBulk),
    block_of("ogden", "terms: [[100, 2]], convention: febio" + kBulk),
    block_of("arruda_boyce", "mu: 100, N: 8" + kBulk),
    block_of("veronda_westmann", "c1: 100, c2: 2" + kBulk),
    block_of("fung_orthotropic",
             "c: 100, E1: 9, E2: 8, E3: 7, G12: 3, G23: 2, G31: 1, nu12: 0.1, nu23: 0.2, nu31: 0.3,"
             " axis_1: x, axis_2: y" +
                 kBulk),
    block_of("transversely_isotropic",
             "c1: 100, c2: 10, c3: 1, c4: 20, c5: 1000, lambda_max: 1.1, direction: x" + kBulk),
    block_of("transversely_isotropic",
             "c1: 100, c4: 20, c5: 1000, lambda_max: 1.1, direction: x, fields: {constants: {direction: {angle: 0.5, "
             "about: z}}}" +
                 kBulk),
    block_of("holzapfel_gasser_ogden",
             "c: 100, k1: 10, k2: 2, kappa: 0.1, angle: 0.5, direction: x, across: y" + kBulk),
    kBlock + "experiment: {kind: tension, axis: z, force: 1}\nsolver: {engine: threads}\n",
    kBlock + kFree +
        "loads: [{gravity: {acceleration: [0, 0, -9.81]}}, {damping: {coefficient: 1}}, {stokes_drag: {viscosity: 1}},"
        " {floor: {point: [0, 0, -1], normal: z}}, {cell_damping: {bulk: 1, shear: 1}}, {rayleigh: {mass: 1}},"
        " {quadratic_drag: {density: 1, drag_coefficient: 1}}, {point: {molecules: [0], force: [0, 0, 1]}},"
        " {face: {side: z, traction: [0, 0, 1]}, in_time: {sine: {frequency: 1}}}]\n",
    kBlock + kInTime + "time: {duration: 1, integrator: {scheme: xpbd, iterations: 2, substeps: 3, balanced: 1}}\n",
    kBlock + kInTime + "time: {duration: 1, integrator: {scheme: projective, solves: 2, memory: 3}}\n",
    kBlock + kInTime + "time: {duration: 1, integrator: {scheme: block_descent, sweeps: 2}}\n",
    kBlock + kInTime + "time: {duration: 1, integrator: {scheme: generalized_alpha, spectral_radius: 0.5}}\n",
    kBlock +
        "experiment: {kind: motion, fixture: {kind: tension, force: 1}, in_time: {step: {at: 0.5}}}\n"
        "time: {duration: 1, integrator: {scheme: newmark}, step: {error: 0.001}}\n"
        "contact: {obstacles: [{sphere: {radius: 1}, at: [0, 0, -9]}, {cylinder: {radius: 1, length: 1}, at: [0, 0, "
        "-19]},"
        " {capsule: {radius: 1, length: 1}, at: [0, 0, -29]}, {mesh: {file: " +
        kScenes +
        "/material/ball.stl,"
        " length_unit: mm}, at: [0, 0, -39]}]}\n",
    "body: {lattice: {kind: cubic, molecules: [2, 2, 2], spacing: 1, connections: {within: 1.5}}}\n"
    "material: {youngs_modulus: 1000}\nstiffness: {strategy: lattice}\nstrategies: [{strategy: angles}]\n" +
        kFree,
    "body: {lattice: {kind: body_centred, cells: [1, 1, 1], spacing: 1, connections: second}}\n"
    "material: {youngs_modulus: 1000}\nstiffness: standard\n" +
        kFree,
    "body: {molecules: [[0, 0, 0], [0, 0, 1]], connections: {within: 1.5}}\n"
    "material: {youngs_modulus: 1000}\nstiffness: standard\n" +
        kFree,
    kBlock +
        "experiment: {kind: tension, force: 1}\nreference: {computed: {uncertainty: 0.01, most_cells: 1000, seconds: 9,"
        " strategy: neo_hookean}}\n",
    "body: {sheet: {size: [1, 1], squares: [2, 2]}}\n" + kMembrane + kFree + "loads: [{pressure: {pressure: 1}}]\n",
    kBlock +
        "experiment: {kind: tension, strain: 0.1}\nsupports: [{molecules: [0], fix: [x]}, {molecules: {side: z}},"
        " {molecules: {box: {from: [0, 0, 0], to: [1, 1, 1]}}}, {molecules: {nearest: [0, 0, 0]}},"
        " {molecules: {plane: {point: [0, 0, 0], normal: z, within: 0.1}}},"
        " {molecules: {sphere: {centre: [0, 0, 0], radius: 0.1}}}]\n",
    "body: {tetrahedra: {kind: kuhn, cubes: [2, 1, 1], size: [2, 1, 1]}, grade: {axis: x, ratio: 2, ends: both},"
    " regions: [{molecules: [0, 1], stiffness: 2}]}\n" +
        kSolid + kFree,
    "body: {sheet: {size: [1, 1], squares: [2, 2]}}\n" + kMembrane +
        "experiment: {kind: vibration}\nsupports: [{molecules: {rim: true}}]\n",
    "body: {mesh: {file: " ELASTIN_TEST_DATA "/mesh/data/gmsh_groups_41.msh, length_unit: m}}\n" + kSolid +
        "experiment: {kind: vibration}\nsupports: [{molecules: {set: base}}]\n",
    "body: {tetrahedra: {kind: kuhn, cubes: [1, 1, 2], size: [1, 1, 2]}}\nstiffness: neo_hookean\n"
    "material: {youngs_modulus: 1000, fields: {stiffness: {expression: 2}, density: {expression: 900}, youngs_modulus:"
    " {file: " ELASTIN_TEST_DATA "/mesh/data/layers.vtk, data: E, unit: Pa, length_unit: m}}}\n" +
        kFree,
    "body: {sphere: {radius: 1, divisions: 2}}\n" + kMembrane +
        "experiment: {kind: inflation, gas: {amount: 1e6}}\nloads: [{gas: {amount: 1e6}}]\n",
};

/// The keys of `identify` that no scene of the tree has.
const std::string kIdentify =
    "material: {law: mooney_rivlin, c1: 1 kPa, c2: 0.1 kPa}\n"
    "identify: {unknowns: {c1: {low: 0 Pa, high: 9 kPa, start: 1 kPa}}, fixed: [c2], residuals: absolute, starts: 2,"
    " laws: all, tests: [{kind: relaxation, name: a, file: a.csv, strain: 0.1, held: uniaxial, ramp: 1 s, from: 0 s, "
    "to: 9 s, weight: 1,"
    " residuals: relative, cross_section: 1 mm2, length: 1 mm, columns: {a: time}, rows: {b: c}},"
    " {kind: specimen, file: a.csv, scene: b.yaml}]}\n";

std::string path_of(const std::string& section, const std::string& key) {
  return section.empty() ? key : section + "." + key;
}

/// Keys by path. A key may stand in two tables of one section.
std::map<std::string, SceneKey> listed_keys() {
  std::map<std::string, SceneKey> listed;
  for (const KeySection& section : key_sections(built_in_catalog(), built_in_experiments()))
    for (const SceneKey& key : section.keys) listed[path_of(section.path, key.name)] = key;
  return listed;
}

/// Of all scenes but those of the zoo, whose 33 bodies take long to build and have no other keys.
KeyUses uses_of_scenes() {
  KeyUses uses;
  for (const auto& entry : fs::recursive_directory_iterator(kScenes))
    if (entry.path().parent_path().filename() == "identify" && entry.path().extension() == ".yaml")
      load_identify_task(entry.path().string(), built_in_catalog(), {}, &uses);
    else if (entry.path().extension() == ".yaml" && entry.path().parent_path().filename() != "zoo")
      load_scene(entry.path().string(), built_in_catalog(), {}, kMostMolecules, built_in_experiments(), &uses);
  return uses;
}

bool has_word(const std::string& text, const std::string& word) { return text.find(word) != std::string::npos; }

/// What the reference says wrongly of a key that was read so; "" = nothing.
std::string fault_of(const SceneKey& key, const KeyUse& use) {
  const bool direction = has_word(key.type, "direction"), any = key.unit == "the measure's";
  const bool many = use.kinds.contains("list"), numbers = has_word(key.type, "vector") || has_word(key.type, "pairs");
  for (const std::string& kind : use.kinds) {
    const bool list = kind == "list" && (numbers || has_word(key.type, "list") || has_word(key.type, "two") ||
                                         has_word(key.type, "three"));
    const bool inside = many && numbers && (kind == "quantity" || kind == "number");  // of a vector or pair
    const std::string stem = kind == "quantity" ? "quantit" : kind;
    if (!direction && !any && !list && !inside && !has_word(key.type, stem)) return "is read as " + kind;
  }
  for (const std::string& unit : use.units)
    if (!any && !has_word(", " + key.unit + ",", ", " + unit + ",")) return "has the unit " + unit;
  for (const std::string& range : use.ranges)
    if (!has_word(", " + key.range + ",", ", " + range + ",")) return "has the range " + range;
  if (!key.range.empty() && !use.kinds.empty() && use.ranges.empty()) return "has no range";
  for (const std::string& word : use.words)
    if (!direction && !has_word(key.type, "`" + word + "`")) return "may be " + word;
  return "";
}

}  // namespace

TEST_CASE("the key reference lists what readers ask for, with unit, range and words", "[scene][keys][slow]") {
  KeyUses uses = uses_of_scenes();
  const TemporaryFolder folder;
  load_identify_task(folder.write("identify.yaml", kIdentify), built_in_catalog(), {}, &uses);
  for (const std::string& text : kRest)
    load_scene(folder.write("rest.yaml", text), built_in_catalog(), {}, kMostMolecules, built_in_experiments(), &uses);
  const std::map<std::string, SceneKey> listed = listed_keys();
  for (const auto& [path, use] : uses) {
    INFO(path);
    const auto found = listed.find(path);
    const auto inside = listed.lower_bound(path + ".");
    const bool known = found != listed.end() || (inside != listed.end() && inside->first.starts_with(path + "."));
    CHECK(known);  // a key that readers ask for is in the reference, itself or by the keys of its map
    if (found != listed.end()) CHECK(fault_of(found->second, use) == "");
  }
  for (const auto& [path, key] : listed) {
    INFO(path);
    CHECK(uses.contains(path));
    CHECK_FALSE(key.text.empty());
    CHECK_FALSE(key.fallback.empty());
    CHECK_FALSE(key.type.empty());
  }
}

TEST_CASE("a key that the reference leaves out or tells wrongly is found", "[scene][keys]") {
  const SceneKey key{"force", "quantity", "N", "> 0", "needed", "on the end"};
  CHECK(fault_of(key, {{"quantity"}, {"N"}, {"> 0"}, {}}) == "");
  CHECK(fault_of(key, {{"whole"}, {}, {"> 0"}, {}}) == "is read as whole");
  CHECK(fault_of(key, {{"quantity"}, {"m"}, {"> 0"}, {}}) == "has the unit m");
  CHECK(fault_of(key, {{"quantity"}, {"N"}, {"≥ 0"}, {}}) == "has the range ≥ 0");
  CHECK(fault_of(key, {{"quantity"}, {"N"}, {}, {}}) == "has no range");
  CHECK(fault_of({"sides", "`free`", "", "", "`free`", "…"}, {{}, {}, {}, {"free", "affine"}}) == "may be affine");
}

TEST_CASE("ranges of keys are written as one reads them", "[scene][keys]") {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  CHECK(range_text(-infinity, infinity, false) == "");
  CHECK(range_text(0, infinity, true) == "> 0");
  CHECK(range_text(0, infinity, false) == "≥ 0");
  CHECK(range_text(-0.99, 0.5, false) == "−0.99 … 0.5");
  CHECK(range_text(0, 1, true) == "> 0 … 1");
}
