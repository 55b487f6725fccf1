#pragma once
#include <optional>
#include <vector>

#include "contact/contact_response.h"
#include "contact/search.h"
#include "elastin/contact/contact.h"

namespace elastin::contact {

/// The one kind of Contact. Its files: contact_force.cpp what a load does; contact_state.cpp the touches of a state,
/// and what is remembered of them; max_step_fraction.cpp what keeps steps short; contact_report.cpp.
class ContactForce final : public Contact {
 public:
  ContactForce(const Body& body, const ContactOptions& options, const Cells<3>& triangles);

  void add_forces(const State& state, Positions& forces) const override;
  void add_resistance(const State& state, Positions& forces) const override;
  double energy(const State& state) const override;
  bool has_energy() const override { return !has_friction_; }
  bool resists() const override { return has_friction_ || damping_ratio_ > 0; }
  bool feels_velocity() const override { return resists(); }
  bool symmetric() const override { return !has_friction_; }
  bool steady() const override { return !moves_; }
  bool changes() const override { return true; }

  void add_change(const State& state, const Positions& moved, const Positions& sped, Positions& forces) const override;
  void visit_blocks(const State& state, double velocity_weight, const BlockVisitor& visit) const override;
  void commit_step(State& state) const override;
  bool update_multipliers(State& state) const override;
  double max_step_fraction(const State& from, const State& to) const override;
  double square_frequency(const State& state, double ahead) const override;

  ContactReport report(const State& state) const override;
  const std::vector<Obstacle>& obstacles() const override { return options_.obstacles; }
  void set_moment(double moment) override {
    moment_ = moment;
    cached_ = false;
  }
  std::vector<Pose> poses(double time) const override {
    std::vector<Pose> all;
    for (const Obstacle& obstacle : options_.obstacles) all.push_back(obstacle.at(moment_.value_or(time)));
    return all;
  }

 private:
  double friction_of(const Obstacle& obstacle) const {
    return obstacle.friction >= 0 ? obstacle.friction : options_.friction;
  }
  int obstacle_count() const { return static_cast<int>(options_.obstacles.size()); }
  Vector3 sample_position(const State& state, int sample) const;
  int piece_of_target(const ContactResponse& response) const {
    const int number = response.target - obstacle_count();
    return spheres_ ? search_.samples()[number - pieces_].piece : number;
  }

  void set_poses(double time) const;
  double farthest(const Positions& from, const Positions& to) const;
  double obstacle_displacement(const Positions& positions, const std::vector<Pose>& from,
                               const std::vector<Pose>& to) const;
  /// Makes `at` the anchor of a touch: a place that moves with the target.
  void anchor(const State& state, const ContactPoint& contact_point, const Vector3& at, ContactHistory& memory) const;
  /// The sample's place less its anchor's.
  Vector3 slip_from(const State& state, const ContactPoint& contact_point, const ContactHistory& memory) const;
  /// Touches at a state, those that press or, on request, all within reach.
  const std::vector<ContactResponse>& responses(const State& state) const;
  bool same_as_cached(const State& state) const;
  void store(const State& state) const;
  void evaluate(const State& state, double reach, bool all) const;
  ContactSetting setting_of(const State& state, const ContactPoint& contact_point, const ContactHistory* memory) const;
  void set_sides(const ContactPoint& contact_point, const ContactHistory* memory, ContactResponse& response) const;

  const Body& body_;
  ContactOptions options_;
  bool spheres_, moves_ = false, has_friction_ = false;
  int pieces_ = 0;
  double damping_ratio_, mean_size_ = 0;
  std::vector<double> half_thickness_;   // of each obstacle [m]: deeper, the shortest way out is another than it came
  std::vector<int> watched_;             // molecules on whose places everything here depends
  VectorX area_;                         // of the surface that each molecule stands for [m²]
  double largest_square_frequency_ = 0;  // of any molecule against what it may touch [1/s²]
  std::optional<double> moment_;
  // A cache of the last state's touches: the answers never depend on it.
  mutable ContactSearch search_;
  mutable bool cached_ = false;
  mutable std::vector<Pose> poses_, begin_;
  mutable std::vector<ContactPoint> found_, contact_points_;  // near; of these, those that were answered
  mutable std::vector<double> multipliers_;
  mutable std::vector<ContactResponse> responses_;
  mutable Positions cached_positions_, cached_velocities_;
  mutable double cached_time_ = 0;
  mutable std::vector<ContactHistory> cached_memory_, next_history_;
};

/// Σ weight · place.
inline Vector3 position_of(const std::array<int, 3>& molecules, const std::array<double, 3>& weights, int count,
                           const Positions& positions) {
  Vector3 sum = Vector3::Zero();
  for (int i = 0; i < count; ++i) sum += weights[i] * positions.col(molecules[i]);
  return sum;
}

}  // namespace elastin::contact
