#include "lab/experiment/supported.h"

#include <algorithm>
#include <utility>

#include "elastin/core/base/dense.h"

namespace elastin::lab {
namespace {

/// Projector on the directions that both leave free.
Matrix3 free_in_both(const Matrix3& a, const Matrix3& b) {
  const Matrix3 held = (Matrix3::Identity() - a) + (Matrix3::Identity() - b);
  const SymmetricEigen3 modes = symmetric_eigen3(held);
  Matrix3 free = Matrix3::Zero();
  for (Eigen::Index k = 0; k < 3; ++k)
    if (modes.values[k] < 1e-9) free += modes.vectors.col(k) * modes.vectors.col(k).transpose();
  return free;
}

class Supported final : public StaticExperiment {
 public:
  Supported(std::unique_ptr<const StaticExperiment> inner, std::vector<Support> supports)
      : inner_(std::move(inner)), supports_(std::move(supports)) {}

  const StaticExperiment& inner() const { return *inner_; }
  std::string name() const override { return inner_->name(); }
  std::unique_ptr<StaticRig> static_rig(Model& model) const override;
  const StaticExperiment* calibration() const override { return inner_->calibration() ? this : nullptr; }
  std::optional<Vector3> axis() const override { return inner_->axis(); }
  double copies() const override { return inner_->copies(); }
  bool stiffened_by_load() const override { return inner_->stiffened_by_load(); }
  std::vector<MainMeasure> main_measures(const Material& material, const Measures& measured) const override {
    return inner_->main_measures(material, measured);
  }
  std::string remark(const Measures& measures) const override { return inner_->remark(measures); }
  bool apparent() const override { return inner_->apparent(); }
  std::string no_reference() const override { return inner_->no_reference(); }
  std::vector<std::string> notes() const override { return inner_->notes(); }
  int load_steps() const override { return inner_->load_steps(); }
  double load_factor(int step) const override { return inner_->load_factor(step); }
  ResponseMeasures response_measures() const override { return inner_->response_measures(); }
  std::optional<Identification> identification() const override { return inner_->identification(); }

 private:
  friend class SupportedRig;
  std::unique_ptr<const StaticExperiment> inner_;
  std::vector<Support> supports_;
};

class SupportedRig final : public StaticRig {
 public:
  SupportedRig(const Supported& experiment, Model& model)
      : experiment_(experiment), model_(model), inner_(experiment.inner_->static_rig(model)) {
    add();
  }

  void set_load(double factor) override { inner_->set_load(factor); }
  bool adjust(const State& state) override { return inner_->adjust(state); }
  void shape_start(Positions& positions) const override { inner_->shape_start(positions); }
  void approach(Positions& positions) const override { inner_->approach(positions); }
  double longest_step() const override { return inner_->longest_step(); }
  void set_load_rate(double rate) override { inner_->set_load_rate(rate); }
  void release() override {
    inner_->release();
    add();
  }
  Measures measure(const Start& start, const State& state, const StaticOptions& options,
                   StaticResult& solved) const override {
    return inner_->measure(start, state, options, solved);
  }
  void measure_end(const State& state, const StaticOptions& options, Measures& measures,
                   int& iterations) const override {
    inner_->measure_end(state, options, measures, iterations);
  }
  bool leaves_saddles() const override { return inner_->leaves_saddles(); }

 private:
  /// Behind the supports of the experiment, whose numbers it knows; a molecule has one alone.
  void add() {
    std::vector<std::ptrdiff_t> known(static_cast<std::size_t>(model_.body().size()), -1);
    for (std::size_t i = 0; i < model_.supports.size(); ++i)
      known[model_.supports[i].molecule] = static_cast<std::ptrdiff_t>(i);
    for (const Support& support : experiment_.supports_)
      if (const auto at = known[support.molecule]; at < 0) {
        model_.supports.push_back(support);
      } else {
        Matrix3& free = model_.supports[at].free;
        free = free_in_both(free, support.free);
      }
  }

  const Supported& experiment_;
  Model& model_;
  std::unique_ptr<StaticRig> inner_;
};

std::unique_ptr<StaticRig> Supported::static_rig(Model& model) const {
  return std::make_unique<SupportedRig>(*this, model);
}

}  // namespace

std::unique_ptr<StaticExperiment> with_supports(std::unique_ptr<const StaticExperiment> experiment,
                                                std::vector<Support> supports) {
  return std::make_unique<Supported>(std::move(experiment), std::move(supports));
}

const Experiment& without_supports(const Experiment& experiment) {
  const auto* supported = dynamic_cast<const Supported*>(&experiment);
  return supported ? supported->inner() : experiment;
}

}  // namespace elastin::lab
