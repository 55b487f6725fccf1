// The scenes that `elastin new` writes run as they are.

#include "lab/study/study.h"

#include <sys/wait.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <string>

#include "elastin/core/base/error.h"
#include "elastin/core/simulation/catalog.h"
#include "lab/run/specimen.h"
#include "lab/scene/scene.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;
using Catch::Matchers::Contains;

namespace {

int exit_code(const TemporaryFolder& folder, const std::string& arguments) {
  const int status = std::system(
      ("cd '" + folder.path("") + "' && '" ELASTIN_COMMAND "' " + arguments + " < /dev/null > /dev/null").c_str());
  REQUIRE(WIFEXITED(status));
  return WEXITSTATUS(status);
}

}  // namespace

TEST_CASE("what new writes runs", "[new][slow]") {
  const std::string scenes = ELASTIN_SOURCE_DIR "/scenes/";
  const TemporaryFolder folder;
  for (const NewSpecimen& row : new_specimens()) {
    const std::string name = row.name;
    const std::string file = scenes + (name == "organ"  ? "tissue/organ.stl"
                                       : name == "scan" ? "scans/waist.nrrd"
                                                        : "tension/dogbone.msh");
    CAPTURE(name);
    const std::string of = row.from_file() ? " --mesh '" + file + "'" : " --size '24 x 12 mm x 12 mm'";
    CHECK(exit_code(folder, "new " + name + of) == 0);
    CHECK(exit_code(folder, "compare " + name + ".yaml --reference none --quiet") == 0);  // each of its strategies
    CHECK(exit_code(folder, "new " + name + of) == 2);                                    // already exists
  }
}

TEST_CASE("the sphere of new's indentation presses on enough molecules of its block, cube, layer or bar",
          "[new][slow]") {
  const TemporaryFolder folder;
  const Catalog catalog = built_in_catalog();
  for (const char* size :
       {"10 x 10 x 10 mm", "20 mm x 2 cm x 5 mm", "40 x 10 x 4 mm", "5 x 5 x 14 mm", "3 x 20 x 4 mm"}) {
    INFO(size);
    const auto scene =
        load_scene(folder.write("scene.yaml", new_scene_text({"indentation", size, ""}, folder.path(""))), catalog);
    CHECK(scene->specimen.body.size() < 2500);
    const Run run = run_strategy(scene->specimen, *scene->experiment, choose_strategy(catalog, "standard"),
                                 {.statics = scene->statics});
    CHECK(run.outcome == Outcome::converged);
    CHECK(run.measures.get("molecules_in_contact") >= 12);
    CHECK(run.remark.empty());
  }
  CHECK_THROWS_WITH(
      new_scene_text({"indentation", "1 x 1 x 10 mm", ""}, ""),
      Contains("--size: a block of 1 x 1 x 10 mm stands on its end") && Contains("write the longest length first"));
}

TEST_CASE("a size is three lengths, the last of which may give the unit", "[new]") {
  const auto text = [](const std::string& size) { return new_scene_text({"strip", size, ""}, ""); };
  for (const char* size : {"40 x 10 x 4 mm", "40 mm x 1 cm x 4 mm", "40×10×4 mm", "0.04 m, 0.01 m, 0.004 m"})
    CHECK_THAT(text(size), Contains("size: [40 mm, 10 mm, 4 mm]") && Contains("cubes: [20, 5, 2]") &&
                               Contains("axis: x ") && Contains("displacement: 6 mm"));
  CHECK_THAT(text("1 x 2 x 100 mm"), Contains("axis: z ") && Contains("displacement: 15 mm"));
  for (const char* size : {"40 x 10", "40 x 10 x 4", "a x b x c mm", "40 x -1 x 4 mm", ""})
    CHECK_THROWS_WITH(text(size), Contains("is not three lengths, such as 40 x 10 x 4 mm"));
}

TEST_CASE("calibration is offered to specimens that measure what a rule can be calibrated to", "[new][slow]") {
  const std::string scenes = ELASTIN_SOURCE_DIR "/scenes/";
  const TemporaryFolder folder;
  const NewScene specimens[] = {
      {"strip", "40 x 10 x 4 mm", ""},           {"dogbone", "", scenes + "tension/dogbone.msh"},
      {"indentation", "20 x 20 x 10 mm", ""},    {"organ", "", scenes + "tissue/organ.stl"},
      {"scan", "", scenes + "scans/waist.nrrd"},    // boxes filled in part
      {"scan", "", scenes + "scans/kidney.nrrd"}};  // of a voxel each
  for (const NewScene& wanted : specimens) {
    CAPTURE(wanted.specimen, wanted.mesh);
    const auto scene =
        load_scene(folder.write("scene.yaml", new_scene_text(wanted, folder.path(""))), built_in_catalog());
    const std::string unsuited = calibration_unsuited(*scene->experiment, scene->specimen);
    // What shows an apparent modulus alone gets its reference when `compare` computes it.
    const bool suited = unsuited.empty() || unsuited.find("computed reference") != std::string::npos;
    CHECK(suited == std::any_of(scene->strategies.begin(), scene->strategies.end(),
                                [](const StrategyChoice& choice) { return choice.name.calibrated; }));
  }
}

