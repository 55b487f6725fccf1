// Stress-strain curves written as a secant modulus E(ε) = σ/ε.

#include <cmath>
#include <cstdio>

#include "elastin/core/base/error.h"
#include "elastin/core/model/stress_strain.h"

namespace elastin {
namespace {

/// A modulus at a strain, and how it changes with the strain.
struct Secant {
  double modulus, slope;  ///< E, dE/dε [Pa]
};

/// Throws InputError unless σ = E ε rises there.
void check_rise(double strain, const Secant& secant) {
  const double rise = secant.modulus + strain * secant.slope;
  if (rise > 0 && secant.modulus > 0 && std::isfinite(rise)) return;
  char text[160];
  std::snprintf(text, sizeof text,
                "at a strain of %.4g the secant modulus is %.4g Pa and the stress has a slope of %.4g Pa: both must be "
                "above 0",
                strain, secant.modulus, rise);
  throw InputError(text);
}

/// Monotone cubic through three points' worth of slopes. [Fritsch & Butland 1984]
double middle_slope(double before_step, double before, double after_step, double after) {
  if (!(before * after > 0)) return 0;
  const double first = before_step + 2 * after_step, second = 2 * before_step + after_step;
  return (first + second) / (first / before + second / after);
}

}  // namespace

/// Through knots of tension and their images in compression.
StressStrain StressStrain::both_ways(const std::vector<Knot>& tension) {
  std::vector<Knot> knots;
  for (auto knot = tension.rbegin(); knot != tension.rend(); ++knot)
    if (knot->strain > 0) knots.push_back({-knot->strain, -knot->stress, knot->slope});
  knots.insert(knots.end(), tension.begin(), tension.end());
  return StressStrain(knots);
}

StressStrain StressStrain::secant_polynomial(const std::vector<double>& coefficients, double up_to) {
  if (coefficients.empty()) throw InputError("a polynomial needs at least one coefficient");
  if (!(up_to > 0 && std::isfinite(up_to))) throw InputError("up_to must be above 0");
  const auto at = [&](double strain) {
    Secant secant{0, 0};
    for (auto c = coefficients.rbegin(); c != coefficients.rend(); ++c) {
      secant.slope = secant.slope * strain + secant.modulus;
      secant.modulus = secant.modulus * strain + *c;
    }
    return secant;
  };
  constexpr int checks = 64;
  for (int i = 0; i <= checks; ++i) check_rise(up_to * i / checks, at(up_to * i / checks));
  // Up to degree 2 the stress is a cubic: one piece is exact.
  const int pieces = coefficients.size() <= 3 ? 1 : checks;
  std::vector<Knot> knots;
  for (int i = 0; i <= pieces; ++i) {
    const double strain = up_to * i / pieces;
    const auto [modulus, slope] = at(strain);
    knots.push_back({strain, modulus * strain, modulus + strain * slope});
  }
  return both_ways(knots);
}

StressStrain StressStrain::secant_table(const std::vector<SecantPoint>& points) {
  if (points.size() < 2) throw InputError("a table of secant moduli needs at least two points");
  const std::size_t last = points.size() - 1;
  std::vector<double> step(last), rise(last), slope(last + 1);
  for (std::size_t k = 0; k < last; ++k) {
    step[k] = points[k + 1].strain - points[k].strain;
    if (!(points[0].strain >= 0 && step[k] > 0)) throw InputError("strains must start at 0 or above, and increase");
    rise[k] = (points[k + 1].modulus - points[k].modulus) / step[k];
  }
  for (std::size_t k = 1; k < last; ++k) slope[k] = middle_slope(step[k - 1], rise[k - 1], step[k], rise[k]);
  slope[0] = points[0].strain > 0 ? 0 : rise[0];
  slope[last] = rise[last - 1];

  constexpr int intervals =
      8;  // of a piece: E is a cubic, so σ = E ε is not; what cubics miss of it is 1e-5 of a piece's
  std::vector<Knot> knots{{0, 0, points[0].modulus}};
  const auto add = [&](double strain, const Secant& secant) {
    check_rise(strain, secant);
    if (strain > 0) knots.push_back({strain, secant.modulus * strain, secant.modulus + strain * secant.slope});
  };
  check_rise(0, {points[0].modulus, 0});
  for (std::size_t k = 0; k < last; ++k)
    for (int interval = k == 0 ? 0 : 1; interval <= intervals; ++interval) {
      const double h = step[k], d = h * interval / intervals;
      const double c2 = (3 * rise[k] - 2 * slope[k] - slope[k + 1]) / h,
                   c3 = (slope[k] + slope[k + 1] - 2 * rise[k]) / (h * h);
      add(points[k].strain + d,
          {points[k].modulus + d * (slope[k] + d * (c2 + d * c3)), slope[k] + d * (2 * c2 + 3 * d * c3)});
    }
  return both_ways(knots);
}

}  // namespace elastin
