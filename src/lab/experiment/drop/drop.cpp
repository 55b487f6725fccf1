#include <algorithm>
#include <array>
#include <cmath>

#include "core/forces/floor.h"
#include "elastin/contact/contact.h"
#include "elastin/core/base/text.h"
#include "elastin/core/model/share.h"
#include "lab/experiment/keys.h"
#include "lab/run/contact_measures.h"

namespace elastin::lab {
namespace {

/// A free body that falls on a floor, or on the obstacles of its scene.
struct DropSetup {
  Vector3 direction = -Vector3::UnitZ();  ///< down
  double gravity = 0;                     ///< [m/s²]; 0: none
  double height = 0;                      ///< [m] of the lowest sphere above the floor at time 0
  double speed = 0;                       ///< [m/s] down at time 0
  double stiffness = 0, damping = 0;      ///< of its own floor, a molecule [N/m], [N s/m]
  /// None: it falls on a floor of its own.
  std::optional<contact::ContactOptions> contact = {};
  const ExperimentContext* context = nullptr;  ///< in which it is read
};

const MeasureList& drop_measures() {
  using namespace dimension;
  using Role = MeasureRole;
  static const MeasureList list{
      {{"impact_speed", velocity, "speed of the mass centre towards the floor at the first touch"},
       {"rebound_speed", velocity, "speed of the mass centre away from the floor after the last touch of the impact"},
       {"restitution", none, "rebound speed / impact speed"},
       {"contact_duration", dimension::time,
        "duration of the impact: from the first touch until the body has left for good, to fall again or not at all"},
       {"compression", none, "shortening of the body across the floor / its length, the largest of the impact",
        Role::share},
       {"floor_force", force, "force of the floor on the body, the largest of the impact"},
       {"fall_speed", velocity, "speed of the mass centre towards the floor"},
       {"gap", length, "distance between the floor and the nearest sphere; negative: penetration"}},
      {{"time", "compression"}}};
  return list;
}

/// Of the largest speed of the mass centre: a change between two frames beyond that of a free fall is of a touch.
constexpr double kPushed = 5e-3;
/// Of the impact's duration: a free flight up to the end of the run that is shorter may only be between two touches.
constexpr double kFlight = 0.25;

class Drop final : public TimedExperiment {
 public:
  Drop(const Body& body, const DropSetup& setup) : body_(body), setup_(setup), up_(-setup.direction.normalized()) {
    const VectorX height = body.rest.transpose() * up_;
    reach_ = body.radius;
    if (setup.contact && setup.contact->surface == contact::ContactSurface::triangles) reach_.setZero();
    const double lowest = least_over(body, (height - reach_).minCoeff());
    length_ = largest_over(body, (height + reach_).maxCoeff()) - lowest;
    if (setup.contact) {
      find_plane();
      return;
    }
    floor_.normal = up_;
    floor_.point = (lowest - setup.height) * up_;
    floor_.stiffness = setup.stiffness;
    floor_.damping = setup.damping;
  }

  std::string name() const override { return "drop"; }
  MeasureList measures() const override { return drop_measures(); }
  std::unique_ptr<TimedRig> timed_rig(Model& model) const override;

