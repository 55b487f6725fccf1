#include "lab/identify/layer.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <utility>

#include "core/base/dense.h"
#include "lab/identify/measured_test.h"

namespace elastin::lab {
namespace {

constexpr double kWidest = 8;    // contact radius over thickness
constexpr int kRadii = 120;      // of the table
constexpr int kPoints = 32;      // of the contact radius, Gauss's
constexpr int kWaves = 240;      // of the kernel's integral
constexpr double kLongest = 30;  // wave number times thickness where the kernel has gone

/// 1 − M(η), by which a layer yields less than a half-space to waves of this number times thickness.
double kernel(double wave, LayerBottom bottom, double nu) {
  if (wave > 300) return 0;
  const double sinh2 = std::sinh(2 * wave), cosh2 = std::cosh(2 * wave);
  if (bottom == LayerBottom::free) return 1 - (cosh2 - 1) / (sinh2 + 2 * wave);
  const double k = 3 - 4 * nu;
  return 1 - (k * sinh2 - 2 * wave) / (k * cosh2 + 2 * wave * wave + 5 - 12 * nu + 8 * nu * nu);
}

/// Gauss's points and weights from 0 to an end.                                          [Golub & Welsch 1969]
std::pair<VectorX, VectorX> gauss_points(int count, double end) {
  MatrixX recurrence = MatrixX::Zero(count, count);
  for (int i = 1; i < count; ++i) recurrence(i, i - 1) = recurrence(i - 1, i) = i / std::sqrt(4. * i * i - 1);
  const Eigen::SelfAdjointEigenSolver<MatrixX> solver(recurrence);
  return {end / 2 * (solver.eigenvalues().array() + 1).matrix(),
          end * solver.eigenvectors().row(0).transpose().cwiseAbs2()};
}

}  // namespace

IndentedLayer::IndentedLayer(Indenter indenter, double size, double thickness, LayerBottom bottom,
                             double poissons_ratio)
    : indenter_(indenter), size_(size), thickness_(thickness) {
  if (!std::isfinite(thickness)) return;
  const auto [places, weights] = gauss_points(kPoints, 1);
  const auto [waves, widths] = gauss_points(kWaves, kLongest);
  VectorX reduced(kWaves);
  for (int i = 0; i < kWaves; ++i) reduced[i] = widths[i] * kernel(waves[i], bottom, poissons_ratio);
  depths_.resize(kRadii + 1), ratios_.resize(kRadii + 1);
  depths_[0] = 0, ratios_[0] = 1;
  for (int step = 1; step <= kRadii; ++step) {
    // φ(x) − (2/π) ∫ φ(t) K(x, t) dt = S(x) over x = 0 … 1 of the contact radius a, K = κ ∫ (1 − M(η)) cos(κ η x)
    // cos(κ η t) dη with κ = a / thickness; S = 1 of a depth, and what the indenter's shape takes from it.
    const double radius = kWidest * step / kRadii;
    MatrixX cosines(kPoints + 1, kWaves);  // the last row is at the rim
    for (int wave = 0; wave < kWaves; ++wave)
      for (int i = 0; i <= kPoints; ++i)
        cosines(i, wave) = std::cos(radius * waves[wave] * (i < kPoints ? places[i] : 1));
    const MatrixX coupling = 2 * radius / std::numbers::pi * cosines * reduced.asDiagonal() *
                             cosines.topRows(kPoints).transpose() * weights.asDiagonal();
    MatrixX shapes(kPoints, 2);
    shapes.col(0).setOnes();
    if (indenter == Indenter::sphere) shapes.col(1) = places.cwiseAbs2();
    if (indenter == Indenter::cone) shapes.col(1) = std::numbers::pi / 2 * places;
    if (indenter == Indenter::flat) shapes.col(1).setZero();
    const MatrixX found =
        (MatrixX::Identity(kPoints, kPoints) - coupling.topRows(kPoints)).partialPivLu().solve(shapes);
    const double rim = indenter == Indenter::cone ? std::numbers::pi / 2 : 1;
    const Eigen::RowVectorXd at_rim = Eigen::RowVector2d(1, rim) + coupling.row(kPoints) * found;
    const Eigen::RowVectorXd sums = weights.transpose() * found;
    // No pressure at the rim: depth = shape's amount times at_rim[1] / at_rim[0]; amounts are a² / R and a / tan α.
    if (indenter == Indenter::flat) {
      depths_[step] = radius, ratios_[step] = sums[0];
      continue;
    }
    const double depth = at_rim[1] / at_rim[0], force = depth * sums[0] - sums[1];
    if (indenter == Indenter::sphere) {  // over (2/3) a δ at the same depth, where a² = R δ
      depths_[step] = radius * std::sqrt(depth);
      ratios_[step] = force / (2. / 3 * std::pow(depth, 1.5));
    } else {  // over δ² tan α / π
      depths_[step] = radius * depth;
      ratios_[step] = force / (depth * depth / std::numbers::pi);
    }
  }
}

double IndentedLayer::half_space(double depth) const {
  switch (indenter_) {
    case Indenter::sphere:
      return 4. / 3 * std::sqrt(size_) * std::pow(depth, 1.5);
    case Indenter::cone:
      return 2 / std::numbers::pi * depth * depth * std::tan(size_);
    case Indenter::flat:
      return 2 * size_ * depth;
  }
  return 0;
}

double IndentedLayer::force(double depth) const {
  if (!(depth > 0)) return 0;
  if (depths_.size() == 0) return half_space(depth);
  const double reduced = indenter_ == Indenter::sphere ? std::sqrt(size_ * depth) / thickness_
                         : indenter_ == Indenter::cone ? depth * std::tan(size_) / thickness_
                                                       : size_ / thickness_;
  const auto end = std::upper_bound(depths_.begin(), depths_.end(), reduced);
  if (end == depths_.end()) return std::numeric_limits<double>::quiet_NaN();
  // A parabola of logarithms through three points of the table.
  const Eigen::Index last = std::clamp<Eigen::Index>(end - depths_.begin(), 1, depths_.size() - 2) + 1, from = last - 2;
  double logarithm = 0;
  for (Eigen::Index i = from; i <= last; ++i) {
    double share = 1;
    for (Eigen::Index j = from; j <= last; ++j)
      if (j != i) share *= (reduced - depths_[j]) / (depths_[i] - depths_[j]);
    logarithm += share * std::log(ratios_[i]);
  }
  return half_space(depth) * std::exp(logarithm);
}

double IndentedLayer::force(double depth, double adhesion, bool drawn) const {
  if (!(adhesion > 0)) return force(depth);
  // δ = a²/R − √(2π w a), F = 4 a³/(3 R) − √(8π w a³) over the modulus; the least δ is where (8/π) a³ = w R².
  constexpr double pi = std::numbers::pi;
  const double least = std::cbrt(pi * adhesion * size_ * size_ / 8);
  const auto reached = [&](double a) { return a * a / size_ - std::sqrt(2 * pi * adhesion * a); };
  if (depth < (drawn ? reached(least) : 0)) return 0;
  double a = std::max(2 * least, std::sqrt(size_ * std::max(depth, 0.)) + 2 * least);
  for (int step = 0; step < 60; ++step) {  // from above, where δ is convex: it falls all the way
    const double change = (reached(a) - depth) / (2 * a / size_ - std::sqrt(pi * adhesion / (2 * a)));
    a = std::max(a - change, least);
    if (std::abs(change) < 1e-14 * a) break;
  }
  return 4 * a * a * a / (3 * size_) - std::sqrt(8 * pi * adhesion * a * a * a);
}

namespace {

class LayerTest final : public MeasuredTest {
 public:
  LayerTest(MeasuredData data, const DataTest& test, const Material& material)
      : MeasuredTest(std::move(data)), stated_(test) {
    std::string note = test.kind->in_time ? "E, nu and relaxation alone count, in small strains"
                                          : "E and nu alone count, in small strains";
    const double most = test.kind->in_time ? test.depth : data_.x.maxCoeff() - (test.contact_given ? 0 : first_guess());
    if (std::isfinite(test.thickness) && most > 0)
      note += fmt::format("; at the largest depth the layer is {:.3g} times as stiff as a half-space",
                          layer(material.poissons_ratio).stiffening(most));
    data_.notes.push_back(note);
    if (test.adhesion > 0 && (test.indenter != Indenter::sphere || std::isfinite(test.thickness)))
      test.fail("adhesion: of a sphere on a half-space alone; leave out `thickness`, or the adhesion");
  }

