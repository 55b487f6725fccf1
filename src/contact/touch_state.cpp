#include "contact/contact_force.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace elastin::contact {
namespace {

bool before(const TouchMemory& memory, const Touch& touch) {
  return std::pair{memory.sample, memory.target} < std::pair{touch.sample, touch.target};
}

bool before_touch(const Touch& touch, const TouchMemory& memory) {
  return std::pair{touch.sample, touch.target} < std::pair{memory.sample, memory.target};
}

bool same(const TouchMemory& a, const TouchMemory& b) {
  return a.sample == b.sample && a.target == b.target && a.molecules == b.molecules && a.weights == b.weights &&
         a.offset == b.offset && a.multiplier == b.multiplier;
}

}  // namespace

Vector3 ContactForce::sample_place(const State& state, int sample) const {
  const Sample& s = search_.samples()[sample];
  return place_of(s.molecules, s.weights, s.count, state.positions);
}

void ContactForce::set_poses(double time) const {
  poses_.clear();
  for (const Obstacle& obstacle : options_.obstacles) poses_.push_back(obstacle.at(moment_.value_or(time)));
}

void ContactForce::anchor(const State& state, const Touch& touch, const Vector3& at, TouchMemory& memory) const {
  memory.molecules = touch.molecules;
  memory.weights = touch.weights;
  memory.count = touch.count;
  memory.offset = touch.count == 0
                      ? poses_[touch.target].to_own(at)
                      : Vector3(at - place_of(touch.molecules, touch.weights, touch.count, state.positions));
}

Vector3 ContactForce::slip_from(const State& state, const Touch& touch, const TouchMemory& memory) const {
  const Vector3 at =
      memory.count == 0
          ? poses_[touch.target].to_world(memory.offset)
          : Vector3(memory.offset + place_of(memory.molecules, memory.weights, memory.count, state.positions));
  return sample_place(state, touch.sample) - at;
}

const std::vector<Answer>& ContactForce::answers(const State& state) const {
  if (!(cached_ && same_as_cached(state))) {
    evaluate(state, 0, false);
    if (found_.empty())
      cached_ = false;  // to find nothing again costs less than to compare
    else
      keep(state);
  }
  return answers_;
}

bool ContactForce::same_as_cached(const State& state) const {
  if (moves_ && state.time != cached_time_) return false;
  const int count = static_cast<int>(watched_.size());
  for (int i = 0; i < count; ++i)
    if (state.positions.col(watched_[i]) != cached_positions_.col(i)) return false;
  if (resists())
    for (int i = 0; i < count; ++i)
      if (state.velocities.col(watched_[i]) != cached_velocities_.col(i)) return false;
  return std::equal(state.touches.begin(), state.touches.end(), cached_memory_.begin(), cached_memory_.end(), same);
}

void ContactForce::keep(const State& state) const {
  const auto count = static_cast<Eigen::Index>(watched_.size());
  cached_positions_.resize(3, count);
  cached_velocities_.resize(3, resists() ? count : 0);
  for (Eigen::Index i = 0; i < count; ++i) {
    cached_positions_.col(i) = state.positions.col(watched_[static_cast<std::size_t>(i)]);
    if (resists()) cached_velocities_.col(i) = state.velocities.col(watched_[static_cast<std::size_t>(i)]);
  }
  cached_time_ = state.time;
  cached_memory_ = state.touches;
  cached_ = true;
}

void ContactForce::evaluate(const State& state, double reach, bool all) const {
  reach = std::max(reach, 1e-9 * mean_size_);      // what just touches counts
  for (const TouchMemory& memory : state.touches)  // what was held back beyond its penalty lets go at a gap
    if (memory.multiplier > 0)
      reach = std::max(reach, memory.multiplier / (options_.stiffness * search_.samples()[memory.sample].area / 2));
  set_poses(state.time);
  search_.find(state.positions, poses_, reach, found_);
  answers_.clear();
  touches_.clear();
  multipliers_.clear();
  std::size_t known = 0;
  for (const Touch& touch : found_) {
    while (known < state.touches.size() && before(state.touches[known], touch)) ++known;
    const bool match = known < state.touches.size() && !before_touch(touch, state.touches[known]);
    const TouchMemory* memory = match ? &state.touches[known] : nullptr;
    const TouchSetting setting = setting_of(state, touch, memory);
    Answer& answer = answers_.emplace_back();
    set_answer(touch, setting, answer);
    if (!all && answer.pressing == 0 && answer.stiffness.isZero(0) && answer.energy == 0) {
      answers_.pop_back();
      continue;
    }
    answer.sample = touch.sample;
    answer.target = touch.target;
    answer.place = touch.place;
    set_sides(touch, memory, answer);
    touches_.push_back(touch);
    multipliers_.push_back(setting.multiplier);
  }
}

