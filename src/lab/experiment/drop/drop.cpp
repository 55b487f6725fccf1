#include <algorithm>
#include <array>
#include <cmath>

#include "core/forces/floor.h"
#include "elastin/contact/contact.h"
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
      {{"impact_speed", velocity, "speed of the mass centre towards the floor at first contact"},
       {"rebound_speed", velocity, "speed of the mass centre away from the floor at its end"},
       {"restitution", none, "rebound speed / impact speed"},
       {"contact_duration", dimension::time, "duration of the first contact"},
       {"compression", none, "shortening of the body across the floor / its length, the largest of all frames",
        Role::share},
       {"floor_force", force, "force of the floor on the body, the largest of all frames"},
       {"gap", length, "distance between the floor and the nearest sphere; negative: penetration"}},
      {{"time", "compression"}}};
  return list;
}

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

  /// The first contact: from the gap's fall below zero to its rise above; where no gap is known, by frames that touch.
  /// On obstacles and without weight it comes but once, and what touched first may bounce before the rest has come:
  /// there the last touch counts.
  void read_history(const std::vector<CurvePoint>& history, Measures& measures) const override {
    const auto gap = [&](std::size_t i) { return history[i].measures.get("gap"); };
    const auto touches = [&](std::size_t i) { return plane_ ? gap(i) < 0 : history[i].measures.get("contacts") > 0; };
    const auto crossing = [&](std::size_t i) {  // between frames i - 1 and i
      const double part = plane_ ? gap(i - 1) / (gap(i - 1) - gap(i)) : 0.5;
      return history[i - 1].time + (history[i].time - history[i - 1].time) * part;
    };
    std::size_t first = 1;
    while (first < history.size() && !touches(first)) ++first;
    if (first == history.size()) return;
    std::size_t last = first;
    double deepest = 0, force = 0;
    std::size_t end = first;
    for (std::size_t i = first; i < history.size(); ++i)
      if (touches(i) && ((setup_.contact && setup_.gravity == 0) || i == end)) end = i + 1;
    for (; last < end; ++last) {
      deepest = std::max(deepest, history[last].measures.get("compression"));
      force = std::max(force, history[last].measures.get("floor_force"));
    }
    measures.set("compression", deepest);
    measures.set("floor_force", force);
    const double touched = touches(first - 1) ? history[first - 1].time : crossing(first);
    const CurvePoint& before = history[first - 1];
    const double impact = before.measures.get("impact_speed") + setup_.gravity * (touched - before.time);
    measures.set("impact_speed", impact);
    if (last == history.size()) return;  // it has not left
    const double left = crossing(last);
    const double rebound = -history[last].measures.get("impact_speed") + setup_.gravity * (history[last].time - left);
    measures.set("contact_duration", left - touched);
    measures.set("rebound_speed", rebound);
    measures.set("restitution", rebound / impact);
  }

  std::vector<MainMeasure> main_measures(const Material&, const Measures&) const override {
    return {{"restitution"}, {"contact_duration"}, {"compression"}};
  }

  std::string remark(const Measures& measures) const override {
    if (std::isfinite(measures.get("restitution"))) return "";
    return "the body has not left the floor within the duration";
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
    measures.set("impact_speed", sums[0] / sums[1]);
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
