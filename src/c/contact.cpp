#include <map>

#include "c/handles.h"
#ifdef ELASTIN_C_CONTACT
#include "elastin/contact/contact.h"
#endif

namespace elastin::c {
namespace {

Pose pose_of(const double position[3], const double turn[9]) {
  Pose pose;
  pose.position = position_of(position, "position");
  if (turn) pose.turn = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(turn);
  return pose;
}

#ifdef ELASTIN_C_CONTACT

contact::Obstacle obstacle_of(const elastin_simulation& handle, const elastin_obstacle* obstacles, std::size_t number) {
  const elastin_obstacle from = checked_element(obstacles, number, "elastin_obstacle");
  std::map<std::string, double> sizes;
  if (from.size_count > 0) given(from.sizes, "elastin_obstacle.sizes");
  for (std::size_t i = 0; i < from.size_count; ++i) {
    const std::string key = &given(from.sizes[i].name, "a size's name");
    if (!sizes.emplace(key, from.sizes[i].value).second) refuse_twice("sizes", key);
  }
  contact::Obstacle obstacle{"obstacle" + std::to_string(number),
                             contact::make_shape(&given(from.shape, "elastin_obstacle.shape"), sizes)};
  bool turned = false;
  for (const double entry : from.turn) turned = turned || entry != 0;
  obstacle.pose = pose_of(from.position, turned ? from.turn : nullptr);
  if ((obstacle.pose.turn.transpose() * obstacle.pose.turn - Matrix3::Identity()).norm() > 1e-9)
    throw InputError("elastin_obstacle.turn is no rotation");
  if (from.tool) obstacle.motion = handle.simulation.tool_motion(from.tool);
  return obstacle;
}

contact::ContactOptions contact_options(const elastin_simulation& handle, const elastin_contact* given_one) {
  const elastin_contact from = checked_copy(given_one, "elastin_contact");
  contact::ContactOptions options;
  options.surface = from.spheres ? contact::ContactSurface::spheres : contact::ContactSurface::triangles;
  options.stiffness = from.stiffness;
  if (from.stiffness == 0) {
    if (!(handle.youngs_modulus > 0))
      throw InputError("elastin_contact.stiffness: must be given where the material's modulus is not known");
    options.stiffness = contact::default_contact_stiffness(handle.simulation.body(), handle.youngs_modulus);
  }
  options.friction = from.friction;
  if (from.restitution != 0) options.restitution = from.restitution;
  options.penetration = from.penetration;
  options.self = from.self != 0;
  if (from.obstacle_count > 0) given(from.obstacles, "elastin_contact.obstacles");
  for (std::size_t i = 0; i < from.obstacle_count; ++i)
    options.obstacles.push_back(obstacle_of(handle, from.obstacles, i));
  return options;
}

void put_of_obstacle(const std::vector<std::pair<std::string, Vector3>>& all, std::size_t obstacle, double numbers[3],
                     const char* name) {
  if (obstacle >= all.size())
    throw InputError("obstacle " + std::to_string(obstacle) + ": there are " + std::to_string(all.size()) + ", from 0");
  Eigen::Map<Vector3>(&given(numbers, name)) = all[obstacle].second;
}

#endif

}  // namespace
}  // namespace elastin::c

using elastin::c::given;
using elastin::c::guarded;

extern "C" {

elastin_status elastin_add_tool(elastin_simulation* simulation, const double position[3], const double turn[9],
                                int* tool) {
  return guarded([&] {
    elastin_simulation& handle = given(simulation, "simulation");
    given(tool, "tool") = handle.simulation.add_tool(elastin::c::pose_of(position, turn));
  });
}

elastin_status elastin_move_tool(elastin_simulation* simulation, int tool, const double position[3],
                                 const double turn[9]) {
  return guarded([&] {
    const elastin::Pose pose = elastin::c::pose_of(position, turn);
    given(simulation, "simulation")
        .simulation.move_tool(tool, pose.position, turn ? std::optional(pose.turn) : std::nullopt);
  });
}

#ifdef ELASTIN_C_CONTACT

elastin_status elastin_add_contact(elastin_simulation* simulation, const elastin_contact* contact) {
  return guarded([&] {
    elastin_simulation& handle = given(simulation, "simulation");
    handle.simulation.add([options = elastin::c::contact_options(handle, contact)](elastin::Model& model) {
      model.add(elastin::contact::make_contact(model.body(), options));
    });
  });
}

elastin_status elastin_contact_force(const elastin_simulation* simulation, size_t obstacle, double force[3]) {
  return guarded([&] {
    elastin::c::put_of_obstacle(elastin::contact::forces_on_obstacles(given(simulation, "simulation").simulation),
                                obstacle, force, "force");
  });
}

elastin_status elastin_contact_torque(const elastin_simulation* simulation, size_t obstacle, double torque[3]) {
  return guarded([&] {
    elastin::c::put_of_obstacle(elastin::contact::torques_on_obstacles(given(simulation, "simulation").simulation),
                                obstacle, torque, "torque");
  });
}

#else

namespace {
elastin_status no_contact() {
  return elastin::c::failed(ELASTIN_MISSING, "this library was built without contact (ELASTIN_CONTACT)");
}
}  // namespace

elastin_status elastin_add_contact(elastin_simulation*, const elastin_contact*) { return no_contact(); }
elastin_status elastin_contact_force(const elastin_simulation*, size_t, double[3]) { return no_contact(); }
elastin_status elastin_contact_torque(const elastin_simulation*, size_t, double[3]) { return no_contact(); }

#endif
}
