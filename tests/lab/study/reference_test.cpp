// References that compute themselves, compared with independent ones, and where they are computed at all.

#include "lab/study/reference.h"

#include <sys/wait.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "elastin/core/base/error.h"
#include "lab/report/comparison.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;
using Catch::Matchers::Contains;
using Json = nlohmann::json;

namespace {

/// A scene in a folder of its own.
struct Written {
  explicit Written(const std::string& text) : path(folder.write("scene.yaml", text)) {}
  std::unique_ptr<Scene> load(const std::vector<std::string>& overrides = {}) const {
    return load_scene(path, built_in_catalog(), overrides);
  }
  ComputedReferences compute(const std::vector<std::string>& overrides = {}) const {
    ReferenceStore store;
    return compute_references(*load(overrides), built_in_catalog(), overrides, store, {}, {});
  }
  /// Runs the command in the folder; what it prints is in `out` and `err`.
  int command(const std::string& line) const {
    const int status =
        std::system(("cd '" + folder.path("") + "' && '" ELASTIN_COMMAND "' " + line + " > out 2> err").c_str());
    REQUIRE(WIFEXITED(status));
    return WEXITSTATUS(status);
  }
  std::string out() const { return text_of_file(folder.path("out")); }
  TemporaryFolder folder;
  std::string path;
};

const Reference& of(const ComputedReferences& found, const std::string& measure) {
  for (const Reference& reference : found.references)
    if (reference.measure == measure) return reference;
  FAIL("no reference of " + measure + ": " + found.trouble);
  return found.references.front();
}

std::string block(const std::string& body, const std::string& material, const std::string& experiment,
                  const std::string& more = "") {
  return "body: {tetrahedra: {kind: body_centred, " + body + "}}\nmaterial: {" + material +
         "}\nstiffness: neo_hookean\nexperiment: {kind: tension, axis: z, " + experiment + "}\n" + more;
}

const std::string kT1 = "cubes: [4, 4, 2], size: [30 mm, 30 mm, 15 mm]",
                  kT2 = "cubes: [4, 4, 3], size: [1 m, 1 m, 0.86 m]",
                  kClamped = "fixed_grip: clamped, loaded_grip: clamped", kSmall = "solver: {displacements: small}\n",
                  kCells = "reference: {computed: {most_cells: 60000}}\n",
                  kBar = "cubes: [1, 1, 3], size: [1 mm, 1 mm, 3 mm]",
                  kRubber = "youngs_modulus: 5 kPa, poissons_ratio: 0.3";

const std::string kDogbone = "body: {mesh: {file: '" ELASTIN_SOURCE_DIR
                             "/scenes/tension/dogbone.msh', length_unit: mm}}\n"
                             "material: {youngs_modulus: 10 kPa, poissons_ratio: 0.25}\nstiffness: neo_hookean\n"
                             "strategies: [\"calibrated:standard\", neo_hookean]\n"
                             "experiment: {kind: tension, axis: z, displacement: 1 mm, fixed_grip: clamped, "
                             "loaded_grip: clamped}\nreference: {computed: {uncertainty: 1 %, most_cells: 30000}}\n";

}  // namespace

