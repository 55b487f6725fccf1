#include "lab/identify/measured_test.h"

#include <cmath>
#include <complex>
#include <numbers>

#include "lab/run/material_numbers.h"

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
  if (test.kind->layer) return make_layer_test(test, material);
  if (test.kind->oscillates) return make_oscillation_test(test, row, material);
  if (test.kind->in_time && test.scene)
    return make_specimen_relaxation_test(test, catalog, material, overrides, strategy);
  if (test.kind->in_time) return make_relaxation_test(test, row, material);
  return make_specimen_test(test, catalog, overrides, strategy);
}

void need_law(const DataTest& test, const MaterialLaw* row) {
  if (!row)
    test.fail(
        "a homogeneous test needs a `law` in the material, for example mooney_rivlin; a `curve` serves uniaxial "
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
  if (read.up->name == "true_stress" && !is_incompressible(*row, material))
    test.fail("true_stress is that of an incompressible law alone; give nominal_stress" +
              std::string(row->whole ? "" : ", or leave out bulk_modulus"));
  return std::make_unique<HomogeneousDataTest>(as_strain_and_stress(test, read), *test.kind->homogeneous,
                                               axes_of_law(*row, material));
}

namespace {

/// Σ over the intervals of the ramp: Δσᵉ times the mean of G(t − s) over the interval, as far as t reaches.
double relaxed(const VectorX& elastic, const Relaxation& relaxation, double ramp, double time) {
  const double interval = ramp / static_cast<double>(elastic.size());
  double sum = 0;
  for (Eigen::Index i = 0; i < elastic.size(); ++i) {
    const double begin = static_cast<double>(i) * interval, rise = elastic[i] - (i > 0 ? elastic[i - 1] : 0);
    if (ramp > 0 && !(time > begin)) break;
    const double end = std::min(time, begin + interval), done = ramp > 0 ? (end - begin) / interval : 1;
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

/// Of many times: behind the ramp each term has what it has at its end, times one exponential.
VectorX relaxed(const VectorX& elastic, const Relaxation& relaxation, double ramp, const VectorX& times) {
  std::vector<std::pair<double, double>> terms;  // stress of a term alone at the end of the ramp, and its time
  for (const auto& [share, tau] : relaxation.terms)
    terms.emplace_back(relaxed(elastic, {.terms = {{share, tau}}}, ramp, ramp) - elastic[elastic.size() - 1], tau);
  const double permanent = relaxation.long_term() * elastic[elastic.size() - 1];
  return times.unaryExpr([&](double time) {
    if (time < ramp) return relaxed(elastic, relaxation, ramp, time);
    double stress = permanent;
    for (const auto& [end, tau] : terms) stress += end * std::exp(-(time - ramp) / tau);
    return stress;
  });
}

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
    return relaxed(elastic->stresses, *material.relaxation, ramp_, data_.x);
  }

  HomogeneousTest test_;
  double ramp_;
  Matrix3 axes_;
  VectorX strains_;
};

/// Complex modulus of Prony terms over the frequency: E* = E (g₀ + Σ gᵢ iωτᵢ/(1 + iωτᵢ) + iωθ), E the slope of the law
/// at rest.                                                                          [Ferry 1980, eq. 3.26, 3.27]
class OscillationTest final : public MeasuredTest {
 public:
  OscillationTest(MeasuredData data, HomogeneousTest test, const Matrix3& axes)
      : MeasuredTest(std::move(data)), test_(test), axes_(axes) {}

  std::optional<Prediction> predict(const TestedMaterial& tested) override {
    return by_differences(tested, [&](const Trial& trial) { return moduli(*tested.row, trial.material, data_.x); });
  }
  std::optional<VectorX> line(const TestedMaterial& tested, const VectorX& along) const override {
    return moduli(*tested.row, tested.trial.material, along);
  }

 private:
  std::optional<VectorX> moduli(const MaterialLaw& row, const Material& material, const VectorX& frequencies) const {
    constexpr double small = 1e-4;
    const auto elastic = homogeneous_stresses(row, material, test_, Eigen::Vector2d(-small, small), {}, axes_);
    if (!elastic) return std::nullopt;
    const double slope = (elastic->stresses[1] - elastic->stresses[0]) / (2 * small);
    return frequencies.unaryExpr([&](double frequency) {
      const double rate = 2 * std::numbers::pi * frequency;
      std::complex<double> modulus(material.relaxation->long_term(), rate * material.relaxation->retardation);
      for (const auto& [share, tau] : material.relaxation->terms)
        modulus += share * (1. - 1. / std::complex<double>(1, rate * tau));
      return data_.up->name == "loss_tangent"
                 ? modulus.imag() / modulus.real()
                 : slope * (data_.up->name == "loss_modulus" ? modulus.imag() : modulus.real());
    });
  }

  HomogeneousTest test_;
  Matrix3 axes_;
};

/// The force of a specimen that is kept in its grips, from its equilibria on the ramp as if it were elastic.
class SpecimenRelaxationTest final : public MeasuredTest {
 public:
  SpecimenRelaxationTest(MeasuredData data, double ramp, std::unique_ptr<MeasuredTest> elastic)
      : MeasuredTest(std::move(data)), ramp_(ramp), elastic_(std::move(elastic)) {}

  std::optional<Prediction> predict(const TestedMaterial& tested) override {
    const std::optional<Prediction> elastic = elastic_->predict(tested);
    if (!elastic) {
      why_ = elastic_->why();
      return std::nullopt;
    }
    const auto relaxed_by = [&](const VectorX& forces, const Trial& trial) {
      return relaxed(forces, *trial.material.relaxation, ramp_, data_.x);
    };
    Prediction result{relaxed_by(elastic->values, tested.trial),
                      MatrixX(data_.x.size(), static_cast<Eigen::Index>(tested.changes.size()))};
    for (std::size_t change = 0; change < tested.changes.size(); ++change) {
      const auto column = static_cast<Eigen::Index>(change);
      const TrialChange& by = tested.changes[change];
      result.slopes.col(column) = relaxed_by(elastic->slopes.col(column), tested.trial);
      for (std::size_t i = 0; i < by.trials.size(); ++i)  // of its own relaxation
        result.slopes.col(column) += by.weights[i] * relaxed_by(elastic->values, by.trials[i]);
    }
    return result;
  }
  std::vector<MaterialNumber> own_numbers() const override { return elastic_->own_numbers(); }
  std::vector<std::pair<std::string, std::string>> scene_keys(const Trial& trial, bool plain) const override {
    return elastic_->scene_keys(trial, plain);
  }

 private:
  double ramp_;
  std::unique_ptr<MeasuredTest> elastic_;
};

void need_terms(const DataTest& test, const Material& material) {
  if (!material.relaxation || material.relaxation->terms.empty())
    test.fail("needs `relaxation` with its terms in the material: where the search begins");
}

}  // namespace

std::unique_ptr<MeasuredTest> make_relaxation_test(const DataTest& test, const MaterialLaw* row,
                                                   const Material& material) {
  need_law(test, row);
  need_law_alone(test, material);
  need_terms(test, material);
  return std::make_unique<RelaxationTest>(as_strain_and_stress(test, load_data(test)), test,
                                          axes_of_law(*row, material));
}

std::unique_ptr<MeasuredTest> make_oscillation_test(const DataTest& test, const MaterialLaw* row,
                                                    const Material& material) {
  need_law(test, row);
  need_law_alone(test, material);
  need_terms(test, material);
  return std::make_unique<OscillationTest>(load_data(test), test.held, axes_of_law(*row, material));
}

std::unique_ptr<MeasuredTest> make_specimen_relaxation_test(const DataTest& test, const Catalog& catalog,
                                                            const Material& material,
                                                            const std::vector<std::string>& overrides,
                                                            const std::string& strategy) {
  constexpr Eigen::Index points = 8;  // equilibria of a ramp
  need_terms(test, material);
  MeasuredData data = load_data(test);
  MeasuredData ramp = data;
  ramp.along = nullptr;
  ramp.x = test.ramp > 0 ? VectorX(VectorX::LinSpaced(points, 1. / points, 1)) : VectorX::Ones(1);
  Eigen::Index largest = 0;
  data.y.cwiseAbs().maxCoeff(&largest);
  ramp.y = data.y[largest] * ramp.x;
  ramp.lines.assign(static_cast<std::size_t>(ramp.x.size()), data.lines[largest]);
  return std::make_unique<SpecimenRelaxationTest>(
      std::move(data), test.ramp, make_specimen_test(test, std::move(ramp), catalog, overrides, strategy));
}

}  // namespace elastin::lab
