// What a page and ParaView get of a run's states.

#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <pugixml.hpp>
#include <string>
#include <vector>

#include "lab/report/files.h"
#include "lab/report/page.h"
#include "lab/study/request.h"
#include "support/temporary_folder.h"
#include "support/vtu_arrays.h"

using namespace elastin;
using namespace elastin::lab;
using Json = nlohmann::json;

namespace {

/// A run with all its states.
struct Shown {
  explicit Shown(const std::string& text)
      : scene(load_scene(folder.write("it.yaml", text), built_in_catalog())),
        record(make_record(*scene,
                           run_strategy(scene->specimen, *scene->experiment, scene->stiffness,
                                        {.statics = scene->statics, .keep_snapshots = true, .time = scene->time}))) {}
  Json body() const { return Json::parse(body_view(*scene, record)); }
  Json frames() const { return Json::parse(states_view(*scene, record))["frames"]; }
  /// Timesteps and files of the collection for ParaView.
  std::vector<std::pair<double, std::string>> files() const {
    write_states(folder.path(""), "it", scene->specimen.body, record.run);
    pugi::xml_document document;
    REQUIRE(document.load_file(folder.path("it.pvd").c_str()));
    std::vector<std::pair<double, std::string>> all;
    for (const pugi::xml_node set : document.child("VTKFile").child("Collection").children("DataSet"))
      all.emplace_back(set.attribute("timestep").as_double(), set.attribute("file").value());
    return all;
  }

  TemporaryFolder folder;
  std::unique_ptr<Scene> scene;
  Record record;
};

const std::string kString =
    "body: {molecules: [[0, 0, 0], [10 mm, 0, 0], [20 mm, 0, 0]], connections: {within: 11 mm}, radius: 1 mm}\n"
    "material: {youngs_modulus: 1 MPa, density: 1000 kg/m3}\n"
    "stiffness: {strategy: uniform, constant: 100 N/m}\nexperiment: {kind: vibration, count: 3, load: applied,"
    " fixture: {kind: tension, axis: x, strain: 10 %, fixed_grip: clamped, loaded_grip: clamped,"
    " cross_section: 1 mm2}}\n";

}  // namespace

TEST_CASE("a vibration shows the state about which it moves, then each mode", "[files][vibration]") {
  const Shown shown(kString);
  REQUIRE(shown.record.run.outcome == Outcome::converged);
  const Json frames = shown.frames();
  REQUIRE(frames.size() == 4);
  CHECK(frames[0].count("frequency") == 0);
  CHECK(frames[0]["tensions"]["most"].get<double>() == Approx(0.1));  // 100 N/m, by 1 mm
  for (int mode = 1; mode <= 3; ++mode) {
    CHECK(frames[mode]["at"] == mode);
    CHECK(frames[mode]["frequency"].get<double>() ==
          shown.record.run.measures.get("frequency_" + std::to_string(mode)));
    CHECK(frames[mode]["tensions"]["most"] == 0);
  }
  const auto files = shown.files();
  REQUIRE(files.size() == 4);
  const auto positions = [&](int file) {
    CHECK(files[file].first == file);
    pugi::xml_document vtu;
    REQUIRE(vtu.load_file(shown.folder.path(files[file].second).c_str()));
    return numbers_of(vtu.select_node("//Points/DataArray").node());
  };
  const std::vector<double> about = positions(0);
  CHECK(about[6] == Approx(22e-3));  // pulled by 10 %
  for (int mode = 1; mode <= 3; ++mode) {
    std::vector<double> moved = positions(mode);
    Vector3 bead;
    for (int k = 0; k < 9; ++k) moved[k] -= about[k];
    for (int k = 0; k < 3; ++k) bead[k] = moved[3 + k];
    CHECK(bead.norm() == Approx(2.2e-3));                                      // a tenth of 22 mm
    CHECK(std::abs(bead.x()) == Approx(mode == 3 ? 2.2e-3 : 0).margin(1e-9));  // two modes across, one along
    for (const int end : {0, 1, 2, 6, 7, 8}) CHECK(moved[end] == Approx(0).margin(1e-12));
  }
}

TEST_CASE("forces and stresses that are rounding are shown as none", "[files]") {
  const std::string block =
      "body: {lattice: {kind: cubic, molecules: [4, 4, 4], spacing: 1 cm, order: 1}}\n"
      "material: {youngs_modulus: 100 kPa, poissons_ratio: 0.3}\nstiffness: neo_hookean\n";
  const Shown turned(block +
                     "experiment: {kind: motion}\ntime: {duration: 1 ms, frames: 1}\n"
                     "initial: {spin: [0, 0, 1e-7 1/s]}\n");
  REQUIRE(turned.record.run.outcome == Outcome::converged);
  for (const Json& frame : turned.frames()) {
    CHECK(frame.count("stresses") == 0);
    CHECK(frame["forces"]["most"] == 0);
  }
  const Shown pulled(block + "experiment: {kind: tension, axis: z, strain: 0.0001 %}\n");
  CHECK(pulled.frames().back()["stresses"]["most"].get<double>() == Approx(0.1).epsilon(0.01));
}

TEST_CASE("a floor of loads is shown as obstacles are", "[files]") {
  const std::string cube =
      "body: {lattice: {kind: cubic, molecules: [2, 2, 2], spacing: 1 cm, connections: [axis, face]}}\n"
      "material: {youngs_modulus: 100 kPa, density: 1000 kg/m3}\nstiffness: lattice\n"
      "time: {duration: 1 ms, frames: 2}\n";
  for (const std::string& experiment :
       {std::string("experiment: {kind: drop, gravity: 9.81 m/s2, height: 5 cm}\n"),
        std::string("experiment: {kind: motion}\nloads: [{floor: {point: [0, 0, -55 mm], normal: [0, 0, 2]}}]\n")}) {
    const Shown shown(cube + experiment);
    REQUIRE(shown.record.run.outcome == Outcome::converged);
    REQUIRE(shown.body()["obstacles"].size() == 1);
    CHECK(shown.body()["obstacles"][0]["name"] == "floor");
    const Json pose = shown.frames().back()["poses"][0];
    CHECK(std::abs(pose[8].get<double>()) == Approx(1));  // its normal is along z
    CHECK(pose[11].get<double>() == Approx(-55e-3));      // 5 cm below the lowest sphere, of a radius of 5 mm
    int floors = 0;
    for (const auto& [at, file] : shown.files()) floors += file.find("-obstacles-") != std::string::npos;
    CHECK(floors == 3);
  }
}

TEST_CASE("a run that ends before it has a state is shown at rest", "[files]") {
  const std::string text =
      "body: {molecules: [[0, 0, 0], [0, 0, 1 mm], [0, 0, 2 mm]], connections: [[0, 1], [1, 2]], radius: 1 mm}\n"
      "material: {youngs_modulus: 5 kPa}\nexperiment: {kind: tension, axis: z, displacement: 1 mm, cross_section: 1 "
      "mm2,"
      " fixed_grip: clamped, loaded_grip: clamped}\n";
  Shown shown(text + "stiffness: standard\n");
  REQUIRE(shown.record.run.outcome == Outcome::converged);
  shown.record.run.snapshots.clear();
  REQUIRE(shown.frames().size() == 1);
  CHECK(shown.frames()[0]["displacements"]["most"] == 0);
  shown.record.run.suited = false;
  CHECK(states_view(*shown.scene, shown.record).empty());
}
