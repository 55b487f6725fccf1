#include "contact/contact_force.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace elastin {
namespace {

/// How deep a point may get into an obstacle before the shortest way out is another than it came [m].
double half_thickness(const ObstacleShape& obstacle) {
  struct Visitor {
    double operator()(const shape::Plane&) const { return std::numeric_limits<double>::infinity(); }
    double operator()(const shape::Box& box) const { return box.size.minCoeff() / 2; }
    double operator()(const shape::Sphere& sphere) const { return sphere.radius; }
    double operator()(const shape::Cylinder& cylinder) const { return std::min(cylinder.radius, cylinder.length / 2); }
    double operator()(const shape::Capsule& capsule) const { return capsule.radius; }
    double operator()(const shape::Convex& convex) const { return of(convex.points); }
    double operator()(const shape::Mesh& mesh) const { return of(mesh.points); }
    static double of(const Positions& points) {
      return (points.rowwise().maxCoeff() - points.rowwise().minCoeff()).minCoeff() / 2;
    }
  };
  return std::visit(Visitor{}, obstacle);
}

}  // namespace

double ContactForce::free_way(const State& from, const State& to) const {
  const std::vector<Sample>& samples = search_.samples();
  const int count = static_cast<int>(samples.size());
  set_poses(from.time);
  const std::vector<Pose> begin = poses_;
  set_poses(to.time);
  double obstacle_way = 0;
  for (std::size_t i = 0; i < begin.size(); ++i)
    obstacle_way = std::max(obstacle_way, (poses_[i].place - begin[i].place).norm());
  double farthest = 0;
  for (int i = 0; i < count; ++i) farthest = std::max(farthest, (sample_place(to, i) - sample_place(from, i)).norm());
  // No sample gets deeper in one go than half its own size, or half the obstacle, where the way out is still the way
  // in.
  const auto depth_into = [&](const Touch& touch) {
    const double own = mean_size_ / 2;
    return touch.count > 0 ? own
                           : std::min(own, samples[touch.sample].radius +
                                               half_thickness(options_.obstacles[touch.target].shape) / 2);
  };
  const double reach = obstacle_way + 2 * farthest;
  double least = mean_size_ / 2;
  for (const Obstacle& obstacle : options_.obstacles) least = std::min(least, half_thickness(obstacle.shape) / 2);
  if (reach <= least) return 1;
  search_.find(from.positions, begin, reach, found_);
  double part = 1;
  for (const Touch& touch : found_) {
    const Sample& sample = samples[touch.sample];
    Vector3 way = sample_place(to, touch.sample) - sample_place(from, touch.sample);
    if (touch.count == 0) {
      const Vector3 own = begin[touch.target].to_own(touch.place);
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
  double fastest = 0;
  for (const int molecule : watched_) fastest = std::max(fastest, state.velocities.col(molecule).squaredNorm());
  const bool pairs = options_.self || pieces_ > 1;
  double reach = (pairs ? 2 : 1) * std::sqrt(fastest) * ahead;
  set_poses(state.time);
  for (const Pose& pose : poses_) reach = std::max(reach, std::sqrt(fastest) * ahead + pose.velocity.norm() * ahead);
  search_.find(state.positions, poses_, 1.5 * reach, found_);
  return found_.empty() ? 0 : largest_square_frequency_;
}

}  // namespace elastin
