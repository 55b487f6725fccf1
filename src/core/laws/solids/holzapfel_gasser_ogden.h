#pragma once
#include <algorithm>
#include <array>
#include <cmath>

#include "core/laws/solids/isochoric.h"
#include "elastin/core/laws/material_law.h"

namespace elastin {

/// An artery's layer: a neo-Hookean matrix and two families of fibres at ±γ to a direction, each dispersed by κ:
///   ψ = c/2 (Ĩ₁ − 3) + k₁/(2k₂) Σ_± (e^(k₂ ⟨E⟩²) − 1),  E = κ (Ĩ₁ − 3) + (1 − 3κ)(Ĩ₄ − 1),
/// ⟨E⟩ = max(E, 0): it is E that decides whether fibres bear, not Ĩ₄ alone.  [Gasser, Ogden & Holzapfel 2006, eq. 4.5]
struct HolzapfelGasserOgden : NearlyIncompressible<HolzapfelGasserOgden> {
  static constexpr std::string_view name = "holzapfel_gasser_ogden";
  static constexpr std::string_view summary = "arteries: two families of fibres with dispersion, nearly incompressible";
  static constexpr std::string_view source = "[Gasser, Ogden & Holzapfel 2006]";

  struct Shape {
    double c, k1, k2, kappa;
    std::array<Vector3, 2> families;

    Matrix3 stress(const Matrix3& A) const {
      const Isochoric now(A);
      const Components first = now.first_slope();
      Components S = c / 2 * first;
      for (const Vector3& a : families)
        if (const double E = strain(now, a); E > 0)
          S += k1 * E * growth(E) * (kappa * first + (1 - 3 * kappa) * now.along_slope(a));
      return 2 * tensor(S);
    }

    TangentModuli<3> tangent(const Matrix3& A) const {
      const Isochoric now(A);
      const Components first = now.first_slope();
      TangentModuli<3> result = TangentModuli<3>::Zero();
      double even = c / 2;
      for (const Vector3& a : families)
        if (const double E = strain(now, a); E > 0) {
          const Components slope = kappa * first + (1 - 3 * kappa) * now.along_slope(a);
          const double g = k1 * E * growth(E);
          result += 2 * k1 * (1 + 2 * k2 * E * E) * growth(E) * slope * slope.transpose();
          now.add_along_curvature(2 * g * (1 - 3 * kappa), a, result);
          even += g * kappa;
        }
      now.add_first_curvature(2 * even, result);
      return result;
    }

    double energy(const Matrix3& A) const {
      const Isochoric now(A);
      double sum = c / 2 * now.first();
      for (const Vector3& a : families)
        if (const double E = strain(now, a); E > 0) sum += k1 / (2 * k2) * std::expm1(power(E));
      return sum;
    }

   private:
    double strain(const Isochoric& now, const Vector3& a) const {
      return kappa * now.first() + (1 - 3 * kappa) * now.along(a);
    }
    double power(double E) const { return std::min(k2 * E * E, 500.); }
    double growth(double E) const { return std::exp(power(E)); }
  };

  static MaterialLaw constants() {
    constexpr double inf = std::numeric_limits<double>::infinity(), none = std::numeric_limits<double>::quiet_NaN();
    constexpr double right_angle = 1.5707963267948966;
    MaterialLaw row;
    row.parameters = {
        {"c", dimension::pressure, 0, inf, none, "shear modulus of the matrix", true, ValueKind::number, true},
        {"k1", dimension::pressure, 0, inf, none, "k₁ of the fibres", false, ValueKind::number, true},
        {"k2", dimension::none, 0, inf, none, "k₂ of the fibres, of the exponent", true, ValueKind::number, true},
        {"kappa", dimension::none, 0, 1. / 3, 0, "κ, dispersion: 0 all parallel, 1/3 in all directions alike"},
        {"angle", dimension::none, 0, right_angle, none, "γ between each family and `direction`, rad or with a unit",
         false, ValueKind::number, true},
        {"direction", dimension::none, 0, 0, none,
         "the direction between the two families, of an artery its circumference", false, ValueKind::direction, true},
        {"across", dimension::none, 0, 0, none, "a second direction in their plane, of an artery its axis", false,
         ValueKind::direction, true}};
    add_bulk_modulus(row, Volumetric::Form::mixed);
    return row;
  }

  /// Throws InputError where the two directions are one.
  Shape shape(const Material& material) const {
    const ConstantsOf own(material, name);
    const Vector3& along = own.direction("direction");
    const Vector3 across = own.direction("across") - along * along.dot(own.direction("across"));
    if (!(across.norm() > 1e-6)) throw InputError("holzapfel_gasser_ogden: `across` is along `direction`");
    const double angle = own.number("angle");
    const Vector3 cosine = std::cos(angle) * along, sine = std::sin(angle) * across.normalized();
    return {own.modulus("c"), own.modulus("k1"), own.number("k2"), own.number("kappa"), {cosine + sine, cosine - sine}};
  }
};

}  // namespace elastin