TEST_CASE("a clamped block under dead traction is known to what is stated", "[reference][slow]") {
  // Converged Q2 to Q4 hexahedra of another program: modulus over E and elongation [m], each within 6e-5 at most.
  struct Row {
    std::string scene;
    double youngs_modulus, modulus, elongation;
  };
  const std::vector<Row> rows{
      {block(kT1, kRubber, "force: 1 N, fixed_grip: clamped", kCells), 5e3, 0.92587, 0.0036002},
      {block(kT1, "youngs_modulus: 5 kPa, poissons_ratio: 0.25", "force: 1 N, fixed_grip: clamped", kSmall), 5e3,
       1.04069778, 0.00320297919},
      {block(kT2, "youngs_modulus: 100 kPa, poissons_ratio: 0.3", "force: 1 kN, fixed_grip: clamped", kCells), 1e5,
       1.028665, 0.00836035},
      {block(kT2, "youngs_modulus: 100 kPa, poissons_ratio: 0.3", "force: 1 kN, fixed_grip: clamped", kSmall), 1e5,
       1.03537645, 0.00830615765}};
  for (const Row& row : rows) {
    INFO(row.scene);
    const ComputedReferences found = Written(row.scene).compute();
    const Reference& modulus = of(found, "effective_modulus");
    CHECK(std::abs(modulus.value / row.youngs_modulus / row.modulus - 1) <= modulus.uncertainty + 6e-5);
    const Reference& elongation = of(found, "elongation");
    CHECK(std::abs(elongation.value / row.elongation - 1) <= elongation.uncertainty + 6e-5);
    CHECK(modulus.uncertainty <= 3e-3);
    CHECK((modulus.computed && modulus.seconds > 0));
    CHECK_THAT(modulus.source, Contains("neo_hookean on") && Contains("order 1."));
  }
}

TEST_CASE("a lattice and the molecules of a packing have the domain that they fill", "[reference][slow]") {
  // Small displacements of a clamped bar of 1 x 1 x 2: the same solid, however its molecules lie.
  const std::string rest =
      "\nmaterial: {youngs_modulus: 5 kPa, poissons_ratio: 0.25}\nstiffness: standard\n"
      "experiment: {kind: tension, axis: z, displacement: 0.02 mm, " +
      kClamped + "}\n" + kSmall + kCells;
  std::vector<Reference> found;
  for (const std::string body : {"tetrahedra: {kind: kuhn, cubes: [3, 3, 6], size: [1 mm, 1 mm, 2 mm]}",
                                 "lattice: {kind: cubic, molecules: [4, 4, 7], spacing: 0.333333333333333 mm}",
                                 "lattice: {kind: body_centred, cells: [3, 3, 6], spacing: 0.333333333333333 mm}"})
    found.push_back(of(Written("body: {" + body + "}" + rest).compute(), "effective_modulus"));
  for (const Reference& reference : found)
    CHECK(std::abs(reference.value / found[0].value - 1) <= reference.uncertainty + found[0].uncertainty);
  // More than E, which the clamps make of it, and less than what no lateral motion would: E (1 − ν) / ((1 + ν) (1 −
  // 2ν)).
  CHECK((found[0].value > 5e3 && found[0].value < 1.2 * 5e3));
}

TEST_CASE("Poisson's ratio of a clamped lattice has the reference of the block that it fills", "[reference][slow]") {
  const auto ratio = [](const std::string& lattice, const std::string& law) {
    const Written scene("body: {lattice: {kind: cubic, molecules: [3, 3, 4], spacing: 3 mm, " + lattice +
                        "}}\nmaterial: {youngs_modulus: 10 kPa, poissons_ratio: 0.25}\nstiffness: " + law +
                        "\nexperiment: {kind: tension, axis: z, displacement: 1 um, " + kClamped + "}\n" + kSmall +
                        "reference: computed\n");
    return of(scene.compute(), "poissons_ratio").value;
  };
  CHECK(ratio("connections: [axis, face]", "lattice") == Approx(ratio("order: 2", "neo_hookean")).epsilon(1e-6));
}

TEST_CASE("a membrane is refined by its own law", "[reference]") {
  const ComputedReferences found =
      Written(
          "body: {sheet: {size: [20 mm, 20 mm], squares: [2, 2], pattern: crossed}}\n"
          "material: {youngs_modulus: 500 kPa, poissons_ratio: 0.3, thickness: 1 mm}\n"
          "stiffness: neo_hookean_membrane\nexperiment: {kind: tension, axis: y, displacement: 0.2 mm, "
          "cross_section: 20 mm2, " +
          kClamped + "}\n" + kSmall)
          .compute();
  const Reference& modulus = of(found, "effective_modulus");
  // Plane stress between E, free sides, and E / (1 − ν²), no lateral motion at all.
  CHECK((modulus.value > 500e3 && modulus.value < 500e3 / 0.91));
  CHECK_THAT(modulus.source, Contains("neo_hookean_membrane on 16 to"));
}

