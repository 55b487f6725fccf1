// Scenes that extend others, and materials by name from a file.

#include <catch2/catch.hpp>

#include "lab/scene/scene.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

namespace {

const std::string kBase = R"(title: Base
body:
  tetrahedra: {kind: kuhn, cubes: [2, 2, 2], size: [10 mm, 10 mm, 10 mm]}
material: {youngs_modulus: 5 kPa, poissons_ratio: 0.3}
stiffness: neo_hookean
experiment: {kind: tension, axis: z, displacement: 1 mm, load_steps: 2}
)";

std::unique_ptr<Scene> load(const std::string& path, const std::vector<std::string>& overrides = {}) {
  return load_scene(path, built_in_catalog(), overrides);
}

std::string refusal(const std::string& path) {
  try {
    load(path);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("a scene that extends another is that scene with its own keys in place of the other's", "[scene][extends]") {
  const TemporaryFolder folder;
  folder.write("base.yaml", kBase);
  const auto own = load(folder.write("own.yaml",
                                     "extends: base.yaml\ntitle: Own\nmaterial: {poissons_ratio: 0.4}\n"
                                     "experiment: {displacement: ~, force: 1 mN}\n"));
  const auto written =
      load(folder.write("written.yaml",
                        "title: Own\nbody:\n  tetrahedra: {kind: kuhn, cubes: [2, 2, 2], size: [10 mm, 10 mm, 10 mm]}\n"
                        "material: {youngs_modulus: 5 kPa, poissons_ratio: 0.4}\nstiffness: neo_hookean\n"
                        "experiment: {kind: tension, axis: z, force: 1 mN, load_steps: 2}\n"));
  CHECK(own->title == "Own");
  CHECK(own->specimen.body.rest == written->specimen.body.rest);
  CHECK(own->specimen.material.youngs_modulus == 5000);
  CHECK(own->specimen.material.poissons_ratio == 0.4);
  const auto measured = [](const Scene& scene) {
    return run_strategy(scene.specimen, *scene.experiment, scene.stiffness, {.statics = scene.statics})
        .measures.get("elongation");
  };
  CHECK(measured(*own) == measured(*written));
  // --set counts before both; a chain of three; another kind replaces the whole map.
  CHECK(load(folder.path("own.yaml"), {"material.poissons_ratio=0.1"})->specimen.material.poissons_ratio == 0.1);
  const auto third =
      load(folder.write("third.yaml", "extends: own.yaml\nexperiment: {kind: shear, direction: x, strain: 10 %}\n"));
  CHECK(third->experiment->name() == "shear");
  CHECK(third->specimen.material.poissons_ratio == 0.4);
}

TEST_CASE("errors name the file in which the wrong key stands", "[scene][extends]") {
  const TemporaryFolder folder;
  const std::string base = folder.write("base.yaml", kBase + "solver: {tolerence: 1e-9}\n"),
                    own = folder.write("own.yaml", "extends: base.yaml\n");
  CHECK_THAT(refusal(own), StartsWith(base + ":7:10: solver: unknown key 'tolerence'"));
  folder.write("base.yaml", kBase);
  CHECK_THAT(refusal(folder.write("own.yaml", "extends: base.yaml\nexperiment: {axes: x}\n")),
             StartsWith(own + ":2:14: experiment: unknown key 'axes'; did you mean 'axis'?"));
  CHECK_THAT(
      refusal(folder.write("own.yaml", "extends: basis.yaml\n")),
      StartsWith(own + ":1:10: extends: " + folder.path("basis.yaml") + ": no such file; did you mean 'base.yaml'?"));
  CHECK_THAT(refusal(folder.write("own.yaml", "extends: own.yaml\n")),
             StartsWith(own + ":1:10: extends: 'own.yaml' is extended already"));
  CHECK_THAT(refusal(folder.write("own.yaml", "extends: [base.yaml]\n")), Contains("name one file"));
}

TEST_CASE("files that a base names lie in the base's folder", "[scene][extends]") {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.path("sub"));
  folder.write("sub/cell.msh",
               "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n"
               "$Elements\n1\n1 4 0 1 2 3 4\n$EndElements\n");
  folder.write("sub/base.yaml",
               "body: {mesh: {file: cell.msh, length_unit: mm}}\nmaterial: {youngs_modulus: 5 kPa}\n"
               "stiffness: neo_hookean\nexperiment: {kind: vibration}\n");
  CHECK(load(folder.write("own.yaml", "extends: sub/base.yaml\n"))->specimen.body.size() == 4);
}

TEST_CASE("a material is taken by name from a file, and the scene's own keys count before it", "[scene][material]") {
  const TemporaryFolder folder;
  folder.write("tissues.yml",
               "values: {soft: 2 kPa}\nskin: {youngs_modulus: = 3 * soft, poissons_ratio: 0.4, density: 1100 kg/m3}\n"
               "rubber: {law: mooney_rivlin, c1: 100 kPa, c2: 10 kPa, bulk_modulus: 10 MPa}\n");
  const auto with = [&](const std::string& material) {
    std::string text = kBase;
    const std::string plain = "material: {youngs_modulus: 5 kPa, poissons_ratio: 0.3}";
    return folder.write("scene.yaml", text.replace(text.find(plain), plain.size(), "material: " + material));
  };
  const auto skin = load(with("{file: tissues.yml, name: skin, poissons_ratio: 0.45}"));
  CHECK(skin->specimen.material.youngs_modulus == Approx(6000));
  CHECK(skin->specimen.material.poissons_ratio == 0.45);
  CHECK(skin->specimen.material.density == 1100);
  const auto rubber = load(with("{file: tissues.yml, name: rubber, density: 1200 kg/m3}"));
  REQUIRE(rubber->specimen.material.law);
  CHECK(rubber->specimen.material.law->numbers.at("c1") == Approx(1e5));
  CHECK(rubber->specimen.material.density == 1200);
  const std::string scene = folder.path("scene.yaml");
  CHECK_THAT(refusal(with("{file: tissues.yml, name: skim}")),
             StartsWith(scene + ":4:37: material.name: 'tissues.yml' has no material 'skim'; did you mean 'skin'?"));
  CHECK_THAT(refusal(with("{file: tissue.yml, name: skin}")), Contains("no such file; did you mean 'tissues.yml'?"));
  CHECK_THAT(refusal(with("{file: tissues.yml}")), Contains("key 'name' is missing"));
  CHECK_THAT(refusal(with("{name: skin}")), Contains("key 'file' is missing"));
}
