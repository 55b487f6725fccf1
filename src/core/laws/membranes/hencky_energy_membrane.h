#pragma once
#include <cmath>

#include "core/laws/membranes/membrane.h"
#include "core/laws/membranes/tension_field.h"
#include "core/laws/moduli.h"

namespace elastin {

/// Logarithmic strain in plane stress, true thinning. With m the mean of the two principal logarithmic strains and d
/// their difference, β = (1 − 2ν)/(1 − ν), the thickness stretch is e^(−2νm/(1−ν)) and J = e^(2βm):
///   w = t (A(m) + μ d²/2),   A′ = 2E/(1−ν) m J,   A = 2E/(1−ν) m² φ(2βm),   φ(z) = (eᶻ (z − 1) + 1)/z².
/// The first term makes the true mean stress E/(1−ν) m for any strain, hence a sphere that obeys exactly
/// ln λ = (p R₀ (1−ν)/(2 E t)) λ^(1+2ν/(1−ν)), as `hencky_membrane` does. The second is Hencky's own shear energy: that
/// of a difference of the *Kirchhoff* stresses, 2μ d. (With the Cauchy stresses', as in `hencky_membrane`, there is no
/// energy unless ν = ½, where both laws are one.) A flat triangle has infinite energy. Pressed evenly below a stretch
/// of e^(−1/(2β)) it softens, as that Cauchy stress does.
struct HenckyDensity {
  static constexpr bool resists_flattening = true;

  double mean, shear, beta;  ///< 2 E t/(1−ν), t μ [N/m]; β

  /// Throws InputError unless −1 < ν ≤ ½.
  explicit HenckyDensity(const Material& m)
      : mean(2 * m.youngs_modulus * m.thickness / (1 - m.poissons_ratio)),
        shear(lame<2>(m).mu * m.thickness),
        beta((1 - 2 * m.poissons_ratio) / (1 - m.poissons_ratio)) {}

  Jet operator()(const PlaneStrain& strain) const {
    const Jet D1 = swelling(strain), m = 0.25 * log1p(D1);
    const double J = std::exp(2 * beta * m.value);
    const Jet even = m.through(m.value * m.value * phi(2 * beta * m.value), m.value * J, (1 + 2 * beta * m.value) * J);
    // sinh² d = ρ/(4 det C); d² and its derivatives by it are smooth at d = 0.
    const Jet sinh2 = Jet::second(strain.split) / (4 * (1 + D1));
    return mean * even + 0.5 * shear * squared_difference(sinh2);
  }

 private:
  static double phi(double z) {
    if (std::abs(z) > 0.1) return (std::exp(z) * (z - 1) + 1) / (z * z);
    double sum = 0, power = 1;  // Σ zⁿ/(n! (n + 2)): where the formula cancels
    for (int n = 0; n < 10; ++n) {
      sum += power / (n + 2);
      power *= z / (n + 1);
    }
    return sum;
  }

  /// arsinh²(√z) of z = sinh² d.
  static Jet squared_difference(const Jet& z) {
    const double at = z.value;
    if (at < 1e-3)  // d² = z − z²/3 + 8 z³/45 − 4 z⁴/35 + 128 z⁵/1575 …
      return z.through(at * (1 + at * (-1. / 3 + at * (8. / 45 + at * (-4. / 35 + at * 128. / 1575)))),
                       1 + at * (-2. / 3 + at * (8. / 15 + at * (-16. / 35 + at * 128. / 315))),
                       -2. / 3 + at * (16. / 15 + at * (-48. / 35 + at * 512. / 315)));
    const double sinh = std::sqrt(at), d = std::asinh(sinh), cosh = std::sqrt(1 + at), tanh2 = 2 * sinh * cosh;
    const double by_z = 2 * d / tanh2;  // dz = 2 sinh cosh dd
    return z.through(d * d, by_z, (2 / tanh2 - by_z * 2 * (1 + 2 * at) / tanh2) / tanh2);
  }
};

/// A membrane law alone: in plane stress it is not what a solid of that name would be.
struct HenckyEnergy {
  static constexpr std::string_view name = "hencky_energy";
  static constexpr std::string_view summary =
      "energy of logarithmic strain, triangles: true mean stress linear in it, thins as it stretches";
  static constexpr std::string_view source = "[Hencky 1928] in plane stress, made conservative";

  /// Throws InputError unless −1 < ν ≤ ½.
  IsotropicMembrane<HenckyDensity> membrane(const Material& material) const { return {material}; }
};

}  // namespace elastin
