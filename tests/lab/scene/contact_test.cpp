// Contact as a scene writes it: what is read, and mistakes named with their place.

#include "elastin/contact/contact.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "lab/run/contact_measures.h"
#include "lab/run/specimen.h"
#include "lab/scene/scene.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::contact;
using namespace elastin::lab;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

namespace {

const Catalog kCatalog = built_in_catalog();
const char* const kCells = "tetrahedra: {kind: kuhn, cubes: [2, 2, 2], size: [10 mm, 10 mm, 10 mm]}";
const char* const kLattice = "lattice: {kind: cubic, molecules: [3, 3, 3], spacing: 5 mm}";

/// A scene whose line 6 is its contact.
std::string scene_with(const std::string& contact, const std::string& body = kCells,
                       const std::string& experiment = "kind: compression, axis: z, displacement: 1 mm",
                       const std::string& more = "") {
  return "title: Contact\nbody: {" + body +
         "}\nmaterial: {youngs_modulus: 10 kPa, poissons_ratio: 0.3, density: 1000 kg/m3}\nstiffness: standard\n"
         "experiment: {" +
         experiment + "}\n" + (contact.empty() ? "" : "contact: " + contact + "\n") + more;
}

std::unique_ptr<Scene> load(const std::string& text) {
  const TemporaryFolder folder;
  return load_scene(folder.write("scene.yaml", text), kCatalog);
}

ContactOptions options_of(const std::string& contact, const std::string& body = kCells) {
  return *load(scene_with(contact, body))->specimen.contact;
}

Obstacle obstacle_of(const std::string& obstacle, const std::string& more = "") {
  return load(scene_with("{obstacles: [{" + obstacle + "}]}", kCells, "kind: compression, axis: z, displacement: 1 mm",
                         more))
      ->specimen.contact->obstacles.at(0);
}

std::string refusal_of(const std::string& text) {
  const TemporaryFolder folder;
  const std::string file = folder.write("slip.yaml", text);
  try {
    load_scene(file, kCatalog);
  } catch (const InputError& error) {
    const std::string message = error.what();
    REQUIRE_THAT(message, StartsWith(file + ":"));
    return message.substr(file.size() + 1);
  }
  return "";
}

}  // namespace

TEST_CASE("a scene without contact builds no contact object", "[scene][contact]") {
  for (const bool with : {false, true}) {
    const auto scene = load(scene_with(with ? "{friction: 0.1}" : ""));
    CHECK(scene->specimen.contact.has_value() == with);
    Run run;
    const auto held = make_model(scene->specimen, *scene->experiment, scene->stiffness, {}, run);
    REQUIRE(held);
    CHECK((contact_of(*held->model) != nullptr) == with);
    CHECK(held->model->loads().size() == (with ? 1u : 0u));
  }
}

TEST_CASE("contact has defaults that suit the body", "[scene][contact]") {
  const ContactOptions cells = options_of("{self: false}");
  CHECK(cells.surface == ContactSurface::triangles);
  CHECK(cells.stiffness == Approx(10 * 10e3 / 5e-3));  // molecules are as wide as the shortest connection
  CHECK(cells.friction == 0);
  CHECK(cells.restitution == 1);
  CHECK(cells.penetration == 0);
  CHECK_FALSE(cells.self);
  CHECK(cells.obstacles.empty());
  CHECK(options_of("{self: false}", kLattice).surface == ContactSurface::spheres);
  CHECK(options_of("{surface: spheres}").surface == ContactSurface::spheres);
  CHECK(options_of("{surface: triangles}", kLattice).surface == ContactSurface::triangles);
}

TEST_CASE("a body without cells among others touches as spheres, or it is said that it does not", "[scene][contact]") {
  const auto scene = [](const std::string& contact) {
    return load("bodies: [{name: block, " + std::string(kCells) +
                "}, {name: rope, molecules: [[0, 0, 12 mm], [5 mm, 0, 12 mm]], "
                "connections: [[0, 1]], radius: 1 mm}]\nmaterial: {youngs_modulus: 10 kPa, poissons_ratio: 0.3, "
                "density: 1000 kg/m3}\n"
                "stiffness: standard\nexperiment: {kind: loads}\ncontact: " +
                contact + "\n");
  };
  const auto automatic = scene("{friction: 0}"), triangles = scene("{surface: triangles}"),
             spheres = scene("{surface: spheres}");
  CHECK(automatic->specimen.contact->surface == ContactSurface::spheres);
  REQUIRE(!automatic->notes.empty());
  CHECK_THAT(automatic->notes.back(), StartsWith("body 'rope' has no cells") && Contains("as spheres"));
  CHECK(triangles->specimen.contact->surface == ContactSurface::triangles);
  REQUIRE(!triangles->warnings.empty());
  CHECK_THAT(triangles->warnings.back(), StartsWith("body 'rope' has no cells") && Contains("touches nothing"));
  CHECK(spheres->warnings.size() + 1 == triangles->warnings.size());
}

