#include "core/simulation/volume_fit.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "elastin/core/base/types.h"

namespace elastin {
namespace {

/// What the springs measure with a volume term κ.
struct Sampled {
  double kappa, nu, youngs;
};

/// Where ν = (a + b κ)/(1 + c κ) through three points reaches a value; NaN if they do not lie on a rising branch.
double inverse_of_hyperbola(const Sampled* points, double nu) {
  const double unit = std::max(std::abs(points[1].kappa), std::abs(points[2].kappa));
  Matrix3 equations;  // a + b κ − c κ ν = ν
  Vector3 values;
  for (int i = 0; i < 3; ++i) {
    const double kappa = points[i].kappa / unit;
    equations.row(i) << 1, kappa, -kappa * points[i].nu;
    values[i] = points[i].nu;
  }
  const Vector3 x = equations.inverse() * values;
  const bool rising = x[1] > x[0] * x[2];
  return rising ? unit * (nu - x[0]) / (x[1] - x[2] * nu) : std::nan("");
}

/// Looks for the κ with a wanted ν among those that are measured, in t = 1/(κ + q), which is small where κ is large.
class Search {
 public:
  Search(double target, const Sampled& springs) : target_(target), points_{springs} {
    const double bounded = std::min(springs.nu, 0.45);
    softness_ = springs.youngs / (2 * (1 + bounded) * (1 - 2 * bounded));
    least_ = t_of(10 * std::max(guess(), softness_));
  }
  bool met() const { return std::abs(points_.back().nu - target_) <= std::min(1e-3, (0.5 - target_) / 10); }
  void add(const Sampled& point) { points_.push_back(point); }
  /// That the body is not stable with this κ.
  void add_unstable(double kappa) { end_ = std::min(end_, t_of(kappa)); }
  /// The κ to be measured next, or nothing.
  std::optional<double> next();
  const Sampled& nearest() const {
    return *std::min_element(points_.begin(), points_.end(), [&](const Sampled& a, const Sampled& b) {
      return std::abs(a.nu - target_) < std::abs(b.nu - target_);
    });
  }

 private:
  static constexpr double kFar = 1e-2;   ///< of the softness q: how near κ comes to −q
  static constexpr double kJump = 1e-6;  ///< width of a bracket, over its place, in which ν does not change but jumps
  static constexpr int kScanned = 4;     ///< terms from the largest on

  double t_of(double kappa) const { return 1 / (kappa + softness_); }
  double kappa_of(double t) const { return 1 / t - softness_; }
  bool is_below(const Sampled& point) const { return point.nu < target_; }
  /// κ by the first line to ν = ½ at t = 0, by the secant of two, by the hyperbola of three.
  double guess() const;

  double target_;
  std::vector<Sampled> points_;        ///< as they were measured
  double softness_ = 0;                ///< q
  double least_ = 0, end_ = INFINITY;  ///< t of the κ that is taken for infinite, and of the first unstable one
  double width_ = INFINITY;            ///< of the last bracket
  int scanned_ = 0;
};

double Search::guess() const {
  const Sampled& last = points_.back();
  const double t = t_of(last.kappa);
  const bool alone = points_.size() == 1;
  const double before_t = alone ? 0 : t_of(points_[points_.size() - 2].kappa);
  const double before = alone ? std::max(0.5, last.nu + 0.05) : points_[points_.size() - 2].nu;
  const double slope = (last.nu - before) / (t - before_t);
  const double next = slope < 0 ? t + (target_ - last.nu) / slope : t / 2;
  const double better = points_.size() < 3 ? std::nan("") : inverse_of_hyperbola(&points_[points_.size() - 3], target_);
  return better > -softness_ ? better : 1 / std::clamp(next, 1e-3 * t, 2 * t) - softness_;
}

std::optional<double> Search::next() {
  std::vector<Sampled> ordered = points_;
  std::sort(ordered.begin(), ordered.end(), [](const Sampled& a, const Sampled& b) { return a.kappa > b.kappa; });
  const auto crossing = std::adjacent_find(
      ordered.begin(), ordered.end(), [&](const Sampled& a, const Sampled& b) { return is_below(a) != is_below(b); });
  const double guessed = t_of(guess());
  if (crossing != ordered.end()) {
    const double from = t_of(crossing->kappa), to = t_of((crossing + 1)->kappa), width = to - from;
    if (width < kJump * from) return std::nullopt;
    const bool slow = width > width_ / 2;
    width_ = width;
    return kappa_of(!slow && guessed > from && guessed < to ? guessed : (from + to) / 2);
  }
  const double smallest = t_of(ordered.front().kappa), largest = t_of(ordered.back().kappa);
  const double last = std::min(end_, 1 / (kFar * softness_));
  if (scanned_ == 0 && is_below(ordered.front()) && smallest > least_)
    return kappa_of(std::max(guessed < smallest ? guessed : smallest / 2, least_));
  if (scanned_ == 0 && !is_below(ordered.front()) && largest < last * (1 - kFar))
    return kappa_of(guessed > largest && guessed < last ? guessed : (largest + std::min(last, 3 * largest)) / 2);
  if (scanned_ == kScanned) return std::nullopt;
  ++scanned_;
  return kappa_of(least_ * std::pow(std::min(last, largest) / least_, (scanned_ - 1.) / kScanned));
}

}  // namespace

std::optional<VolumeFit> fit_volume(const Material& material, const MeasureModuli& measure) {
  constexpr int most_solves = 40;
  const auto measured = [&](double kappa) -> std::optional<Sampled> {
    const auto moduli = measure(kappa);
    if (!moduli || !(moduli->first > 0) || !(std::abs(moduli->second) < 10)) return std::nullopt;
    return Sampled{kappa, moduli->second, moduli->first};
  };
  const std::optional<Sampled> springs = measured(0);
  if (!springs) return std::nullopt;
  Search search(material.poissons_ratio, *springs);
  for (int solves = 1; !search.met() && solves < most_solves; ++solves) {
    const std::optional<double> kappa = search.next();
    if (!kappa) break;
    if (const std::optional<Sampled> point = measured(*kappa))
      search.add(*point);
    else if (*kappa < 0)
      search.add_unstable(*kappa);
    else
      return std::nullopt;
  }
  const bool met = search.met();
  const Sampled& best = search.nearest();
  const double scale = material.youngs_modulus / best.youngs;
  return VolumeFit{scale, scale * best.kappa, best.nu, met};
}

}  // namespace elastin
