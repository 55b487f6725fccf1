#pragma once
#include <functional>
#include <map>
#include <string>
#include <variant>

#include "elastin/core/geometry/pose.h"
#include "elastin/core/model/body.h"

namespace elastin::contact {

using elastin::Pose;

/// Shapes of obstacles, each in its own frame. All are solid: what is inside is pushed out.
namespace shape {
struct Plane {  ///< the half-space z < 0
  static constexpr const char* name = "plane";
};
struct Box {
  static constexpr const char* name = "box";
  Vector3 size = Vector3::Zero();  ///< full lengths of its sides [m], about the origin
};
struct Sphere {
  static constexpr const char* name = "sphere";
  double radius;  ///< [m], about the origin
};
struct Cylinder {
  static constexpr const char* name = "cylinder";
  double radius, length;  ///< [m], along z, about the origin; its rims are sharp
};
struct Capsule {
  static constexpr const char* name = "capsule";
  double radius, length;  ///< [m], of the cylinder between its two half spheres; along z, about the origin
};
struct Convex {
  static constexpr const char* name = "convex";
  Positions points;  ///< [m]; their hull is the obstacle
};
struct Mesh {
  static constexpr const char* name = "mesh";
  Positions points;    ///< [m]
  Cells<3> triangles;  ///< closed, normals outwards; see check_surface
};
}  // namespace shape
using ObstacleShape =
    std::variant<shape::Plane, shape::Box, shape::Sphere, shape::Cylinder, shape::Capsule, shape::Convex, shape::Mesh>;

/// A shape by name, for faces to other languages: plane; box (x, y, z); sphere (radius); cylinder and capsule (radius,
/// length); sizes [m], above 0. Throws InputError with the nearest name, and on sizes that are missing, too many or out
/// of range.
/// @param others names of shapes that the caller makes itself, which the message lists as well
ObstacleShape make_shape(const std::string& name, const std::map<std::string, double>& sizes,
                         const std::vector<std::string>& others = {});

/// A rigid thing that molecules cannot pass, fixed or moved as prescribed.
struct Obstacle {
  std::string name;
  ObstacleShape shape;
  Pose pose = {};  ///< where it stays, if it has no motion
  /// Its pose at a time [s]; of an experiment at rest, at a load factor. Empty: it stays.
  std::function<Pose(double time)> motion = {};
  double friction = -1;  ///< μ against it; below 0 = that of the contact
  Pose at(double time) const { return motion ? motion(time) : pose; }
};

}  // namespace elastin::contact
