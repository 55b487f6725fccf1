#pragma once
#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "contact/search.h"
#include "elastin/contact/contact_points.h"
#include "elastin/core/model/state.h"

namespace elastin::contact {

/// A relative motion of a sample against its target, as weights of molecules: u = Σ weight · δx.
struct Side {
  int molecule = -1;
  double normal = 0;                ///< weight in the motion that closes the gap
  double tangential = 0;            ///< in the motion away from the anchor
  Vector3 slope = Vector3::Zero();  ///< Touch::slopes, of the target's molecules
};

/// What a touch answers with: forces, and how they change. Everything on the sample; the target gets the opposite.
struct ContactResponse {
  int sample = 0, target = 0;
  double gap = 0;  ///< [m]
  Vector3 normal = Vector3::UnitZ(), position = Vector3::Zero();
  std::array<Side, 11> sides;  ///< of sample, target, and anchor where that lies elsewhere
  int count = 0;
  double pressing = 0;                           ///< N, damping included [N]; below 0 where adhesion pulls
  double elastic = 0;                            ///< of it, from penalty and multiplier [N]
  double energy = 0;                             ///< of the elastic part [J]
  Vector3 friction = Vector3::Zero();            ///< [N]
  Vector3 slip = Vector3::Zero();                ///< elastic, after its return to the cone [m]
  Matrix3 stiffness = Matrix3::Zero();           ///< −∂(normal force)/∂u, but for the target's turning [N/m]
  Matrix3 damping = Matrix3::Zero();             ///< −∂(normal force)/∂u̇ [N s/m]
  Matrix3 friction_stiffness = Matrix3::Zero();  ///< −∂friction/∂(motion from the anchor) [N/m]
  Matrix3 friction_damping = Matrix3::Zero();    ///< −∂friction/∂(its rate) [N s/m]
  Vector3 friction_gap_slope = Vector3::Zero();  ///< −∂friction/∂gap: what is lost of it as the gap opens [N/m]
  Matrix3 friction_gap_rate_slope = Matrix3::Zero();  ///< the same of the damping part of N, by ġ [N s/m]
};

/// What decides about a contact point in addition to its geometry.
struct ContactSetting {
  double stiffness = 0;                ///< [N/m]
  double mass = 0;                     ///< reduced, of the two that touch [kg]
  double damping_ratio = 0;            ///< of the normal motion, from the restitution
  double friction = 0;                 ///< μ
  double onset = 0;                    ///< largest depth over which damping sets in [m]
  double multiplier = 0;               ///< [N]
  double adhesion = 0, range = 0;      ///< work of adhesion [J], and the gap at which it ends [m]
  bool anchored = false;               ///< whether there is an anchor
  Vector3 slip = Vector3::Zero();      ///< from the anchor, tangential or not [m]
  Vector3 velocity = Vector3::Zero();  ///< of the sample against the target [m/s]
};

/// Of the elastic slip: it settles, it does not rebound.
inline constexpr double kSlipDampingRatio = 0.2;

/// Penalty, damping and friction of one touch. The normal force is N = max(0, λ − k g − c w ġ), w growing from 0 to 1
/// over the onset's depth, or a part of |ġ| √(m/k) where that is less; friction is −k s − c ṡ of the elastic slip s
/// while that is within μN, else μN against it. Sets everything but sample, target, position and sides. @param geometry
/// normal, gap and turning
void set_response(const ContactPoint& geometry, const ContactSetting& setting, ContactResponse& response);

/// Damping ratio ζ ≥ 0 at which a mass on a linear spring and dashpot that only press leaves as fast as `restitution`
/// times the speed it came with, 0.01 ≤ e ≤ 1. [Schwager & Pöschel 2007]
double damping_ratio_of(double restitution);

/// Which of its molecules a sample is nearest to: of a side's samples each to another.
inline int nearest_of(const Sample& sample) {
  return static_cast<int>(std::max_element(sample.weights.begin(), sample.weights.end()) - sample.weights.begin());
}

/// What a molecule's share of the surface is pressed with by one target, beyond the penalty.
struct MoleculePressure {
  int molecule = 0, target = 0;
  double pressure = 0;  ///< [Pa], ≥ 0
  bool operator==(const MoleculePressure&) const = default;
};

/// Of updates that follow each other: what the last one made, the depth that it met, by which factor the penalty is
/// raised from there on, and how many they are.
struct MultiplierUpdates {
  std::vector<MoleculePressure> made;
  double depth = std::numeric_limits<double>::infinity();  ///< [m]
  double raised = 1;
  int count = 0;
};

/// The one kind of Contact. Its files: contact_force.cpp what a load does; contact_state.cpp the touches of a state,
/// and their history; multipliers.cpp what bounds the depth; max_step_fraction.cpp what keeps steps short;
/// contact_report.cpp.
class ContactForce final : public Contact {
 public:
  ContactForce(const Body& body, const ContactOptions& options, const SurfaceSides& sides);

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
  bool has_multipliers() const override { return options_.penetration > 0; }
  double max_step_fraction(const State& from, const State& to) const override;
  bool bodies_may_pass(const State& from, const State& to) const;
  double square_frequency(const State& state, double ahead) const override;

