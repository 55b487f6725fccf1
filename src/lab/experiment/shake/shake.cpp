#include <cmath>
#include <numbers>

#include "elastin/core/forces/time_function.h"
#include "elastin/core/model/share.h"
#include "lab/experiment/keys.h"
#include "lab/run/time_history_fits.h"

namespace elastin::lab {
namespace {

/// A body clamped at one end, which is moved to and fro.
struct ShakeSetup : GripSetup {
  Vector3 axis = Vector3::UnitX();       ///< from the clamped end to the far one
  std::optional<Vector3> oscillates;     ///< direction of the oscillation; none: along the axis
  Vector3 direction = Vector3::UnitX();  ///< that which it is
  double amplitude = 0;                  ///< [m]
  double frequency = 0;                  ///< [Hz]
};

const MeasureList& shake_measures() {
  using namespace dimension;
  using Role = MeasureRole;
  static const MeasureList list{
      {{"amplitude_ratio", none, "amplitude of the far end / of the shaken one, over the last periods"},
       {"phase", none, "angle by which the far end is behind", Role::none, "", "rad"},
       {"sine_misfit", none,
        "residual of the sine fitted to the far end over the last periods / all, as root mean squares"},
       {"base_displacement", length, "displacement of the shaken end", Role::none, "displacement of the shaken end", "",
        "base_way"},
       {"far_displacement", length, "mean displacement of the far end", Role::none, "displacement of the far end", "",
        "far_way"}},
      {{"time", "far_displacement"}}};
  return list;
}

class Shake final : public TimedExperiment {
 public:
  Shake(const Body& body, const ShakeSetup& setup) : body_(body), setup_(setup) {
    Ends ends(body, setup.axis, setup);
    findings_ = std::move(ends.findings);
    base_ = std::move(ends.fixed), far_ = std::move(ends.loaded);
  }

  std::string name() const override { return "shake"; }
  MeasureList measures() const override { return shake_measures(); }
  std::unique_ptr<TimedRig> timed_rig(Model& model) const override;

  /// Over the last half of the time, in whole periods.
  void read_history(const std::vector<CurvePoint>& history, Measures& measures) const override {
    const double period = 1 / setup_.frequency, end = history.back().time;
    const double periods = std::floor(end / 2 / period);
    if (periods < 1) return;
    const auto ratio_since = [&](double from, double to) {
      Series far{VectorX(history.size()), VectorX(history.size())};
      Eigen::Index count = 0;
      for (const CurvePoint& row : history)
        if (row.time > from && row.time <= to * (1 + 1e-12)) {
          far.times[count] = row.time;
          far.values[count++] = row.measures.get("far_displacement");
        }
      far.times.conservativeResize(count);
      far.values.conservativeResize(count);
      return count < 8 ? VibrationFit{} : fit_sine(far, 2 * std::numbers::pi * setup_.frequency);
    };
    const VibrationFit fit = ratio_since(end - periods * period, end);
    if (fit.circular_frequency == 0) return;
    const double ratio = std::hypot(fit.cosine, fit.sine) / std::abs(setup_.amplitude);
    measures.set("amplitude_ratio", ratio);
    measures.set("phase", std::atan2(-fit.cosine, fit.sine * (setup_.amplitude > 0 ? 1 : -1)));
    measures.set("sine_misfit", fit.misfit);
  }

  std::vector<MainMeasure> main_measures(const Material&, const Measures&) const override {
    return {{"amplitude_ratio"}, {"phase"}};
  }

  std::string remark(const Measures& measures) const override {
    if (!std::isfinite(measures.get("amplitude_ratio")))
      return "too short: half of the duration has no whole period with eight frames";
    return measures.get("sine_misfit") < 0.02
               ? ""
               : "not steady yet: the far end does not follow one sine over the last half of the time";
  }

 private:
  friend class ShakeRig;
  const Body& body_;
  ShakeSetup setup_;
  Face base_, far_;
};

class ShakeRig final : public TimedRig {
 public:
  ShakeRig(const Shake& experiment, Model& model) : experiment_(experiment), setup_(experiment.setup_), model_(model) {
    for (const int molecule : experiment_.base_.molecules) model.supports.push_back({molecule, Matrix3::Zero()});
  }

  StaticResult start(State& state, const StaticOptions& options) override {
    StaticResult result;
    if (any_over(model_.body(), !model_.load_forces(state).isZero(0))) result = solve_static(model_, state, options);
    middle_ = middle_of(model_.body(), experiment_.far_, state.positions);
    model_.drive = [this](double time, std::vector<Support>& supports) {
      const TimeFunction wave = TimeFunction::sine(setup_.frequency);
      for (Support& support : supports) {
        support.displacement = setup_.amplitude * wave.value(time) * setup_.direction;
        support.velocity = setup_.amplitude * wave.rate(time) * setup_.direction;
      }
    };
    return result;
  }

  Measures read(const State& state) const override {
    Measures measures;
    measures.set("base_displacement", setup_.amplitude * TimeFunction::sine(setup_.frequency).value(state.time));
    measures.set("far_displacement",
                 setup_.direction.dot(middle_of(model_.body(), experiment_.far_, state.positions) - middle_));
    return measures;
  }

 private:
  const Shake& experiment_;
  const ShakeSetup& setup_;
  Model& model_;
  Vector3 middle_ = Vector3::Zero();
};

std::unique_ptr<TimedRig> Shake::timed_rig(Model& model) const { return std::make_unique<ShakeRig>(*this, model); }

}  // namespace

ExperimentInfo shake_row() {
  using S = ShakeSetup;
  const std::vector<Key<S>> amplitude =
      travel_keys("amplitude", &S::amplitude, &S::axis, "amplitude of the clamped end");
  return with_keys(
      {.name = "shake",
       .summary = "the clamped end of a body oscillates: amplitude ratio and phase of the far end",
       .in_time = true,
       .of_shares = true,
       .measures = shake_measures()},
      Keys<S>{axis_key(&S::axis, "from the clamped end to the far one"),
              key::direction("direction", &S::oscillates, "direction of the oscillation").otherwise("`axis`"),
              one_of<S>("key 'amplitude' is missing", amplitude).naming_the_second(),
              key::quantity("frequency", &S::frequency, {0, 0, -1}, "frequency of the oscillation", kPositive)
                  .needed()
                  .then([](const Reader& value, S& setup) { value.note(TimeFunction::sine(setup.frequency)); }),
              grip_keys<S>()},
      [](const ExperimentContext& context, S setup) {
        setup.direction = setup.oscillates.value_or(setup.axis);
        return std::make_unique<Shake>(context.body, setup);
      });
}

}  // namespace elastin::lab
