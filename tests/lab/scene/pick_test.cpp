// Molecules picked by place, and what stays where it is.

#include "lab/scene/parts.h"

#include <catch2/catch.hpp>
#include <set>

#include "core/geometry/rim.h"
#include "core/shapes/surfaces.h"
#include "elastin/core/shapes/shapes.h"
#include "lab/scene/scene.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

namespace {

/// Molecules at whole coordinates 0 … 4 [mm].
Body lattice() { return cubic_lattice({5, 5, 5}, 1e-3, {}); }

std::vector<int> picked(const Body& body, const std::string& text, const Matrix3& rotation = Matrix3::Identity()) {
  Reader reader = open_scene(SceneSource::of_text("a.yaml", "x: " + text + "\n"), {}, 1e6);
  return read_molecules(reader.at("x"), body, rotation);
}

std::set<std::array<long, 3>> places(const Body& body, const std::vector<int>& molecules) {
  std::set<std::array<long, 3>> all;
  for (const int molecule : molecules) {
    const Vector3 at = 1e3 * body.rest.col(molecule);
    all.insert({std::lround(at.x()), std::lround(at.y()), std::lround(at.z())});
  }
  return all;
}

std::string refusal(const std::string& text) {
  try {
    picked(lattice(), text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

double modulus_of(const std::string& text) {
  const TemporaryFolder folder;
  const auto scene = load_scene(folder.write("a.yaml", text), built_in_catalog());
  const Run run = run_strategy(scene->specimen, *scene->experiment, scene->stiffness, {.statics = scene->statics});
  REQUIRE(run.outcome == Outcome::converged);
  return run.measures.get("effective_modulus");
}

}  // namespace

TEST_CASE("places pick the molecules that lie there", "[scene][pick]") {
  const Body body = lattice();
  CHECK(picked(body, "[3, 1, 2]") == std::vector{3, 1, 2});
  CHECK(places(body, picked(body, "{box: {from: [0, 0, 0], to: [1 mm, 0 mm, 0 mm]}}")) ==
        std::set<std::array<long, 3>>{{0, 0, 0}, {1, 0, 0}});
  CHECK(picked(body, "{plane: {point: [0, 0, 2 mm], normal: z}}").size() == 25);
  CHECK(picked(body, "{plane: {point: [0, 0, 2 mm], normal: z, within: 1.1 mm}}").size() == 75);
  CHECK(picked(body, "{sphere: {centre: [2 mm, 2 mm, 2 mm], radius: 1 mm}}").size() == 7);
  CHECK(picked(body, "{side: -y}").size() == 25);
  CHECK(places(body, picked(body, "{nearest: [3.2 mm, 0.1 mm, 9 mm]}")) == std::set<std::array<long, 3>>{{3, 0, 4}});
  // All of several places; the nearest of those.
  CHECK(picked(body, "{side: x, plane: {point: [0, 0, 0], normal: y}}").size() == 5);
  CHECK(places(body, picked(body, "{side: x, nearest: [0, 0, 0]}")) == std::set<std::array<long, 3>>{{4, 0, 0}});
}

TEST_CASE("a scene that is turned picks the same molecules", "[scene][pick]") {
  Body body = lattice();
  const auto straight = picked(body, "{box: {from: [0, 0, 0], to: [1 mm, 2 mm, 3 mm]}}");
  const Matrix3 turn = Eigen::AngleAxisd(0.7, Vector3(1, 2, 3).normalized()).toRotationMatrix();
  rotate(body, turn);
  CHECK(picked(body, "{box: {from: [0, 0, 0], to: [1 mm, 2 mm, 3 mm]}}", turn) == straight);
}

TEST_CASE("the rim of a surface is its free edge", "[scene][pick]") {
  const Body sheet = rectangular_sheet({1, 1}, {3, 2}, SheetPattern::alternating);
  const std::vector<int> rim = picked(sheet, "{rim: true}");
  CHECK(rim.size() == 10);
  for (const int molecule : rim) {
    const Vector3 at = sheet.rest.col(molecule);
    CHECK((at.x() < 1e-9 || at.x() > 1 - 1e-9 || at.y() < 1e-9 || at.y() > 1 - 1e-9));
  }
  CHECK(rim_of(sphere(1, SphereMesh::icosahedron, 2).triangles).empty());
}

TEST_CASE("what picks nothing is refused with the body's extent", "[scene][pick]") {
  CHECK_THAT(refusal("{sphere: {centre: [9 mm, 9 mm, 9 mm], radius: 1 mm}}"),
             StartsWith("a.yaml:1:4: x: no molecule lies there; the body reaches from [0, 0, 0] mm to [4, 4, 4] mm"));
  CHECK_THAT(refusal("{sphere: {center: [9 mm, 9 mm, 9 mm], radius: 1 mm}}"), Contains("did you mean 'centre'?"));
  CHECK_THAT(refusal("{}"), Contains("names no place: give box, plane, sphere, side, nearest, rim, set or body"));
  CHECK_THAT(refusal("{rim: true}"), Contains("no molecule lies there") || Contains("is of bodies of triangles"));
  CHECK_THAT(refusal("{set: TOP}"), Contains("x.set: the body has no sets") && Contains("`image` of cells"));
  CHECK_THAT(refusal("{body: bone}"), Contains("x.body: is one of several `bodies`; the scene has one"));
  CHECK_THAT(refusal("[125]"), Contains("x[0]: '125' is not a whole number of at least 0 and at most 124"));
}

TEST_CASE("sets of a mesh file pick their molecules", "[scene][pick]") {
  const TemporaryFolder folder;
  const std::string tetrahedron =
      "*NODE, NSET=ALL\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n*ELEMENT, TYPE=C3D4, ELSET=BODY\n"
      "7,1,2,3,4\n*NSET, NSET=BASE, GENERATE\n1, 3, 1\n*NSET, NSET=TOP\n4\n";
  folder.write("cell.inp", tetrahedron);
  const auto loaded = [&](const std::string& set) {
    const auto scene = load_scene(
        folder.write("a.yaml",
                     "body: {mesh: {file: cell.inp, length_unit: mm}}\nmaterial: {youngs_modulus: 5 kPa}\n"
                     "stiffness: neo_hookean\nexperiment: {kind: vibration}\nsupports: [{molecules: {set: BASE}}]\n"
                     "loads: [{point: {molecules: {set: " +
                         set + "}, force: [0, 0, 1 uN]}}]\n"),
        built_in_catalog());
    return scene->specimen.loads.at(0).row.value().second.molecules.at("molecules");
  };
  CHECK(loaded("TOP") == std::vector{3});
  CHECK(loaded("BASE") == std::vector{0, 1, 2});
  CHECK(loaded("BODY") == std::vector{0, 1, 2, 3});
  CHECK(loaded("ALL") == std::vector{0, 1, 2, 3});
  CHECK(loaded("[BODY, BASE]") == std::vector{0, 1, 2});
  CHECK_THROWS_WITH(loaded("[TOP, BASE]"), Contains("no molecule lies there"));
  CHECK_THROWS_WITH(loaded("[]"), Contains("names no set"));
  CHECK_THROWS_WITH(loaded("TIP"), Contains("the mesh has no set 'TIP'; did you mean 'TOP'?"));
}

TEST_CASE("a region is the same on cells of second order, and one that catches nothing is an error", "[scene][pick]") {
  const TemporaryFolder folder;
  std::string nodes, cells, upper = "*NSET, NSET=UPPER\n";
  for (int level = 0; level <= 4; ++level)
    for (int corner = 0; corner < 4; ++corner) {
      const int number = 4 * level + corner + 1;
      nodes += std::to_string(number) + ", " + (corner == 1 || corner == 2 ? "1" : "0") + ", " +
               (corner >= 2 ? "1" : "0") + ", " + std::to_string(level) + "\n";
      if (level >= 2) upper += std::to_string(number) + ",\n";
    }
  for (int cell = 0; cell < 4; ++cell) {
    cells += std::to_string(cell + 1);
    for (int corner = 0; corner < 8; ++corner) cells += ", " + std::to_string(4 * cell + corner + 1);
    cells += "\n";
  }
  folder.write("bar.inp", "*NODE\n" + nodes + "*ELEMENT, TYPE=C3D8\n" + cells + upper);
  const auto scene_with = [&](const std::string& region, int order) {
    return load_scene(folder.write("bar.yaml", "body: {mesh: {file: bar.inp, length_unit: mm, order: " +
                                                   std::to_string(order) + "}, regions: [{" + region +
                                                   "}]}\nmaterial: {youngs_modulus: 10 kPa}\n"
                                                   "stiffness: neo_hookean\nexperiment: {kind: vibration}\n"),
                      built_in_catalog());
  };
  const std::string set = "molecules: {set: UPPER}, stiffness: 7";
  for (const int order : {1, 2}) {
    const auto scene = scene_with(set, order);
    REQUIRE(scene->specimen.body.blocks.size() == 1);
    CHECK(scene->specimen.body.blocks.front().stiffness == VectorX(Eigen::Vector4d(1, 1, 7, 7)));
    CHECK(scene_with("from: [0, 0, 2 mm], to: [1 mm, 1 mm, 4 mm], stiffness: 7", order)->notes.size() == 1);
    CHECK_THAT(scene_with("from: [0, 0, 1.6 mm], to: [1 mm, 1 mm, 4 mm], stiffness: 7", order)->notes.back(),
               Contains("the box has a part of 1 cell; those whose middle lies in it count whole"));
    CHECK_THROWS_WITH(scene_with("from: [0, 0, 5 mm], to: [1 mm, 1 mm, 6 mm], stiffness: 7", order),
                      Contains("body.regions[0]") && Contains("no cell and no connection has its middle in this box"));
    CHECK_THROWS_WITH(scene_with("molecules: [0, 19], stiffness: 7", order),
                      Contains("no cell and no connection has all its molecules among these"));
    if (order == 1)
      CHECK_THAT(scene_with("molecules: [0, 1], stiffness: 7", order)->notes.back(),
                 Contains("no cell has all its molecules among these, but 1 connection: springs get this stiffness"));
    CHECK_NOTHROW(scene_with("molecules: [0], mass: 7", order));
    CHECK_NOTHROW(scene_with("from: [0, 0, 4 mm], to: [0, 0, 4 mm], mass: 7", order));
  }
}

TEST_CASE("each of several bodies has sides and sets of its own", "[scene][pick]") {
  const TemporaryFolder folder;
  const auto cell = [](const std::string& base) {
    return "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n*ELEMENT, TYPE=C3D4, ELSET=BODY\n7,1,2,3,4\n*NSET, NSET=" +
           base + ", GENERATE\n1, 3, 1\n*NSET, NSET=TOP\n4\n";
  };
  folder.write("one.inp", cell("FLOOR"));
  folder.write("two.inp", cell("BASE"));
  const auto picked_in = [&](const std::string& where, const std::string& ties = "") {
    const auto scene = load_scene(
        folder.write(
            "a.yaml",
            "bodies:\n- {name: one, mesh: {file: one.inp, length_unit: mm}}\n"
            "- {name: block, at: [0, 0, 5 mm], tetrahedra: {kind: kuhn, cubes: [1, 1, 1], size: [1 mm, 1 mm, 1 mm]}}\n"
            "- {name: two, mesh: {file: two.inp, length_unit: mm}, at: [1 mm, 0, 0]}\n" +
                ties +
                "material: {youngs_modulus: 5 kPa}\nstiffness: neo_hookean\nexperiment: {kind: vibration}\n"
                "loads: [{point: {molecules: " +
                where + ", force: [0, 0, 1 uN]}}]\n"),
        built_in_catalog());
    return scene->specimen.loads.at(0).row.value().second.molecules.at("molecules");
  };
  CHECK(picked_in("{set: FLOOR}") == std::vector{0, 1, 2});
  CHECK(picked_in("{set: BASE}") == std::vector{12, 13, 14});
  CHECK(picked_in("{set: TOP}") == std::vector{3, 15});
  CHECK(picked_in("{set: TOP, body: two}") == std::vector{15});
  CHECK(picked_in("{body: one}") == std::vector{0, 1, 2, 3});
  CHECK(picked_in("{side: z, body: two}") == std::vector{15});
  CHECK(picked_in("{side: z}").size() == 4);  // the block stands highest
  CHECK_THROWS_WITH(picked_in("{set: TOP, body: tow}"), Contains("did you mean 'two'?"));
  CHECK_THROWS_WITH(picked_in("{set: BASE, body: block}"), Contains("no molecule lies there"));
  // Molecule 1 of the first is at the place of molecule 0 of the last, and they become one.
  CHECK(picked_in("{set: BASE}", "ties: [{between: [one, two], within: 1 um}]\n") == std::vector{1, 12, 13});
}

TEST_CASE("planes of symmetry make a quarter of a block measure as the whole of it", "[scene][supports]") {
  const auto block = [](const std::string& size, const std::string& cubes, const std::string& more) {
    return "body: {tetrahedra: {kind: alternating, cubes: " + cubes + ", size: " + size +
           "}}\nmaterial: {youngs_modulus: 5 kPa, poissons_ratio: 0.4}\nstiffness: neo_hookean\n"
           "experiment: {kind: tension, axis: z, strain: 10 %, fixed_grip: clamped, loaded_grip: clamped}\n" +
           more;
  };
  const double whole = modulus_of(block("[20 mm, 20 mm, 20 mm]", "[4, 4, 4]", ""));
  const std::string planes = "supports: [{symmetry: x}, {symmetry: y}]\n";
  const double quarter = modulus_of(block("[10 mm, 10 mm, 20 mm]", "[2, 2, 4]", planes));
  // The alternating cells of the whole are their own mirror images, so that both are the same equations.
  CHECK(quarter == Approx(whole).epsilon(1e-8));
  const double turned =
      modulus_of(block("[10 mm, 10 mm, 20 mm]", "[2, 2, 4]", planes + "rotate: {axis: [1, 2, 3], angle: 40 deg}\n"));
  CHECK(turned == Approx(quarter).epsilon(1e-8));
  // The same planes by molecules and directions.
  const double by_molecules =
      modulus_of(block("[10 mm, 10 mm, 20 mm]", "[2, 2, 4]",
                       "supports: [{molecules: {side: -x}, fix: [x]}, {molecules: {side: -y}, fix: [y]}]\n"));
  CHECK(by_molecules == Approx(quarter).epsilon(1e-10));
}

TEST_CASE("a set of sets in another program's file is the region that it names, in any case", "[scene][pick]") {
  const std::string scene =
      "material: {youngs_modulus: 10 kPa, poissons_ratio: 0}\nstiffness: neo_hookean\n"
      "body: {mesh: {file: " ELASTIN_TEST_DATA
      "/mesh/data/brought/inp_elset_of_elsets.inp, length_unit: mm}, regions: "
      "[{molecules: {set: both}, stiffness: 10}]}\n"
      "experiment: {kind: tension, axis: x, strain: 0.1 %, fixed_grip: clamped, loaded_grip: clamped}\n";
  CHECK(modulus_of(scene) == Approx(10e3 * 3 / (2. / 10 + 1)).epsilon(2e-3));  // two of three cubes in series
}

TEST_CASE("what is wrong with supports is reported", "[scene][supports]") {
  const TemporaryFolder folder;
  const auto said = [&](const std::string& supports, const std::string& experiment = "{kind: tension, force: 1 mN}",
                        const std::string& more = "") {
    try {
      load_scene(folder.write("a.yaml",
                              "body: {lattice: {kind: cubic, molecules: [3, 3, 3], spacing: 1 mm}}\n"
                              "material: {youngs_modulus: 5 kPa}\nstiffness: standard\nexperiment: " +
                                  experiment + "\nsupports: " + supports + "\n" + more),
                 built_in_catalog());
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  CHECK(said("[{symmetry: x}]") == "");
  CHECK_THAT(said("[{symmetry: [1, -1, 0]}]"),
             Contains("supports[0].symmetry: symmetry: the body lies on both sides of one of the planes"));
  CHECK_THAT(said("[{symmetry: x, fix: [x]}]"), Contains("leave out `molecules` and `fix`"));
  CHECK_THAT(said("[{fix: [x]}]"), Contains("supports[0]: key 'molecules' is missing"));
  CHECK_THAT(said("[{molecules: [0], fix: []}]"), Contains("names no direction"));
  CHECK_THAT(said("[{molecules: [], fix: [x]}]"), Contains("supports[0].molecules: names no molecule; write"));
  CHECK_THAT(said("[{symmetry: x}]", "{kind: drop, height: 1 mm, gravity: 9.81 m/s2}", "time: {duration: 1 s}\n"),
             Contains("supports: goes with experiments at rest and with a `fixture`; a drop has none"));
}