  std::optional<Prediction> predict(const TestedMaterial& tested) override {
    return by_differences(tested, [&](const Trial& trial) {
      const std::optional<VectorX> found = curve(trial, data_.x);
      if (found->allFinite()) return found;
      why_ = fmt::format("the contact is wider than {:.0f} thicknesses of the layer", kWidest);
      return std::optional<VectorX>();
    });
  }
  std::optional<VectorX> line(const TestedMaterial& tested, const VectorX& along) const override {
    return curve(tested.trial, along);
  }
  std::vector<MaterialNumber> always_unknown() const override {
    std::vector<MaterialNumber> numbers;
    if (stated_.adhesion > 0)
      numbers.push_back({stated_.name + "_adhesion", dimension::stiffness, 0, std::numeric_limits<double>::infinity(),
                         true, stated_.adhesion, MaterialNumber::Kind::rule_parameter});
    if (stated_.contact_given || stated_.kind->in_time) return numbers;
    const double range = data_.x.maxCoeff() - data_.x.minCoeff();
    numbers.push_back({name(), dimension::length, data_.x.minCoeff() - range, data_.x.maxCoeff(), false, first_guess(),
                       MaterialNumber::Kind::rule_parameter, 0, 0, range});
    return numbers;
  }

 private:
  std::string name() const { return stated_.name + "_contact_point"; }

