#include "contact/contact_force.h"

#include <algorithm>
#include <cmath>

#include "core/parallel/parallel.h"

namespace elastin::contact {

/// The longest displacement of a molecule [m]; no sample goes farther.
double ContactForce::farthest(const Positions& from, const Positions& to) const {
  return std::sqrt(largest_of_ranges(static_cast<int>(watched_.size()), [&](int begin, int end) {
    double most = 0;
    for (int i = begin; i < end; ++i)
      most = std::max(most, (to.col(watched_[i]) - from.col(watched_[i])).squaredNorm());
    return most;
  }));
}

/// The longest displacement of an obstacle's material at any of the positions [m].
double ContactForce::obstacle_displacement(const Positions& positions, const std::vector<Pose>& from,
                                           const std::vector<Pose>& to) const {
  double longest = 0;
  for (std::size_t o = 0; o < from.size(); ++o) {
    double displacement = (to[o].position - from[o].position).norm();
    if (const double turned = (to[o].turn - from[o].turn).norm(); turned > 0)
      displacement += turned * std::sqrt(largest_of_ranges(static_cast<int>(watched_.size()), [&](int begin, int end) {
                        double most = 0;
                        for (int i = begin; i < end; ++i)
                          most = std::max(most, (positions.col(watched_[i]) - from[o].position).squaredNorm());
                        return most;
                      }));
    longest = std::max(longest, displacement);
  }
  return longest;
}

Vector3 ContactForce::displacement_on_body(const ContactPoint& contact_point, const State& from,
                                           const State& to) const {
  const auto of_target = [&](const State& state) {
    return position_of(contact_point.molecules, contact_point.weights, contact_point.count, state.positions);
  };
  return sample_position(to, contact_point.sample) - sample_position(from, contact_point.sample) -
         (of_target(to) - of_target(from));
}

bool ContactForce::bodies_may_pass(const State& from, const State& to) const {
  const double deep = mean_size_ / 2, reach = 2 * farthest(from.positions, to.positions);
  if (!(options_.self || pieces_ > 1) || reach <= deep) return false;
  set_poses(from.time);
  search_.find(from.positions, poses_, reach, found_);
  return std::any_of(found_.begin(), found_.end(), [&](const ContactPoint& point) {
    return point.count > 0 && -point.normal.dot(displacement_on_body(point, from, to)) > std::max(point.gap, 0.) + deep;
  });
}

bool bodies_may_pass(const Contact& contact, const State& from, const State& to) {
  return dynamic_cast<const ContactForce&>(contact).bodies_may_pass(from, to);
}

double ContactForce::max_step_fraction(const State& from, const State& to) const {
  const std::vector<Sample>& samples = search_.samples();
  set_poses(from.time);
  begin_ = poses_;
  set_poses(to.time);
  // No sample gets deeper in one go than half its own size, or half the obstacle, where the way out is still the way
  // in.
  const auto depth_into = [&](const ContactPoint& contact_point) {
    const double own = mean_size_ / 2;
    return contact_point.count > 0
               ? own
               : std::min(own, samples[contact_point.sample].radius + half_thickness_[contact_point.target] / 2);
  };
  const double reach =
      obstacle_displacement(from.positions, begin_, poses_) + 2 * farthest(from.positions, to.positions);
  double least = mean_size_ / 2;
  for (const double thickness : half_thickness_) least = std::min(least, thickness / 2);
  if (reach <= least) return 1;
  search_.find(from.positions, begin_, reach, found_);
  double fraction = 1;
  for (const ContactPoint& contact_point : found_) {
    const Sample& sample = samples[contact_point.sample];
    Vector3 displacement = displacement_on_body(contact_point, from, to);
    if (contact_point.count == 0) {
      const Vector3 own = begin_[contact_point.target].to_own(contact_point.position);
      displacement -= poses_[contact_point.target].to_world(own) - contact_point.position;
    }
    const double depth = depth_into(contact_point);
    const bool flat = contact_point.turning.isZero(0) && contact_point.gap < sample.radius + depth;
    const double approach = flat ? -contact_point.normal.dot(displacement) : displacement.norm();
    if (approach > std::max(contact_point.gap, 0.) + depth)
      fraction = std::min(fraction, (std::max(contact_point.gap, 0.) + depth) / approach);
  }
  return fraction;
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
  double reach = std::max((pairs ? 2 : 1) * fastest * ahead, options_.adhesion_range);
  set_poses(state.time);
  for (const Pose& pose : poses_) reach = std::max(reach, fastest * ahead + pose.velocity.norm() * ahead);
  search_.find(state.positions, poses_, 1.5 * reach, found_);
  return found_.empty() ? 0 : largest_square_frequency_;
}

}  // namespace elastin::contact
