#pragma once
#include <cstdio>

#include "core/laws/membranes/membrane.h"
#include "elastin/core/base/error.h"

namespace elastin {

/// [L03]'s rubber, W = μ/2 (tr C − 3) − μ ln J + λ/2 (J − 1)², as a membrane: its thickness stretch x is the one that
/// leaves no stress across. With I = tr C and D = det C in the plane, J = √D x, that is a quadratic,
///   (μ + λD) x² − λ√D x − μ = 0,
/// solved for y = x − 1 so that nothing cancels near rest, and with μ : λ = (1 − 2ν) : 2ν so that ν = ½ is a case like
/// others: there x = 1/√D and w = t μ/2 (I + 1/D − 3), the incompressible membrane, exactly.
struct NeoHookeanDensity {
  static constexpr bool resists_flattening = true;

  double stiffness, mu, lambda;  ///< t μ [N/m]; 1 − 2ν, 2ν

  explicit NeoHookeanDensity(const Material& m)
      : stiffness(m.thickness * m.youngs_modulus / (2 * (1 + m.poissons_ratio))),
        mu(1 - 2 * m.poissons_ratio),
        lambda(2 * m.poissons_ratio) {
    if (m.poissons_ratio >= 0 && m.poissons_ratio <= 0.5) return;
    char text[100];
    std::snprintf(text, sizeof text, "poissons_ratio %g: neo_hookean_membrane takes 0 to 0.5", m.poissons_ratio);
    throw InputError(text);
  }

  Jet operator()(const PlaneStrain& strain) const {
    const Jet D1 = swelling(strain), r1 = root_minus_1(D1), r = 1 + r1;  // D − 1, √D − 1, √D
    const Jet a = mu + lambda * (1 + D1), b = 2 * a - lambda * r, c = lambda * r * r1;
    const Jet y = -2 * c / (b + sqrt(b * b - 4 * a * c));
    const Jet J1 = r1 + r * y;  // J − 1
    // λ (J − 1) = μ (1 − x²)/J where the thickness has no stress.
    const Jet squeezed = -y * (2 + y);
    return stiffness *
           (0.5 * (Jet::first(strain.trace) - squeezed) - 0.5 * log1p(D1) - log1p(y) + 0.5 * squeezed * J1 / (1 + J1));
  }
};

}  // namespace elastin
