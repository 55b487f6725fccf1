// Bodies out of images: their geometry, labels, fractions and pieces.

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>

#include "core/simulation/warnings.h"
#include "elastin/core/forces/block_cells.h"
#include "lab/report/records.h"
#include "lab/run/specimen.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;
using Catch::Matchers::Contains;

namespace {

const Catalog kCatalog = built_in_catalog();

/// An image as text with voxels of 2 × 1 × 1 mm, whose axes go along `directions`.
std::string nrrd(std::array<int, 3> size, const std::function<double(int, int, int)>& value,
                 const std::string& directions = "(2,0,0) (0,1,0) (0,0,1)") {
  std::string text = "NRRD0004\ntype: float\ndimension: 3\nsizes: " + std::to_string(size[0]) + " " +
                     std::to_string(size[1]) + " " + std::to_string(size[2]) + "\nspace directions: " + directions +
                     "\nspace origin: (1,0.5,0.5)\nencoding: ascii\n\n";
  for (int z = 0; z < size[2]; ++z)
    for (int y = 0; y < size[1]; ++y)
      for (int x = 0; x < size[0]; ++x) text += std::to_string(value(x, y, z)) + " ";
  return text;
}

std::unique_ptr<Scene> scene_of(const TemporaryFolder& folder, const std::string& image, const std::string& keys,
                                const std::string& strategy = "neo_hookean") {
  folder.write("a.nrrd", image);
  auto scene = load_scene(
      folder.write("scene.yaml", "title: A scan\nbody: {image: {file: a.nrrd, length_unit: mm" + keys +
                                     "}}\nmaterial: {youngs_modulus: 10 kPa, poissons_ratio: 0, density: 1000 kg/m3}\n"
                                     "stiffness: " +
                                     strategy +
                                     "\nexperiment: {kind: tension, axis: z, force: 1 uN}\n"
                                     "solver: {displacements: small}\nreference: none\n"),
      kCatalog);
  prepare(scene->specimen, scene->stiffness.strategy);
  return scene;
}

double modulus(const Scene& scene) {
  const Run run = run_strategy(scene.specimen, *scene.experiment, scene.stiffness, {.statics = scene.statics});
  INFO(run.cause);
  REQUIRE(run.outcome == Outcome::converged);
  return run.measures.get("effective_modulus");
}

const std::array<int, 3> kSize{3, 4, 6};
double halves(int, int, int z) { return z < 3 ? 1 : 2; }

}  // namespace

TEST_CASE("image: labels in series, as cells and whatever the directions of the image", "[image]") {
  const TemporaryFolder folder;
  const std::string labels =
      ", labels: {1: {name: soft}, 2: {name: stiff, material: {youngs_modulus: 40 kPa, density: 2000 kg/m3}}}";
  // 3 × 4 × 6 voxels: 6 × 4 × 6 mm, in the last three turned, mirrored and rotated by 30 degrees about z.
  for (const char* directions : {"(2,0,0) (0,1,0) (0,0,1)", "(0,2,0) (1,0,0) (0,0,1)", "(2,0,0) (0,1,0) (0,0,-1)",
                                 "(1.7320508075688772,1,0) (-0.5,0.8660254037844386,0) (0,0,1)"})
    for (const char* as : {"hexahedra", "tetrahedra"}) {
      INFO(directions << " " << as);
      const auto scene = scene_of(folder, nrrd(kSize, halves, directions), labels + ", as: " + as);
      const Body& body = scene->specimen.body;
      CHECK(body.size() == 4 * 5 * 7);
      CHECK(body.mass.sum() == Approx(144e-9 * 1500));
      CHECK(modulus(*scene) == Approx(16e3).epsilon(1e-6));  // 2 / (1/10 + 1/40) kPa
    }
}

TEST_CASE("image: cells of second order have the stiffness, mass and ends of their labels", "[image]") {
  const TemporaryFolder folder;
  const std::string labels =
      ", order: 2, labels: {1: {}, 2: {material: {youngs_modulus: 40 kPa, density: 2000 kg/m3}}}, as: ";
  for (const char* as : {"hexahedra", "tetrahedra"}) {
    INFO(as);
    const auto scene = scene_of(folder, nrrd(kSize, halves), labels + as);
    const Body& body = scene->specimen.body;
    CHECK(body.size() == 7 * 9 * 13);
    CHECK(body.mass.sum() == Approx(144e-9 * 1500));
    CHECK(body.mass.minCoeff() > 0);
    double moment = 0;  // 72 mg at 1.5 mm and 144 mg at 4.5 mm
    for (int molecule = 0; molecule < body.size(); ++molecule) moment += body.mass[molecule] * body.rest(2, molecule);
    CHECK(moment == Approx(72e-6 * 1.5e-3 + 144e-6 * 4.5e-3));
    CHECK(modulus(*scene) == Approx(16e3).epsilon(1e-6));
  }
}

