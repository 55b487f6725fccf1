#pragma once
#include <array>
#include <cmath>

#include "core/laws/membranes/membrane.h"
#include "core/laws/moduli.h"

namespace elastin {

/// Plane stress with the Cauchy stress linear in logarithmic strain, true thinning: of principal strains h₁ and h₂
///   σ₁ = E/(1−ν²) (h₁ + ν h₂),   J = e^(β (h₁ + h₂)),   β = (1 − 2ν)/(1 − ν),   S₁ = t J σ₁/C₁.
/// In uniaxial stress the force per width and thickness at rest is E ln λ λ^(−2ν). With m = (h₁ + h₂)/2, d = h₁ − h₂
/// and g = d/(C₁ − C₂), C⁻¹ = (tr C/2 I − D)/det C, D = C − tr C/2 I the part of C without trace, no principal
/// direction is needed:
///   S = a I + b D,   a = t J/det C (E/(1−ν) m tr C/2 − E/(1+ν) g ρ/4),   b = t J/det C (E/(1+ν) g tr C/2 − E/(1−ν) m).
/// It has no energy unless ν = ½: round a closed path of stretches the stress does work of third order in the strain.
/// A triangle flatter than kFlatTriangle has the stress of one at that limit.
class HenckyMembrane {
 public:
  /// Throws InputError unless −1 < ν ≤ ½.
  explicit HenckyMembrane(const Material& m)
      : mean_(m.youngs_modulus * m.thickness / (1 - m.poissons_ratio)),
        shear_(2 * lame<2>(m).mu * m.thickness),
        beta_((1 - 2 * m.poissons_ratio) / (1 - m.poissons_ratio)) {}

  Eigen::Matrix2d stress(const Eigen::Matrix2d& A) const {
    const Present now(*this, A);
    Eigen::Matrix2d S;
    S << now.a.value + now.b.value * now.u / 2, now.b.value * now.v / 2, now.b.value * now.v / 2,
        now.a.value - now.b.value * now.u / 2;
    return S;
  }

  TangentModuli<2> tangent(const Eigen::Matrix2d& A) const {
    const Present now(*this, A);
    const Vector3 by_a(now.a.x, 2 * now.u * now.a.y, 2 * now.v * now.a.y);  // by τ, u, v
    const Vector3 by_b(now.b.x, 2 * now.u * now.b.y, 2 * now.v * now.b.y);
    Matrix3 slope;
    slope.row(0) = by_a + now.u / 2 * by_b + now.b.value / 2 * Vector3::UnitY();
    slope.row(1) = by_a - now.u / 2 * by_b - now.b.value / 2 * Vector3::UnitY();
    slope.row(2) = now.v / 2 * by_b + now.b.value / 2 * Vector3::UnitZ();
    Matrix3 strains;  // (τ, u, v) of (A₁₁, A₂₂, 2 A₁₂)
    strains << 1, 1, 0, 1, -1, 0, 0, 0, 1;
    return slope * strains;
  }

 private:
  struct Present {
    double u, v;  ///< A₁₁ − A₂₂, 2 A₁₂
    Jet a, b;     ///< [N/m], in (τ, ρ); their second slopes are not used

    Present(const HenckyMembrane& law, const Eigen::Matrix2d& A) : u(A(0, 0) - A(1, 1)), v(2 * A(0, 1)) {
      const PlaneStrain strain{A.trace(), u * u + v * v};
      const Jet D1 = swelling(strain), det = 1 + D1, m = 0.25 * log1p(D1), split = Jet::second(strain.split);
      const Jet half = 1 + 0.5 * Jet::first(strain.trace);  // tr C/2
      const double J = std::exp(2 * law.beta_ * m.value);
      const Jet swollen = m.through(J, 2 * law.beta_ * J, 4 * law.beta_ * law.beta_ * J) / det;
      // g = arsinh(y)/(2 y √det C) of y² = ρ/(4 det C).
      const Jet shear = law.shear_ * half_difference(split / (4 * det)) / sqrt(det), mean = law.mean_ * m;
      a = swollen * (mean * half - 0.25 * shear * split);
      b = swollen * (shear * half - mean);
    }
  };

  /// arsinh(√z)/(2 √z).
  static Jet half_difference(const Jet& z) {
    const double at = z.value, root = std::sqrt(1 + at);
    double k, k1, k2;
    if (at < 0.02) {  // Σ (−1)ⁿ (2n)!/(4ⁿ n!² (2n + 1)) zⁿ: where the formulas cancel
      static constexpr std::array<double, 9> series{1,           -1. / 6,      3. / 40,       -5. / 112,     35. / 1152,
                                                    -63. / 2816, 231. / 13312, -143. / 10240, 6435. / 557056};
      k = k1 = k2 = 0;
      for (std::size_t n = series.size(); n-- > 0;) {
        k2 = k2 * at + 2 * k1;
        k1 = k1 * at + k;
        k = k * at + series[n];
      }
    } else {
      k = std::asinh(std::sqrt(at)) / std::sqrt(at);
      k1 = (1 / root - k) / (2 * at);
      k2 = (-0.5 / (root * root * root) - 3 * k1) / (2 * at);
    }
    return z.through(k / 2, k1 / 2, k2 / 2);
  }

  double mean_, shear_, beta_;  // E t/(1−ν), E t/(1+ν) [N/m]; β
};

/// A membrane law alone: in plane stress it is not what a solid of that name would be.
struct Hencky {
  static constexpr std::string_view name = "hencky";
  static constexpr std::string_view summary =
      "true stress linear in logarithmic strain, triangles: thins as it stretches; not conservative";
  static constexpr std::string_view source = "[Hencky 1928] in plane stress, the reference of [TP]";

  /// Throws InputError unless −1 < ν ≤ ½.
  HenckyMembrane membrane(const Material& material) const { return HenckyMembrane(material); }
};

}  // namespace elastin