TouchSetting ContactForce::setting_of(const State& state, const Touch& touch, const TouchMemory* memory) const {
  const Sample& sample = search_.samples()[touch.sample];
  TouchSetting setting;
  double area = sample.area, inverse_mass = 0;
  const bool resisting = resists();  // else velocities may be anything: see feels_velocity
  for (int i = 0; i < sample.count; ++i) {
    inverse_mass += sample.weights[i] * sample.weights[i] / body_.mass[sample.molecules[i]];
    if (resisting) setting.velocity += sample.weights[i] * state.velocities.col(sample.molecules[i]);
  }
  if (touch.count == 0) {
    if (resisting) setting.velocity -= poses_[touch.target].velocity_at(touch.place);
  } else {
    for (int i = 0; i < touch.count; ++i) {
      inverse_mass += touch.weights[i] * touch.weights[i] / body_.mass[touch.molecules[i]];
      if (resisting) setting.velocity -= touch.weights[i] * state.velocities.col(touch.molecules[i]);
    }
    // Of spheres the smaller counts; triangles press on each other from both sides, each with half.
    area = spheres_ ? std::min(area, area_[touch.molecules[0]]) : area / 2;
  }
  setting.stiffness = options_.stiffness * area;
  setting.mass = 1 / inverse_mass;
  setting.damping_ratio = damping_ratio_;
  setting.friction = touch.count == 0 ? friction_of(options_.obstacles[touch.target]) : options_.friction;
  setting.onset = 1e-3 * std::sqrt(sample.area);
  if (memory) {
    setting.multiplier = memory->multiplier;
    setting.slip = slip_from(state, touch, *memory);
  }
  return setting;
}

void ContactForce::set_sides(const Touch& touch, const TouchMemory* memory, Answer& answer) const {
  const auto side_of = [&](int molecule) -> Side& {
    for (int i = 0; i < answer.count; ++i)
      if (answer.sides[i].molecule == molecule) return answer.sides[i];
    answer.sides[answer.count].molecule = molecule;
    return answer.sides[answer.count++];
  };
  const Sample& sample = search_.samples()[touch.sample];
  for (int i = 0; i < sample.count; ++i) {
    Side& side = side_of(sample.molecules[i]);
    side.normal += sample.weights[i];
    side.tangential += sample.weights[i];
  }
  for (int i = 0; i < touch.count; ++i) {
    Side& side = side_of(touch.molecules[i]);
    side.normal -= touch.weights[i];
    side.slope += touch.slopes[i];
  }
  const auto& anchors = memory ? memory->molecules : touch.molecules;
  const auto& weights = memory ? memory->weights : touch.weights;
  const int count = memory ? memory->count : touch.count;
  for (int i = 0; i < count; ++i) side_of(anchors[i]).tangential -= weights[i];
}

void ContactForce::remember(State& state) const {
  if (!rubs_ && options_.penetration == 0) return;
  evaluate(state, rubs_ ? mean_size_ : 0, true);
  // Where it stuck is where it sticks again, unless it slid; what is near but not pressed sticks from here on.
  remembered_.clear();
  for (const Answer& answer : answers_) {
    TouchMemory memory{answer.sample, answer.target};
    const Touch& touch = touches_[remembered_.size()];
    memory.multiplier = answer.elastic > 0 ? multipliers_[remembered_.size()] : 0;
    anchor(state, touch, sample_place(state, touch.sample) - answer.slip, memory);
    remembered_.push_back(memory);
  }
  state.touches = remembered_;
  cached_ = false;
}

bool ContactForce::tighten(State& state) const {
  if (options_.penetration == 0) return false;
  double deepest = 0;
  for (const Answer& answer : answers(state)) deepest = std::max(deepest, -answer.gap);
  if (deepest <= options_.penetration) return false;
  set_poses(state.time);
  remembered_.clear();
  std::size_t known = 0;
  for (std::size_t i = 0; i < answers_.size(); ++i) {
    const Touch& touch = touches_[i];
    while (known < state.touches.size() && before(state.touches[known], touch))
      remembered_.push_back(state.touches[known++]);
    if (known < state.touches.size() && !before_touch(touch, state.touches[known])) {
      remembered_.push_back(state.touches[known++]);
    } else {
      remembered_.push_back({touch.sample, touch.target});
      anchor(state, touch, sample_place(state, touch.sample), remembered_.back());
    }
    remembered_.back().multiplier = answers_[i].elastic;
  }
  remembered_.insert(remembered_.end(), state.touches.begin() + static_cast<std::ptrdiff_t>(known),
                     state.touches.end());
  state.touches = remembered_;
  return true;
}

}  // namespace elastin::contact
