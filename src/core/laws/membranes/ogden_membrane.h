#pragma once
#include <array>
#include <cmath>

#include "core/laws/membranes/tension_field.h"
#include "elastin/core/base/error.h"

namespace elastin {

/// c [Pa] and m of up to six terms Σ c/m² (λ₁^m + λ₂^m + λ₃^m − 3).
struct OgdenTerms {
  static constexpr int kMost = 6;
  int count = 0;

  void add(double c, double m) {
    if (count == kMost) throw InputError("ogden takes up to 6 terms");
    values_[count++] = {c, m, c / m};
  }
  double c(int term) const { return values_[term][0]; }
  double m(int term) const { return values_[term][1]; }
  double scale(int term) const { return values_[term][2]; }  ///< c/m

 private:
  std::array<std::array<double, 3>, kMost> values_{};
};

/// An incompressible Ogden membrane. With D = det C in the plane and z = tr C/(2√D) − 1 = cosh ln(λ₁/λ₂) − 1,
///   λ₁^m + λ₂^m + λ₃^m = 2 D^(m/4) cosh(m/2 · arcosh(1 + z)) + D^(−m/2),
/// which is smooth at equal stretches, z = 0.
struct OgdenMembrane {
  static constexpr bool resists_flattening = true;

  double thickness;
  OgdenTerms terms;

  explicit OgdenMembrane(const Material& material);

  Jet operator()(const PlaneStrain& strain) const {
    const Jet trace = Jet::first(strain.trace), D1 = swelling(strain), root = sqrt(1 + D1);
    const Jet z = Jet::second(strain.split) / (2 * root * (2 + trace + 2 * root)), log_D = log1p(D1);
    Jet sum = 0;
    for (int t = 0; t < terms.count; ++t) {
      const double m = terms.m(t);
      const Jet y = m / 4 * log_D;
      const double up = std::expm1(y.value), down = std::expm1(-2 * y.value);
      const Jet even = y.through(2 * up + down, 2 * (up - down), 6 + 2 * up + 4 * down);
      sum = sum + terms.c(t) / (m * m) * (2 * (1 + expm1(y)) * uneven(m / 2, z) + even);
    }
    return thickness * sum;
  }

 private:
  /// cosh(k arcosh(1 + z)) − 1. Near 0 by its series in z, Σ Π_(j<n) (k² − j²) (2z)^n/(2n)!.
  static Jet uneven(double k, const Jet& z) {
    const double x = z.value;
    if (x * std::max(1., k * k) < 0.1) {
      double term = 1, slope_term = 0, bend_term = 0, f = 0, f1 = 0, f2 = 0;  // c_n z^n, c_n z^(n−1), c_n z^(n−2)
      for (int n = 1; n < 16; ++n) {
        const double factor = (k * k - (n - 1.) * (n - 1)) * 2 / ((2. * n - 1) * 2 * n);
        bend_term = slope_term * factor;
        slope_term = term * factor;
        term = slope_term * x;
        f += term, f1 += n * slope_term, f2 += n * (n - 1.) * bend_term;
      }
      return z.through(f, f1, f2);
    }
    const double sinh_x = std::sqrt(x * (2 + x)), angle = std::log1p(x + sinh_x);
    const double half = std::sinh(k * angle / 2), f1 = k * std::sinh(k * angle) / sinh_x;
    const double f2 = (k * k * std::cosh(k * angle) - (1 + x) * f1) / (sinh_x * sinh_x);
    return z.through(2 * half * half, f1, f2);
  }
};

}  // namespace elastin
