#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "elastin/core/solve/vibrations.h"
#include "lab/experiment/keys.h"

namespace elastin::lab {
namespace {

const MeasureList& vibration_measures() {
  using namespace dimension;
  using Role = MeasureRole;
  constexpr Dimension rate{0, 0, -1};
  static const MeasureList list{
      {"rigid_motions", none, "number of motions of the whole body that supports leave free"},
      {"frequency_1", rate, "lowest natural frequency about the state under the scene's loads", Role::none, "", "Hz"},
      {"frequency_2", rate, "natural frequency number 2", Role::none, "", "Hz"},
      {"frequency_3", rate, "natural frequency number 3", Role::none, "", "Hz"},
      {"frequency_4", rate, "natural frequency number 4", Role::none, "", "Hz"},
      {"frequency_5", rate, "natural frequency number 5", Role::none, "", "Hz"},
      {"frequency_6", rate, "natural frequency number 6", Role::none, "", "Hz"},
      {"frequency_7", rate, "natural frequency number 7", Role::none, "", "Hz"},
      {"frequency_8", rate, "natural frequency number 8", Role::none, "", "Hz"},
      {"frequency_9", rate, "natural frequency number 9", Role::none, "", "Hz"},
      {"frequency_10", rate, "natural frequency number 10", Role::none, "", "Hz"}};
  return list;
}

/// Part (0 … 1) of what relaxes by which the storage modulus at a frequency [Hz] is above the long-term modulus:
/// Σ gᵢ x²/(1 + x²) / Σ gᵢ, x = ωτᵢ.
double stored_part(const Relaxation& relaxation, double frequency) {
  double stored = 0, all = 0;
  for (const auto& [share, time] : relaxation.terms) {
    const double square = std::pow(2 * std::numbers::pi * frequency * time, 2);
    stored += share * square / (1 + square);
    all += share;
  }
  return stored / all;
}

/// The frequency whose own storage modulus it has: f² = f₀² + (f_g² − f₀²) s(f), between those of the long-term moduli
/// and of the instantaneous ones. There is one, since s is concave in f².
double with_storage_modulus(const Relaxation& relaxation, double long_term, double instantaneous) {
  double low = long_term, high = instantaneous;
  if (!(low > 0 && low < high)) return instantaneous;
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2, stiff = std::lerp(long_term * long_term, instantaneous * instantaneous,
                                                              stored_part(relaxation, middle));
    (middle * middle < stiff ? low : high) = middle;
  }
  return high;
}

/// Natural frequencies of a body held as an experiment at rest says, or free, about its equilibrium under the scene's
/// own loads and, if `loaded`, the fixture's. At rest: it takes no time. What relaxes has at each frequency the storage
/// modulus of that frequency.
class Vibration final : public StaticExperiment {
 public:
  Vibration(std::unique_ptr<const StaticExperiment> fixture, int count, bool loaded, const Material& material)
      : fixture_(std::move(fixture)), count_(count), loaded_(loaded), relaxation_(material.relaxation) {
    if (relaxation_ && relaxation_->terms.empty()) relaxation_.reset();
  }

  std::string name() const override { return "vibration"; }
  MeasureList measures() const override { return vibration_measures(); }
  std::unique_ptr<StaticRig> make_rig(Model& model) const override;
  /// The fixture, which knows no further supports.
  const StaticExperiment* calibration() const override { return further_supports().empty() ? fixture_.get() : this; }
  bool stiffened_by_load() const override { return loaded_; }
  bool leaves_out_rigid_motions() const override { return true; }
  int load_steps() const override { return loaded_ ? fixture_->load_steps() : 1; }
  double load_factor(int step) const override { return loaded_ ? fixture_->load_factor(step) : 1; }

  std::vector<MainMeasure> main_measures(const Material&, const Measures&) const override {
    return {{"frequency_1"}, {"frequency_2"}, {"frequency_3"}, {"frequency_4"}};
  }

  std::vector<std::string> notes() const override {
    if (!relaxation_) return {};
    return {"frequencies of `prony:` strategies are those of the storage modulus at each frequency, without damping"};
  }