TEST_CASE("what touches with friction from the start is at rest in few iterations, and sticks", "[scene][contact]") {
  const std::string gravity = "loads: [{gravity: {acceleration: [2 m/s2, 0, -9.81 m/s2]}}]\n",
                    wall = "obstacles: [{name: wall, plane: {point: [10 mm, 0, 0], normal: -x}}]}";
  const auto run_of = [&](const std::string& friction) {
    const auto scene = load(scene_with("{friction: " + friction + ", " + wall, kCells,
                                       "kind: tension, axis: z, strain: 0.01 %, fixed_grip: clamped", gravity));
    const Run run = run_strategy(scene->specimen, *scene->experiment, scene->stiffness, {.statics = scene->statics});
    INFO(friction << ": " << run.cause);
    CHECK(run.outcome == Outcome::converged);
    CHECK(run.newton_iterations < 30);
    return run.measures.get("contact_force");
  };
  const double free = run_of("0"), held = run_of("0.5");
  CHECK(held > 1.02 * free);  // the wall bears weight, too
  // A block on a slope of 16.7 degrees stays where 0.35 > tan 16.7° = 0.3, and has no equilibrium at 0.25.
  for (const auto& [friction, stays] : {std::pair{"0.35", true}, {"0.25", false}}) {
    const auto scene = load(scene_with(
        std::string("{friction: ") + friction + ", obstacles: [{name: slope, plane: {point: [0, 0, 0], normal: z}}]}",
        kCells, "kind: loads", "loads: [{gravity: {acceleration: [2.82 m/s2, 0, -9.4 m/s2]}}]\n"));
    const Run run = run_strategy(scene->specimen, *scene->experiment, scene->stiffness, {.statics = scene->statics});
    INFO(friction << ": " << run.cause);
    CHECK((run.outcome == Outcome::converged) == stays);
  }
}

TEST_CASE("contact takes its numbers with their units", "[scene][contact]") {
  const ContactOptions options =
      options_of("{stiffness: 40, friction: 0.3, restitution: 0.5, penetration: 10 um, self: true}");
  CHECK(options.stiffness == Approx(40 * 10e3 / 5e-3));
  CHECK(options.friction == 0.3);
  CHECK(options.restitution == 0.5);
  CHECK(options.penetration == Approx(1e-5));
  CHECK(options.self);
  CHECK(options_of("{stiffness: 2 MPa/mm}").stiffness == Approx(2e9));
  CHECK(options_of("{stiffness: 1e2}").stiffness == Approx(100 * 10e3 / 5e-3));
}

TEST_CASE("obstacles lie where the scene says, turned with it", "[scene][contact]") {
  const Vector3 at(0.001, 0.002, 0.003);
  const Obstacle plane = obstacle_of("plane: {point: [1 mm, 2 mm, 3 mm], normal: -x}");
  CHECK(plane.name == "plane");
  CHECK((plane.pose.turn.col(2) + Vector3::UnitX()).norm() < 1e-12);
  CHECK((plane.pose.position - at).norm() < 1e-12);
  const Obstacle rod = obstacle_of(
      "name: rod, cylinder: {radius: 1 mm, length: 20 mm, axis: x}, at: [1 mm, 2 mm, 3 mm], turn: {axis: z, angle: 90 "
      "deg}, friction: 0.2");
  CHECK(rod.name == "rod");
  CHECK(rod.friction == 0.2);
  CHECK((rod.pose.turn.col(2) - Vector3::UnitY()).norm() < 1e-12);
  CHECK(std::get<shape::Cylinder>(rod.shape).length == Approx(0.02));
  const Obstacle turned = obstacle_of("sphere: {radius: 1 mm}, at: [1 mm, 0, 0], motion: {by: [0, 2 mm, 0]}",
                                      "rotate: {axis: z, angle: 90 deg}\n");
  CHECK((turned.pose.position - Vector3(0, 0.001, 0)).norm() < 1e-12);
  CHECK((turned.at(0.5).position - Vector3(-0.001, 0.001, 0)).norm() < 1e-12);
  const auto scene =
      load(scene_with("{obstacles: [{box: {size: [1 mm, 1 mm, 1 mm]}}, {box: {size: [1 mm, 2 mm, 3 mm]}}]}"));
  CHECK(scene->specimen.contact->obstacles[1].name == "box 2");
}

