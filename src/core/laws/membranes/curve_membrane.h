#pragma once
#include <algorithm>
#include <array>
#include <cmath>

#include "core/laws/membranes/membrane.h"
#include "core/laws/moduli.h"
#include "core/laws/solids/curve_size.h"

namespace elastin {

/// The membrane that shows exactly the material's nominal curve P(ε) in uniaxial stress, and ν at every strain, at
/// constant thickness: Hooke's plane stress between Biot stress and engineering strain e = U − I, with a secant modulus
/// that depends on the size q of the strain; the sister of Curve:
///   w = t Φ(q),  Φ′ = P,  q² = (λ tr²e + 2μ |e|²)/E,  λ = E ν/(1−ν²).
/// Without a curve it is engineering strain at constant thickness, with an energy: what two_parameter is a form of.
/// With a = λ₁ + λ₂ − 2 and the squared difference b of the stretches, q² = ((λ + μ) a² + μ b)/E.
struct CurveMembraneDensity {
  static constexpr bool resists_flattening = false;

  double thickness, even, shear;  ///< t [m]; (λ + μ)/E, μ/E
  StressStrain curve;

  /// Throws InputError unless −1 < ν ≤ ½.
  explicit CurveMembraneDensity(const Material& m)
      : thickness(m.thickness),
        even(0.5 / (1 - m.poissons_ratio)),
        shear(lame<2>(m).mu / m.youngs_modulus),
        curve(m.curve ? *m.curve : StressStrain::linear(m.youngs_modulus)) {}

  Jet operator()(const PlaneStrain& strain) const {
    const Sizes now(*this, strain);
    const CurveSize psi = size(now);
    // Ψ(q(a, b), a), with q's second derivatives from those of q².
    const auto [by_a, by_b] = slopes(now);
    const double bend = psi.by_qq - psi.secant;
    const double A = psi.secant * even * now.a.value + psi.by_t, B = psi.secant * shear / 2;
    const double AA = bend * by_a * by_a + psi.secant * even + 2 * psi.by_qt * by_a + psi.by_tt,
                 AB = bend * by_a * by_b + psi.by_qt * by_b, BB = bend * by_b * by_b;
    const Jet da = now.a - now.a.value, db = now.b - now.b.value;
    return thickness * (psi.energy + A * da + B * db + 0.5 * AA * da * da + AB * da * db + 0.5 * BB * db * db);
  }

  /// The secant modulus Ψ_q/q [Pa] at a strain, with its first slopes.
  Jet secant(const PlaneStrain& strain) const {
    const Sizes now(*this, strain);
    const CurveSize psi = size(now);
    if (!(psi.q > kStraight)) return psi.secant;
    const auto [by_a, by_b] = slopes(now);
    const double by_q = (psi.by_qq - psi.secant) / psi.q;
    return psi.secant + (by_q * by_a + psi.by_qt / psi.q) * (now.a - now.a.value) + by_q * by_b * (now.b - now.b.value);
  }

 private:
  static constexpr double kStraight = 1e-9;  ///< of q: below it the curve is straight to rounding

  struct Sizes {
    Jet a, b;
    double q;

    Sizes(const CurveMembraneDensity& law, const PlaneStrain& strain) {
      const Jet j1 = root_minus_1(swelling(strain));  // λ₁ λ₂ − 1
      Jet square = 0.25 * (Jet::first(strain.trace) + 2 * j1);
      square.value = std::max(square.value, kFlatTriangle - 1);
      a = 2 * root_minus_1(square);  // (λ₁ + λ₂)² = 4 (1 + square)
      b = Jet::second(strain.split) / (4 * (1 + square));
      q = std::sqrt(law.even * a.value * a.value + law.shear * b.value);
    }
  };

  CurveSize size(const Sizes& now) const { return {curve, now.q, now.a.value, 2 * even}; }
  /// ∂q/∂a and ∂q/∂b.
  std::array<double, 2> slopes(const Sizes& now) const {
    if (!(now.q > kStraight)) return {0, 0};
    return {even * now.a.value / now.q, shear / (2 * now.q)};
  }
};

}  // namespace elastin
