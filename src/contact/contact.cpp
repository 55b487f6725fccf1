#include "elastin/contact/contact.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "contact/answer.h"
#include "contact/search.h"
#include "elastin/base/error.h"

namespace elastin {
namespace {

std::vector<Sample> samples_of(const Body& body, ContactSurface surface, const Cells<3>& triangles) {
  if (surface == ContactSurface::spheres) return sphere_samples(body, surface_molecules(body));
  return triangle_samples(body, triangles);
}

Vector3 place_of(const std::array<int, 3>& molecules, const std::array<double, 3>& weights, int count,
                 const Positions& places) {
  Vector3 sum = Vector3::Zero();
  for (int i = 0; i < count; ++i) sum += weights[i] * places.col(molecules[i]);
  return sum;
}

bool before(const TouchMemory& memory, const Touch& touch) {
  return std::pair{memory.sample, memory.target} < std::pair{touch.sample, touch.target};
}

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

class ContactForce final : public Contact {
 public:
  ContactForce(const Body& body, const ContactOptions& options, const Cells<3>& triangles)
      : body_(body),
        options_(options),
        spheres_(options.surface == ContactSurface::spheres),
        damping_ratio_(damping_ratio_of(options.restitution)),
        search_(body, samples_of(body, options.surface, triangles), triangles, spheres_, options.obstacles,
                options.self) {
    BodyFindings findings = inspect(body);
    pieces_ = findings.pieces;
    piece_of_molecule_ = std::move(findings.piece_of);
    for (const Obstacle& obstacle : options_.obstacles) {
      moves_ |= static_cast<bool>(obstacle.motion);
      rubs_ |= friction_of(obstacle) > 0;
    }
    rubs_ |= options_.friction > 0;
    std::vector<char> seen(static_cast<std::size_t>(body.size()), 0);
    for (const Sample& sample : search_.samples())
      for (int i = 0; i < sample.count; ++i) seen[sample.molecules[i]] = 1;
    for (int molecule = 0; molecule < body.size(); ++molecule)
      if (seen[molecule]) watched_.push_back(molecule);
    area_ = VectorX::Zero(body.size());
    for (const Sample& sample : search_.samples()) {
      mean_size_ += std::sqrt(sample.area) / static_cast<double>(search_.samples().size());
      for (int i = 0; i < sample.count; ++i) area_[sample.molecules[i]] += sample.weights[i] * sample.area;
    }
    const bool pairs = options_.self || pieces_ > 1;
    const double zeta = std::max(damping_ratio_, rubs_ ? kSlipDampingRatio : 0);
    const double damped = std::sqrt(1 + zeta * zeta) + zeta;
    for (const int molecule : watched_)
      largest_square_frequency_ =
          std::max(largest_square_frequency_,
                   options_.stiffness * area_[molecule] / body_.mass[molecule] * (pairs ? 4 : 1) * damped * damped);
  }

  void add_forces(const State& state, Positions& forces) const override {
    for (const Answer& answer : answers(state)) add(answer, answer.pressing * answer.normal, answer.friction, forces);
  }
  void add_resistance(const State& state, Positions& forces) const override {
    for (const Answer& answer : answers(state))
      add(answer, (answer.pressing - answer.elastic) * answer.normal, answer.friction, forces);
  }
  double energy(const State& state) const override {
    double sum = 0;
    for (const Answer& answer : answers(state)) sum += answer.energy;
    return sum;
  }

  bool has_energy() const override { return !rubs_; }
  bool resists() const override { return rubs_ || damping_ratio_ > 0; }
  bool symmetric() const override { return !rubs_; }
  bool steady() const override { return !moves_; }
  bool changes() const override { return true; }

  void add_change(const State& state, const Positions& moved, const Positions& sped, Positions& forces) const override {
    for (const Answer& answer : answers(state)) {
      Vector3 closing = Vector3::Zero(), closing_rate = Vector3::Zero(), slipping = Vector3::Zero(),
              slipping_rate = Vector3::Zero(), turned = Vector3::Zero();
      for (int i = 0; i < answer.count; ++i) {
        const Side& side = answer.sides[i];
        closing += side.normal * moved.col(side.molecule);
        slipping += side.tangential * moved.col(side.molecule);
        closing_rate += side.normal * sped.col(side.molecule);
        slipping_rate += side.tangential * sped.col(side.molecule);
        turned += side.slope * answer.normal.dot(moved.col(side.molecule));
      }
      const Vector3 normal = answer.stiffness * closing + answer.damping * closing_rate + answer.pressing * turned;
      const Vector3 tangential = answer.sticking * slipping + answer.rubbing * slipping_rate +
                                 answer.grip * answer.normal.dot(closing) + answer.grip_rate * closing_rate;
      for (int i = 0; i < answer.count; ++i) {
        const Side& side = answer.sides[i];
        forces.col(side.molecule) -= side.normal * normal + side.tangential * tangential +
                                     answer.pressing * side.slope.dot(closing) * answer.normal;
      }
    }
  }