TEST_CASE("image: smoothing takes off bumps and specks and fills pits, and keeps the volume", "[image]") {
  const TemporaryFolder folder;
  // A slab up to z = 5 with a bump, a pit and a speck of the second label.
  const auto rough = nrrd({9, 12, 9}, [](int x, int y, int z) {
    if (x == 4 && y == 4) return z < 6 ? 1 : 0;
    if (x == 6 && y == 8) return z < 4 ? 1 : 0;
    if (x == 2 && y == 3 && z == 2) return 2;
    return z < 5 ? 1 : 0;
  });
  const auto scene = scene_of(folder, rough, ", labels: [1, 2], smoothing: 1 mm");
  const Body& body = scene->specimen.body;
  CHECK(body.blocks.front().size() == 9 * 12 * 5);
  CHECK(body.size() == 10 * 13 * 6);  // an even slab, up to the ends of the image
  CHECK(body.rest.row(2).maxCoeff() == Approx(5e-3));
  CHECK_THAT(scene->warnings.front(), Contains("no voxel of the body has the label 2"));
  const auto said = std::find_if(scene->notes.begin(), scene->notes.end(),
                                 [](const std::string& note) { return note.find("smoothed over") != note.npos; });
  REQUIRE(said != scene->notes.end());
  CHECK_THAT(*said, Contains("3 of 540 voxels") && Contains("1.0000 times"));
}

TEST_CASE("image: each label has its Poisson's ratio, whatever the directions of the image", "[image]") {
  const TemporaryFolder folder;
  for (const char* directions : {"(2,0,0) (0,1,0) (0,0,1)", "(0,2,0) (1,0,0) (0,0,-1)",
                                 "(1.7320508075688772,1,0) (-0.5,0.8660254037844386,0) (0,0,1)"}) {
    INFO(directions);
    const auto scene =
        scene_of(folder, nrrd(kSize, halves, directions), ", labels: {1: {}, 2: {material: {poissons_ratio: 0.4}}}");
    const CellBlock& block = scene->specimen.body.blocks.front();
    for (int cell = 0; cell < block.size(); ++cell) {  // in the voxels' order: 36 of each label
      const Vector3 middle = middle_of(scene->specimen.body, block, cell);
      CHECK(local_material(scene->specimen.material, middle).poissons_ratio == (cell < 36 ? 0 : 0.4));
    }
  }
  const auto springs = scene_of(folder, nrrd(kSize, halves),
                                ", as: lattice, labels: {1: {}, 2: {material: {poissons_ratio: 0.4}}}", "standard");
  const Run one =
      run_strategy(springs->specimen, *springs->experiment, springs->stiffness, {.statics = springs->statics});
  CHECK(std::any_of(one.warnings.begin(), one.warnings.end(),
                    [](const std::string& said) { return said.find("Poisson's ratio everywhere") != said.npos; }));
  const auto even = scene_of(folder, nrrd(kSize, halves),
                             ", labels: {1: {material: {poissons_ratio: 0.4}}, 2: "
                             "{material: {poissons_ratio: 0.4}}}");
  const Run run = run_strategy(even->specimen, *even->experiment, even->stiffness, {.statics = even->statics});
  CHECK(run.measures.get("poissons_ratio") == Approx(0.4).epsilon(1e-6));
}

