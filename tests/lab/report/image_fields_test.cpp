// The last state of a run as images.

#include "lab/report/image_fields.h"
#include "lab/run/cell_stress.h"

#include <catch2/catch.hpp>
#include <cstring>

#include "lab/report/page.h"
#include "lab/report/records.h"
#include "lab/run/specimen.h"
#include "mesh/image_file.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;
using Catch::Matchers::Contains;

namespace {

const Catalog kCatalog = built_in_catalog();

struct Ran {
  std::unique_ptr<Scene> scene;
  Run run;
};

Ran run_of(const TemporaryFolder& folder, const std::string& body, const std::string& more = "") {
  Ran ran{
      load_scene(folder.write("scene.yaml",
                              "body: " + body +
                                  "\nmaterial: {youngs_modulus: 10 kPa, poissons_ratio: 0}\nstiffness: neo_hookean\n"
                                  "experiment: {kind: tension, axis: z, strain: 20 %}\nreference: none\n" +
                                  more),
                 kCatalog),
      {}};
  prepare(ran.scene->specimen, ran.scene->stiffness.strategy);
  ran.run = run_strategy(ran.scene->specimen, *ran.scene->experiment, ran.scene->stiffness,
                         {.statics = ran.scene->statics, .keep_snapshots = true});
  REQUIRE(ran.run.outcome == Outcome::converged);
  return ran;
}

/// Voxels of 2 × 1 × 1 mm: a bar of 4 × 4 × 6 mm in air, the upper half label 3.
std::string bar(const std::string& space) {
  std::string text = "NRRD0004\ntype: uchar\ndimension: 3\nspace: " + space +
                     "\nsizes: 4 6 8\nspace directions: (2,0,0) (0,1,0) (0,0,1)\nspace origin: (1,0.5,0.5)\n"
                     "encoding: ascii\n\n";
  for (int z = 0; z < 8; ++z)
    for (int y = 0; y < 6; ++y)
      for (int x = 0; x < 4; ++x) text += x % 3 == 0 || y % 5 == 0 || z < 1 || z > 6 ? "0 " : z < 4 ? "1 " : "3 ";
  return text;
}

}  // namespace

TEST_CASE("image out: strain, label and displacement on the grid of the body's own image", "[image]") {
  const TemporaryFolder folder;
  folder.write("a.nrrd", bar("left-posterior-superior"));
  const std::string turn = GENERATE("", "rotate: {axis: x, angle: 30 deg}\n");  // the scene's, not the image's
  const Ran ran = run_of(folder, "{image: {file: a.nrrd, length_unit: mm, labels: [1, 3]}}", turn);
  // Stretched by 20 % from its lower end, z = 1 mm: λ²/2 − ½ of Green and Lagrange.
  for (const std::string ending : {".nii.gz", ".nii", ".nrrd"}) {
    INFO(ending);
    write_image(folder.path("out" + ending), 0, *ran.scene, ran.run);
    const mesh::Image strain = mesh::load_image(folder.path("out-strain" + ending));
    const mesh::Image label = mesh::load_image(folder.path("out-label" + ending));
    CHECK(strain.size == std::array<int, 3>{4, 6, 8});
    const bool turned = ending != ".nrrd";  // NIfTI has RAS
    CHECK(strain.space == (turned ? "RAS" : "LPS"));
    CHECK(strain.origin.isApprox(turned ? Vector3(-1, -0.5, 0.5) : Vector3(1, 0.5, 0.5)));
    CHECK(strain.steps.col(0).isApprox(Vector3(turned ? -2 : 2, 0, 0)));
    CHECK(strain.at(1, 3, 4) == Approx(0.22).epsilon(1e-5));
    CHECK(strain.at(0, 3, 4) == 0);
    // The boundary of the labels goes from z = 4 mm to 4.6 mm, the upper end from 7 mm to 8.2 mm.
    CHECK(label.at(1, 1, 0) == 0);
    CHECK(label.at(1, 1, 3) == 1);
    CHECK(label.at(1, 1, 4) == 1);
    CHECK(label.at(1, 1, 5) == 3);
    CHECK(label.at(1, 1, 7) == 3);
  }
  CHECK_THAT(body_view(*ran.scene, make_record(*ran.scene, ran.run)), Contains(R"("image":{"size":[4,6,8])"));
  const std::string file = text_of_file(folder.path("out.nii"));
  REQUIRE(file.size() == 352 + 4 * 3 * 192);
  const auto component = [&](int i, std::size_t x, std::size_t y, std::size_t z) {
    float value = 0;
    std::memcpy(&value, file.data() + 352 + 4 * (192 * static_cast<std::size_t>(i) + x + 4 * (y + 6 * z)), 4);
    return value;
  };
  CHECK(component(2, 1, 2, 5) == Approx(0.2 * 4.5).epsilon(1e-5));
  CHECK(component(2, 0, 2, 5) == 0);
  CHECK_THAT(text_of_file(folder.path("out.nrrd")).substr(0, 200),
             Contains("dimension: 4") && Contains("sizes: 3 4 6 8"));
}

TEST_CASE("image out: any body that cells fill, on a grid that is stated", "[image]") {
  const TemporaryFolder folder;
  const Ran ran = run_of(folder, "{tetrahedra: {kind: kuhn, cubes: [2, 2, 4], size: [4 mm, 4 mm, 8 mm]}}");
  CHECK_THROWS_WITH(check_image("out.nii", 0, *ran.scene), Contains("--image-spacing"));
  CHECK_THROWS_WITH(check_image("out.png", 1e-3, *ran.scene), Contains(".nii.gz"));
  write_image(folder.path("out.nii.gz"), 1e-3, *ran.scene, ran.run);
  const mesh::Image strain = mesh::load_image(folder.path("out-strain.nii.gz"));
  CHECK(strain.size == std::array<int, 3>{5, 5, 11});
  CHECK(strain.unit == 1e-3);
  CHECK(strain.at(2, 2, 4) == Approx(0.22).epsilon(1e-5));
  const auto chain = load_scene(folder.write("chain.yaml",
                                             "body: {molecules: [[0, 0, 0], [0, 0, 15 mm]], connections: [[0, 1]], "
                                             "radius: 15 mm}\nmaterial: {youngs_modulus: 10 kPa}\nstiffness: standard\n"
                                             "experiment: {kind: tension, force: 9 N, cross_section: 1 mm2}\n"),
                                kCatalog);
  CHECK_THROWS_WITH(check_image("out.nii", 1e-3, *chain), Contains("cells fill"));
}

TEST_CASE("image out: of labels that are bodies of hexahedra, whose states are all kept", "[image]") {
  const TemporaryFolder folder;
  folder.write("a.nrrd", bar("right-anterior-superior"));
  const Ran ran = run_of(folder,
                         "{image: {file: a.nrrd, length_unit: mm, labels: {1: {}, 3: {material: {law: neo_hookean_log, "
                         "youngs_modulus: 10 kPa, poissons_ratio: 0}}}}}");
  REQUIRE(ran.scene->specimen.body.parts.size() == 2);
  const std::vector<CellState> states = cell_states(ran.scene->specimen.body, ran.run.snapshots.back());
  REQUIRE(states.size() == 2 * 4 * 6);
  for (const CellState& state : states) CHECK(state.strain(2, 2) == Approx(0.22).epsilon(1e-5));
}