TEST_CASE("progress of a reference says how long the next body may take", "[reference][slow]") {
  const Written bar(block(kBar, kRubber, "displacement: 0.1 mm, " + kClamped, kSmall));
  ReferenceStore store;
  std::vector<std::string> said;  // as each body begins
  const auto tell = [&](const std::string& doing) {
    if (!Contains(": ").match(doing)) said.push_back(doing);
  };
  compute_references(*bar.load(), built_in_catalog(), {}, store, tell, {});
  REQUIRE(said.size() >= 3);
  CHECK_THAT(said[0], !Contains("up to"));  // nothing is known yet
  CHECK_THAT(said[1], Contains(", up to ") && !Contains("known to"));
  CHECK_THAT(said[2], Contains(", up to ") && Contains("known to") && Contains("target 0.1 %"));
}

TEST_CASE("a prism with sliding grips shows the material and has no computed reference", "[reference]") {
  const Written prism(block(kBar, kRubber, "displacement: 0.1 mm"));
  CHECK_FALSE(wants_computed_references(*prism.load(), ""));
  CHECK(wants_computed_references(*prism.load({"reference=computed"}), ""));
  CHECK(wants_computed_references(*prism.load(), "computed"));
  // Requested, it is the material's own: the patch test, whatever the cells.
  const ComputedReferences found = prism.compute({"solver.displacements=small"});
  CHECK(of(found, "effective_modulus").value == Approx(5e3).epsilon(1e-6));

  const Written clamped(block(kBar, kRubber, "displacement: 0.1 mm, " + kClamped));
  CHECK(wants_computed_references(*clamped.load(), ""));
  CHECK_FALSE(wants_computed_references(*clamped.load(), "none"));
  CHECK_FALSE(wants_computed_references(*clamped.load({"reference=none"}), ""));
  CHECK(wants_computed_references(*clamped.load({"reference=none"}), "computed"));
  const std::string stated = "{measure: effective_modulus, value: 6 kPa, source: elsewhere}";
  CHECK_FALSE(wants_computed_references(*clamped.load({"reference=[" + stated + "]"}), ""));
  CHECK_FALSE(wants_computed_references(*clamped.load({"reference=" + stated}), ""));
  CHECK(wants_computed_references(*clamped.load({"reference=[computed, " + stated + "]"}), ""));
}

TEST_CASE("a block sheared with free sides is compared with the solid, but for a force that is next to nothing",
          "[reference][shear][slow]") {
  const Written scene(
      "body: {tetrahedra: {kind: kuhn, cubes: [3, 3, 4], size: [6 mm, 6 mm, 8 mm], order: 2}}\n"
      "material: {youngs_modulus: 10 kPa, poissons_ratio: 0.3}\nstiffness: neo_hookean\n"
      "experiment: {kind: shear, axis: z, direction: x, strain: 1 %}\n"
      "solver: {displacements: small}\nreference: {computed: {uncertainty: 1 %}}\n");
  const ComputedReferences found = scene.compute();
  // Timoshenko: F = u / (h³ / (12 E I) + 1.2 h / (G A)), which a block this short has within some tenths.
  const double h = 8e-3, a = 6e-3, G = 1e4 / 2.6;
  const double beam = 0.01 * h / (h * h * h / (1e4 * a * a * a * a) + 1.2 * h / (G * a * a));
  CHECK(of(found, "force").value == Approx(beam).epsilon(0.2));
  CHECK(of(found, "shear_modulus").value < 0.6 * G);
  CHECK(std::none_of(found.references.begin(), found.references.end(),
                     [](const Reference& reference) { return reference.measure == "axial_force"; }));
  const auto affine = scene.load({"experiment.sides=affine"});
  CHECK(no_reference(*affine).empty());
}