TEST_CASE("image: each label has a law of its own", "[image][slow]") {
  const TemporaryFolder folder;
  folder.write("a.nrrd", nrrd({4, 4, 4}, [](int x, int, int) { return x < 2 ? 1 : 2; }));
  const auto load = [&](const std::string& as, const std::string& stiffness) {
    auto scene = load_scene(
        folder.write("scene.yaml",
                     "body: {image: {file: a.nrrd, length_unit: mm, as: " + as +
                         ", labels: {2: {name: muscle, material: {law: yeoh, terms: [1 kPa, 2 kPa, 3 kPa], "
                         "bulk_modulus: 10 MPa, density: 1060 kg/m3}}, 1: {name: fat, material: {law: mooney_rivlin, "
                         "c1: 2 kPa, c2: 1 kPa, bulk_modulus: 10 MPa}}}}}\nmaterial: {youngs_modulus: 10 kPa, "
                         "poissons_ratio: 0.3, density: 900 kg/m3}\nstiffness: " +
                         stiffness + "\nexperiment: {kind: tension, axis: z, strain: 20 %}\nreference: none\n"),
        kCatalog);
    prepare(scene->specimen, scene->stiffness.strategy);
    return scene;
  };
  // Incompressible, so that both become thinner alike: 2 (λ − 1/λ²) (c1 + c2/λ), and the same with the slope of Yeoh's
  // polynomial, on half of 8 mm × 4 mm each.
  const double stretch = 1.2, more = stretch * stretch + 2 / stretch - 3, shape = 2 * (stretch - 1 / stretch / stretch);
  const double force = 16e-6 * shape * (2e3 + 1e3 / stretch + 1e3 + 4e3 * more + 9e3 * more * more);
  for (const auto& [as, shared] : {std::pair{"hexahedra", 25u},
                                   {"tetrahedra", 25u},
                                   {"hexahedra, order: 2", 81u},
                                   {"tetrahedra, order: 2", 81u}}) {
    INFO(as);
    const auto scene = load(as, "neo_hookean");
    const Body& body = scene->specimen.body;
    REQUIRE(body.parts.size() == 2);
    CHECK(body.parts[0].name == "muscle");
    CHECK(body.parts[0].count + body.parts[1].count == body.size());
    CHECK(body.parts[1].shared.size() == shared);
    CHECK(body.mass.sum() == Approx(64e-9 * (1060 + 900)));
    const Run run = run_strategy(scene->specimen, *scene->experiment, scene->stiffness, {.statics = scene->statics});
    INFO(run.cause);
    REQUIRE(run.outcome == Outcome::converged);
    CHECK(run.measures.get("force") == Approx(force).epsilon(2e-3));
  }
  CHECK_THAT(load("tetrahedra", "neo_hookean")->warnings.front(), Contains("yeoh") && Contains("may lock"));
  const auto springs = load("lattice", "lattice");  // by E at rest
  const Run run = run_strategy(springs->specimen, *springs->experiment, springs->stiffness, {});
  CHECK(run.outcome == Outcome::converged);
  CHECK(springs->specimen.materials[1].youngs_modulus == Approx(6e3).epsilon(1e-3));
  CHECK_THROWS_WITH(load("packing", "standard"), Contains("scene.yaml") && Contains("a packing has one material"));
}

TEST_CASE("image: near v = 1/2 labels of tetrahedra keep their volumes each by itself", "[image]") {
  const TemporaryFolder folder;
  const auto scene = scene_of(folder, nrrd(kSize, halves),
                              ", as: tetrahedra, labels: {1: {material: {poissons_ratio: 0.49}}, 2: {material: "
                              "{youngs_modulus: 40 kPa, poissons_ratio: 0.49}}}");
  CHECK(scene->stiffness.strategy.name == "neo_hookean+volume");
  CHECK(scene->specimen.body.parts.size() == 2);
}

TEST_CASE("image: a formula of the grey value is E at each box", "[image]") {
  const TemporaryFolder folder;
  const auto scene = scene_of(folder, nrrd(kSize, [](int, int, int z) { return z < 3 ? 100 : 200; }),
                              ", youngs_modulus: 1 kPa * (value / 100)^2");
  CHECK(modulus(*scene) == Approx(1.6e3).epsilon(1e-6));  // 2 / (1/1 + 1/4)
}

