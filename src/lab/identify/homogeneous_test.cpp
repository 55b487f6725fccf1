#include <cmath>

#include "lab/experiment/material_numbers.h"
#include "lab/identify/measured_test.h"

namespace elastin::lab {
namespace {

void need_law(const DataTest& test, const MaterialLaw* row) {
  if (!row)
    test.fail(
        "a homogeneous test needs a `law` in the material, for example neo_hookean; a `curve` serves uniaxial "
        "ones alone");
}

/// What a material has beside its law is in no closed form.
void need_law_alone(const DataTest& test, const Material& material) {
  if (material.fibre || material.active)
    test.fail(std::string("a homogeneous test knows the law alone; the material's `") +
              (material.fibre ? "fibre" : "active") +
              "` would be left out: write kind: specimen with its body, or a law with fibres of its own");
}

class HomogeneousDataTest final : public MeasuredTest {
 public:
  HomogeneousDataTest(MeasuredData data, HomogeneousTest test, const Matrix3& axes)
      : MeasuredTest(std::move(data)), test_(test), axes_(axes) {}

  std::optional<Prediction> predict(const TestedMaterial& tested) override {
    auto found = homogeneous_stresses(*tested.row, tested.trial.material, test_, data_.x,
                                      material_changes(tested.changes), axes_);
    if (!found) {
      why_ = std::string("no equilibrium in the ") + name_of(test_) + " test";
      return std::nullopt;
    }
    return Prediction{std::move(found->stresses), std::move(found->slopes)};
  }

  std::optional<VectorX> line(const TestedMaterial& tested, const VectorX& along) const override {
    const auto found = homogeneous_stresses(*tested.row, tested.trial.material, test_, along, {}, axes_);
    return found ? std::optional(found->stresses) : std::nullopt;
  }

 private:
  HomogeneousTest test_;
  Matrix3 axes_;
};

/// A stress-strain curve under uniaxial stress, which is what it is.
class CurveTest final : public MeasuredTest {
 public:
  using MeasuredTest::MeasuredTest;

  std::optional<Prediction> predict(const TestedMaterial& tested) override {
    return by_differences(tested, [&](const Trial& trial) { return stresses(trial.material, data_.x); });
  }
  std::optional<VectorX> line(const TestedMaterial& tested, const VectorX& along) const override {
    return stresses(tested.trial.material, along);
  }

 private:
  static std::optional<VectorX> stresses(const Material& material, const VectorX& strains) {
    return VectorX(strains.unaryExpr([&](double strain) { return material.curve->stress(strain); }));
  }
};

class RelaxationTest final : public MeasuredTest {
 public:
  RelaxationTest(MeasuredData data, const DataTest& test, const Matrix3& axes)
      : MeasuredTest(std::move(data)), test_(test.held), ramp_(test.ramp), axes_(axes) {
    const Eigen::Index points = ramp_ > 0 ? kPoints : 1;
    strains_ = VectorX::LinSpaced(points, test.strain / static_cast<double>(points), test.strain);
  }

  std::optional<Prediction> predict(const TestedMaterial& tested) override {
    return by_differences(tested, [&](const Trial& trial) { return history(*tested.row, trial.material); });
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
  const bool of_curve = !row && material.curve && test.kind->homogeneous == HomogeneousTest::uniaxial;
  if (!of_curve) need_law(test, row);
  need_law_alone(test, material);
  const MeasuredData read = load_data(test);
  if (of_curve) {
    if (read.up->name == "true_stress") test.fail("a curve is over the section at rest: give nominal_stress");
    return std::make_unique<CurveTest>(as_strain_and_stress(test, read));
  }
  if (read.up->name == "true_stress" && (row->from_moduli || material.law->numbers.contains("bulk_modulus")))
    test.fail("true_stress is that of an incompressible law alone; give nominal_stress, or leave out bulk_modulus");
  return std::make_unique<HomogeneousDataTest>(as_strain_and_stress(test, read), *test.kind->homogeneous,
                                               axes_of_law(*row, material));
}

std::unique_ptr<MeasuredTest> make_relaxation_test(const DataTest& test, const MaterialLaw* row,
                                                   const Material& material) {
  need_law(test, row);
  need_law_alone(test, material);
  if (!material.relaxation || material.relaxation->terms.empty())
    test.fail("needs `relaxation` with its terms in the material: where the search begins");
  return std::make_unique<RelaxationTest>(as_strain_and_stress(test, load_data(test)), test,
                                          axes_of_law(*row, material));
}

}  // namespace elastin::lab
