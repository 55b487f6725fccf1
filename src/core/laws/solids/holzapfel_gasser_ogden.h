#pragma once
#include <algorithm>
#include <array>
#include <cmath>

#include "core/laws/exponential.h"
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
    std::array<Components, 2> families;  ///< a aᵀ

    Matrix3 stress(const Strained& point) const {
      const Isochoric now(point);
      const Components first = now.first_slope();
      Components S = each_component([&](int row) { return c * first[row]; });
      for (const Components& aa : families)
        if (const Family f(*this, now, aa, point); f.strain > 0) {
          const double tension = 2 * k1 * f.strain * growth(f.strain);
          const Components slope = f.slope(*this, now, aa, first);
          S = each_component([&](int row) { return S[row] + tension * slope[row]; });
        }
      return tensor(S);
    }

    TangentModuli<3> tangent(const Strained& point) const {
      const Isochoric now(point);
      const Components first = now.first_slope();
      TangentModuli<3> result = TangentModuli<3>::Zero();
      double even = c / 2;
      for (const Components& aa : families)
        if (const Family f(*this, now, aa, point); f.strain > 0) {
          const double E = f.strain, e = growth(E), g = k1 * E * e;
          const Components slope = f.slope(*this, now, aa, first);
          add_square(2 * k1 * (1 + 2 * k2 * E * E) * e, slope, result);
          now.add_along_curvature(2 * g * (1 - 3 * kappa), aa, f.change, result);
          even += g * kappa;
        }
      now.add_first_curvature(2 * even, result);
      return result;
    }

    double energy(const Strained& point) const {
      const Isochoric now(point);
      double sum = c / 2 * now.first();
      for (const Components& aa : families)
        if (const Family f(*this, now, aa, point); f.strain > 0) sum += k1 / (2 * k2) * std::expm1(power(f.strain));
      return sum;
    }

   private:
    struct Family {
      double change, strain;  ///< aᵀ A a; E

      Family(const Shape& law, const Isochoric& now, const Components& aa, const Matrix3& A)
          : change(double_product(aa, A)), strain(law.kappa * now.first() + (1 - 3 * law.kappa) * now.along(change)) {}
      /// ∂E/∂C, of ∂Ĩ₁/∂C.
      Components slope(const Shape& law, const Isochoric& now, const Components& aa, const Components& first) const {
        const Components along = now.along_slope(aa, change);
        return each_component([&](int row) { return law.kappa * first[row] + (1 - 3 * law.kappa) * along[row]; });
      }
    };
    double power(double E) const { return std::min(k2 * E * E, kMostPower); }
    double growth(double E) const { return 1 + limited_expm1(power(E)); }
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
    const Vector3 plus = cosine + sine, minus = cosine - sine;
    return {own.modulus("c"),
            own.modulus("k1"),
            own.number("k2"),
            own.number("kappa"),
            {symmetric_product(plus, plus), symmetric_product(minus, minus)}};
  }
};

}  // namespace elastin
