#include "elastin/contact/contact_points.h"

#include <pybind11/eigen.h>

#include <map>

#include "core/base/named.h"
#include "elastin/core/base/error.h"
#include "python/bind.h"

namespace elastin::python {
namespace {

Pose pose_from(const Vector3& position, const std::optional<Matrix3>& turn) {
  Pose pose;
  pose.position = position;
  if (turn) pose.turn = *turn;
  return pose;
}

/// {'shape': 'sphere', 'radius': 3e-3, 'tool': tool}: what is neither where it is nor how rough is a size of the shape.
contact::Obstacle obstacle_from(const Simulation& simulation, const py::dict& given, std::size_t number,
                                const std::vector<std::string>& taken) {
  contact::Obstacle obstacle;
  std::map<std::string, double> sizes;
  Positions points;
  Cells<3> triangles;
  std::string shape;
  for (const auto& [key, value] : given) {
    const auto name = word_of(key, "a key of an obstacle");
    if (name == "shape")
      shape = word_of(value, name);
    else if (name == "name")
      obstacle.name = word_of(value, name);
    else if (name == "position")
      obstacle.pose.position = entry_of<Vector3>(value, name, "three numbers [m]");
    else if (name == "turn")
      obstacle.pose.turn = entry_of<Matrix3>(value, name, "a rotation, a 3 x 3 matrix");
    else if (name == "tool")
      obstacle.motion = simulation.tool_motion(entry_of<ToolId>(value, name, "a number that add_tool gave"));
    else if (name == "friction")
      obstacle.friction = number_of(value, name);
    else if (name == "points")
      points = positions_from(value, "points");
    else if (name == "triangles")
      triangles = entry_of<Cells<3>>(value, name, "(k, 3), numbers of points");
    else
      sizes[name] = entry_of<double>(value, "obstacles: " + name,
                                     "a number, for it counts as a size of the shape: other keys are shape, name, "
                                     "position, turn, tool, friction, points and triangles");
  }
  if (given.contains("tool") && (given.contains("position") || given.contains("turn")))
    throw InputError("obstacles: number " + std::to_string(number) +
                     " has a tool, which says where it is; leave out `position` and `turn`");
  if (shape.empty()) throw InputError("obstacles: number " + std::to_string(number) + " has no 'shape'");
  if ((obstacle.pose.turn.transpose() * obstacle.pose.turn - Matrix3::Identity()).norm() > 1e-9)
    throw InputError("obstacles: the turn of number " + std::to_string(number) + " is no rotation");
  if (obstacle.name.empty()) obstacle.name = shape + std::to_string(taken.size());
  if (std::find(taken.begin(), taken.end(), obstacle.name) != taken.end())
    throw InputError("obstacles: the name '" + obstacle.name + "' is taken by an obstacle before; give another `name`");
  const bool is_mesh = shape == contact::shape::Mesh::name, is_hull = shape == contact::shape::Convex::name;
  if (!is_mesh && !is_hull && points.cols() == 0) {
    obstacle.shape = contact::make_shape(shape, sizes, {contact::shape::Convex::name, contact::shape::Mesh::name});
    return obstacle;
  }
  const std::string key = "obstacles: '" + obstacle.name + "'";
  if (!is_mesh && !is_hull) throw InputError(key + ": points are of a convex or a mesh");
  if (!sizes.empty()) throw InputError(key + ": unknown key '" + sizes.begin()->first + "'");
  if (points.cols() < 4) throw InputError(key + ": a " + shape + " needs points, (n, 3) [m], 4 or more");
  if (is_mesh != !triangles.empty())
    throw InputError(key +
                     (is_mesh ? ": a mesh needs triangles, (k, 3)" : ": a convex has no triangles, but its hull"));
  for (const auto& corners : triangles)
    for (const int corner : corners)
      if (corner < 0 || corner >= points.cols())
        throw InputError(key + ": there is no point " + std::to_string(corner));
  if (is_mesh)
    obstacle.shape = contact::shape::Mesh{points, triangles};
  else
    obstacle.shape = contact::shape::Convex{points};
  return obstacle;
}

void add_contact_to(Moving& self, double stiffness, const std::vector<py::dict>& obstacles, double friction,
                    double restitution, double penetration, const std::string& surface, bool self_contact) {
  contact::ContactOptions options{.stiffness = stiffness,
                                  .friction = friction,
                                  .restitution = restitution,
                                  .penetration = penetration,
                                  .self = self_contact,
                                  .obstacles = {}};
  if (surface != "triangles" && surface != "spheres")
    throw InputError("surface: is '" + surface + "'; allowed: triangles, spheres");
  options.surface = surface == "triangles" ? contact::ContactSurface::triangles : contact::ContactSurface::spheres;
  // Of all contacts: forces go by them.
  std::vector<std::string> names =
      names_of(contact::forces_on_obstacles(self.simulation), [](const auto& known) { return known.first; });
  for (std::size_t number = 0; number < obstacles.size(); ++number) {
    options.obstacles.push_back(obstacle_from(self.simulation, obstacles[number], number, names));
    names.push_back(options.obstacles.back().name);
  }
  self.in_turn([&](Simulation& simulation) {
    simulation.add([options](Model& model) { model.add(contact::make_contact(model.body(), options)); });
  });
  self.record("add_contact", py::dict(py::arg("stiffness") = stiffness, py::arg("obstacles") = obstacles,
                                      py::arg("friction") = friction, py::arg("restitution") = restitution,
                                      py::arg("penetration") = penetration, py::arg("surface") = surface,
                                      py::arg("self_contact") = self_contact));
}

py::dict contact_points(Moving& self) {
  using Touched = std::pair<std::string, contact::PressedPoint>;  // the obstacle's name, "" = the body itself
  const auto all = self.in_turn([&](Simulation& simulation) {
    std::vector<Touched> found;
    for (const auto& load : simulation.model().loads())
      if (const auto* contact = dynamic_cast<const contact::Contact*>(load.get()))
        for (const contact::PressedPoint& point : contact::pressed_points(*contact, simulation.state()))
          found.emplace_back(point.obstacle < 0 ? "" : contact->obstacles()[point.obstacle].name, point);
    return found;
  });
  const auto count = static_cast<py::ssize_t>(all.size());
  py::array_t<double> positions({count, py::ssize_t{3}}), forces({count, py::ssize_t{3}});
  py::list obstacles;
  for (py::ssize_t i = 0; i < count; ++i) {
    Eigen::Map<Vector3>(positions.mutable_data(i, 0)) = all[i].second.position;
    Eigen::Map<Vector3>(forces.mutable_data(i, 0)) = all[i].second.force;
    obstacles.append(all[i].first);
  }
  return py::dict(py::arg("position") = positions, py::arg("force") = forces, py::arg("obstacle") = obstacles);
}

/// What `of` says of each obstacle, by its name.
template <class Of>
auto by_obstacle(Of of) {
  return [of](Moving& self) {
    py::dict named;
    for (const auto& [name, vector] : self.in_turn([&](Simulation& simulation) { return of(simulation); }))
      named[name.c_str()] = vector;
    return named;
  };
}

}  // namespace

void add_contact(MovingClass& simulation) {
  simulation
      .def(
          "add_tool",
          [](Moving& self, const Vector3& position, const std::optional<Matrix3>& turn) {
            const ToolId tool = self.in_turn([&](Simulation& s) { return s.add_tool(pose_from(position, turn)); });
            self.record("add_tool", py::dict(py::arg("position") = position, py::arg("turn") = turn));
            return tool;
          },
          py::arg("position"), py::arg("turn") = py::none(),
          "A rigid thing that one moves, an instrument: its position [m] and its rotation, a 3 x 3 matrix. Gives its "
          "number, which obstacles of add_contact take as their tool.")
      .def(
          "move_tool",
          [](Moving& self, ToolId tool, const Vector3& position, const std::optional<Matrix3>& turn) {
            self.in_turn([&](Simulation& s) { s.move_tool(tool, position, turn); });
          },
          py::arg("tool"), py::arg("position"), py::arg("turn") = py::none(),
          "Where a tool is to be at the end of the next step [m]: it goes there at constant speed, and stays. Without "
          "a turn it keeps its own.")
      .def(
          "add_contact", &add_contact_to, py::arg("stiffness"), py::arg("obstacles") = std::vector<py::dict>{},
          py::kw_only(), py::arg("friction") = 0., py::arg("restitution") = 1., py::arg("penetration") = 0.,
          py::arg("surface") = "triangles", py::arg("self_contact") = false,
          "Contact with obstacles and between pieces, at any time between steps. stiffness [Pa/m]: pressure over "
          "depth. "
          "Each obstacle is a dict: shape 'plane' (z < 0), 'box' (x, y, z), 'sphere' (radius), 'cylinder' or 'capsule' "
          "(radius, length), 'convex' (points, their hull) or 'mesh' (points, closed triangles) [m]; where it is: "
          "tool, or position and turn; friction and name if one likes. surface: "
          "'triangles', or 'spheres' of the molecules, which a cut leaves without a force.")
      .def("contact_forces", by_obstacle(&contact::forces_on_obstacles),
           "Force of the body on each obstacle by its name [N].")
      .def("contact_torques", by_obstacle(&contact::torques_on_obstacles),
           "Torque of the body on each obstacle by its name [N m], about where the obstacle, or its tool, is now.")
      .def("contact_points", &contact_points,
           "Where the body is pressed now: a dict of 'position' (k, 3) [m], 'force' on the body (k, 3) [N], and "
           "'obstacle', a list of names, '' where it touches itself.");
}

}  // namespace elastin::python
