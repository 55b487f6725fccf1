#include <algorithm>
#include <cmath>
#include <limits>

#include "elastin/core/forces/floor.h"
#include "lab/experiment/contact_measures.h"
#include "lab/experiment/motion.h"

namespace elastin::lab {
namespace {

class Drop final : public TimedExperiment {
 public:
  Drop(const Body& body, const DropSetup& setup) : body_(body), setup_(setup), up_(-setup.direction.normalized()) {
    const VectorX height = body.rest.transpose() * up_;
    reach_ = body.radius;
    if (setup.contact && setup.contact->surface == contact::ContactSurface::triangles) reach_.setZero();
    length_ = (height + reach_).maxCoeff() - (height - reach_).minCoeff();
    if (setup.contact) {
      find_plane();
      return;
    }
    floor_.normal = up_;
    floor_.point = ((height - body.radius).minCoeff() - setup.height) * up_;
    floor_.stiffness = setup.stiffness;
    floor_.damping = setup.damping;
  }

  std::string name() const override { return "drop"; }
  Experiment* at_rest() override { return nullptr; }

  void set_up(Model& model) override {
    contact_ = contact_of(model);
    if (!contact_) {
      auto floor = make_floor(body_, floor_);
      pressing_ = floor.get();
      model.add(std::move(floor));
      if (floor_.damping > 0) model.add(make_floor_damping(body_, floor_));
    }
    if (setup_.gravity != 0) model.add(make_gravity(body_, -setup_.gravity * up_));
  }

  StaticResult start(Model&, State& state, const StaticOptions&) override {
    state.velocities.colwise() -= setup_.speed * up_;
    return {};
  }

  Measures read(Model&, const State& state) override {
    const VectorX height = state.positions.transpose() * up_;
    Measures measures;
    const double lowest = (height - reach_).minCoeff(), ground = plane_ ? floor_.point.dot(up_) : lowest;
    if (plane_) measures.set("gap", lowest - ground);
    measures.set("floor_force", push(state).dot(up_));
    measures.set("compression", 1 - ((height + reach_).maxCoeff() - std::max(ground, lowest)) / length_);
    measures.set("impact_speed", -up_.dot(state.velocities * body_.mass) / body_.mass.sum());
    return measures;
  }

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

  /// Of the floor, or of all obstacles, on the body [N].
  Vector3 push(const State& state) const {
    if (contact_) return contact_->report(state).forces.rowwise().sum();
    Positions force = Positions::Zero(3, body_.size());
    pressing_->add_forces(state, force);
    return force.rowwise().sum();
  }

  const Body& body_;
  DropSetup setup_;
  Vector3 up_;
  VectorX reach_;      // of what touches, from each molecule [m]
  bool plane_ = true;  // whether there is a level ground
  double length_ = 0;  // along the fall, spheres included
  Floor floor_;
  const Load* pressing_ = nullptr;             // its own floor, owned by the model that was held last
  const contact::Contact* contact_ = nullptr;  // or the scene's
};

}  // namespace

std::unique_ptr<TimedExperiment> make_drop(const Body& body, const DropSetup& setup) {
  return std::make_unique<Drop>(body, setup);
}

}  // namespace elastin::lab