TEST_CASE("image: a scan gives E where its segmentation says what is body", "[image]") {
  const TemporaryFolder folder;
  const auto scan = [&](const std::string& space, const std::string& directions, const std::string& origin,
                        std::array<int, 3> size = kSize) {
    std::string text = nrrd(
        size, [](int, int y, int z) { return y == 0  ? 1e6
                                             : z < 3 ? 100
                                                     : 200; }, directions);
    text.insert(text.find("space directions"), "space: " + space + "\n");
    folder.write("scan.nrrd", text.replace(text.find("(1,0.5,0.5)"), 11, origin));
  };
  std::string labels = nrrd(kSize, [](int, int y, int) { return y == 0 ? 0 : 3; });
  labels.insert(labels.find("space directions"), "space: RAS\n");
  const std::string keys = ", labels: [3], youngs_modulus: 1 kPa * (value / 100)^2, grey_values: scan.nrrd";
  for (const char* space : {"RAS", "LPS"}) {
    INFO(space);
    *space == 'R' ? scan(space, "(2,0,0) (0,1,0) (0,0,1)", "(1,0.5,0.5)")
                  : scan(space, "(-2,0,0) (0,-1,0) (0,0,1)", "(-1,-0.5,0.5)");
    CHECK(modulus(*scene_of(folder, labels, keys)) == Approx(1.6e3).epsilon(1e-6));  // 2 / (1/1 + 1/4)
  }
  scan("RAS", "(2,0,0) (0,1,0) (0,0,1)", "(1,0.5,1.5)");
  CHECK_THROWS_WITH(scene_of(folder, labels, keys),
                    Contains("grey_values: has its voxels up to 1 voxels away from those of a.nrrd"));
  scan("RAS", "(2,0,0) (0,1,0) (0,0,1)", "(1,0.5,0.5)", {3, 4, 7});
  CHECK_THROWS_WITH(scene_of(folder, labels, keys), Contains("grey_values: has 3 x 4 x 7 voxels for the 3 x 4 x 6"));
  CHECK_THROWS_WITH(scene_of(folder, labels, ", grey_values: scan.nrrd"), Contains("goes with a formula of `value`"));
  CHECK_THROWS_WITH(scene_of(folder, labels, keys + ", as: packing"),
                    Contains("image.youngs_modulus: goes with `as: hexahedra`"));
}

TEST_CASE("image: a label keeps E and density of its own next to a formula of the grey value", "[image]") {
  const TemporaryFolder folder;
  // The formula makes 10 kPa and 1000 kg/m³ of label 1, and would make 20 kPa and 2000 kg/m³ of label 2.
  for (const char* law : {"", ", law: yeoh, terms: [10 kPa], bulk_modulus: 13333.333333333334 Pa"}) {
    INFO(law);
    const std::string own = *law ? law + 2 : "youngs_modulus: 40 kPa";
    const auto scene = scene_of(folder, nrrd(kSize, halves),
                                ", youngs_modulus: 10 kPa * value, density: 1000 kg/m3 * value, labels: {1: {}, 2: "
                                "{material: {" +
                                    own + ", density: 4000 kg/m3}}}");
    CHECK(scene->specimen.body.mass.sum() == Approx(144e-9 * 2500));
    CHECK(modulus(*scene) == Approx(16e3).epsilon(1e-3));  // 2 / (1/10 + 1/40) kPa
  }
}

TEST_CASE("image: a label that is the most frequent of no box is said to be so", "[image]") {
  const TemporaryFolder folder;
  const auto image = nrrd({4, 4, 4}, [](int x, int y, int z) { return x == 1 && y == 1 && z == 1 ? 2 : 1; });
  const auto warnings = [&](const std::string& keys) { return scene_of(folder, image, keys)->warnings; };
  CHECK_THAT(warnings(", spacing: 2 mm, labels: [1, 2]").front(),
             Contains("no box is of the label 2, of which the body has 1 voxel") && Contains("`spacing`"));
  CHECK_THAT(warnings(", labels: [1, 3]").back(), Contains("no voxel of the body has the label 3"));
}

TEST_CASE("image: grey values without a threshold are warned of, labels are not", "[image]") {
  const TemporaryFolder folder;
  const auto warned = [&](const std::string& image, const std::string& keys = "") {
    const auto scene = scene_of(folder, image, keys);
    const auto found = std::find_if(scene->warnings.begin(), scene->warnings.end(),
                                    [](const std::string& said) { return said.find("Otsu") != said.npos; });
    return found == scene->warnings.end() ? "" : *found;
  };
  const auto grey = nrrd({6, 6, 6}, [](int x, int y, int z) { return x < 3 ? -1000 : 40 + (7 * y + 11 * z + x) % 41; });
  CHECK_THAT(warned(grey), Contains("body.image.file: the image has grey values") && Contains("such as -480 by Otsu"));
  CHECK(warned(grey, ", threshold: 0").empty());
  CHECK(warned(nrrd({6, 6, 6}, [](int x, int y, int z) { return x / 2 + 3 * (y / 2) + 9 * (z / 2) + 1; })).empty());
}

