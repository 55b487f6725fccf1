#include "lab/format/vtu.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>

#include "contact/surface_check.h"
#include "elastin/mesh/mesh_file.h"
#include "lab/report/files.h"
#include "lab/report/records.h"
#include "lab/report/table.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::contact;
using namespace elastin::mesh;
using namespace elastin::lab;
using Catch::Matchers::Contains;

namespace {

double volume_of(const Mesh& mesh) {
  double volume = 0;
  for (const auto& [a, b, c] : mesh.triangles)
    volume += mesh.points.col(a).dot(mesh.points.col(b).cross(mesh.points.col(c))) / 6;
  return volume;
}

Mesh drawn(const Obstacle& obstacle, const Vector3& high = Vector3::Ones()) {
  const TemporaryFolder folder;
  return load_mesh(folder.write("it.vtu", obstacles_vtu_text({obstacle}, {obstacle.pose}, -high, high)));
}

/// A block that is pressed with a sphere, with all that the command keeps of it.
struct Pressed {
  Pressed() {
    const TemporaryFolder folder;
    scene =
        load_scene(folder.write("pressed.yaml",
                                "body: {tetrahedra: {kind: kuhn, cubes: [4, 4, 2], size: [20 mm, 20 mm, 10 mm]}}\n"
                                "material: {youngs_modulus: 10 kPa, poissons_ratio: 0.3}\nstiffness: neo_hookean\n"
                                "experiment: {kind: indentation, indenter: {sphere: {radius: 10 mm}}, depth: 1 mm}\n"
                                "contact: {friction: 0.1}\n"),
                   built_in_catalog());
    RunOptions options;
    options.keep_snapshots = true;
    record = make_record(*scene, run_strategy(scene->specimen, *scene->experiment, scene->stiffness, options));
    REQUIRE(record.run.outcome == Outcome::converged);
  }
  std::unique_ptr<Scene> scene;
  Record record;
};

}  // namespace

TEST_CASE("obstacles are drawn as closed surfaces of their size", "[files][contact]") {
  const Pose pose{Eigen::AngleAxisd(1, Vector3(1, 2, 3).normalized()).toRotationMatrix(), {0.1, 0.2, 0.3}};
  Positions corners(3, 4);
  corners << 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1;
  const double pi = std::numbers::pi;
  const std::vector<std::tuple<ObstacleShape, double, double>> cases{
      {shape::Box{{1, 2, 3}}, 6, 1e-6},
      {shape::Sphere{0.5}, pi / 6, 0.03},
      {shape::Cylinder{0.5, 2}, pi / 2, 0.003},
      {shape::Capsule{0.5, 2}, pi / 6 + pi / 2, 0.06},
      {shape::Convex{corners}, 1. / 6, 1e-6},
      {shape::Mesh{corners, {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}}, 1. / 6, 1e-6}};
  for (const auto& [form, volume, tolerance] : cases) {
    INFO(form.index());
    const Mesh mesh = drawn({"it", form, pose});
    CHECK(check_surface(mesh.points, mesh.triangles) == "");
    CHECK(volume_of(mesh) == Approx(volume).epsilon(tolerance));
  }
  // A plane is a square under the body, turned the same way.
  const Mesh plane = drawn({"floor", shape::Plane{}, {Matrix3::Identity(), {7, 8, -1}}});
  CHECK((plane.points.row(2).array() + 1).abs().maxCoeff() < 1e-12);
  CHECK(plane.points.row(0).mean() == Approx(0).margin(1e-12));
}

TEST_CASE("states of contact are written with pressure, surface and obstacles", "[files][contact]") {
  const Pressed pressed;
  const Record& record = pressed.record;
  const Snapshot& end = record.run.snapshots.back();
  const TemporaryFolder folder;
  const std::string out = folder.path("out");
  write_states(out, "it", pressed.scene->specimen.body, record.run);
  for (const char* file : {"/it.pvd", "/it-001.vtu", "/it-surface-001.vtu", "/it-obstacles-001.vtu"})
    CHECK(std::filesystem::exists(out + file));
  const Mesh surface = load_mesh(out + "/it-surface-001.vtu");
  CHECK(surface.triangles.size() == 2 * (4 * 4 + 4 * 2 + 4 * 2) * 2);
  // The sphere's lowest point has gone down to a depth of 1 mm below the block's top.
  const Mesh sphere = load_mesh(out + "/it-obstacles-001.vtu");
  CHECK(sphere.points.row(2).minCoeff() == Approx(9e-3).epsilon(0.01));
  CHECK_THAT(vtu_text(pressed.scene->specimen.body, end, {}),
             Contains("Name=\"contact_pressure\"") && Contains("Name=\"contact_force\""));
  // What presses on the molecules is the force that the experiment reads, and the pressures belong to it.
  CHECK(-end.contact_forces.row(2).sum() == Approx(record.run.measures.get("force")).epsilon(1e-9));
  CHECK(end.contact_pressure.maxCoeff() == Approx(record.run.measures.get("largest_pressure")));
}

TEST_CASE("contact stands on the page and in the JSON", "[texts][files][contact]") {
  const Pressed pressed;
  const Record& record = pressed.record;
  CHECK_THAT(run_text(record, false), Contains("  contact: ") && Contains(" on indenter; broad phase "));
  const auto run = nlohmann::json::parse(json_text({record}))["runs"][0];
  const auto force = run["contact"]["on_obstacles"]["indenter"];
  CHECK(force[2].get<double>() == Approx(record.run.measures.get("force")).epsilon(1e-9));
  CHECK(run["contact"]["pairs"].get<int>() == static_cast<int>(record.run.measures.get("contacts")));
  CHECK(run["contact"]["narrow_seconds"].get<double>() >= 0);
  CHECK_THAT(csv_text({record}), Contains(",contact_area [m^2],"));
}