TEST_CASE("obstacles move in time as the scene says", "[scene][contact]") {
  const auto scene = load(scene_with(
      "{obstacles: [{plane: {point: [0, 0, -5 mm], normal: z}, motion: {by: [0, 0, 2 mm], in_time: {ramp: {duration: 4 "
      "s}}}}, {sphere: {radius: 1 mm}, at: [0, 0, 90 mm], velocity: [0, 0, -1 m/s], spin: [0, 0, 3 1/s]}]}",
      kCells, "kind: motion", "time: {duration: 1 s}\n"));
  const Pose plane = scene->specimen.contact->obstacles[0].at(1);
  CHECK(plane.position.z() == Approx(-0.005 + 0.0005));
  CHECK(plane.velocity.z() == Approx(0.0005));
  const Pose sphere = scene->specimen.contact->obstacles[1].at(0.01);
  CHECK(sphere.position.z() == Approx(0.09 - 0.01));
  CHECK((sphere.turn - Eigen::AngleAxisd(0.03, Vector3::UnitZ()).toRotationMatrix()).norm() < 1e-12);
  // A point on the rim goes with both.
  const Vector3 rim = sphere.to_world({0.001, 0, 0});
  const Vector3 before = scene->specimen.contact->obstacles[1].at(0.01 - 1e-6).to_world({0.001, 0, 0});
  CHECK((sphere.velocity_at(rim) - (rim - before) / 1e-6).norm() < 1e-6);
}

TEST_CASE("mistakes in contact are named with their place", "[scene][contact]") {
  const std::vector<std::pair<std::string, std::string>> cases{
      {"{frictoin: 0.3}", "6:11: contact: unknown key 'frictoin'; did you mean 'friction'?"},
      {"{friction: -1}", "6:21: contact.friction: '-1' is out of range"},
      {"{adhesion: 0.1 J/m2}", "6:10: contact: key 'adhesion_range' is missing, with `adhesion`"},
      {"{adhesion_range: 1 um}", "6:27: contact.adhesion_range: needs `adhesion` too"},
      {"{restitution: 2}", "6:24: contact.restitution: '2' is out of range"},
      {"{penetration: 0 m}", "6:24: contact.penetration: '0 m' is out of range"},
      {"{surface: sphere}", "6:20: contact.surface: 'sphere' is not known here; did you mean 'spheres'?"},
      {"{stiffness: 3 Pa}", "6:22: contact.stiffness: 'Pa' cannot be converted to Pa/m"},
      {"{stiffness: 0}", "6:22: contact.stiffness: '0' is out of range"},
      {"{obstacles: [{shere: {radius: 1 mm}}]}", "unknown key 'shere'; did you mean 'sphere'?"},
      {"{obstacles: [{name: x}]}", "an obstacle is one of plane, box, sphere, cylinder, capsule, convex, mesh"},
      {"{obstacles: [{plane: {point: [0, 0, 0], normal: z}, at: [0, 0, 1 mm]}]}", "a plane lies through its own point"},
      {"{obstacles: [{sphere: {radius: 1 mm}, name: a}, {sphere: {radius: 1 mm}, name: a}]}",
       "'a' is the name of another obstacle"},
      {"{obstacles: [{convex: {points: [[0, 0, 0], [1 mm, 0, 0], [0, 1 mm, 0], [1 mm, 1 mm, 0]]}}]}",
       "at least four points that do not lie in one plane"},
      {"{obstacles: [{mesh: {file: no.stl, length_unit: mm}}]}",
       "contact.obstacles[0].mesh.file: 'no.stl': no such file"},
      {"{obstacles: [{sphere: {radius: 1 mm}, velocity: [0, 0, 1 m/s]}]}", "an experiment at rest has no time"},
      {"{obstacles: [{sphere: {radius: 1 mm}, motion: {by: [0, 0, 1 mm]}, velocity: [0, 0, 1 m/s]}]}",
       "there is a motion already"}};
  for (const auto& [contact, says] : cases) {
    INFO(contact);
    CHECK_THAT(refusal_of(scene_with(contact)), Contains(says));
  }
  CHECK_THAT(
      refusal_of(scene_with("{surface: triangles}", "molecules: [[0, 0, 0], [0, 0, 9 mm]], connections: [[0, 1]]",
                            "kind: compression, axis: z, displacement: 1 mm, cross_section: 1 mm2")),
      Contains("contact: the body has no surface of triangles"));
  CHECK_THAT(refusal_of(scene_with("{friction: 0}", kCells, "kind: compression, axis: z, displacement: 1 mm",
                                   "solver: {displacements: small}\n")),
             Contains("one linear solve cannot find what touches"));
  CHECK_THAT(refusal_of(scene_with("{obstacles: [{sphere: {radius: 1 mm}, motion: {by: [0, 0, 1 mm]}}]}", kCells,
                                   "kind: motion", "time: {duration: 1 s}\n")),
             Contains("key 'in_time' is missing"));
  CHECK_THAT(refusal_of(scene_with("{penetration: 1 um}", kCells, "kind: motion",
                                   "time: {duration: 1 s, stepper: velocity_verlet}\n")),
             Contains("6:24: contact.penetration: explicit steps do not keep"));
}