TEST_CASE("image: lattice and packing of the voxels run as springs", "[image][slow]") {
  const TemporaryFolder folder;
  const auto lattice = scene_of(folder, nrrd(kSize, halves), ", as: lattice", "lattice");
  CHECK(lattice->specimen.body.cubes.size() == 72);
  CHECK(lattice->specimen.body.mass.sum() == Approx(144e-6));
  const auto packing = scene_of(folder, nrrd({10, 20, 20}, halves), ", as: packing", "standard");
  CHECK(packing->specimen.body.mass.sum() == Approx(8e-3));
  CHECK(packing->specimen.body.connections.size() > 3 * packing->specimen.body.size());
}

TEST_CASE("image: larger boxes, and the part of them that is body", "[image]") {
  const TemporaryFolder folder;
  // Of two voxels along y one is body: half of the section.
  const std::string image = nrrd({4, 4, 4}, [](int, int y, int) { return y % 3 == 0; });
  const auto whole = scene_of(folder, image, ", spacing: 2 mm");
  CHECK(whole->specimen.body.size() == 5 * 3 * 3);
  CHECK(whole->specimen.body.mass.sum() == Approx(128e-6));
  const auto part = scene_of(folder, image, ", spacing: 2 mm, fill_fraction: true");
  CHECK(part->specimen.body.mass.sum() == Approx(64e-6));
  CHECK(modulus(*part) == Approx(5e3).epsilon(1e-6));
  CHECK_THAT(part->warnings.back(), Contains("2 times what is filled: give `cross_section`"));
}

TEST_CASE("image: boxes that close the gap between pieces are warned of, and springs do not cross it",
          "[image][slow]") {
  const TemporaryFolder folder;
  const auto gap = [](int, int, int z) { return z != 4; };
  const auto joined = [](const Scene& scene) {
    return std::any_of(scene.warnings.begin(), scene.warnings.end(), [](const std::string& warning) {
      return warning.find(
                 "2 pieces of the image that share no face make 1 piece of the body: boxes of 1 x 2 x 2 "
                 "voxels") != std::string::npos;
    });
  };
  CHECK(joined(*scene_of(folder, nrrd({4, 4, 9}, gap), ", spacing: 2 mm")));
  CHECK(!joined(*scene_of(folder, nrrd({4, 4, 9}, gap), ", spacing: 2 mm, pieces: largest")));
  // A gap that stays, a speck and one piece with a slot are none of it.
  CHECK(!joined(*scene_of(folder, nrrd({4, 4, 10}, [](int, int, int z) { return z / 2 != 2; }), ", spacing: 2 mm")));
  CHECK(!joined(*scene_of(folder,
                          nrrd({4, 8, 20}, [](int x, int y, int z) { return z > 1 || (z == 0 && x == 0 && y == 0); }),
                          ", spacing: 2 mm")));
  CHECK(!joined(
      *scene_of(folder, nrrd({4, 4, 9}, [](int x, int, int z) { return z != 4 || x == 0; }), ", spacing: 2 mm")));
  const auto packing =
      scene_of(folder, nrrd({10, 20, 20}, [](int, int, int z) { return z != 10; }), ", as: packing", "standard");
  const Body& body = packing->specimen.body;
  for (const auto& [a, b] : body.connections.ends) REQUIRE((body.rest(2, a) < 10.5e-3) == (body.rest(2, b) < 10.5e-3));
}

TEST_CASE("image: boxes next to a grip are as full as their sides at its plane", "[image]") {
  const TemporaryFolder folder;
  // A foot of 8 mm × 4 mm under a slab of 16 mm × 8 mm, in boxes of 4 mm of which all of the lowest ones have some
  // body; the foot covers half of the sides of four.
  folder.write("a.nrrd",
               nrrd({8, 8, 8}, [](int x, int y, int z) { return z > 1 || (x / 2 % 3 != 0 && y / 2 % 3 != 0); }));
  for (const int order : {1, 2}) {
    const auto scene = load_scene(
        folder.write(
            "scene.yaml",
            "body: {image: {file: a.nrrd, length_unit: mm, spacing: 4 mm, fill_fraction: true, ends: k, order: " +
                std::to_string(order) +
                "}}\nmaterial: {youngs_modulus: 10 kPa, poissons_ratio: 0}\nstiffness: neo_hookean\n"
                "experiment: {kind: tension, axis: z, strain: 1 %, fixed: {set: low k}, loaded: {set: high k}, "
                "fixed_grip: clamped, loaded_grip: clamped, cross_section: 128 mm2}\nreference: none\n"),
        kCatalog);
    const CellBlock& block = scene->specimen.body.blocks.front();
    REQUIRE(block.size() == 4 + 8);
    for (int cell = 0; cell < 12; ++cell) CHECK(block.stiffness[cell] == Approx(cell < 4 ? 0.5 : 1));
    Model model(scene->specimen.body);
    const auto rig = scene->experiment->rig(model);
    CHECK(model.supports.size() == (order == 1 ? 3 * 3 + 5 * 3 : 5 * 5 + 9 * 5));
  }
}

