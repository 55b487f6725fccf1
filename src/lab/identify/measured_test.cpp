#include "lab/identify/measured_test.h"

namespace elastin::lab {

std::optional<Prediction> by_differences(const TestedMaterial& tested,
                                         const std::function<std::optional<VectorX>(const Trial&)>& values_of) {
  const std::optional<VectorX> values = values_of(tested.trial);
  if (!values) return std::nullopt;
  Prediction result{*values, MatrixX::Zero(values->size(), static_cast<Eigen::Index>(tested.changes.size()))};
  for (std::size_t change = 0; change < tested.changes.size(); ++change) {
    const TrialChange& by = tested.changes[change];
    for (std::size_t i = 0; i < by.trials.size(); ++i) {
      const std::optional<VectorX> other = values_of(by.trials[i]);
      if (!other) return std::nullopt;
      result.slopes.col(static_cast<Eigen::Index>(change)) += by.weights[i] * *other;
    }
  }
  return result;
}

std::unique_ptr<MeasuredTest> make_measured_test(const DataTest& test, const Catalog& catalog, const MaterialLaw* row,
                                                 const Material& material, const std::vector<std::string>& overrides,
                                                 const std::string& strategy) {
  if (test.kind->homogeneous) return make_homogeneous_test(test, row, material);
  if (test.kind->in_time && test.scene)
    return make_specimen_relaxation_test(test, catalog, material, overrides, strategy);
  if (test.kind->in_time) return make_relaxation_test(test, row, material);
  return make_specimen_test(test, catalog, overrides, strategy);
}

}  // namespace elastin::lab
