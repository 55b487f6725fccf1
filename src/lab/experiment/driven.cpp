#include "lab/experiment/driven.h"

#include "elastin/core/model/share.h"
#include "elastin/core/solve/homogenisation.h"

namespace elastin::lab {

class DrivenRig final : public StaticRig {
 public:
  DrivenRig(const Driven& driven, Model& model) : driven_(driven), held_{model} {
    for (const Driven::Fixed& fixed : driven.fixed_)
      model.supports.push_back({fixed.molecule, fixed.free, Vector3::Zero()});
  }

  void set_load(double factor) override {
    held_.factor = factor;
    for (std::size_t i = 0; i < driven_.fixed_.size(); ++i)
      held_.model.supports[i].displacement = driven_.displacement(i, factor);
  }

  double longest_step() const override { return driven_.longest_step(); }

  void set_load_rate(double rate) override {
    for (std::size_t i = 0; i < driven_.fixed_.size(); ++i)
      held_.model.supports[i].velocity = rate * driven_.displacement_slope(i, held_.factor);
  }

  void release(const State& /*loaded*/) override {
    const auto first = driven_.first_released();
    if (!first) return;
    held_.model.release_supports(*first, driven_.fixed_.size());
    held_.released = true;
  }

  Measures measure(const Start& start, const State& state, const StaticOptions& options,
                   StaticResult& solved) const override {
    return driven_.measure(held_, start, state, options, solved);
  }

 private:
  const Driven& driven_;
  Driven::Held held_;
};

std::unique_ptr<StaticRig> Driven::make_rig(Model& model) const { return std::make_unique<DrivenRig>(*this, model); }

void Driven::fix_fully(const std::vector<int>& molecules) {
  for (const int molecule : molecules) fixed_.push_back({molecule, Matrix3::Zero()});
}

Matrix3 Driven::virial(const Positions& pull, const Positions& positions) const {
  std::vector<int> molecules;
  for (const Fixed& fixed : fixed_) molecules.push_back(fixed.molecule);
  const Vector3 middle = vector_sum_over(body_, Vector3(positions.leftCols(owned_molecules(body_)).rowwise().sum())) /
                         static_cast<double>(molecules_of_whole(body_));
  Matrix3 sum = elastin::virial(pull, molecules, positions, middle);
  sum_over(body_, {sum.data(), 9});
  return sum;
}

}  // namespace elastin::lab