TEST_CASE("image: boxes begin and end where the body does", "[image]") {
  const TemporaryFolder folder;
  // A bar of 8 mm × 8 mm × 14 mm, inside of the image or filling it, in boxes of 4 mm: along z 4, 4, 4 and 2 mm.
  const auto inside = [](int x, int y, int z) { return x > 0 && x < 5 && y > 1 && y < 10 && z > 2 && z < 17; };
  const std::string padded = nrrd({6, 12, 20}, inside), filled = nrrd({6, 12, 20}, [](int, int, int) { return 1; });
  const std::string crop = ", from: [2 mm, 2 mm, 3 mm], to: [10 mm, 10 mm, 17 mm]";
  for (const auto& [image, keys] :
       {std::pair{padded, std::string()}, {padded, std::string(", ends: k")}, {padded, crop}, {filled, crop}})
    for (const char* as : {"hexahedra", "tetrahedra", "lattice", "hexahedra, order: 2", "tetrahedra, order: 2"}) {
      INFO(keys << " " << as);
      const auto scene = scene_of(folder, image, keys + ", spacing: 4 mm, fill_fraction: true, as: " + as,
                                  std::string(as) == "lattice" ? "lattice" : "neo_hookean");
      const Body& body = scene->specimen.body;
      if (std::string(as).find("order") == std::string::npos) CHECK(body.size() == 3 * 3 * 5);
      CHECK(body.rest.row(2).minCoeff() == Approx(3e-3));
      CHECK(body.rest.row(2).maxCoeff() == Approx(17e-3));
      CHECK(body.mass.sum() == Approx(896e-6));
      if (std::string(as) != "lattice") CHECK(modulus(*scene) == Approx(10e3).epsilon(1e-6));
    }
}

TEST_CASE("image: a grip is as deep as is stated behind the voxels' end, and not behind boxes that stand out over it",
          "[image][slow]") {
  const TemporaryFolder folder;
  // A bar of 48 mm × 16 mm × 12 mm, turned about z in the image, held over 6 mm at each end and pulled by 0.36 mm.
  for (const double degrees : {0., 20., 30., 45., 75.}) {
    const double angle = degrees * std::acos(-1.) / 180, c = std::cos(angle), s = std::sin(angle);
    const std::string image = nrrd(
        {64, 64, 12},
        [&](int i, int j, int) {
          const double x = i - 31.5, y = j - 31.5;
          return std::abs(x * c + y * s) < 24 && std::abs(y * c - x * s) < 8;
        },
        "(1,0,0) (0,1,0) (0,0,1)");
    const auto force = [&](const std::string& keys) {
      INFO(keys << " " << degrees);
      folder.write("a.nrrd", image);
      const auto scene = load_scene(
          folder.write("scene.yaml",
                       "body: {image: {file: a.nrrd, length_unit: mm, fill_fraction: true" + keys +
                           "}}\nmaterial: {youngs_modulus: 10 kPa, poissons_ratio: 0}\nstiffness: neo_hookean\n"
                           "experiment: {kind: tension, axis: [" +
                           std::to_string(c) + ", " + std::to_string(s) +
                           ", 0], grip_depth: 6 mm, displacement: 0.36 mm, cross_section: 192 mm2, "
                           "fixed_grip: clamped, loaded_grip: clamped}\n"
                           "solver: {displacements: small}\nreference: none\n"),
          kCatalog);
      const Body& body = scene->specimen.body;
      const Vector3 axis(c, s, 0);
      const VectorX heights = body.outline.transpose() * axis;
      CHECK(heights.maxCoeff() - heights.minCoeff() == Approx(48e-3).margin(1.1e-3));
      prepare(scene->specimen, scene->stiffness.strategy);
      const Run run = run_strategy(scene->specimen, *scene->experiment, scene->stiffness, {.statics = scene->statics});
      REQUIRE(run.outcome == Outcome::converged);
      return run.measures.get("force");
    };
    const double exact = 10e3 * 192e-6 * 0.36 / 36;
    CHECK(force(", spacing: 1 mm") == Approx(exact).epsilon(0.08));
    // Layers of boxes lie up to a box within the grips' planes.
    CHECK(force(", spacing: 3 mm") == Approx(exact).epsilon(0.12));
  }
}

