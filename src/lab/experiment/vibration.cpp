#include "elastin/core/solve/vibrations.h"
#include "lab/experiment/motion.h"

namespace elastin::lab {
namespace {

class Vibration final : public Experiment {
 public:
  Vibration(std::unique_ptr<Experiment> fixture, int count) : fixture_(std::move(fixture)), count_(count) {}

  std::string name() const override { return "vibration"; }
  int load_steps() const override { return 1; }
  Experiment* at_rest() override { return fixture_.get(); }

  /// The hold's own load stays away: what it holds is held.
  void set_up(Model& model) override {
    if (!fixture_) return;
    fixture_->set_up(model);
    fixture_->set_load(model, 0);
  }
  void set_load(Model&, double) override {}

  Measures measure(Model& model, const Start&, const State& state, const StaticOptions&,
                   StaticResult& solved) const override {
    const Vibrations found = find_vibrations(model, state, count_);
    solved.linear_iterations += found.iterations;
    solved.residual = 0;  // of a state without loads it would be that of rounding
    solved.outcome = found.outcome;
    solved.cause = found.cause;
    Measures measures;
    measures.set("rigid_motions", found.rigid_motions);
    for (Eigen::Index k = 0; k < found.frequencies.size(); ++k)
      measures.set("frequency_" + std::to_string(k + 1), found.frequencies[k]);
    return measures;
  }

  std::vector<MainMeasure> main_measures(const Material&, const Measures&) const override {
    return {{"frequency_1"}, {"frequency_2"}, {"frequency_3"}, {"frequency_4"}};
  }

 private:
  std::unique_ptr<Experiment> fixture_;
  int count_;
};

}  // namespace

std::unique_ptr<Experiment> make_vibration(const Body&, std::unique_ptr<Experiment> fixture, int count) {
  return std::make_unique<Vibration>(std::move(fixture), count);
}

}  // namespace elastin::lab
