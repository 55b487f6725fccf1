#include "elastin/config/scene_source.h"

#include <catch2/catch.hpp>

#include "config/scene_tree.h"
#include "elastin/core/base/error.h"
#include "elastin/core/shapes/shapes.h"
#include "elastin/lab/study/laboratory.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

namespace {

const std::string kTension = "\nstiffness: lattice\nexperiment: {kind: tension, force: 1e-3}\n";

std::shared_ptr<const Body> cube() {
  auto body = std::make_shared<Body>(cubic_lattice({3, 3, 3}, 7.5e-3, {.axis = true, .face = true}));
  set_matter(*body, 3.75e-3, 1000, 0, 1e-5);
  return body;
}

}  // namespace

TEST_CASE("A scene in memory is run as a file, with bodies and materials of the program", "[scene]") {
  const auto material = std::make_shared<Material>(Material{.youngs_modulus = 5e3, .density = 900});
  const HeldScene given({"body: {given: 0}\nmaterial: {given: 0}" + kTension, {cube()}, {material}});
  const HeldScene described(
      {"body: {lattice: {kind: cubic, molecules: [3, 3, 3], spacing: 7.5 mm, connections: [axis, "
       "face]}}\nmaterial: {youngs_modulus: 5000, density: 900}" +
       kTension});
  Laboratory one(given), other(described);
  CHECK(one.run().get("effective_modulus") == other.run().get("effective_modulus"));
  CHECK(one.body().mass == cube()->mass);                                 // its own
  CHECK(other.body().mass.sum() == Approx(900 * 15e-3 * 15e-3 * 15e-3));  // of the material
  CHECK(one.name() == "scene");
  const HeldScene shape(
      {"body: {given_shape: 0, radius: 1 mm}\nmaterial: {given: 0, density: 500}" + kTension, {cube()}, {material}});
  const Laboratory third(shape);
  CHECK(third.body().mass.sum() == Approx(500 * 15e-3 * 15e-3 * 15e-3));
  CHECK(third.body().radius[0] == 1e-3);
  CHECK(third.material().youngs_modulus == 5e3);
}

TEST_CASE("Messages of a scene in memory have its own places", "[scene]") {
  const HeldScene scene({"body: {given: 1}\nmaterial: {youngs_modulus: 5 kPa}" + kTension, {cube()}, {}});
  CHECK_THROWS_WITH(Laboratory(scene), StartsWith("scene:1:15: body.given: '1' is not a whole number"));
  const HeldScene misspelt({"body: {given: 0}\nmaterial: {youngs_modulus: 5 kPa, densty: 1}" + kTension, {cube()}, {}});
  CHECK_THROWS_WITH(
      Laboratory(misspelt),
      StartsWith("scene:2:35: material: unknown key 'densty'; did you mean 'density'") && !Contains("given"));
}

TEST_CASE("A scene and what it extends are read once, whatever happens to the files since", "[scene]") {
  const TemporaryFolder folder;
  const std::string base = folder.write("base.yaml", "material: {youngs_modulus: 5 kPa}\n");
  const std::string path = folder.write("scene.yaml", "extends: base.yaml\ntitle: first\n");
  const config::SceneSource source(path), copy(source);
  CHECK(config::load_scene_tree(source, {}).root["title"].Scalar() == "first");
  folder.write("scene.yaml", "extends: base.yaml\ntitle: second\n");
  folder.write("base.yaml", "material: {youngs_modulus: 6 kPa}\n");
  const config::SceneTree again = config::load_scene_tree(copy, {});
  CHECK(again.root["title"].Scalar() == "first");
  CHECK(again.root["material"]["youngs_modulus"].Scalar() == "5 kPa");
  CHECK(source.other(base).text() == "material: {youngs_modulus: 5 kPa}\n");
  CHECK(config::load_scene_tree(path, {}).root["title"].Scalar() == "second");  // another source reads again
  CHECK_THROWS_WITH(config::SceneSource(path + "l").text(), Contains("no such file; did you mean 'scene.yaml'?"));
}