  /// The first impact. Molecules bounce one by one while the body is pressed: it is over when the body flies free until
  /// its centre falls again, or to the end. A touch shorter than the rows are apart shows in the centre's speed.
  void read_history(const std::vector<CurvePoint>& history, Measures& measures) const override {
    const std::size_t count = history.size();
    const auto get = [&](std::size_t i, const char* name) { return history[i].measures.get(name); };
    const auto fall = [&](std::size_t i) { return get(i, "fall_speed"); };
    double fastest = 0;
    for (std::size_t i = 0; i < count; ++i) fastest = std::max(fastest, std::abs(fall(i)));
    const auto touches = [&](std::size_t i) { return plane_ ? get(i, "gap") < 0 : get(i, "contacts") > 0; };
    const auto crossing = [&](std::size_t i) {  // of the ground, between frames i - 1 and i
      const double before = plane_ ? get(i - 1, "gap") : 1, after = plane_ ? get(i, "gap") : -1;
      const double part = before * after < 0 ? before / (before - after) : 0.5;
      return history[i - 1].time + (history[i].time - history[i - 1].time) * part;
    };
    std::size_t first = 1;
    while (first < count && !touches(first)) ++first;
    if (first >= count) return;
    const double weight = first > 1 ? (fall(first - 1) - fall(0)) / (history[first - 1].time - history[0].time)
                                    : setup_.gravity;  // of all loads [m/s²]
    const auto pushed = [&](std::size_t i) {           // at frame i, or since the one before
      const double free = fall(i - 1) + weight * (history[i].time - history[i - 1].time);
      return touches(i) || std::abs(fall(i) - free) > kPushed * fastest;
    };
    std::size_t last = first;
    for (std::size_t i = first + 1; i < count && !(fall(last + 1) < 0 && fall(i) > 0); ++i)
      if (pushed(i)) last = i;
    double deepest = 0, force = 0;
    for (std::size_t i = first; i <= last; ++i) {
      deepest = std::max(deepest, get(i, "compression"));
      force = std::max(force, get(i, "floor_force"));
    }
    measures.set("compression", deepest);
    measures.set("floor_force", force);
    const double touched = touches(first - 1) ? history[first - 1].time : crossing(first);
    const double impact = fall(first - 1) + weight * (touched - history[first - 1].time);
    measures.set("impact_speed", impact);
    if (last + 1 == count || (plane_ && fall(last + 1) > 0)) return;
    const double left = crossing(last + 1);
    if (history.back().time - left < kFlight * (left - touched)) return;
    const double rebound = weight * (history[last + 1].time - left) - fall(last + 1);
    measures.set("contact_duration", left - touched);
    measures.set("rebound_speed", rebound);
    measures.set("restitution", rebound / impact);
  }

  std::vector<MainMeasure> main_measures(const Material&, const Measures&) const override {
    return {{"restitution"}, {"contact_duration"}, {"compression"}};
  }

  std::string remark(const Measures& measures) const override {
    if (std::isfinite(measures.get("restitution"))) return "";
    if (std::isfinite(measures.get("impact_speed")))
      return "the body has not left the floor for good within the duration: write a longer one";
    const double gap = measures.get("gap");
    return "the body has not reached the floor within the duration" +
           (gap > 0 ? ", at whose end it is " + number(1e3 * gap, 3) + " mm away" : std::string()) +
           ": write a longer duration, a smaller height or a speed";
  }

 private:
  friend class DropRig;
  /// The first plane among the obstacles that stands still and lies level is the ground to which gaps are read.
  void find_plane() {
    plane_ = false;
    for (const contact::Obstacle& obstacle : setup_.contact->obstacles)
      if (std::holds_alternative<contact::shape::Plane>(obstacle.shape) && !obstacle.motion &&
          obstacle.pose.turn.col(2).dot(up_) > 1 - 1e-9) {
        floor_.point = obstacle.pose.position;
        plane_ = true;
        return;
      }
  }

  const Body& body_;
  DropSetup setup_;
  Vector3 up_;
  VectorX reach_;      // of what touches, from each molecule [m]
  bool plane_ = true;  // whether there is a level ground
  double length_ = 0;  // along the fall, spheres included
  Floor floor_;
};

class DropRig final : public TimedRig {
 public:
  DropRig(const Drop& experiment, Model& model)
      : experiment_(experiment), setup_(experiment.setup_), body_(experiment.body_) {
    contact_ = contact_of(model);
    if (!contact_) {
      auto floor = make_floor(body_, experiment_.floor_);
      pressing_ = floor.get();
      model.add(std::move(floor));
      if (experiment_.floor_.damping > 0) model.add(make_floor_damping(body_, experiment_.floor_));
    }
    if (setup_.gravity != 0) model.add(make_gravity(body_, -setup_.gravity * experiment_.up_));
  }