TEST_CASE("the reference of a scan has boxes down to the image's voxels", "[reference][image][slow]") {
  // A ball of 24 voxels; boxes of 4 voxels that are body or not are far from it.
  const Written ball(
      "body: {image: {file: ball.nrrd, length_unit: mm, spacing: 4 mm}}\n"
      "material: {youngs_modulus: 10 kPa, poissons_ratio: 0.3}\nstiffness: neo_hookean\n"
      "experiment: {kind: tension, axis: z, grip_depth: 5 mm, displacement: 0.1 mm, fixed_grip: clamped, "
      "loaded_grip: clamped, cross_section: 400 mm2}\nsolver: {displacements: small}\nreference: computed\n");
  std::string image = "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 26 26 26\nspacings: 1 1 1\nencoding: ascii\n\n";
  for (int voxel = 0; voxel < 26 * 26 * 26; ++voxel) {
    const double x = voxel % 26 - 12.5, y = voxel / 26 % 26 - 12.5, z = voxel / 676 - 12.5;
    image += x * x + y * y + z * z < 144 ? "1 " : "0 ";
  }
  ball.folder.write("ball.nrrd", image);
  const ComputedReferences coarse = ball.compute(), voxels = ball.compute({"body.image.spacing=1 mm"});
  const Reference &own = of(coarse, "effective_modulus"), &fine = of(voxels, "effective_modulus");
  INFO(own.source << " " << own.value << " ± " << own.uncertainty << "; " << fine.source << " " << fine.value);
  CHECK_THAT(own.source, Contains("hexahedra of 27 nodes") && !Contains("order "));
  CHECK(own.value == Approx(fine.value).epsilon(own.uncertainty + fine.uncertainty));
  CHECK(own.uncertainty < 0.1);
  CHECK(coarse.references.size() == voxels.references.size());
}

TEST_CASE("keys of a computed reference are read, and slips named", "[reference][scene][slow]") {
  const Written scene(block(kBar, kRubber, "displacement: 0.1 mm, " + kClamped,
                            "reference: {computed: {uncertainty: 0.5 %, most_cells: 5000, seconds: 20 s, strategy: "
                            "st_venant_kirchhoff}}\n"));
  const ComputedReference how = scene.load()->computed;
  CHECK((how.when == ComputedReference::When::always && how.uncertainty == Approx(0.005) && how.most_cells == 5000 &&
         how.seconds == 20 && how.strategy == "st_venant_kirchhoff"));
  CHECK_THAT(of(scene.compute(), "effective_modulus").source, Contains("st_venant_kirchhoff on 36 to"));
  for (const auto& [value, message] : std::vector<std::pair<std::string, std::string>>{
           {"compute", "'compute' is not known here; did you mean 'computed'"},
           {"[none]", "stands alone"},
           {"{computed: {uncertainty: 0.5}}", "0.05"},
           {"{computed: {strategy: neo_hooke}}", "did you mean 'neo_hookean'"},
           {"{computed: {cells: 7}}", "unknown key 'cells'"},
           {"{computed: {}, value: 1}", "unknown key 'value'"}})
    CHECK_THROWS_WITH(scene.load({"reference=" + value}), Contains(message));
}

