#include "elastin/contact/contact.h"

#include <cctype>
#include <cmath>
#include <filesystem>

#include "elastin/contact/surface_check.h"
#include "elastin/core/base/dense.h"
#include "elastin/mesh/mesh_file.h"
#include "lab/scene/parts.h"

namespace elastin::lab {
namespace {

/// Turns z to a direction.
Matrix3 turn_to(const Vector3& direction) { return rotation_between(Vector3::UnitZ(), direction); }

/// A shape in its own frame, and how it lies there.
struct Form {
  contact::ObstacleShape shape;
  contact::Pose pose = {};
};

Form read_plane(Reader reader) {
  const Vector3 point = reader.at("point").vector(dimension::length), normal = reader.at("normal").direction();
  reader.finish();
  return {contact::shape::Plane{}, {turn_to(normal), point}};
}

Form read_box(Reader reader) {
  const Vector3 size = reader.at("size").vector(dimension::length, kPositive);
  reader.finish();
  return {contact::shape::Box{size}};
}

Form read_sphere(Reader reader) {
  const double radius = read_length(reader, "radius");
  reader.finish();
  return {contact::shape::Sphere{radius}};
}

template <class Round>
Form read_round(Reader reader) {
  const double radius = read_length(reader, "radius"), length = read_length(reader, "length");
  const auto axis = reader.find("axis");
  const Vector3 direction = axis ? axis->direction() : Vector3(Vector3::UnitZ());
  reader.finish();
  return {Round{radius, length}, {turn_to(direction)}};
}

Form read_convex(Reader reader) {
  const Reader list = reader.at("points");
  const std::vector<Reader> items = list.items();
  reader.finish();
  contact::shape::Convex convex{Positions(3, static_cast<Eigen::Index>(items.size()))};
  for (std::size_t i = 0; i < items.size(); ++i)
    convex.points.col(static_cast<Eigen::Index>(i)) = items[i].vector(dimension::length);
  const Positions centred = convex.points.colwise() - Vector3(convex.points.rowwise().mean());
  const VectorX spread = symmetric_eigenvalues3(Matrix3(centred * centred.transpose()));
  if (items.size() < 4 || !(spread[0] > 1e-12 * spread[2]))
    list.fail("a convex obstacle needs at least four points that do not lie in one plane");
  return {convex};
}

Form read_surface_file(Reader reader) {
  const Reader file = reader.at("file");
  const mesh::Mesh mesh = read_mesh_file(reader);
  reader.finish();
  if (!mesh.tetrahedra.empty()) file.fail("an obstacle is a surface of triangles; this mesh has tetrahedra");
  const std::string fault = contact::check_surface(mesh.points, mesh.triangles);
  if (!fault.empty()) file.fail("the surface encloses no volume: " + fault);
  return {contact::shape::Mesh{mesh.points, mesh.triangles}};
}

/// {by: [0, 0, -1 mm], in_time: {ramp: …}}
std::function<contact::Pose(double)> read_by(Reader reader, const contact::Pose& pose, const Matrix3& rotation,
                                             SceneContact& contact) {
  const Vector3 by = rotation * reader.at("by").vector(dimension::length);
  const auto in_time = reader.find("in_time");
  reader.finish();
  if (!in_time) {
    contact.by_load.push_back(reader);
    return [=](double factor) {
      contact::Pose moved = pose;
      moved.position += factor * by;
      return moved;
    };
  }
  contact.by_time.push_back(reader);
  return [=, function = read_time_function(*in_time)](double time) {
    contact::Pose moved = pose;
    moved.position += function.value(time) * by;
    moved.velocity = function.rate(time) * by;
    return moved;
  };
}

std::function<contact::Pose(double)> steady_motion(const contact::Pose& pose, const Vector3& velocity,
                                                   const Vector3& spin) {
  return [=](double time) {
    contact::Pose moved = pose;
    if (const double angle = spin.norm() * time; angle != 0)
      moved.turn = Eigen::AngleAxisd(angle, spin.normalized()).toRotationMatrix() * pose.turn;
    moved.position += time * velocity;
    moved.velocity = velocity;
    moved.spin = spin;
    return moved;
  };
}

void read_motion(Reader& reader, const Matrix3& rotation, contact::Obstacle& obstacle, SceneContact& contact) {
  const auto motion = reader.find("motion"), velocity = reader.find("velocity"), spin = reader.find("spin");
  if (motion && (velocity || spin)) (velocity ? *velocity : *spin).fail("there is a motion already; give one of them");
  if (motion) obstacle.motion = read_by(*motion, obstacle.pose, rotation, contact);
  if (!velocity && !spin) return;
  contact.by_time.push_back(velocity ? *velocity : *spin);
  const Vector3 translation =
      velocity ? Vector3(rotation * velocity->vector(dimension::velocity)) : Vector3(Vector3::Zero());
  const Vector3 turn = spin ? Vector3(rotation * spin->vector({0, 0, -1})) : Vector3(Vector3::Zero());
  obstacle.motion = steady_motion(obstacle.pose, translation, turn);
}

bool is_named(const std::vector<contact::Obstacle>& obstacles, const std::string& name) {
  return std::any_of(obstacles.begin(), obstacles.end(), [&](const contact::Obstacle& o) { return o.name == name; });
}

void read_obstacle(Reader reader, const Matrix3& rotation, SceneContact& contact) {
  const std::vector<std::pair<std::string, Form (*)(Reader)>> kinds{
      {contact::shape::Plane::name, read_plane},
      {contact::shape::Box::name, read_box},
      {contact::shape::Sphere::name, read_sphere},
      {contact::shape::Cylinder::name, read_round<contact::shape::Cylinder>},
      {contact::shape::Capsule::name, read_round<contact::shape::Capsule>},
      {contact::shape::Convex::name, read_convex},
      {contact::shape::Mesh::name, read_surface_file}};
  std::vector<std::pair<std::string, Form>> found;
  std::string names;
  for (const auto& [kind, read] : kinds) {
    if (auto value = reader.find(kind)) found.emplace_back(kind, read(*value));
    names += (names.empty() ? "" : ", ") + kind;
  }
  for (const char* key : {"name", "at", "turn", "friction", "motion", "velocity", "spin"}) reader.has(key);
  if (found.size() != 1) {
    reader.finish();
    reader.fail("an obstacle is one of " + names + "; write each as an item of its own");
  }
  auto& obstacles = contact.options.obstacles;
  const auto& [kind, form] = found.front();
  contact::Obstacle obstacle{kind, form.shape, form.pose};
  const auto name = reader.find("name"), at = reader.find("at"), turn = reader.find("turn"),
             friction = reader.find("friction");
  for (int number = 2; !name && is_named(obstacles, obstacle.name); ++number)
    obstacle.name = kind + " " + std::to_string(number);
  if (name) obstacle.name = name->text();
  if (name && is_named(obstacles, obstacle.name)) name->fail("'" + obstacle.name + "' is the name of another obstacle");
  if (at && kind == "plane") at->fail("a plane lies through its own point: leave this out");
  if (turn && kind == "plane") turn->fail("a plane has a normal: leave this out");
  if (turn) obstacle.pose.turn = turn->rotation() * obstacle.pose.turn;
  if (at) obstacle.pose.position = at->vector(dimension::length);
  obstacle.pose.turn = rotation * obstacle.pose.turn;
  obstacle.pose.position = rotation * obstacle.pose.position;
  if (friction) obstacle.friction = friction->quantity(dimension::none, kNotNegative);
  read_motion(reader, rotation, obstacle, contact);
  reader.finish();
  obstacles.push_back(std::move(obstacle));
}

/// A plain number is times E over a molecule's diameter; with a unit, pressure over depth.
double read_contact_stiffness(const Reader& reader, const Body& body, const Material& material) {
  const std::string given = reader.text();
  const bool plain =
      std::none_of(given.begin(), given.end(), [](unsigned char c) { return std::isalpha(c) && c != 'e' && c != 'E'; });
  if (!plain) return reader.quantity({-2, 1, -2}, kPositive);
  return reader.quantity(dimension::none, kPositive) / 10 *
         contact::default_contact_stiffness(body, material.youngs_modulus);
}

}  // namespace

SceneContact read_contact(Reader reader, const Body& body, const Material& material, const Matrix3& rotation) {
  SceneContact contact;
  contact::ContactOptions& options = contact.options;
  const bool cells = !body.tetrahedra.empty() || !body.triangles.empty();
  options.surface = cells ? contact::ContactSurface::triangles : contact::ContactSurface::spheres;
  if (auto value = reader.find("surface"))
    options.surface = value->choice<contact::ContactSurface>(
        {{"spheres", contact::ContactSurface::spheres}, {"triangles", contact::ContactSurface::triangles}});
  options.stiffness = contact::default_contact_stiffness(body, material.youngs_modulus);
  if (auto value = reader.find("stiffness")) options.stiffness = read_contact_stiffness(*value, body, material);
  if (auto value = reader.find("friction")) options.friction = value->quantity(dimension::none, kNotNegative);
  if (auto value = reader.find("restitution")) options.restitution = value->quantity(dimension::none, {0.01, 1, false});
  if (auto value = reader.find("penetration")) options.penetration = value->quantity(dimension::length, kPositive);
  if (auto value = reader.find("self")) options.self = value->choice<bool>({{"true", true}, {"false", false}});
  if (auto obstacles = reader.find("obstacles"))
    for (const Reader& item : obstacles->items()) read_obstacle(item, rotation, contact);
  reader.finish();
  return contact;
}

void check_motions(const SceneContact& contact, bool timed) {
  if (timed && !contact.by_load.empty())
    contact.by_load.front().fail(
        "key 'in_time' is missing: how an obstacle moves through time, for example in_time: "
        "{ramp: {duration: 1 s}}");
  if (!timed && !contact.by_time.empty())
    contact.by_time.front().fail(
        "an experiment at rest has no time: write motion: {by: [x, y, z]}, which goes with "
        "the load");
}

std::vector<KeySection> contact_keys() {
  const auto quantity = [](const char* name, const char* text) {
    return SceneKey{name, "quantity", "m", "> 0", "needed", text};
  };
  const std::string axis = "axis of the shape";
  return {
      {"contact",
       "Contact",
       "",
       {{"surface", "`triangles`, `spheres`", "", "", "`triangles` with cells, else `spheres`",
         "what meets others: the surface of the cells, or the molecules"},
        {"stiffness", "number, or quantity", "Pa/m", "> 0", "10", "a number is times E over a molecule's diameter"},
        {"friction", "number", "", "≥ 0", "0", "coefficient of Coulomb friction; sticking contact does not creep"},
        {"restitution", "number", "", "0.01 … 1", "1", "coefficient of restitution of two molecules that meet alone"},
        {"penetration", "quantity", "m", "> 0", "what the penalty leaves",
         "largest depth, in the mean about a molecule, by multipliers; at rest and in implicit steps"},
        {"self", "`true`, `false`", "", "", "`false`", "whether contact of a piece with itself counts"},
        {"obstacles", "list of maps", "", "", "none", "rigid bodies, each with one shape"}}},
      {"contact.obstacles",
       "",
       "Each item of `obstacles` has one shape, and the keys after the shapes:",
       {{"plane.point", "vector", "m", "", "needed", "a point of the plane"},
        {"plane.normal", "direction", "", "", "needed", "normal towards the free side"},
        {"box.size", "vector", "m", "> 0", "needed", "sides of the box about its middle"},
        quantity("sphere.radius", "radius of the sphere"),
        quantity("cylinder.radius", "radius of the cylinder"),
        quantity("cylinder.length", "length of the cylinder about its middle"),
        {"cylinder.axis", "direction", "", "", "`z`", axis},
        quantity("capsule.radius", "radius of the capsule"),
        quantity("capsule.length", "length of its straight part"),
        {"capsule.axis", "direction", "", "", "`z`", axis},
        {"convex.points", "list of vectors", "m", "", "needed", "four points or more that do not lie in one plane"},
        {"mesh.file", "file beside the scene", "", "", "needed", "a closed surface of triangles"},
        {"mesh.length_unit", kLengthUnits, "", "", "needed", "unit of the file's coordinates"},
        {"name", "text", "", "", "the shape, numbered", "name of the obstacle"},
        {"at", "vector", "m", "", "0", "position; not of a plane"},
        {"turn", "rotation", "", "", "none", "orientation; not of a plane"},
        {"friction", "number", "", "≥ 0", "the contact's", "coefficient of friction of this obstacle"},
        {"motion.by", "vector", "m", "", "needed", "displacement under the whole load; in time with `in_time`"},
        {"motion.in_time", "time function", "", "", "needed in time", "factor of the displacement"},
        {"velocity", "vector", "m/s", "", "0", "steady velocity in time; not with `motion`"},
        {"spin", "vector", "1/s", "", "0", "steady rotation in time; not with `motion`"}}}};
}

}  // namespace elastin::lab
