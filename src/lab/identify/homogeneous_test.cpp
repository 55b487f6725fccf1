
#include "lab/identify/measured_test.h"
#include "lab/run/material_numbers.h"

namespace elastin::lab {

void need_law(const DataTest& test, const MaterialLaw* row) {
  if (!row)
    test.fail(
        "a homogeneous test needs a `law` in the material, for example neo_hookean; a `curve` serves uniaxial "
        "ones alone");
}

/// A closed form covers the law of a material only.
void need_law_alone(const DataTest& test, const Material& material) {
  if (material.fibre || material.active)
    test.fail(std::string("a homogeneous test knows the law alone; the material's `") +
              (material.fibre ? "fibre" : "active") +
              "` would be left out: write kind: specimen with its body, or a law with fibres of its own");
}

namespace {

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

}  // namespace elastin::lab