TEST_CASE("what has no solution to refine gets a reason, in a sentence", "[reference]") {
  const std::string graph =
      "body: {molecules: [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.2, 0.2, 1], [0.1, 1, 1.1], [1, 0, 1]], connections: "
      "{within: 2}}\nmaterial: {youngs_modulus: 1000}\nstiffness: standard\nexperiment: {kind: tension, displacement: "
      "0.01, grip_depth: 0.2, fixed_grip: clamped, loaded_grip: clamped}\n";
  const Written listed(graph);
  const ComputedReferences none = listed.compute();
  CHECK(none.references.empty());
  CHECK_THAT(none.trouble, Contains("does not say what it fills (`cells: delaunay`"));
  CHECK(listed.compute({"body.cells=delaunay", "reference={computed: {most_cells: 100}}"})
            .trouble.find("what it fills") == std::string::npos);
  CHECK_THAT(Written("body: {tetrahedra: {kind: kuhn, cubes: [1, 1, 2], size: [1, 1, 2]}}\nmaterial: {youngs_modulus: "
                     "1000}\nstiffness: neo_hookean\nexperiment: {kind: motion}\ntime: {duration: 1}\n")
                 .compute()
                 .trouble,
             Contains("no equilibrium to refine"));
}

TEST_CASE("a body without Poisson's ratio has its reference as soon as its modulus is known", "[reference]") {
  const std::string tapered =
      "body: {tetrahedra: {kind: kuhn, cubes: [2, 2, 4], size: [10 mm, 10 mm, 20 mm]}, regions: [{from: [0, 0, 0], "
      "to: [10 mm, 10 mm, 10 mm], stiffness: 3}]}\nmaterial: {youngs_modulus: 10 kPa, poissons_ratio: 0}\nstiffness: "
      "neo_hookean\nexperiment: {kind: tension, axis: z, strain: 0.05}\n" +
      kSmall;
  const ComputedReferences found = Written(tapered).compute({"reference={computed: {most_cells: 60000}}"});
  CHECK(of(found, "effective_modulus").value == Approx(15e3).epsilon(1e-6));  // of 10 and 30 kPa in series
  CHECK_THAT(of(found, "effective_modulus").source, Contains("on 96 to 768 "));
}

TEST_CASE("what yields without limit as cells are refined has no computed reference", "[reference][slow]") {
  // A force on one molecule: the displacement goes with one over the cells' size.
  const ComputedReferences found =
      Written(block("cubes: [2, 2, 2], size: [10 mm, 10 mm, 20 mm]", "youngs_modulus: 30 kPa, poissons_ratio: 0.3",
                    "force: 1 mN, loaded: {nearest: [5 mm, 5 mm, 20 mm]}, fixed_grip: clamped",
                    "reference: {computed: {most_cells: 7000}}\n"))
          .compute();
  CHECK(found.references.empty());
  CHECK_THAT(found.trouble, Contains("no limit shows of E") && Contains("hold a patch"));
}

TEST_CASE("where one body alone is affordable its cells' order says how well the measures are known",
          "[reference][slow]") {
  const std::string bar = block(kBar, kRubber, "displacement: 0.1 mm, " + kClamped);
  const ComputedReferences coarse = Written(bar + "reference: {computed: {most_cells: 40}}\n").compute();
  const ComputedReferences exact = Written(bar).compute();
  const Reference &rough = of(coarse, "effective_modulus"), &fine = of(exact, "effective_modulus");
  CHECK_THAT(rough.source, Contains("on 36 tetrahedra of second order, compared with first order"));
  CHECK(std::abs(rough.value / fine.value - 1) <= rough.uncertainty);
  CHECK((rough.uncertainty > 10 * fine.uncertainty && rough.uncertainty < 0.1));
}

TEST_CASE("a reference that takes too long is given up, and one that is interrupted is not kept", "[reference][slow]") {
  const std::string bar = block(kBar, kRubber, "displacement: 0.1 mm, " + kClamped);
  CHECK_THAT(Written(bar + "reference: {computed: {seconds: 1e-9 s}}\n").compute().trouble,
             Contains("given up after") && Contains("computed.seconds"));

  const Written scene(bar);
  ReferenceStore store(scene.folder.path("kept"));
  int asked = 0;
  const auto compute = [&](const std::function<bool()>& stop) {
    return compute_references(*scene.load({}), built_in_catalog(), {}, store, {}, stop);
  };
  CHECK(compute([&] { return ++asked > 8; }).trouble == "interrupted");
  const ComputedReferences whole = compute({});
  CHECK(whole.trouble.empty());
  REQUIRE(!whole.references.empty());
  CHECK(!whole.references.front().read_back);
}