TEST_CASE("a scene of an image has its labels or a threshold, and its unit", "[new][scan]") {
  const TemporaryFolder folder;
  // 30 × 4 × 4 voxels.
  const auto text = [&](const std::string& fields, const auto& value) {
    std::string image = "NRRD0004\ntype: float\ndimension: 3\nsizes: 30 4 4\n" + fields + "encoding: ascii\n\n";
    for (int i = 0; i < 480; ++i) image += std::to_string(value(i)) + " ";
    return new_scene_text({"scan", "", folder.write("a.nrrd", image)}, folder.path(""));
  };
  const std::string plain = "spacings: 1 1 1\n";
  CHECK_THAT(text(plain, [](int i) { return i % 30 / 10; }), Contains("1: {name: label_1}   # 160 voxels") &&
                                                                 Contains("2: {name: label_2}") &&
                                                                 Contains("length_unit: mm"));
  CHECK_THAT(text(plain + "Segment0_LabelValue:=1\nSegment0_Name:=left lobe\nSegment1_Name:=tumour\n"
                          "Segment1_LabelValue:=2\nSegment2_Name:=left lobe\nSegment2_LabelValue:=3\n",
                  [](int i) { return i % 30 / 10 + 1; }),
             Contains("1: {name: \"left lobe\"}") && Contains("2: {name: \"tumour\"}") &&
                 Contains("3: {name: \"left lobe 3\"}"));
  const std::string many = text(plain, [](int i) { return i % 30 + 1; });  // each a plane of voxels
  CHECK_THAT(many, Contains("# 30 labels: every value but 0 is body") && !Contains("threshold"));
  CHECK_THAT(many, Contains("cross_section: 16 mm2"));
  // Air of -1000 and tissue of 40 to 80: Otsu's threshold lies half-way between them.
  const std::string grey = text(plain, [](int i) { return i % 30 < 15 ? -1000 : 40 + i * 7 % 41; });
  CHECK_THAT(grey, Contains("threshold: -480 ") && Contains("cross_section: 16 mm2") && Contains(": 15 mm"));
  CHECK_THAT(text("space: RAS\nspace directions: (1,0,0) (0,1,0) (0,0,1)\nspace units: \"um\" \"um\" \"um\"\n",
                  [](int) { return 1; }),
             Contains("length_unit: um") && Contains("cross_section: 16 um2"));
  CHECK_THAT(many, Contains("axis: x "));
  // A block of 12 voxels' length, with one more on it, and a speck that shares no face with it.
  const std::string specks = text(plain, [](int i) { return i % 30 < 12 || i == 29 || i == 12 + 30 * 15 ? 1 : 0; });
  CHECK_THAT(specks, Contains(": 13 mm") && Contains("cross_section: 14.85 mm2"));
  // NumPy's arrays have no size of their voxels: 30 x 4 x 4 of 2 x 1 x 1 mm.
  std::string array("\x93NUMPY\x01\x00\x76\x00", 10),
      header = "{'descr': '|u1', 'fortran_order': True, 'shape': (30, 4, 4), }";
  array += header + std::string(117 - header.size(), ' ') + "\n" + std::string(480, '\1');
  NewScene scan{"scan", "", folder.write("a.npy", array)};
  CHECK_THROWS_WITH(new_scene_text(scan, ""), Contains("give --voxel-size"));
  scan.voxel_size = "2 x 1 mm";
  CHECK_THROWS_WITH(new_scene_text(scan, ""), Contains("--voxel-size: '2 x 1 mm' is not three lengths"));
  scan.voxel_size = "2 x 1 x 1 mm";
  const std::string written = new_scene_text(scan, folder.path(""));
  CHECK_THAT(written, Contains("voxel_size: [2 mm, 1 mm, 1 mm]") && Contains("cross_section: 16 mm2"));
  CHECK(load_scene(folder.write("scene.yaml", written), built_in_catalog())->specimen.body.size() == 31 * 25);
  // A bar that lies across the voxels.
  CHECK_THAT(text(plain, [](int i) { return std::abs(i % 30 - 8 - 4 * (i / 120)) < 6; }), Contains("axis: longest "));
}

TEST_CASE("a slip in what new is given names what is allowed", "[new]") {
  CHECK_THROWS_WITH(new_scene_text({"stripp", "", ""}, ""), Contains("did you mean 'strip'?"));
  NewScene scene{"strip", "40 x 10 x 4 mm", ""};
  scene.poissons_ratio = 0.5;
  CHECK_THROWS_WITH(new_scene_text(scene, ""), Contains("--poissons-ratio: 0.5 is not from 0 to below 0.5"));
  scene.poissons_ratio = 0.3;
  for (const char* modulus : {"20 mm", "10", "soft", "-1 kPa", "0 Pa"}) {
    scene.modulus = modulus;
    CHECK_THROWS_WITH(new_scene_text(scene, ""), "--modulus: '" + std::string(modulus) +
                                                     "' is not a modulus above 0 with its unit, such as 20 kPa");
  }
  const std::string scenes = ELASTIN_SOURCE_DIR "/scenes/";
  CHECK_THROWS_WITH(new_scene_text({"organ", "", scenes + "tension/dogbone.msh"}, ""),
                    Contains("this mesh is solid; elastin new dogbone --mesh takes solids"));
  CHECK_THROWS_WITH(new_scene_text({"dogbone", "", scenes + "tissue/organ.stl"}, ""),
                    Contains("and this one has none; elastin new organ --mesh fills a closed surface"));
}
