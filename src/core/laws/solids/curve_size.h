#pragma once
#include "elastin/core/model/stress_strain.h"

namespace elastin {

/// Ψ(q, t), the energy density of a solid or membrane that shows a nominal curve P in uniaxial stress (see Curve), and
/// its derivatives: q the size of the strain, |ε| in uniaxial stress, t its trace. Ψ = Φ(q), Φ′ = P, if the curve is
/// the same in tension and in compression.
///
/// Where they differ, Φ is the one of tension for s ≥ ½, that of compression for s ≤ −½, and in between
/// Φ₋ + w(s) (Φ₊ − Φ₋), w = the smooth step of continuous curvature; s is the trace of the linear stress over q: 1 in
/// uniaxial tension, −1 in compression, 0 in shear. In between W is not convex once the two moduli differ by more than
/// 13, 6, 2, 1 % at ν = 0, ¼, 0.4, 0.45 (solids): near uniaxial stress nothing comes of it, but a body in shear or
/// clamped at large ν may then find no stable equilibrium, and the solver says so.
struct CurveSize {
  double q = 0, energy = 0, secant = 0, by_t = 0, by_qq = 0, by_qt = 0, by_tt = 0;  ///< secant = Ψ_q/q

  CurveSize() = default;
  /// @param stress_of_trace trace of the linear stress over E t: s = stress_of_trace t/q.
  CurveSize(const StressStrain& P, double length, double t, double stress_of_trace) : q(length) {
    constexpr double negligible = 1e-9;  // the curve is straight to rounding, and s undefined at 0
    const double s = q > negligible ? t * stress_of_trace / q : 1;
    if (s >= 0.5 || s <= -0.5) {
      const StressStrain::Response now = P.response(s > 0 ? q : -q);
      energy = now.energy_density, secant = now.secant, by_qq = now.modulus;
      return;
    }
    const double x = s + 0.5, w = x * x * x * (10 + x * (6 * x - 15)), w1 = 30 * x * x * (1 - x) * (1 - x),
                 w2 = 60 * x * (1 - x) * (1 - 2 * x);
    const double D = P.energy_density(q) - P.energy_density(-q), D1 = P.stress(q) + P.stress(-q), s_q = -s / q,
                 s_t = stress_of_trace / q;
    energy = P.energy_density(-q) + w * D;
    secant = P.secant(-q) + w * (P.secant(q) - P.secant(-q)) + D * w1 * s_q / q;
    by_t = D * w1 * s_t;
    by_qq = P.modulus(-q) + w * (P.modulus(q) - P.modulus(-q)) + 2 * D1 * w1 * s_q +
            D * (w2 * s_q * s_q + w1 * 2 * s / (q * q));
    by_qt = D1 * w1 * s_t + D * (w2 * s_q * s_t - w1 * s_t / q);
    by_tt = D * w2 * s_t * s_t;
  }
};

}  // namespace elastin