  void visit_blocks(const State& state, double velocity_weight, const BlockVisitor& visit) const override {
    for (const Answer& answer : answers(state)) {
      const Vector3& n = answer.normal;
      const Matrix3 normal = answer.stiffness + velocity_weight * answer.damping;
      const Matrix3 tangential = answer.sticking + velocity_weight * answer.rubbing;
      const Matrix3 grip = answer.grip * n.transpose() + velocity_weight * answer.grip_rate;
      for (int i = 0; i < answer.count; ++i)
        for (int j = 0; j < answer.count; ++j) {
          const Side &a = answer.sides[i], &b = answer.sides[j];
          visit(a.molecule, b.molecule,
                a.normal * b.normal * normal + a.tangential * b.tangential * tangential +
                    a.tangential * b.normal * grip +
                    answer.pressing * (a.normal * b.slope * n.transpose() + b.normal * n * a.slope.transpose()));
        }
    }
  }

  void remember(State& state) const override {
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

  bool tighten(State& state) const override {
    if (options_.penetration == 0) return false;
    double deepest = 0;
    for (const Answer& answer : answers(state)) deepest = std::max(deepest, -answer.gap);
    if (deepest <= options_.penetration) return false;
    remembered_.clear();
    std::size_t known = 0;
    for (std::size_t i = 0; i < answers_.size(); ++i) {
      const Touch& touch = touches_[i];
      while (known < state.touches.size() && before(state.touches[known], touch))
        remembered_.push_back(state.touches[known++]);
      if (known < state.touches.size() && !(before_touch(touch, state.touches[known]))) {
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

  double free_way(const State& from, const State& to) const override;
  double square_frequency(const State& state, double ahead) const override;

  ContactReport report(const State& state) const override;
  const std::vector<Obstacle>& obstacles() const override { return options_.obstacles; }
  void set_moment(double moment) override {
    moment_ = moment;
    cached_ = false;
  }

 private:
  double friction_of(const Obstacle& obstacle) const {
    return obstacle.friction >= 0 ? obstacle.friction : options_.friction;
  }
  int obstacle_count() const { return static_cast<int>(options_.obstacles.size()); }
  Vector3 sample_place(const State& state, int sample) const {
    const Sample& s = search_.samples()[sample];
    return place_of(s.molecules, s.weights, s.count, state.positions);
  }
  static bool before_touch(const Touch& touch, const TouchMemory& memory) {
    return std::pair{touch.sample, touch.target} < std::pair{memory.sample, memory.target};
  }

  static void add(const Answer& answer, const Vector3& normal, const Vector3& tangential, Positions& forces) {
    for (int i = 0; i < answer.count; ++i) {
      const Side& side = answer.sides[i];
      forces.col(side.molecule) += side.normal * normal + side.tangential * tangential;
    }
  }

  int piece_of_target(const Answer& answer) const {
    const int number = answer.target - obstacle_count();
    return spheres_ ? piece_of_molecule_[number - pieces_] : number;
  }

  void set_poses(double time) const {
    poses_.clear();
    for (const Obstacle& obstacle : options_.obstacles) poses_.push_back(obstacle.at(moment_.value_or(time)));
  }

  /// Makes `at` the anchor of a touch: a place that moves with the target.
  void anchor(const State& state, const Touch& touch, const Vector3& at, TouchMemory& memory) const {
    memory.molecules = touch.molecules;
    memory.weights = touch.weights;
    memory.count = touch.count;
    memory.offset = touch.count == 0
                        ? poses_[touch.target].to_own(at)
                        : Vector3(at - place_of(touch.molecules, touch.weights, touch.count, state.positions));
  }

  /// The sample's place less its anchor's.
  Vector3 slip_from(const State& state, const Touch& touch, const TouchMemory& memory) const {
    const Vector3 at =
        memory.count == 0
            ? poses_[touch.target].to_world(memory.offset)
            : Vector3(memory.offset + place_of(memory.molecules, memory.weights, memory.count, state.positions));
    return sample_place(state, touch.sample) - at;
  }

  /// Touches at a state, those that press or, on request, all within reach.
  const std::vector<Answer>& answers(const State& state) const {
    if (!(cached_ && same_as_cached(state))) {
      evaluate(state, 0, false);
      keep(state);
    }
    return answers_;
  }
  bool same_as_cached(const State& state) const;
  void keep(const State& state) const;
  void evaluate(const State& state, double reach, bool all) const;
  TouchSetting setting_of(const State& state, const Touch& touch, const TouchMemory* memory) const;
  void set_sides(const Touch& touch, const TouchMemory* memory, Answer& answer) const;

  const Body& body_;
  ContactOptions options_;
  bool spheres_, moves_ = false, rubs_ = false;
  int pieces_ = 0;
  std::vector<int> piece_of_molecule_;
  double damping_ratio_, mean_size_ = 0;
  std::vector<int> watched_;             // molecules on whose places everything here depends
  VectorX area_;                         // of the surface that each molecule stands for [m²]
  double largest_square_frequency_ = 0;  // of any molecule against what it may touch [1/s²]
  std::optional<double> moment_;
  // A cache of the last state's touches: the answers never depend on it.
  mutable ContactSearch search_;
  mutable bool cached_ = false;
  mutable std::vector<Pose> poses_;
  mutable std::vector<Touch> found_, touches_;  // near; of these, those that were answered
  mutable std::vector<double> multipliers_;
  mutable std::vector<Answer> answers_;
  mutable Positions cached_positions_, cached_velocities_;
  mutable double cached_time_ = 0;
  mutable std::vector<TouchMemory> cached_memory_, remembered_;
};

bool same(const TouchMemory& a, const TouchMemory& b) {
  return a.sample == b.sample && a.target == b.target && a.molecules == b.molecules && a.weights == b.weights &&
         a.offset == b.offset && a.multiplier == b.multiplier;
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
  for (int i = 0; i < sample.count; ++i) {
    inverse_mass += sample.weights[i] * sample.weights[i] / body_.mass[sample.molecules[i]];
    setting.velocity += sample.weights[i] * state.velocities.col(sample.molecules[i]);
  }
  if (touch.count == 0) {
    setting.velocity -= poses_[touch.target].velocity_at(touch.place);
  } else {
    for (int i = 0; i < touch.count; ++i) {
      inverse_mass += touch.weights[i] * touch.weights[i] / body_.mass[touch.molecules[i]];
      setting.velocity -= touch.weights[i] * state.velocities.col(touch.molecules[i]);
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

ContactReport ContactForce::report(const State& state) const {
  ContactReport report;
  report.forces = Positions::Zero(3, body_.size());
  report.on_obstacles.assign(options_.obstacles.size(), Vector3::Zero());
  VectorX pressing = VectorX::Zero(body_.size());
  const std::vector<Sample>& samples = search_.samples();
  for (const Answer& answer : answers(state)) {
    if (!(answer.pressing > 0)) continue;
    const Sample& sample = samples[answer.sample];
    const Vector3 force = answer.pressing * answer.normal + answer.friction;
    ++report.pairs;
    report.sticking += answer.sticks;
    report.largest_penetration = std::max(report.largest_penetration, -answer.gap);
    // Bodies touch each other from both sides: their area is counted once.
    report.area += answer.target < obstacle_count() || spheres_ ? sample.area : sample.area / 2;
    for (int i = 0; i < answer.count; ++i) {
      const Side& side = answer.sides[i];
      report.forces.col(side.molecule) +=
          side.normal * answer.pressing * answer.normal + side.tangential * answer.friction;
      pressing[side.molecule] += std::abs(side.normal) * answer.pressing;
    }
    if (answer.target < obstacle_count())
      report.on_obstacles[answer.target] -= force;
    else if (const int other = piece_of_target(answer); other != sample.piece)
      report.between_pieces += sample.piece < other ? force : Vector3(-force);
  }
  report.pressure = VectorX::Zero(body_.size());
  for (const int molecule : watched_)
    if (pressing[molecule] > 0) report.pressure[molecule] = pressing[molecule] / area_[molecule];
  report.largest_pressure = report.pressure.size() ? report.pressure.maxCoeff() : 0;
  report.broad_seconds = search_.cost().broad_seconds;
  report.narrow_seconds = search_.cost().narrow_seconds;
  return report;
}

}  // namespace

double default_contact_stiffness(const Body& body, double youngs_modulus) {
  return 10 * youngs_modulus / (2 * body.radius.mean());
}

std::unique_ptr<Contact> make_contact(const Body& body, const ContactOptions& options) {
  if (!(options.stiffness > 0) || !std::isfinite(options.stiffness))
    throw InputError("the contact's stiffness must be above 0");
  if (!(options.friction >= 0) || !std::isfinite(options.friction))
    throw InputError("the coefficient of friction must not be negative");
  if (!(options.restitution >= 0.01 && options.restitution <= 1))
    throw InputError("the restitution must be from 0.01 to 1");
  if (!(options.penetration >= 0)) throw InputError("the penetration must not be negative");
  Cells<3> triangles;
  if (options.surface == ContactSurface::triangles) {
    triangles = surface_triangles(body);
    if (triangles.empty())
      throw InputError("the body has no surface of triangles (no cells, cubes or triangles); take its spheres");
  }
  return std::make_unique<ContactForce>(body, options, triangles);
}

}  // namespace elastin