TEST_CASE("a reference that was computed is read back equal, on whatever cells the body is made of",
          "[reference][slow]") {
  const Written scene(
      block(kBar, kRubber, "displacement: 0.1 mm, " + kClamped, "reference: {computed: {uncertainty: 0.5 %}}\n"));
  ReferenceStore store(scene.folder.path("kept"));
  int solved = 0;
  const auto count = [&](const std::string&) { ++solved; };
  const auto compute = [&](ReferenceStore& in, const std::vector<std::string>& overrides) {
    return compute_references(*scene.load(overrides), built_in_catalog(), overrides, in, count, {});
  };
  const ComputedReferences first = compute(store, {});
  const int bodies = solved;
  CHECK(bodies >= 3);
  ReferenceStore again(scene.folder.path("kept"));
  ComputedReferences second = compute(again, {});
  CHECK(solved == bodies);
  REQUIRE(second.references.size() == first.references.size());
  for (Reference& reference : second.references) {
    CHECK(reference.read_back);
    reference.read_back = false;
  }
  CHECK(second == first);
  compute(again, {"stiffness=van_gelder", "body.tetrahedra.cubes=[2, 2, 6]"});  // the same block
  CHECK(solved == bodies);
  for (const std::string change : {"material.poissons_ratio=0.2", "experiment.displacement=0.0002",
                                   "body.tetrahedra.size=[0.001, 0.002, 0.003]", "solver.displacements=small"}) {
    const int before = solved;
    compute(again, {change});
    CHECK(solved > before);
  }
  // A depth of 0.75 mm holds nothing but the end of cells of 1 mm, and 0.5 mm of cells of that size.
  const std::string depth = "experiment.grip_depth=0.00075", finer = "body.tetrahedra.cubes=[2, 2, 6]";
  compute(again, {depth});
  const int before = solved;
  compute(again, {depth, finer});
  CHECK(solved > before);
  // One digit that has changed: computed again, and the same.
  std::string damaged = text_of_file(scene.folder.path("kept/references.json"));
  const std::size_t digit = damaged.find("\"value\": ") + 9;
  damaged[digit] = damaged[digit] == '9' ? '8' : '9';
  std::filesystem::create_directory(scene.folder.path("damaged"));
  scene.folder.write("damaged/references.json", damaged);
  ReferenceStore flipped(scene.folder.path("damaged"));
  ComputedReferences third = compute(flipped, {});
  CHECK(solved > before);
  REQUIRE(third.references.size() == first.references.size());
  CHECK(third.references.front().value == first.references.front().value);
  std::filesystem::create_directory(scene.folder.path("other"));
  scene.folder.write("other/references.json", "{\"version\": 0, \"problems\": {}}");
  CHECK(ReferenceStore(scene.folder.path("other")).find("any") == nullptr);
  scene.folder.write("other/references.json", "no JSON");
  CHECK(ReferenceStore(scene.folder.path("other")).find("any") == nullptr);
}