TEST_CASE("image: ends of a body that is no whole number of boxes wide are full", "[image]") {
  const TemporaryFolder folder;
  const auto scene = scene_of(folder, nrrd({5, 10, 20}, [](int, int, int) { return 1; }),
                              ", spacing: 4 mm, fill_fraction: true, ends: k");
  CHECK(scene->specimen.body.mass.sum() == Approx(2e-3));
  CHECK(modulus(*scene) == Approx(10e3).epsilon(1e-6));
}

TEST_CASE("image: boxes of the largest piece begin where that does", "[image]") {
  const TemporaryFolder folder;
  const auto image = nrrd({6, 8, 20}, [](int x, int y, int z) { return z > 4 || (z == 0 && x == 0 && y == 0); });
  const auto scene = scene_of(folder, image, ", spacing: 4 mm, fill_fraction: true, pieces: largest");
  const Body& body = scene->specimen.body;
  CHECK(body.rest.row(2).minCoeff() == Approx(5e-3));
  CHECK(body.mass.sum() == Approx(12 * 8 * 15e-6));
  CHECK(modulus(*scene) == Approx(10e3).epsilon(1e-6));
}

TEST_CASE("image: an end of a few voxels is warned of, with the key that cuts it off", "[image]") {
  const TemporaryFolder folder;
  const auto warning = [&](const std::string& image, const std::string& keys) {
    const auto scene = scene_of(folder, image, ", spacing: 4 mm, fill_fraction: true, ends: k" + keys);
    const auto found = std::find_if(scene->warnings.begin(), scene->warnings.end(),
                                    [](const std::string& said) { return said.find("outermost layer") != said.npos; });
    return found == scene->warnings.end() ? "" : *found;
  };
  const auto bump = [](int x, int y, int z) { return z > 0 || (x == 1 && y == 1); };
  CHECK_THAT(warning(nrrd({4, 8, 12}, bump), ""),
             Contains("body.image.file") && Contains("`low k` has 1 voxel, the next 32") && Contains("`from`"));
  CHECK(warning(nrrd({4, 8, 12}, bump), ", from: [0 mm, 0 mm, 1 mm]").empty());
  CHECK_THAT(warning(nrrd({4, 8, 12}, bump, "(2,0,0) (0,1,0) (0,0,-1)"), ""), Contains("`low k`") && Contains("`to`"));
}

TEST_CASE("image: closed holes smaller than a box are filled", "[image]") {
  const TemporaryFolder folder;
  const auto pores = nrrd({6, 12, 12}, [](int x, int y, int z) {
    return x % 3 == 1 && y % 4 == 1 && z % 4 == 1 ? 0 : z < 8 ? 100 : 200;
  });
  const std::string keys = ", spacing: 4 mm, fill_fraction: true, youngs_modulus: 1 Pa * value";
  const double whole = 12 * 12 * 12e-6;
  CHECK(scene_of(folder, pores, keys)->specimen.body.mass.sum() == Approx(whole * (1 - 18. / 864)));
  const auto closed = scene_of(folder, pores, keys + ", holes: close");
  CHECK(closed->specimen.body.mass.sum() == Approx(whole));
  CHECK(modulus(*closed) == Approx(120).epsilon(1e-6));  // 3 / (2/100 + 1/200); values of the holes, 0, count nowhere
  CHECK_THAT(closed->notes.front(), Contains("18 voxels of closed holes filled"));
}

TEST_CASE("image: a wall of one box is thin, a step of the surface is not", "[image]") {
  const TemporaryFolder folder;
  const auto thin = [&](auto body) {
    const auto scene = scene_of(folder, nrrd({8, 8, 8}, body), "");
    return std::any_of(scene->warnings.begin(), scene->warnings.end(),
                       [](const std::string& said) { return said.find("thinner than two boxes") != said.npos; });
  };
  CHECK_FALSE(thin([](int x, int y, int z) { return x < 4 || (x == 4 && y == 3 && z % 3 == 0); }));
  CHECK(thin([](int x, int y, int) { return x < 4 || y == 3; }));
}

