#pragma once
#include "core/laws/jet3.h"
#include "elastin/core/laws/law.h"

namespace elastin::febio {

/// A muscle along a, by the invariants Ĩ₁ = tr C̃, Ĩ₄ = a · C̃ a, Ĩ₅ = a · C̃² a of the change of shape C̃ = J^(−2/3) C:
///   ψ = G₁ (Ĩ₅/Ĩ₄² − 1) + G₂ acosh² w + 9/16 G₃ ln² Ĩ₄ + σ ∫ (f_passive + α f_active) dx,
///   w = ½ (Ĩ₁ Ĩ₄ − Ĩ₅)/√Ĩ₄,  x = √Ĩ₄/λ₀:
/// shear along the fibres, across them, the stretch of the matrix, and the force of the fibres, with
///   f_passive = 0 up to x = 1, P₁ (e^(P₂ (x − 1)) − 1) up to x_m, from there on along its tangent,
///   f_active = 9 (x − 0.4)² in [0.4, 0.6], 1 − 4 (1 − x)² in [0.6, 1.4], 9 (x − 1.6)² in [1.4, 1.6], else 0.
/// [Blemker, Pinsky & Delp 2005; the term with G₃ is FEBio's]
struct Muscle {
  Vector3 direction = Vector3::UnitX();
  double along, across, matrix;  ///< G₁, G₂, G₃ [Pa]
  double passive, rate;          ///< P₁, P₂
  double optimal, straight;      ///< λ₀, x_m ≥ 1
  double peak, activation;       ///< σ [Pa], α

  Matrix3 stress(const Strained& point) const;
  TangentModuli<3> tangent(const Strained& point) const;
  double energy(const Strained& point) const;

  /// f of the stretch x over the optimal one: its integral, itself, its slope.
  struct Force {
    double integral, value, slope;
  };
  Force passive_force(double x) const;
  static Force active_force(double x);

 private:
  struct Present;
};

}  // namespace elastin::febio