  /// Where a power of the depth through the first readings above 0.2 and 0.8 of the largest force begins.
  double first_guess() const {
    const double power = stated_.indenter == Indenter::sphere ? 1.5 : stated_.indenter == Indenter::cone ? 2 : 1;
    const auto first = [&](double share) {
      Eigen::Index row = 0;
      while (data_.y[row] < share * data_.y.maxCoeff()) ++row;
      return data_.x[row];
    };
    const double ratio = std::pow(4, 1 / power);
    return std::clamp((ratio * first(0.2) - first(0.8)) / (ratio - 1), data_.x.minCoeff(), data_.x.maxCoeff());
  }

  const IndentedLayer& layer(double nu) const {
    if (!layer_ || nu_ != nu)
      layer_ = std::make_shared<IndentedLayer>(stated_.indenter, stated_.indenter_size, stated_.thickness,
                                               stated_.bottom, nu_ = nu);
    return *layer_;
  }

  std::optional<VectorX> curve(const Trial& trial, const VectorX& along) const {
    const double nu = trial.material.poissons_ratio, modulus = trial.material.youngs_modulus / (1 - nu * nu);
    const auto found = trial.rule.find(name());
    const double zero = found == trial.rule.end() ? 0 : found->second;
    const auto sticky = trial.rule.find(stated_.name + "_adhesion");
    const double adhesion = sticky == trial.rule.end() ? stated_.adhesion : sticky->second;
    if (stated_.kind->in_time) return over_time(trial, modulus, along);
    const bool drawn = stated_.branch == BranchChoice::unloading;
    return VectorX(along.unaryExpr(
        [&](double depth) { return modulus * layer(nu).force(depth - zero, adhesion / modulus, drawn); }));
  }

  /// The force at times after contact, F = ∫ G(t − s) dFᵉ(δ(s)) over the times s up to t₁ [Lee & Radok 1960]: t itself
  /// while the contact grows, and while it shrinks the time at which it was as wide, from ∫ G(t − s) dδ(s) = 0 over t₁
  /// … t [Ting 1966].
  VectorX over_time(const Trial& trial, double modulus, const VectorX& times) const {
    constexpr int intervals = 200;
    const Relaxation relaxation = trial.material.relaxation.value_or(Relaxation{});
    const double ramp = stated_.ramp, back = stated_.back > 0 ? stated_.back : ramp, kept = ramp + stated_.hold;
    const auto of_depth = [&](double depth) {
      return modulus * layer(trial.material.poissons_ratio).force(depth, 0, false);
    };
    // ∫ G(t − s) ds over a … b, b ≤ t.
    const auto kernel = [&](double t, double a, double b) {
      double sum = relaxation.long_term() * (b - a);
      for (const auto& [share, tau] : relaxation.terms)
        sum += share * tau * std::exp((b - t) / tau) * -std::expm1((a - b) / tau);
      return sum;
    };
    return times.unaryExpr([&](double t) {
      double until = std::min(t, ramp);
      if (t > kept) {
        const double drawn = kernel(t, kept, std::min(t, kept + back)) / back;
        const auto grown = [&](double from) { return kernel(t, from, ramp) / ramp; };
        if (t >= kept + back || grown(0) <= drawn) return 0.;
        double low = 0, high = ramp;
        for (int i = 0; i < 60; ++i) (grown((low + high) / 2) > drawn ? low : high) = (low + high) / 2;
        until = low;
      }
      double sum = 0;
      for (int i = 0; i < intervals && until > 0; ++i) {
        const double from = until * i / intervals, to = until * (i + 1) / intervals;
        sum += (of_depth(stated_.depth * to / ramp) - of_depth(stated_.depth * from / ramp)) * kernel(t, from, to) /
               (to - from);
      }
      return sum;
    });
  }

  const DataTest& stated_;
  mutable std::shared_ptr<IndentedLayer> layer_;  ///< of the ν of the last call
  mutable double nu_ = 0;
};

}  // namespace

std::unique_ptr<MeasuredTest> make_layer_test(const DataTest& test, const Material& material) {
  return std::make_unique<LayerTest>(load_data(test), test, material);
}

}  // namespace elastin::lab