TEST_CASE("image: pieces, holes, threshold and crop", "[image]") {
  const TemporaryFolder folder;
  const auto specks =
      nrrd({5, 5, 5}, [](int x, int y, int z) { return (x > 3 && y > 3 && z > 3) || x < 3 ? 100 : 20; });
  const auto boxes = [](const Scene& scene) { return scene.specimen.body.blocks.front().size(); };
  const auto all = scene_of(folder, specks, ", threshold: 50");
  CHECK(boxes(*all) == 76);
  CHECK_THAT(all->warnings.front(), Contains("2 pieces"));
  CHECK(boxes(*scene_of(folder, specks, ", threshold: 50, pieces: largest")) == 75);
  CHECK(boxes(*scene_of(folder, specks, ", threshold: 50, from: [0 mm, 0 mm, 0 mm], to: [6 mm, 5 mm, 2 mm]")) == 30);
  const auto hollow = nrrd({5, 5, 5}, [](int x, int y, int z) { return x == 2 && y == 2 && z == 2 ? 0 : 1; });
  CHECK(boxes(*scene_of(folder, hollow, "")) == 124);
  CHECK(boxes(*scene_of(folder, hollow, ", holes: close")) == 125);
}

TEST_CASE("image: what cannot be a body is refused by name", "[image]") {
  const TemporaryFolder folder;
  const auto image = nrrd(kSize, halves);
  const auto refused = [&](const std::string& keys) {
    try {
      scene_of(folder, image, keys);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  CHECK_THAT(refused(", labels: [7]"), Contains("leaves no voxel") && Contains("1 and 2"));
  CHECK_THAT(refused(", threshold: 5"), Contains("body.image.threshold") && Contains("a.nrrd") && Contains("1 and 2"));
  CHECK_THAT(
      refused(", from: [50 mm, 0 mm, 0 mm]"),
      Contains("body.image.from") && Contains("a.nrrd, whose voxels lie from (1, 0.5, 0.5) mm to (5, 3.5, 5.5) mm"));
  CHECK_THAT(refused(", to: [0 mm, 0 mm, 0 mm]"), Contains("body.image.to: leaves no voxel"));
  CHECK_THAT(refused(", labels: {1: {name: a}, 1.0: {name: b}}"), Contains("labels: names the label 1 twice"));
  CHECK_THAT(refused(", labels: [liver]"), Contains("no label"));
  CHECK_THAT(refused(", labels: [1], threshold: 3"), Contains("labels"));
  CHECK_THAT(refused(", voxel_size: [1 mm, 1 mm, 1 mm]"), Contains("states the size"));
  CHECK_THAT(refused(", youngs_modulus: value * 2 mm"), Contains("must give"));
  CHECK_THAT(refused(", spacings: 2 mm"), Contains("spacing"));
  CHECK_THAT(refused(", as: lattice, order: 2"), Contains("`as: hexahedra`"));
  CHECK_THAT(refused(", ends: k"), Contains("`fill_fraction: true`"));
  CHECK_THAT(refused(", smoothing: 30 mm"), Contains("more than 20 voxels"));
  const auto refused_of = [&](const std::string& text, const std::string& keys) {
    try {
      scene_of(folder, text, keys);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const auto sparse = nrrd({4, 8, 8}, [](int x, int y, int z) { return (x + y + z) % 4 == 0; });
  CHECK_THAT(refused_of(sparse, ", spacing: 4 mm"),
             Contains("body.image.spacing: leaves no box of a.nrrd: the fullest is body by 25 %, of which 50 %"));
  CHECK_THAT(refused_of("NRRD0004\ntype: float\ndimension: 3\nsizes: 2 2 2\nspacings: 1 1 1\nendian: little\nencoding: "
                        "raw\n\n" +
                            std::string(32, '\xff'),
                        ""),
             Contains("body.image.file: leaves no voxel of a.nrrd; none of its values is a number"));
  std::string large = "NRRD0004\ntype: double\ndimension: 3\nsizes: 1000 1000 1000\nspacings: 1 1 1\n";
  large += "endian: little\nencoding: gzip\n\n";  // what is packed is not looked at
  CHECK_THAT(refused_of(large, ""),
             Contains("scene.yaml:2:22: body.image.file: makes 1e+09 boxes") && Contains("`spacing`"));
  CHECK(refused_of(large, "").find("body.image.file") == refused_of(large, "").rfind("body.image.file"));
  CHECK_THAT(refused_of(large, ", spacing: 4 mm"), Contains("packed data end early"));
  CHECK_THAT(refused_of(large, ", to: [100 mm, 100 mm, 100 mm]"), Contains("packed data end early"));
}
