#include "core/simulation/volume_fit.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

#include "elastin/core/base/types.h"

namespace elastin {
namespace {

struct Sampled {
  double kappa, nu;
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

}  // namespace

std::optional<VolumeFit> fit_volume(const Material& material, const MeasureModuli& measure, int most_solves) {
  const double target = material.poissons_ratio;
  std::vector<Sampled> points;
  double softness = 0, most = 0;  // q, and the κ that is taken for infinite
  for (double kappa = 0;;) {
    const auto measured = measure(kappa);
    if (!measured || !(measured->first > 0) || !(std::abs(measured->second) < 10)) return std::nullopt;
    const auto [E, nu] = *measured;
    const double scale = material.youngs_modulus / E;
    points.push_back({kappa, nu});
    const int solves = static_cast<int>(points.size());
    const bool unreachable = solves > 1 && kappa == most && nu < target;
    if (std::abs(nu - target) <= 0.001 || unreachable || solves >= most_solves)
      return VolumeFit{scale, scale * kappa, nu};
    const double bounded = std::min(nu, 0.45);
    if (solves == 1) softness = E / (2 * (1 + bounded) * (1 - 2 * bounded));
    // In t = 1/(κ + q) the first guess is the line to ½ at t = 0, the second the secant.
    const double t = 1 / (kappa + softness);
    const double before_t = solves == 1 ? 0 : 1 / (points[points.size() - 2].kappa + softness);
    const double before = solves == 1 ? std::max(0.5, nu + 0.05) : points[points.size() - 2].nu;
    const double slope = (nu - before) / (t - before_t);
    const double next = slope < 0 ? t + (target - nu) / slope : t / 2;
    const double guess = 1 / std::clamp(next, 1e-3 * t, 2 * t) - softness;
    const double better = solves < 3 ? std::nan("") : inverse_of_hyperbola(&points[points.size() - 3], target);
    if (solves == 1) most = 10 * std::max(guess, softness);
    kappa = std::min(better > -softness ? better : guess, most);
  }
}

}  // namespace elastin
