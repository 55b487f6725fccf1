#include <algorithm>
#include <cmath>
#include <limits>

#include "elastin/forces/floor.h"
#include "experiment/motion.h"

namespace elastin {
namespace {

class Drop final : public TimedExperiment {
 public:
  Drop(const Body& body, const DropSetup& setup) : body_(body), setup_(setup), up_(-setup.direction.normalized()) {
    const VectorX height = body.rest.transpose() * up_;
    length_ = height.maxCoeff() - height.minCoeff() + body.radius.maxCoeff() + body.radius.minCoeff();
    floor_.normal = up_;
    floor_.point = ((height - body.radius).minCoeff() - setup.height) * up_;
    floor_.stiffness = setup.stiffness;
    floor_.damping = setup.damping;
  }

  std::string name() const override { return "drop"; }
  Experiment* at_rest() override { return nullptr; }

  void hold(Model& model) override {
    auto floor = make_floor(body_, floor_);
    contact_ = floor.get();
    model.add(std::move(floor));
    if (floor_.damping > 0) model.add(make_floor_damping(body_, floor_));
    if (setup_.gravity != 0) model.add(make_gravity(body_, -setup_.gravity * up_));
  }

  StaticResult start(Model&, State& state, const StaticOptions&) override {
    state.velocities.colwise() -= setup_.speed * up_;
    return {};
  }

  Measures read(Model&, const State& state) override {
    const VectorX height = state.positions.transpose() * up_;
    Positions force = Positions::Zero(3, body_.size());
    contact_->add_forces(state, force);
    Measures measures;
    const double ground = floor_.point.dot(up_);
    measures.set("gap", (height - body_.radius).minCoeff() - ground);
    measures.set("floor_force", force.rowwise().sum().dot(up_));
    const double now = (height + body_.radius).maxCoeff() - std::max(ground, (height - body_.radius).minCoeff());
    measures.set("compression", 1 - now / length_);
    measures.set("impact_speed", -up_.dot(state.velocities * body_.mass) / body_.mass.sum());
    return measures;
  }

  /// The first contact: from the gap's fall below zero to its rise above.
  void read_course(const std::vector<CurvePoint>& rows, Measures& measures) const override {
    const auto gap = [&](std::size_t i) { return rows[i].measures.get("gap"); };
    const auto crossing = [&](std::size_t i) {  // between frames i - 1 and i
      return rows[i - 1].time + (rows[i].time - rows[i - 1].time) * gap(i - 1) / (gap(i - 1) - gap(i));
    };
    std::size_t first = 1;
    while (first < rows.size() && !(gap(first) < 0)) ++first;
    if (first == rows.size()) return;
    std::size_t last = first;
    double deepest = 0, force = 0;
    for (; last < rows.size() && gap(last) < 0; ++last) {
      deepest = std::max(deepest, rows[last].measures.get("compression"));
      force = std::max(force, rows[last].measures.get("floor_force"));
    }
    measures.set("compression", deepest);
    measures.set("floor_force", force);
    const double touched = gap(first - 1) > 0 ? crossing(first) : rows[first - 1].time;
    const CurvePoint& before = rows[first - 1];
    const double impact = before.measures.get("impact_speed") + setup_.gravity * (touched - before.time);
    measures.set("impact_speed", impact);
    if (last == rows.size()) return;  // it has not left
    const double left = crossing(last);
    const double rebound = -rows[last].measures.get("impact_speed") + setup_.gravity * (rows[last].time - left);
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
  const Body& body_;
  DropSetup setup_;
  Vector3 up_;
  double length_ = 0;  // along the fall, spheres included
  Floor floor_;
  const Load* contact_ = nullptr;  // owned by the model that was held last
};

}  // namespace

std::unique_ptr<TimedExperiment> make_drop(const Body& body, const DropSetup& setup) {
  return std::make_unique<Drop>(body, setup);
}

}  // namespace elastin