TEST_CASE("a surface that is open is no obstacle", "[scene][contact]") {
  const TemporaryFolder folder;
  folder.write("open.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\n");
  const std::string file =
      folder.write("scene.yaml", scene_with("{obstacles: [{mesh: {file: open.obj, length_unit: mm}}]}"));
  CHECK_THROWS_WITH(load_scene(file, kCatalog),
                    Contains("contact.obstacles[0].mesh.file: the surface encloses no volume: ") && Contains("hole"));
}

TEST_CASE("experiments of contact say what they miss", "[scene][contact]") {
  const std::vector<std::array<std::string, 3>> cases{
      {"kind: indentation, indenter: {sphere: {radius: 1 mm}}, depth: 1 mm", "",
       "key 'contact' of the scene is missing"},
      {"kind: indentation, indenter: {sphere: {radius: 1 mm}}", "{self: false}", "give one of depth, strain and force"},
      {"kind: indentation, indenter: {ball: {radius: 1 mm}}, depth: 1 mm", "{self: false}", "unknown key 'ball'"},
      {"kind: indentation, indenter: tool, depth: 1 mm", "{self: false}", "there is no obstacle 'tool'"},
      {"kind: indentation, indenter: {sphere: {radius: 1 mm}}, depth: 1 mm, symmetry: [z]", "{self: false}",
       "must be perpendicular to the indenter's axis"},
      {"kind: indentation, indenter: {flat: {radius: 1 mm}}, depth: 1 mm, at: [90 mm, 0, 0]", "{self: false}",
       "no molecule lies before the indenter"},
      {"kind: press, displacement: 1 mm, force: 1 N", "{self: false}", "give one of displacement, strain and force"},
      {"kind: press, displacement: 1 mm, move: bone", "{self: false}", "bone"},
      {"kind: press, displacement: 1 mm", "", "key 'contact' of the scene is missing"},
      {"kind: sliding, incline: {angle: 5 deg}, sled: {speed: 1 m/s}", "{self: false}", "give one of incline"},
      {"kind: sliding, incline: {angle: 5 deg}, along: z", "{self: false}", "must be perpendicular to `up`"},
      {"kind: sliding, incline: {angle: 5 deg}, floor: ice", "{self: false}", "there is no obstacle 'ice'"},
      {"kind: drop, gravity: 9.81 m/s2, height: 1 mm", "{self: false}", "this scene has contact"}};
  for (const auto& [experiment, contact, says] : cases) {
    INFO(experiment);
    CHECK_THAT(refusal_of(scene_with(contact, kCells, experiment, "time: {duration: 1 s}\n")), Contains(says));
  }
}
