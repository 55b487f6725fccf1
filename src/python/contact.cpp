#include "elastin/contact/contact.h"

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
    else
      sizes[name] = number_of(value, name);
  }
  if (shape.empty()) throw InputError("obstacles: number " + std::to_string(number) + " has no 'shape'");
  if ((obstacle.pose.turn.transpose() * obstacle.pose.turn - Matrix3::Identity()).norm() > 1e-9)
    throw InputError("obstacles: the turn of number " + std::to_string(number) + " is no rotation");
  if (obstacle.name.empty()) obstacle.name = shape + std::to_string(taken.size());
  if (std::find(taken.begin(), taken.end(), obstacle.name) != taken.end())
    throw InputError("obstacles: the name '" + obstacle.name + "' is taken by an obstacle before; give another `name`");
  obstacle.shape = contact::make_shape(shape, sizes);
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

py::dict contact_forces(Moving& self) {
  std::vector<std::pair<std::string, Vector3>> forces;
  self.in_turn([&](Simulation& simulation) { forces = contact::forces_on_obstacles(simulation); });
  py::dict named;
  for (const auto& [name, force] : forces) named[name.c_str()] = force;
  return named;
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
          "(radius, length) [m]; where it is: tool, or position and turn; friction and name if one likes. surface: "
          "'triangles', or 'spheres' of the molecules, which push the parts of a cut apart.")
      .def("contact_forces", &contact_forces, "Force of the body on each obstacle by its name [N].");
}

}  // namespace elastin::python
