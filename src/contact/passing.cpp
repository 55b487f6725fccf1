#include "contact/contact_force.h"

#include <algorithm>
#include <cmath>

#include "core/parallel/parallel.h"

namespace elastin::contact {

/// The longest way of a molecule [m]; no sample goes farther.
double ContactForce::farthest(const Positions& from, const Positions& to) const {
  return std::sqrt(largest_of_ranges(static_cast<int>(watched_.size()), [&](int begin, int end) {
    double most = 0;
    for (int i = begin; i < end; ++i)
      most = std::max(most, (to.col(watched_[i]) - from.col(watched_[i])).squaredNorm());
    return most;
  }));
}

/// The longest way of an obstacle's material at any of the places [m].
double ContactForce::obstacle_way(const Positions& places, const std::vector<Pose>& from,
                                  const std::vector<Pose>& to) const {
  double longest = 0;
  for (std::size_t o = 0; o < from.size(); ++o) {
    double way = (to[o].place - from[o].place).norm();
    if (const double turned = (to[o].turn - from[o].turn).norm(); turned > 0)
      way += turned * std::sqrt(largest_of_ranges(static_cast<int>(watched_.size()), [&](int begin, int end) {
               double most = 0;
               for (int i = begin; i < end; ++i)
                 most = std::max(most, (places.col(watched_[i]) - from[o].place).squaredNorm());
               return most;
             }));
    longest = std::max(longest, way);
  }
  return longest;
}

double ContactForce::free_way(const State& from, const State& to) const {
  const std::vector<Sample>& samples = search_.samples();
  set_poses(from.time);
  begin_ = poses_;
  set_poses(to.time);
  // No sample gets deeper in one go than half its own size, or half the obstacle, where the way out is still the way
  // in.
  const auto depth_into = [&](const Touch& touch) {
    const double own = mean_size_ / 2;
    return touch.count > 0 ? own : std::min(own, samples[touch.sample].radius + half_thickness_[touch.target] / 2);
  };
  const double reach = obstacle_way(from.positions, begin_, poses_) + 2 * farthest(from.positions, to.positions);
  double least = mean_size_ / 2;
  for (const double thickness : half_thickness_) least = std::min(least, thickness / 2);
  if (reach <= least) return 1;
  search_.find(from.positions, begin_, reach, found_);
  double part = 1;
  for (const Touch& touch : found_) {
    const Sample& sample = samples[touch.sample];
    Vector3 way = sample_place(to, touch.sample) - sample_place(from, touch.sample);
    if (touch.count == 0) {
      const Vector3 own = begin_[touch.target].to_own(touch.place);
      way -= poses_[touch.target].to_world(own) - touch.place;
    } else {
      way -= place_of(touch.molecules, touch.weights, touch.count, to.positions) -
             place_of(touch.molecules, touch.weights, touch.count, from.positions);
    }
    const double depth = depth_into(touch);
    const bool flat = touch.turning.isZero(0) && touch.gap < sample.radius + depth;
    const double approach = flat ? -touch.normal.dot(way) : way.norm();
    if (approach > std::max(touch.gap, 0.) + depth) part = std::min(part, (std::max(touch.gap, 0.) + depth) / approach);
  }
  return part;
}

double ContactForce::square_frequency(const State& state, double ahead) const {
  // So soft that no step feels it: nobody needs to know whether it sets in.
  if (largest_square_frequency_ * ahead * ahead < 0.25) return largest_square_frequency_;
  const double fastest = std::sqrt(largest_of_ranges(static_cast<int>(watched_.size()), [&](int begin, int end) {
    double most = 0;
    for (int i = begin; i < end; ++i) most = std::max(most, state.velocities.col(watched_[i]).squaredNorm());
    return most;
  }));
  const bool pairs = options_.self || pieces_ > 1;
  double reach = (pairs ? 2 : 1) * fastest * ahead;
  set_poses(state.time);
  for (const Pose& pose : poses_) reach = std::max(reach, fastest * ahead + pose.velocity.norm() * ahead);
  search_.find(state.positions, poses_, 1.5 * reach, found_);
  return found_.empty() ? 0 : largest_square_frequency_;
}

}  // namespace elastin::contact