  StaticResult start(State& state, const StaticOptions&) override {
    state.velocities.colwise() -= setup_.speed * experiment_.up_;
    return {};
  }

  Measures read(const State& state) const override {
    const VectorX height = state.positions.transpose() * experiment_.up_;
    Measures measures;
    const double lowest = least_over(body_, (height - experiment_.reach_).minCoeff()),
                 ground = experiment_.plane_ ? experiment_.floor_.point.dot(experiment_.up_) : lowest;
    if (experiment_.plane_) measures.set("gap", lowest - ground);
    measures.set("floor_force", push(state).dot(experiment_.up_));
    const double highest = largest_over(body_, (height + experiment_.reach_).maxCoeff());
    measures.set("compression", 1 - (highest - std::max(ground, lowest)) / experiment_.length_);
    const int owned = owned_molecules(body_);
    std::array<double, 2> sums{-experiment_.up_.dot(state.velocities.leftCols(owned) * body_.mass.head(owned)),
                               body_.mass.head(owned).sum()};
    sum_over(body_, sums);
    measures.set("fall_speed", sums[0] / sums[1]);
    return measures;
  }

 private:
  /// Of the floor, or of all obstacles, on the body [N].
  Vector3 push(const State& state) const {
    if (contact_) return contact_->report(state).forces.rowwise().sum();
    Positions force = Positions::Zero(3, body_.size());
    pressing_->add_forces(state, force);
    Vector3 sum = force.leftCols(owned_molecules(body_)).rowwise().sum();
    sum_over(body_, {sum.data(), 3});
    return sum;
  }

  const Drop& experiment_;
  const DropSetup& setup_;
  const Body& body_;
  const Load* pressing_ = nullptr;             // the experiment's own floor, owned by the model
  const contact::Contact* contact_ = nullptr;  // or the scene's
};

std::unique_ptr<TimedRig> Drop::timed_rig(Model& model) const { return std::make_unique<DropRig>(*this, model); }

}  // namespace

ExperimentInfo drop_row() {
  using S = DropSetup;
  const auto of_floor = [](Key<S> key) {
    return std::move(key).then([](const Reader& value, S& setup) {
      if (setup.context->contact)
        value.fail("belongs to the floor of `drop`; this scene has contact and obstacles of its own");
    });
  };
  return with_keys(
      {.name = "drop",
       .summary = "a free body falls on a floor, or on the scene's obstacles: restitution, duration of contact",
       .in_time = true,
       .of_shares = true,
       .measures = drop_measures()},
      Keys<S>{key::direction("direction", &S::direction, "direction of the fall"),
              key::quantity("gravity", &S::gravity, dimension::acceleration, "acceleration of the fall", kNotNegative),
              of_floor(key::quantity("height", &S::height, dimension::length,
                                     "height of the lowest sphere above the floor; not with `contact`", kNotNegative)),
              key::quantity("speed", &S::speed, dimension::velocity, "speed along `direction` at time 0", kNotNegative),
              of_floor(key::quantity("stiffness", &S::stiffness, dimension::stiffness,
                                     "stiffness of the floor for each molecule; not with `contact`", kPositive)
                           .otherwise("E × mean diameter")),
              of_floor(key::quantity("damping", &S::damping, dimension::damping,
                                     "damping of the floor; not with `contact`", kNotNegative))},
      [](const ExperimentContext& context, S setup) {
        if (context.contact) setup.contact = *context.contact;
        if (setup.stiffness == 0) setup.stiffness = default_floor_stiffness(context.body, context.material);
        if (!(setup.speed > 0 || (setup.gravity > 0 && (setup.height > 0 || setup.contact))))
          throw InputError("nothing falls: give a speed, or gravity and a height");
        return std::make_unique<Drop>(context.body, setup);
      });
}

}  // namespace elastin::lab
