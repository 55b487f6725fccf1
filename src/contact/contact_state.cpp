#include "contact/contact_force.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/geometry/triangle.h"

namespace elastin::contact {
namespace {

bool same(const ContactHistory& a, const ContactHistory& b) {
  return a.sample == b.sample && a.target == b.target && a.molecules == b.molecules && a.weights == b.weights &&
         a.offset == b.offset && a.multiplier == b.multiplier;
}

}  // namespace

Vector3 ContactForce::sample_position(const State& state, int sample) const {
  const Sample& s = search_.samples()[sample];
  return position_of(s.molecules, s.weights, s.count, state.positions);
}

void ContactForce::set_poses(double time) const {
  poses_.clear();
  for (const Obstacle& obstacle : options_.obstacles) poses_.push_back(pose_of(obstacle, time));
}

void ContactForce::anchor(const State& state, const ContactPoint& contact_point, const Vector3& at,
                          ContactHistory& memory) const {
  memory.count = std::min(contact_point.count, 3);
  if (memory.count == 0) {
    memory.offset = poses_[contact_point.target].to_own(at);
    return;
  }
  // Of a quadrilateral the three corners that are nearest to the position.
  const int left_out =
      contact_point.count < 4
          ? 3
          : static_cast<int>(std::min_element(contact_point.weights.begin(), contact_point.weights.end()) -
                             contact_point.weights.begin());
  for (int k = 0, own = 0; k < contact_point.count; ++k)
    if (k != left_out) {
      memory.molecules[own] = contact_point.molecules[k];
      memory.weights[own++] = contact_point.weights[k];
    }
  if (contact_point.count == 4) {
    const auto corner = [&](int k) -> Vector3 { return state.positions.col(memory.molecules[k]); };
    memory.weights = nearest_point(contact_point.position, {corner(0), corner(1), corner(2)}).weights;
  }
  memory.offset = at - position_of(memory.molecules, memory.weights, memory.count, state.positions);
}

Vector3 ContactForce::slip_from(const State& state, const ContactPoint& contact_point,
                                const ContactHistory& memory) const {
  const Vector3 at =
      memory.count == 0
          ? poses_[contact_point.target].to_world(memory.offset)
          : Vector3(memory.offset + position_of(memory.molecules, memory.weights, memory.count, state.positions));
  return sample_position(state, contact_point.sample) - at;
}

const std::vector<ContactResponse>& ContactForce::responses(const State& state) const {
  if (!(cached_ && same_as_cached(state))) {
    evaluate(state, 0, false);
    if (found_.empty())
      cached_ = false;  // to find nothing again costs less than to compare
    else
      store(state);
  }
  return responses_;
}

bool ContactForce::same_as_cached(const State& state) const {
  if (moves_)  // a host may move an obstacle while the time stands still
    for (std::size_t i = 0; i < cached_poses_.size(); ++i)
      if (pose_of(options_.obstacles[i], state.time) != cached_poses_[i]) return false;
  const int count = static_cast<int>(watched_.size());
  for (int i = 0; i < count; ++i)
    if (state.positions.col(watched_[i]) != cached_positions_.col(i)) return false;
  if (resists())
    for (int i = 0; i < count; ++i)
      if (state.velocities.col(watched_[i]) != cached_velocities_.col(i)) return false;
  return std::equal(state.contact_history.begin(), state.contact_history.end(), cached_memory_.begin(),
                    cached_memory_.end(), same);
}

void ContactForce::store(const State& state) const {
  const auto count = static_cast<Eigen::Index>(watched_.size());
  cached_positions_.resize(3, count);
  cached_velocities_.resize(3, resists() ? count : 0);
  for (Eigen::Index i = 0; i < count; ++i) {
    cached_positions_.col(i) = state.positions.col(watched_[i]);
    if (resists()) cached_velocities_.col(i) = state.velocities.col(watched_[i]);
  }
  cached_poses_ = poses_;
  cached_memory_ = state.contact_history;
  cached_ = true;
}

void ContactForce::evaluate(const State& state, double reach, bool all) const {
  reach = std::max(reach, 1e-9 * mean_size_);  // what just touches counts
  set_pressures(state);
  for (const MoleculePressure& held : pressures_)  // what is held back beyond its penalty is released at a gap
    reach = std::max(reach, held.pressure / options_.stiffness);
  reach = std::max(reach, options_.adhesion_range);
  set_poses(state.time);
  search_.find(state.positions, poses_, reach, found_);
  responses_.clear();
  contact_points_.clear();
  multipliers_.clear();
  std::size_t known = 0;
  for (const ContactPoint& contact_point : found_) {
    const std::pair<int, int> key = key_of(contact_point);
    while (known < state.contact_history.size() && key_of(state.contact_history[known]) < key) ++known;
    const bool match = known < state.contact_history.size() && key_of(state.contact_history[known]) == key;
    const ContactHistory* memory = match ? &state.contact_history[known] : nullptr;
    const ContactSetting setting = setting_of(state, contact_point, memory);
    ContactResponse& response = responses_.emplace_back();
    set_response(contact_point, setting, response);
    if (!all && response.pressing == 0 && response.stiffness.isZero(0) && response.energy == 0) {
      responses_.pop_back();
      continue;
    }
    response.sample = contact_point.sample;
    response.target = contact_point.target;
    response.position = contact_point.position;
    set_sides(contact_point, memory, response);
    contact_points_.push_back(contact_point);
    multipliers_.push_back(setting.multiplier);
  }
}

double ContactForce::area_of(const ContactPoint& contact_point) const {
  const double area = search_.samples()[contact_point.sample].area;
  if (contact_point.count == 0) return area;
  return spheres_ ? std::min(area, area_[contact_point.molecules[0]]) : area / 2;
}

ContactSetting ContactForce::setting_of(const State& state, const ContactPoint& contact_point,
                                        const ContactHistory* memory) const {
  const Sample& sample = search_.samples()[contact_point.sample];
  ContactSetting setting;
  double inverse_mass = 0;
  const bool resisting = resists();  // else velocities may be anything: see feels_velocity
  for (int i = 0; i < sample.count; ++i) {
    inverse_mass += sample.weights[i] * sample.weights[i] / body_.mass[sample.molecules[i]];
    if (resisting) setting.velocity += sample.weights[i] * state.velocities.col(sample.molecules[i]);
  }
  if (contact_point.count == 0) {
    if (resisting) setting.velocity -= poses_[contact_point.target].velocity_at(contact_point.position);
  } else {
    for (int i = 0; i < contact_point.count; ++i) {
      inverse_mass += contact_point.weights[i] * contact_point.weights[i] / body_.mass[contact_point.molecules[i]];
      if (resisting) setting.velocity -= contact_point.weights[i] * state.velocities.col(contact_point.molecules[i]);
    }
  }
  setting.stiffness = raised_ * options_.stiffness * area_of(contact_point);
  setting.multiplier = multiplier_of(contact_point);
  if (contact_point.target < obstacle_count()) setting.adhesion = options_.adhesion * area_of(contact_point);
  setting.range = options_.adhesion_range;
  setting.mass = 1 / inverse_mass;
  setting.damping_ratio = damping_ratio_;
  setting.friction = friction_against(contact_point.target);
  setting.onset = 1e-3 * std::sqrt(sample.area);
  setting.anchored = memory != nullptr;
  if (memory) setting.slip = slip_from(state, contact_point, *memory);
  return setting;
}

void ContactForce::set_sides(const ContactPoint& contact_point, const ContactHistory* memory,
                             ContactResponse& response) const {
  const auto side_of = [&](int molecule) -> Side& {
    for (int i = 0; i < response.count; ++i)
      if (response.sides[i].molecule == molecule) return response.sides[i];
    response.sides[response.count].molecule = molecule;
    return response.sides[response.count++];
  };
  const Sample& sample = search_.samples()[contact_point.sample];
  for (int i = 0; i < sample.count; ++i) {
    Side& side = side_of(sample.molecules[i]);
    side.normal += sample.weights[i];
    side.tangential += sample.weights[i];
  }
  for (int i = 0; i < contact_point.count; ++i) {
    Side& side = side_of(contact_point.molecules[i]);
    side.normal -= contact_point.weights[i];
    side.slope += contact_point.slopes[i];
  }
  const auto pull = [&](const auto& anchor) {
    for (int i = 0; i < anchor.count; ++i) side_of(anchor.molecules[i]).tangential -= anchor.weights[i];
  };
  if (memory)
    pull(*memory);
  else
    pull(contact_point);
}

void ContactForce::commit_step(State& state) const {
  if (!has_friction_ && options_.penetration == 0) return;
  updates_ = {};
  evaluate(state, has_friction_ ? mean_size_ : 0, true);
  // Where it stuck is where it sticks again, unless it slid; what is near but not pressed sticks from here on.
  next_history_.clear();
  for (const ContactResponse& response : responses_) {
    ContactHistory memory{response.sample, response.target};
    const ContactPoint& contact_point = contact_points_[next_history_.size()];
    anchor(state, contact_point, sample_position(state, contact_point.sample) - response.slip, memory);
    next_history_.push_back(memory);
  }
  keep_pressures(state);
  state.contact_history = next_history_;
  cached_ = false;
}

}  // namespace elastin::contact
