#pragma once
#include "core/laws/membranes/tension_field.h"

namespace elastin {

/// A law ψ(I₁ − 3, I₂ − 3) of an incompressible solid as a membrane: it thins to J = 1, and the pressure that this
/// takes leaves no stress across. With I = tr C and D = det C in the plane, I₁ = I + 1/D and I₂ = D + I/D.
template <class Law>
struct IncompressibleMembrane {
  static constexpr bool resists_flattening = true;

  double thickness;
  typename Law::Density density;

  explicit IncompressibleMembrane(const Material& m) : thickness(m.thickness), density(Law{}.density(m)) {}

  Jet operator()(const PlaneStrain& strain) const {
    const Jet trace = Jet::first(strain.trace), D1 = swelling(strain), thinning = -D1 / (1 + D1);  // 1/D − 1
    return thickness * density(trace + thinning, D1 + trace + thinning * (2 + trace));
  }
};

}  // namespace elastin
