#include "contact/contact_force.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace elastin::contact {
namespace {

/// Whether a touch is held by less friction than slides: one that slid is kept on the cone, to rounding.
bool sticks(const ContactResponse& response, double coefficient) {
  return response.friction.norm() < (1 - 1e-6) * coefficient * response.pressing;
}

}  // namespace

ContactReport ContactForce::report(const State& state) const {
  ContactReport report;
  report.forces = Positions::Zero(3, body_.size());
  report.on_obstacles.assign(options_.obstacles.size(), Vector3::Zero());
  VectorX pressing = VectorX::Zero(body_.size()), touched = pressing;  // [N], and the area that is pressed [m²]
  std::map<std::pair<int, int>, Vector3> on_lower;                     // of two pieces
  const std::vector<Sample>& samples = search_.samples();
  for (const ContactResponse& response : responses(state)) {
    if (response.pressing == 0) continue;
    const Sample& sample = samples[response.sample];
    const Vector3 force = response.pressing * response.normal + response.friction;
    if (response.pressing < 0) {  // adhesion, to an obstacle
      for (int i = 0; i < sample.count; ++i) report.forces.col(sample.molecules[i]) += sample.weights[i] * force;
      report.on_obstacles[response.target] -= force;
      continue;
    }
    ++report.pairs;
    report.sticking += sticks(response, friction_against(response.target));
    report.largest_penetration = std::max(report.largest_penetration, -response.gap);
    // Bodies touch each other from both sides: their area is counted once.
    report.area += response.target < obstacle_count() || spheres_ ? sample.area : sample.area / 2;
    for (int i = 0; i < sample.count; ++i) touched[sample.molecules[i]] += sample.weights[i] * sample.area;
    for (int i = 0; i < response.count; ++i) {
      const Side& side = response.sides[i];
      if (spheres_ && side.normal < 0) touched[side.molecule] += area_[side.molecule];
      report.forces.col(side.molecule) +=
          side.normal * response.pressing * response.normal + side.tangential * response.friction;
      pressing[side.molecule] += std::abs(side.normal) * response.pressing;
    }
    if (response.target < obstacle_count())
      report.on_obstacles[response.target] -= force;
    else if (const int other = piece_of_target(response); other != sample.piece)
      on_lower.try_emplace(std::minmax(sample.piece, other), Vector3::Zero()).first->second +=
          sample.piece < other ? force : Vector3(-force);
  }
  for (const auto& [pieces, force] : on_lower)
    if (force.norm() > report.between_pieces.norm()) report.between_pieces = force;
  report.pressure = VectorX::Zero(body_.size());
  // What is pressed from the other side alone, next to a rim, has its whole surface for that.
  for (const int molecule : watched_)
    if (pressing[molecule] > 0)
      report.pressure[molecule] = pressing[molecule] / (touched[molecule] > 0 ? touched[molecule] : area_[molecule]);
  report.largest_pressure = report.pressure.size() ? report.pressure.maxCoeff() : 0;
  report.broad_seconds = search_.cost().broad_seconds;
  report.narrow_seconds = search_.cost().narrow_seconds;
  return report;
}

std::vector<PressedPoint> ContactForce::pressed(const State& state) const {
  std::vector<PressedPoint> points;
  for (const ContactResponse& response : responses(state)) {
    if (!(response.pressing > 0)) continue;
    const Sample& sample = search_.samples()[response.sample];
    Vector3 position = Vector3::Zero();
    for (int i = 0; i < sample.count; ++i) position += sample.weights[i] * state.positions.col(sample.molecules[i]);
    points.push_back({position, response.pressing * response.normal + response.friction,
                      response.target < obstacle_count() ? response.target : -1});
  }
  return points;
}

std::vector<PressedPoint> pressed_points(const Contact& contact, const State& state) {
  return dynamic_cast<const ContactForce&>(contact).pressed(state);
}

std::vector<std::pair<std::string, Vector3>> forces_on_obstacles(const Simulation& simulation) {
  std::vector<std::pair<std::string, Vector3>> forces;
  for (const auto& load : simulation.model().loads())
    if (const auto* contact = dynamic_cast<const Contact*>(load.get())) {
      const std::vector<Vector3> on = contact->report(simulation.state()).on_obstacles;
      for (std::size_t i = 0; i < on.size(); ++i) forces.emplace_back(contact->obstacles()[i].name, on[i]);
    }
  return forces;
}

std::vector<std::pair<std::string, Vector3>> torques_on_obstacles(const Simulation& simulation) {
  std::vector<std::pair<std::string, Vector3>> torques;
  for (const auto& load : simulation.model().loads())
    if (const auto* contact = dynamic_cast<const Contact*>(load.get())) {
      const std::size_t first = torques.size();
      for (const Obstacle& obstacle : contact->obstacles()) torques.emplace_back(obstacle.name, Vector3::Zero());
      const std::vector<Pose> poses = contact->poses(simulation.time());
      for (const PressedPoint& point : pressed_points(*contact, simulation.state()))
        if (point.obstacle >= 0)
          torques[first + point.obstacle].second -=
              Vector3(point.position - poses[point.obstacle].position).cross(point.force);
    }
  return torques;
}

}  // namespace elastin::contact
