#include "elastin/contact/contact.h"

#include <cctype>
#include <optional>

#include "contact/search.h"
#include "contact/surface_check.h"
#include "core/base/dense.h"
#include "core/base/named.h"
#include "elastin/mesh/mesh_file.h"
#include "lab/scene/parts.h"

namespace elastin::lab {
namespace {

/// Turns z to a direction.
Matrix3 turn_to(const Vector3& direction) { return rotation_between(Vector3::UnitZ(), direction); }

/// A shape and how it lies there, before the obstacle is displaced.
template <class Shape>
struct Placed : Shape {
  Vector3 point = Vector3::Zero(), axis = Vector3::UnitZ();
};

/// {by: [0, 0, -1 mm], in_time: {ramp: …}}
struct ObstacleMotion {
  Vector3 by = Vector3::Zero();
  std::optional<TimeFunction> in_time;
};

/// An obstacle before the scene is turned.
struct ObstacleSetup : contact::Obstacle {
  std::string kind;  ///< the shape's name
  std::optional<Vector3> at, velocity, spin;
  Matrix3 turn = Matrix3::Identity();
  std::optional<ObstacleMotion> motion;
};

Positions read_convex(const Reader& list) {
  const std::vector<Reader> items = list.items();
  Positions points(3, static_cast<Eigen::Index>(items.size()));
  for (std::size_t i = 0; i < items.size(); ++i)
    points.col(static_cast<Eigen::Index>(i)) = items[i].vector(dimension::length);
  const Positions centred = points.colwise() - Vector3(points.rowwise().mean());
  const VectorX spread = symmetric_eigenvalues3(Matrix3(centred * centred.transpose()));
  if (items.size() < 4 || !(spread[0] > 1e-12 * spread[2]))
    list.fail("a convex obstacle needs at least four points that do not lie in one plane");
  return points;
}

contact::shape::Mesh surface_of(const MeshFile& named) {
  const Reader& file = *named.file;
  const mesh::Mesh mesh = named.load();
  if (!mesh.tetrahedra.empty()) file.fail("an obstacle is a surface of triangles; this mesh has tetrahedra");
  const std::string fault = contact::check_surface(mesh.points, mesh.triangles);
  if (!fault.empty()) file.fail("the surface encloses no volume: " + fault);
  return {mesh.points, mesh.triangles};
}

template <class Shape>
Key<ObstacleSetup> shape_key(const Keys<Placed<Shape>>& keys) {
  return key::map_into<ObstacleSetup>(Shape::name, keys,
                                      [](const Reader&, ObstacleSetup& setup, const Placed<Shape>& placed) {
                                        setup.kind = Shape::name;
                                        setup.shape = static_cast<const Shape&>(placed);
                                        if (placed.axis != Vector3::UnitZ()) setup.pose.turn = turn_to(placed.axis);
                                        setup.pose.position = placed.point;
                                      });
}

template <class Round>
Key<ObstacleSetup> round_key(const std::string& length) {
  return shape_key<Round>({key::quantity("radius", &Round::radius, dimension::length,
                                         std::string("radius of the ") + Round::name, kPositive)
                               .needed(),
                           key::quantity("length", &Round::length, dimension::length, length, kPositive).needed(),
                           key::direction("axis", &Placed<Round>::axis, "axis of the shape")});
}

std::vector<Key<ObstacleSetup>> shape_keys() {
  using namespace contact::shape;
  return {
      shape_key<Plane>({key::vector("point", &Placed<Plane>::point, dimension::length, "a point of the plane").needed(),
                        key::direction("normal", &Placed<Plane>::axis, "normal towards the free side").needed()}),
      shape_key<Box>({key::vector("size", &Box::size, dimension::length, "sides of the box about its middle", kPositive)
                          .needed()}),
      shape_key<Sphere>(
          {key::quantity("radius", &Sphere::radius, dimension::length, "radius of the sphere", kPositive).needed()}),
      round_key<Cylinder>("length of the cylinder about its middle"),
      round_key<Capsule>("length of its straight part"),
      shape_key<Convex>({Key<Convex>({"points", "list of vectors", "m", "", "none",
                                      "four points or more that do not lie in one plane"},
                                     [](const Reader& value, Convex& convex) { convex.points = read_convex(value); })
                             .needed()}),
      key::map_into<ObstacleSetup>(Mesh::name,
                                   Keys<MeshFile>{mesh_file_key("a closed surface of triangles"), length_unit_key()},
                                   [](const Reader&, ObstacleSetup& setup, const MeshFile& file) {
                                     setup.kind = Mesh::name;
                                     setup.shape = surface_of(file);
                                   })};
}

const Keys<ObstacleSetup>& obstacle_keys() {
  using S = ObstacleSetup;
  const auto of_plane = [](bool given, const S& setup, const char* fault) {
    return given && setup.kind == contact::shape::Plane::name ? fault : "";
  };
  const auto after_motion = [](bool given, const S& setup) {
    return given && setup.motion ? "there is a motion already; give one of them" : "";
  };
  std::vector<Key<S>> shapes = shape_keys();
  static const Keys<S> keys{
      KeyGroup<S>{shapes,
                  "an obstacle is one of " + joined(shapes, &Key<S>::name) + "; write each as an item of its own"},
      key::text("name", &S::name, "name of the obstacle").otherwise("the shape, numbered"),
      key::vector("at", &S::at, dimension::length, "position; not of a plane")
          .otherwise("0")
          .refused_for([=](const S& setup) {
            return of_plane(setup.at.has_value(), setup, "a plane lies through its own point: leave this out");
          }),
      key::rotation("turn", &S::turn, "orientation; not of a plane").refused_for([=](const S& setup) {
        return of_plane(setup.turn != Matrix3::Identity(), setup, "a plane has a normal: leave this out");
      }),
      key::quantity("friction", &S::friction, dimension::none, "coefficient of friction of this obstacle", kNotNegative)
          .otherwise("the contact's"),
      key::map("motion", &ObstacleSetup::motion,
               Keys<ObstacleMotion>{key::vector("by", &ObstacleMotion::by, dimension::length,
                                                "displacement under the whole load; in time with `in_time`")
                                        .needed(),
                                    time_function_key("in_time", &ObstacleMotion::in_time, "factor of the displacement")
                                        .otherwise("needed in time")}),
      key::vector("velocity", &S::velocity, dimension::velocity, "steady velocity in time; not with `motion`")
          .otherwise("0")
          .refused_for([=](const S& setup) { return after_motion(setup.velocity.has_value(), setup); }),
      key::vector("spin", &S::spin, {0, 0, -1}, "steady rotation in time; not with `motion`")
          .otherwise("0")
          .refused_for([=](const S& setup) { return after_motion(setup.spin.has_value(), setup); })};
  return keys;
}

/// `along` is the displacement under the whole load.
std::function<contact::Pose(double)> motion_by(const contact::Pose& pose, const Vector3& along,
                                               const std::optional<TimeFunction>& in_time) {
  return [=](double now) {
    contact::Pose moved = pose;
    moved.position += (in_time ? in_time->value(now) : now) * along;
    if (in_time) moved.velocity = in_time->rate(now) * along;
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

void read_obstacle(Reader reader, const Matrix3& rotation, SceneContact& contact) {
  ObstacleSetup setup = obstacle_keys().read(reader);
  const auto is_named = [&](const std::string& name) {
    return std::any_of(contact.obstacles.begin(), contact.obstacles.end(),
                       [&](const contact::Obstacle& other) { return other.name == name; });
  };
  contact::Obstacle& obstacle = setup;
  if (const auto name = reader.find("name"); name && is_named(obstacle.name))
    name->fail("'" + obstacle.name + "' is the name of another obstacle");
  else if (!name)
    obstacle.name = setup.kind;
  for (int number = 2; is_named(obstacle.name); ++number) obstacle.name = setup.kind + " " + std::to_string(number);
  obstacle.pose.turn = rotation * (setup.turn * obstacle.pose.turn);
  obstacle.pose.position = rotation * setup.at.value_or(obstacle.pose.position);
  if (setup.motion) {
    obstacle.motion = motion_by(obstacle.pose, rotation * setup.motion->by, setup.motion->in_time);
    (setup.motion->in_time ? contact.by_time : contact.by_load).push_back(reader.at("motion"));
  }
  if (setup.velocity || setup.spin) {
    const Vector3 still = Vector3::Zero();
    obstacle.motion =
        steady_motion(obstacle.pose, rotation * setup.velocity.value_or(still), rotation * setup.spin.value_or(still));
    contact.by_time.push_back(reader.at(setup.velocity ? "velocity" : "spin"));
  }
  contact.obstacles.push_back(std::move(obstacle));
}

/// A plain number is times E over a molecule's diameter; with a unit, pressure over depth.
void set_stiffness(const Reader& reader, SceneContact& contact) {
  const std::string given = reader.text();
  const bool plain =
      std::none_of(given.begin(), given.end(), [](unsigned char c) { return std::isalpha(c) && c != 'e' && c != 'E'; });
  if (plain)
    contact.stiffness *= reader.quantity(dimension::none, kPositive) / 10;  // of the default, ten
  else
    contact.stiffness = reader.quantity({-2, 1, -2}, kPositive);
}

const Keys<SceneContact>& all_contact_keys() {
  using S = SceneContact;
  using contact::ContactSurface;
  static const Keys<S> keys{
      key::choice("surface", &S::surface,
                  {{"triangles", ContactSurface::triangles}, {"spheres", ContactSurface::spheres}},
                  "what meets others: the surface of the cells, or the molecules")
          .otherwise("`triangles` where every body has cells, else `spheres`"),
      Key<S>(
          {"stiffness", "number, or quantity", "Pa/m", "> 0", "10", "a number is times E over a molecule's diameter"},
          [](const Reader& value, S& contact) { set_stiffness(value, contact); }),
      key::quantity("friction", &S::friction, dimension::none,
                    "coefficient of Coulomb friction; sticking contact does not creep; between molecules as spheres it "
                    "keeps no angular momentum",
                    kNotNegative),
      key::quantity("restitution", &S::restitution, dimension::none,
                    "coefficient of restitution of two molecules that meet alone", {0.01, 1, false}),
      key::quantity("penetration", &S::penetration, dimension::length,
                    "largest depth, in the mean about a molecule, by multipliers; at rest and with each implicit "
                    "stepper; explicit ones are refused",
                    kPositive)
          .otherwise("what the penalty leaves"),
      key::quantity("adhesion", &S::adhesion, dimension::stiffness,
                    "work of adhesion (J/m^2) of the surface to obstacles; with `adhesion_range`", kPositive)
          .otherwise("none"),
      key::quantity(
          "adhesion_range", &S::adhesion_range, dimension::length,
          "gap at which the traction ends that pulls the surface on; small against the contact's radius it is "
          "Johnson, Kendall and Roberts' adhesion, and the surface must resolve the rim",
          kPositive)
          .needed_if([](const contact::ContactOptions& contact) { return contact.adhesion > 0; },
                     "needed, with `adhesion`")
          .refused_for([](const contact::ContactOptions& contact) -> std::string {
            return contact.adhesion_range > 0 && !(contact.adhesion > 0) ? "needs `adhesion` too" : "";
          }),
      key::flag("self", &S::self, "whether contact of a piece with itself counts"),
      Key<S>({"obstacles", "list of maps", "", "", "none", "rigid bodies, each with one shape"},
             [](const Reader& value, S& contact, const Frame& frame) {
               for (const Reader& item : value.items()) read_obstacle(item, frame.rotation, contact);
             })};
  return keys;
}

}  // namespace

SceneContact read_contact(const Reader& reader, const Body& body, const Material& material, const Matrix3& rotation,
                          Findings& findings) {
  SceneContact contact;
  const bool cells = !body.tetrahedra.empty() || !body.triangles.empty();
  const auto without = cells ? contact::parts_without(contact::surface_sides(body), body) : std::vector<std::string>();
  const std::string named = without.empty() ? "" : "body '" + without.front() + "' has no cells, and so no surface";
  contact.surface = cells && named.empty() ? contact::ContactSurface::triangles : contact::ContactSurface::spheres;
  Reader asked = reader;
  const bool chosen = asked.has("surface");
  if (!named.empty() && !chosen)
    findings.notes.push_back(named + ": contact is between the molecules of all bodies as spheres");
  if (!named.empty() && chosen && asked.at("surface").text() == "triangles")
    findings.warnings.push_back(named + ": with `contact.surface: triangles` it touches nothing");
  contact.stiffness = contact::default_contact_stiffness(body, material.youngs_modulus);
  return all_contact_keys().read(reader, {rotation, &body}, std::move(contact));
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
  return {{"contact", "Contact", "", all_contact_keys().rows()},
          {"contact.obstacles", "",
           "Each item of `obstacles` has one shape, and the keys after the shapes:", obstacle_keys().rows()}};
}

}  // namespace elastin::lab