 private:
  friend class VibrationRig;
  std::unique_ptr<const StaticExperiment> fixture_;
  int count_;
  bool loaded_;                           ///< about the equilibrium under the fixture's load
  std::optional<Relaxation> relaxation_;  ///< with terms
};

class VibrationRig final : public StaticRig {
 public:
  /// What the fixture holds is held; its load stays away until set_load, if it counts at all.
  VibrationRig(const Vibration& experiment, Model& model) : experiment_(experiment), model_(model) {
    if (!experiment_.fixture_) return;
    fixture_ = experiment_.fixture_->static_rig(model);
    fixture_->set_load(0);
  }

  void set_load(double factor) override {
    if (experiment_.loaded_) fixture_->set_load(factor);
  }
  double longest_step() const override { return experiment_.loaded_ ? fixture_->longest_step() : 1; }

  Measures measure(const Start&, const State& state, const StaticOptions& options,
                   StaticResult& solved) const override {
    Vibrations& found = found_ = find_vibrations(model_, state, experiment_.count_, 1e-5, options.stop);
    if (experiment_.relaxation_ && !model_.history().empty() && found.outcome == Outcome::converged) {
      model_.begin_step(state, std::numeric_limits<double>::infinity());
      const Vibrations relaxed = find_vibrations(model_, state, experiment_.count_, 1e-5, options.stop);
      model_.begin_step(state, state.time);
      found.iterations += relaxed.iterations;
      found.outcome = relaxed.outcome, found.cause = relaxed.cause;
      for (Eigen::Index k = 0; k < std::min(found.frequencies.size(), relaxed.frequencies.size()); ++k)
        found.frequencies[k] =
            with_storage_modulus(*experiment_.relaxation_, relaxed.frequencies[k], found.frequencies[k]);
    }
    solved.linear_iterations += found.iterations;
    solved.residual = 0;  // of a state without loads it would be that of rounding
    solved.outcome = found.outcome;
    solved.cause = found.cause;
    if (found.outcome == Outcome::converged && found.frequencies.hasNaN()) {
      solved.outcome = Outcome::diverged;
      solved.cause = "the state is no stable equilibrium: a vibration has negative stiffness";
    }
    Measures measures;
    measures.set("rigid_motions", found.rigid_motions);
    for (Eigen::Index k = 0; k < found.frequencies.size(); ++k)
      measures.set("frequency_" + std::to_string(k + 1), found.frequencies[k]);
    return measures;
  }
  const Vibrations* vibrations() const override { return &found_; }

 private:
  const Vibration& experiment_;
  Model& model_;
  std::unique_ptr<StaticRig> fixture_;  // null: the body is free
  mutable Vibrations found_;            // when it measured last
};

std::unique_ptr<StaticRig> Vibration::make_rig(Model& model) const {
  return std::make_unique<VibrationRig>(*this, model);
}

}  // namespace

ExperimentInfo vibration_row() {
  struct S {
    std::unique_ptr<const StaticExperiment> fixture;
    int count = 6;
    bool loaded = false;
    const ExperimentContext* context = nullptr;
  };
  return with_keys(
      {.name = "vibration",
       .summary = "natural frequencies and shapes of a body, free or fixed by a fixture; at rest",
       .measures = vibration_measures()},
      Keys<S>{fixture_key<S>("how the body is fixed").otherwise("free body"),
              key::choice("load", &S::loaded, {{"removed", false}, {"applied", true}},
                          "whether the body vibrates about rest, or about its equilibrium under the fixture's load")
                  .refused_for([](const S& setup) {
                    return setup.loaded && !setup.fixture ? "there is no load: key 'fixture' is missing" : "";
                  }),
              key::whole("count", &S::count, 1, 10, "number of frequencies")},
      [](const ExperimentContext& context, S setup) {
        return std::make_unique<Vibration>(std::move(setup.fixture), setup.count, setup.loaded, context.material);
      });
}

}  // namespace elastin::lab
