#include <cmath>

#include "lab/experiment/material_numbers.h"
#include "lab/identify/measured_test.h"

namespace elastin::lab {
namespace {

void need_law(const DataTest& test, const MaterialLaw* row) {
  if (!row) test.fail("a homogeneous test needs a `law` in the material, for example neo_hookean");
}

class HomogeneousDataTest final : public MeasuredTest {
 public:
  HomogeneousDataTest(MeasuredData data, HomogeneousTest test, const Matrix3& axes)
      : MeasuredTest(std::move(data)), test_(test), axes_(axes) {}

  std::optional<Prediction> predict(const TestedMaterial& tested) override {
    auto found = homogeneous_stresses(*tested.row, tested.material, test_, data_.x, tested.changes, axes_);
    if (!found) {
      why_ = std::string("no equilibrium in the ") + name_of(test_) + " test";
      return std::nullopt;
    }
    return Prediction{std::move(found->stresses), std::move(found->slopes)};
  }

 private:
  HomogeneousTest test_;
  Matrix3 axes_;
};

class RelaxationTest final : public MeasuredTest {
 public:
  RelaxationTest(MeasuredData data, const DataTest& test, const Matrix3& axes)
      : MeasuredTest(std::move(data)), test_(test.held), ramp_(test.ramp), axes_(axes) {
    const Eigen::Index points = ramp_ > 0 ? kPoints : 1;
    strains_ = VectorX::LinSpaced(points, test.strain / static_cast<double>(points), test.strain);
  }

  std::optional<Prediction> predict(const TestedMaterial& tested) override {
    const auto values = history(*tested.row, tested.material);
    if (!values) return std::nullopt;
    Prediction result{*values, MatrixX::Zero(values->size(), static_cast<Eigen::Index>(tested.changes.size()))};
    for (std::size_t change = 0; change < tested.changes.size(); ++change) {
      const MaterialChange& by = tested.changes[change];
      for (std::size_t i = 0; i < by.materials.size(); ++i) {
        const auto other = history(*tested.row, by.materials[i]);
        if (!other) return std::nullopt;
        result.slopes.col(static_cast<Eigen::Index>(change)) += by.weights[i] * *other;
      }
    }
    return result;
  }

 private:
  static constexpr Eigen::Index kPoints = 64;

  std::optional<VectorX> history(const MaterialLaw& row, const Material& material) {
    const auto elastic = homogeneous_stresses(row, material, test_, strains_, {}, axes_);
    if (!elastic) {
      why_ = "no equilibrium at the strain that is kept";
      return std::nullopt;
    }
    VectorX values(data_.x.size());
    for (Eigen::Index i = 0; i < values.size(); ++i)
      values[i] = stress_at(elastic->stresses, *material.relaxation, data_.x[i]);
    return values;
  }

  /// Σ over the intervals of the ramp: Δσᵉ times the mean of G(t − s) over the interval, as far as t reaches.
  double stress_at(const VectorX& elastic, const Relaxation& relaxation, double time) const {
    const double interval = ramp_ / static_cast<double>(elastic.size());
    double sum = 0;
    for (Eigen::Index i = 0; i < elastic.size(); ++i) {
      const double begin = static_cast<double>(i) * interval, rise = elastic[i] - (i > 0 ? elastic[i - 1] : 0);
      if (ramp_ > 0 && !(time > begin)) break;
      const double end = std::min(time, begin + interval), done = ramp_ > 0 ? (end - begin) / interval : 1;
      double kernel = relaxation.long_term();
      for (const auto& [share, tau] : relaxation.terms) {
        const double width = (end - begin) / tau;
        const double mean = width > 1e-8 ? -std::expm1(-width) / width : 1 - width / 2;
        kernel += share * std::exp(-(time - end) / tau) * mean;
      }
      sum += rise * done * kernel;
    }
    return sum;
  }

  HomogeneousTest test_;
  double ramp_;
  Matrix3 axes_;
  VectorX strains_;
};

}  // namespace

std::unique_ptr<MeasuredTest> make_homogeneous_test(const DataTest& test, const MaterialLaw* row,
                                                    const Material& material) {
  need_law(test, row);
  const MeasuredData read = load_data(test);
  if (read.up->name == "true_stress" && (row->from_moduli || material.law->numbers.contains("bulk_modulus")))
    test.fail("true_stress is that of an incompressible law alone; give nominal_stress, or leave out bulk_modulus");
  return std::make_unique<HomogeneousDataTest>(as_strain_and_stress(test, read), *test.kind->homogeneous,
                                               axes_of_law(*row, material));
}

std::unique_ptr<MeasuredTest> make_relaxation_test(const DataTest& test, const MaterialLaw* row,
                                                   const Material& material) {
  need_law(test, row);
  if (!material.relaxation) test.fail("needs `relaxation` with its terms in the material: where the search begins");
  return std::make_unique<RelaxationTest>(as_strain_and_stress(test, load_data(test)), test,
                                          axes_of_law(*row, material));
}

std::unique_ptr<MeasuredTest> make_measured_test(const DataTest& test, const Catalog& catalog, const MaterialLaw* row,
                                                 const Material& material, const std::vector<std::string>& overrides,
                                                 const std::string& strategy) {
  if (test.kind->homogeneous) return make_homogeneous_test(test, row, material);
  if (test.kind->in_time) return make_relaxation_test(test, row, material);
  return make_specimen_test(test, catalog, overrides, strategy);
}

}  // namespace elastin::lab