TEST_CASE("compare ranks by the computed reference, shows it and its cost", "[reference][command][slow]") {
  const Written scene(block("cubes: [2, 2, 4], size: [1 mm, 1 mm, 2 mm]", kRubber, "displacement: 0.1 mm, " + kClamped,
                            "strategies: [van_gelder, neo_hookean]\n"));
  REQUIRE(scene.command("compare scene.yaml --out o") == 0);
  CHECK_THAT(scene.out(), Contains("reference: E ") && Contains("computed: neo_hookean on 192 to") &&
                              Contains("E to reference") && Contains("to the material's E") &&
                              Contains("recommended: "));
  CHECK_THAT(text_of_file(scene.folder.path("o/report.html")), Contains("reference: E "));
  const Json json = Json::parse(text_of_file(scene.folder.path("o/runs.json")));
  REQUIRE_FALSE(json["references"].empty());
  const Json& reference = json["references"][0];
  CHECK((reference["scene"] == "scene" && reference["measure"] == "effective_modulus"));
  CHECK((reference["uncertainty"] > 0 && reference["uncertainty"] <= 0.002 && reference["seconds"] > 0));
  const double value = reference["value"], measured = json["runs"][1]["measures"]["effective_modulus"];
  CHECK(json["runs"][1]["errors"]["effective_modulus_to_reference"].get<double>() ==
        Approx(measured / value - 1).epsilon(1e-12));
  REQUIRE(scene.command("compare scene.yaml --out o") == 0);
  CHECK_THAT(scene.out(), Contains("read back, computed in"));
  CHECK(Json::parse(text_of_file(scene.folder.path("o/runs.json")))["references"] == json["references"]);

  REQUIRE(scene.command("compare scene.yaml --reference none") == 0);
  CHECK_THAT(scene.out(), Contains("no reference: the grips clamp") && !Contains("recommended"));
  REQUIRE(scene.command("run scene.yaml") == 0);  // ranks nothing
  CHECK_THAT(scene.out(), !Contains("reference:"));
  REQUIRE(scene.command("run scene.yaml --reference computed") == 0);
  CHECK_THAT(scene.out(), Contains("reference: E ") && Contains("to reference"));
  CHECK(scene.command("run scene.yaml --reference some") == 2);
}

TEST_CASE("a body that is no prism is calibrated to its computed reference and not praised for it",
          "[reference][command][slow]") {
  const Written scene(kDogbone);
  REQUIRE(scene.command("compare scene.yaml --json r.json") == 0);
  const Json json = Json::parse(text_of_file(scene.folder.path("r.json")));
  const Json& springs = json["runs"][0];
  CHECK(springs["outcome"] == "converged");
  CHECK(springs["calibrated_to_reference"] == true);
  CHECK(springs["errors"]["effective_modulus_to_reference"].get<double>() == Approx(0).margin(1e-5));
  CHECK(springs["calibration_factor"].get<double>() != Approx(1).margin(0.05));
  CHECK_THAT(scene.out(), Contains("recommended: neo_hookean:") && Contains("calibrated to the reference by ×"));
  REQUIRE(scene.command("compare scene.yaml --reference none") == 0);
  CHECK_THAT(scene.out(), Contains("not suited: the experiment tension measures on this body no modulus") &&
                              Contains("there is no computed reference"));
}

TEST_CASE("an uncertain reference recommends nothing and says by how much", "[reference]") {
  Record record;
  record.scene = record.title = "block";
  record.run.strategy = "neo_hookean";
  record.run.measures.set("effective_modulus", 1000);
  record.main_measures = {{"effective_modulus", 900}};
  record.no_reference = "the grips clamp";
  for (const auto& [uncertainty, ranked] : {std::pair{0.04, true}, {0.12, false}}) {
    set_references(record, {{"effective_modulus", 1010, "computed: …", uncertainty, true}});
    const Ranking ranking = rank_strategies({record});
    CHECK(ranking.by_reference == ranked);
    CHECK((ranking.best != nullptr) == ranked);
    if (!ranked) CHECK(ranking.no_reference == "the grips clamp; the computed reference of E is uncertain by 12.00 %");
  }
  // Of a ratio the difference counts: 0.05, not a fifth.
  record.main_measures = {{"poissons_ratio", 0.3}};
  record.run.measures.set("poissons_ratio", 0.2);
  set_references(record, {{"poissons_ratio", 0.25, "computed: …", 0.001, true}});
  CHECK(rank_strategies({record}).error(record) == Approx(0.05));
  set_references(record, {{"poissons_ratio", 0.25, "elsewhere", 0.001}});
  CHECK(rank_strategies({record}).error(record) == Approx(0.2));
}