  ContactReport report(const State& state) const override;
  std::vector<PressedPoint> pressed(const State& state) const;
  const std::vector<Obstacle>& obstacles() const override { return options_.obstacles; }
  void set_moment(double moment) override {
    moment_ = moment;
    cached_ = false;
  }
  std::vector<Pose> poses(double time) const override {
    std::vector<Pose> all;
    for (const Obstacle& obstacle : options_.obstacles) all.push_back(pose_of(obstacle, time));
    return all;
  }

 private:
  double friction_of(const Obstacle& obstacle) const {
    return obstacle.friction >= 0 ? obstacle.friction : options_.friction;
  }
  /// μ against an obstacle or, from the number of obstacles on, the body itself.
  double friction_against(int target) const {
    return target < obstacle_count() ? friction_of(options_.obstacles[target]) : options_.friction;
  }
  int obstacle_count() const { return static_cast<int>(options_.obstacles.size()); }
  Vector3 sample_position(const State& state, int sample) const;
  int piece_of_target(const ContactResponse& response) const {
    const int number = response.target - obstacle_count();
    return spheres_ ? search_.samples()[number - pieces_].piece : number;
  }

  /// Throws InputError where a number of it is not finite.
  Pose pose_of(const Obstacle& obstacle, double time) const;
  void set_poses(double time) const;
  double farthest(const Positions& from, const Positions& to) const;
  /// Of the sample against where it is nearest to on a body [m].
  Vector3 displacement_on_body(const ContactPoint& contact_point, const State& from, const State& to) const;
  double obstacle_displacement(const Positions& positions, const std::vector<Pose>& from,
                               const std::vector<Pose>& to) const;
  /// Makes `at` the anchor of a contact point: a position that moves with the target.
  void anchor(const State& state, const ContactPoint& contact_point, const Vector3& at, ContactHistory& memory) const;
  /// The sample's position less its anchor's.
  Vector3 slip_from(const State& state, const ContactPoint& contact_point, const ContactHistory& memory) const;
  /// Touches at a state, those that press or, on request, all within reach.
  const std::vector<ContactResponse>& responses(const State& state) const;
  bool same_as_cached(const State& state) const;
  void store(const State& state) const;
  void evaluate(const State& state, double reach, bool all) const;
  ContactSetting setting_of(const State& state, const ContactPoint& contact_point, const ContactHistory* memory) const;
  /// Of the area over which a touch is pressed [m²]: of spheres the smaller counts; triangles press on each other from
  /// both sides, each with half.
  double area_of(const ContactPoint& contact_point) const;

  int molecule_of(const ContactHistory& memory) const {
    const Sample& sample = search_.samples()[memory.sample];
    return sample.molecules[nearest_of(sample)];
  }
  /// Sets pressures_ to what the state's history says, and what the penalty is raised by.
  void set_pressures(const State& state) const;
  double pressure_at(int molecule, int target) const;
  /// What the molecules' multipliers press a touch with [N].
  double multiplier_of(const ContactPoint& contact_point) const;
  /// Adds to next_history_ an entry of a sample that has none yet; its anchor moves with what the contact point lies
  /// on.
  void add_entry(const State& state, int sample, const ContactPoint& contact_point) const;
  /// Gives next_history_ all pressures of molecules about what touches: each needs a sample that keeps it.
  void keep_pressures(const State& state) const;
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
  mutable std::vector<ContactPoint> found_, contact_points_;          // near; of these, those that were answered
  mutable std::vector<double> multipliers_;                           // of contact_points_ [N]
  mutable std::vector<MoleculePressure> pressures_, next_pressures_;  // sorted by (molecule, target)
  mutable MultiplierUpdates updates_;
  mutable double raised_ = 1;  // the penalty, by this factor, at pressures_
  mutable std::vector<ContactResponse> responses_;
  mutable Positions cached_positions_, cached_velocities_;
  mutable std::vector<Pose> cached_poses_;
  mutable std::vector<ContactHistory> cached_memory_, next_history_;
};

/// Order of the touches, of their history and of molecules' pressures.
inline std::pair<int, int> key_of(const ContactPoint& point) { return {point.sample, point.target}; }
inline std::pair<int, int> key_of(const ContactHistory& memory) { return {memory.sample, memory.target}; }
inline std::pair<int, int> key_of(const MoleculePressure& held) { return {held.molecule, held.target}; }

/// Σ weight · position.
template <std::size_t N>
Vector3 position_of(const std::array<int, N>& molecules, const std::array<double, N>& weights, int count,
                    const Positions& positions) {
  Vector3 sum = Vector3::Zero();
  for (int i = 0; i < count; ++i) sum += weights[i] * positions.col(molecules[i]);
  return sum;
}

}  // namespace elastin::contact
