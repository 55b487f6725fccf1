#include "lab/experiment/parachute/parachute.h"

#include <algorithm>
#include <cmath>

#include "core/shapes/surfaces.h"
#include "elastin/core/base/error.h"
#include "lab/experiment/keys.h"

namespace elastin::lab {
namespace {

const MeasureList& parachute_measures() {
  using namespace dimension;
  static const MeasureList list{
      {{"line_force", force, "force of all lines on the load, against the fall"},
       {"largest_line_force", force, "the opening force: the largest line force of all frames"},
       {"opening_time", dimension::time, "time until the open area first has its largest value"},
       {"open_area", area, "area of the canopy as the load sees it, along the fall"},
       {"open_part", none, "open area / area of the canopy at rest"},
       {"fall_speed", velocity, "speed of the load"},
       {"drag_balance", none, "drag of the air along the fall / weight - 1: 0 at the terminal speed"}},
      {{"time", "fall_speed"}}};
  return list;
}

class Parachute final : public TimedExperiment {
 public:
  Parachute(const Body& body, const ParachuteSetup& setup)
      : body_(body), setup_(setup), down_(setup.direction.normalized()), load_(body.size() - 1) {
    if (body.cables.empty()) throw InputError("a parachute needs a load on lines: give the body key 'lines'");
    for (const auto& triangle : body.triangles) rest_area_ += area_vector(body.rest, triangle).norm();
  }

  std::string name() const override { return "parachute"; }
  MeasureList measures() const override { return parachute_measures(); }
  std::unique_ptr<TimedRig> timed_rig(Model& model) const override;
  bool stiffened_by_load() const override { return true; }

  void read_history(const std::vector<CurvePoint>& history, Measures& measures) const override {
    const auto largest = [&](std::string_view name, double low, double high) {
      const CurvePoint* most = nullptr;
      for (const CurvePoint& row : history)
        if (row.time >= low && row.time <= high && (!most || row.measures.get(name) > most->measures.get(name)))
          most = &row;
      return most;
    };
    if (history.size() < 2) return;
    measures.set("largest_line_force", largest("line_force", 0, history.back().time)->measures.get("line_force"));
    // The flat canopy at the start is no open one: from the smallest area on.
    const auto least = std::min_element(history.begin(), history.end(), [](const CurvePoint& a, const CurvePoint& b) {
      return a.measures.get("open_area") < b.measures.get("open_area");
    });
    measures.set("opening_time", largest("open_area", least->time, history.back().time)->time);
  }

  std::vector<MainMeasure> main_measures(const Material&, const Measures&) const override {
    return {{"largest_line_force"}, {"fall_speed"}, {"open_part"}};
  }

 private:
  friend class ParachuteRig;
  const Body& body_;
  ParachuteSetup setup_;
  Vector3 down_;
  int load_;
  double rest_area_ = 0;
};

class ParachuteRig final : public TimedRig {
 public:
  ParachuteRig(const Parachute& experiment, Model& model)
      : experiment_(experiment), setup_(experiment.setup_), body_(experiment.body_), model_(model) {
    scene_loads_ = static_cast<int>(model.loads().size());
    if (setup_.gravity > 0) model.add(make_gravity(body_, setup_.gravity * experiment_.down_));
  }

  StaticResult start(State& state, const StaticOptions&) override {
    state.velocities.colwise() += setup_.speed * experiment_.down_;
    return {};
  }

  Measures read(const State& state) const override {
    double pull = 0, area = 0;
    for (const Cable& cable : body_.cables) {
      const auto& [end, load] = body_.connections.ends[cable.connection];
      const Vector3 d = state.positions.col(end) - state.positions.col(load);
      const double length = d.norm(), rest = body_.connections.rest_length[cable.connection];
      if (length > rest) pull -= cable.stiffness * (length - rest) / rest * d.dot(experiment_.down_) / length;
    }
    // Folds that lie over each other count as what they hide: the sum of the area vectors is that of the outline.
    for (const auto& triangle : body_.triangles) area += area_vector(state.positions, triangle).dot(experiment_.down_);
    Positions drag = Positions::Zero(3, body_.size());
    for (int i = 0; i < scene_loads_; ++i) model_.loads()[i]->add_forces(state, drag);
    Measures measures;
    measures.set("line_force", pull);
    measures.set("open_area", std::abs(area));
    measures.set("open_part", std::abs(area) / experiment_.rest_area_);
    measures.set("fall_speed", state.velocities.col(experiment_.load_).dot(experiment_.down_));
    if (setup_.gravity > 0)
      measures.set("drag_balance",
                   -drag.rowwise().sum().dot(experiment_.down_) / (body_.mass.sum() * setup_.gravity) - 1);
    return measures;
  }

 private:
  const Parachute& experiment_;
  const ParachuteSetup& setup_;
  const Body& body_;
  Model& model_;
  int scene_loads_;  // loads of the scene come first in the model
};

std::unique_ptr<TimedRig> Parachute::timed_rig(Model& model) const {
  return std::make_unique<ParachuteRig>(*this, model);
}

}  // namespace

std::unique_ptr<TimedExperiment> make_parachute(const Body& body, const ParachuteSetup& setup) {
  return std::make_unique<Parachute>(body, setup);
}

ExperimentInfo parachute_row() {
  using S = ParachuteSetup;
  return with_keys(
      {.name = "parachute",
       .summary = "a canopy with a load on `lines` falls through air: how it opens, largest force in a line",
       .in_time = true,
       .measures = parachute_measures()},
      Keys<S>{
          key::direction("direction", &S::direction, "direction of the fall"),
          key::quantity("gravity", &S::gravity, dimension::acceleration, "acceleration of the fall", kNotNegative),
          key::quantity("speed", &S::speed, dimension::velocity, "speed along `direction` at time 0", kNotNegative)},
      [](const ExperimentContext& context, const S& setup) { return make_parachute(context.body, setup); });
}

}  // namespace elastin::lab
