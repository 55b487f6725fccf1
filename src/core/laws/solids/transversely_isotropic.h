#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/laws/exponential.h"
#include "core/laws/solids/isochoric.h"
#include "elastin/core/laws/material_law.h"

namespace elastin {

/// Mooney–Rivlin with fibres along a, ψ = c₁ (Ĩ₁ − 3) + c₂ (Ĩ₂ − 3) + F(λ̃), λ̃² = Ĩ₄ = a · C̃ a:
///   λ̃ F′ = 0                          λ̃ ≤ 1: a fibre buckles
///        = c₃ (e^(c₄ (λ̃ − 1)) − 1)    up to λ_m: it becomes straight
///        = c₅ λ̃ + c₆                  beyond, c₆ so that the stress is continuous.
/// Without c₃ its slope is too, c₃ = c₅/c₄ e^(−c₄ (λ_m − 1)).                    [Weiss, Maker & Govindjee 1996, eq. 6]
struct TransverselyIsotropic : NearlyIncompressible<TransverselyIsotropic> {
  static constexpr std::string_view name = "transversely_isotropic";
  static constexpr std::string_view summary =
      "ligament and tendon: Mooney-Rivlin with fibres that have a toe region, nearly incompressible";
  static constexpr std::string_view source = "[Weiss, Maker & Govindjee 1996]";

  struct Fibres {
    double c3, c4, c5, straight;  ///< [Pa], 1, [Pa], λ_m

    /// λ̃ F′, its slope by λ̃, and F, of u = λ̃ − 1.
    double tension(double u) const {
      if (u <= 0) return 0;
      return u <= straight - 1 ? c3 * limited_expm1(c4 * u) : c5 * (u + 1 - straight) + toe_end();
    }
    double slope(double u) const {
      if (u <= 0) return 0;
      return u <= straight - 1 ? c3 * c4 * (1 + limited_expm1(c4 * u)) : c5;
    }
    double energy(double u) const {
      if (u <= 0) return 0;
      const double toe = std::min(u, straight - 1), rest = u - toe;
      // Beyond the toe ∫ (c₅ (s − λ_m) + T_m)/s ds.
      return c3 * integral(toe) + c5 * rest + (toe_end() - c5 * straight) * std::log1p(rest / (1 + toe));
    }

   private:
    double toe_end() const { return c3 * limited_expm1(c4 * (straight - 1)); }

    /// ∫₀ᵘ (e^(c₄ v) − 1)/(1 + v) dv by Gauss's rule of 8 points, in ranges of at most ½ over which the power grows by
    /// at most 2: its error is below 1e-15 of the integral. The closed form, of exponential integrals, cancels near 0.
    double integral(double u) const {
      constexpr std::array<std::array<double, 2>, 4> points{{{0.1834346424956498, 0.3626837833783620},
                                                             {0.5255324099163290, 0.3137066458778873},
                                                             {0.7966664774136267, 0.2223810344533745},
                                                             {0.9602898564975363, 0.1012285362903763}}};
      const double ranges = std::ceil(std::max(2 * u, c4 * u / 2));
      if (!(ranges <= 1000)) return std::numeric_limits<double>::infinity();  // e^2000 is no number
      double sum = 0;
      for (int range = 0; range < static_cast<int>(ranges); ++range)
        for (const auto& [at, weight] : points)
          for (const double part : {(1 + at) / 2, (1 - at) / 2}) {
            const double v = u * (range + part) / ranges;
            sum += weight * std::expm1(c4 * v) / (1 + v);
          }
      return ranges > 0 ? sum * u / (2 * ranges) : 0;
    }
  };

  struct Shape {
    double c1, c2;
    Vector3 direction;
    Fibres fibres;

    Matrix3 stress(const Strained& point) const {
      const Isochoric now(point);
      const Fibre fibre(*this, now, point);
      const Components matrix = now.slope(2 * c1, 2 * c2);
      if (!(fibre.extension > 0)) return tensor(matrix);
      const double tension = 2 * fibre.by_I4();
      const Components along = now.along_slope(fibre.along, fibre.change);
      return tensor(each_component([&](int row) { return matrix[row] + tension * along[row]; }));
    }

    TangentModuli<3> tangent(const Strained& point) const {
      const Isochoric now(point);
      const Fibre fibre(*this, now, point);
      TangentModuli<3> result = TangentModuli<3>::Zero();
      now.add_first_curvature(2 * c1, result);
      if (c2 != 0) now.add_second_curvature(2 * c2, result);
      if (!(fibre.extension > 0)) return result;
      const Components slope = now.along_slope(fibre.along, fibre.change);
      add_square(2 * fibre.by_I4_twice(), slope, result);
      now.add_along_curvature(2 * fibre.by_I4(), fibre.along, fibre.change, result);
      return result;
    }

    double energy(const Strained& point) const {
      const Isochoric now(point);
      const auto [first, second] = now.invariants();
      return c1 * first + c2 * second + fibres.energy(Fibre(*this, now, point).extension);
    }

   private:
    struct Fibre {
      const Fibres& fibres;
      Components along;          ///< a aᵀ
      double change, extension;  ///< aᵀ A a; λ̃ − 1

      Fibre(const Shape& law, const Isochoric& now, const Matrix3& A)
          : fibres(law.fibres),
            along(symmetric_product(law.direction, law.direction)),
            change(double_product(along, A)) {
        const double excess = std::max(now.along(change), -1.);
        extension = excess / (1 + std::sqrt(1 + excess));
      }
      double I4() const { return (1 + extension) * (1 + extension); }
      /// ∂F/∂Ĩ₄ = λ̃F′/(2 Ĩ₄) and ∂²F/∂Ĩ₄².
      double by_I4() const { return fibres.tension(extension) / (2 * I4()); }
      double by_I4_twice() const {
        return (fibres.slope(extension) * (1 + extension) / 2 - fibres.tension(extension)) / (2 * I4() * I4());
      }
    };
  };

  static MaterialLaw constants() {
    constexpr double inf = std::numeric_limits<double>::infinity(), none = std::numeric_limits<double>::quiet_NaN();
    MaterialLaw row;
    row.parameters = {
        {"c1", dimension::pressure, -inf, inf, none, "c₁ of the matrix", false, ValueKind::number, true},
        {"c2", dimension::pressure, -inf, inf, 0, "c₂ of the matrix"},
        {"c3", dimension::pressure, 0, inf, none,
         "c₃, scale of the toe region; without it the slope has no jump at its end"},
        {"c4", dimension::none, 0, 500, none, "c₄, rate of the toe region", true, ValueKind::number, true},
        {"c5", dimension::pressure, 0, inf, none, "c₅, slope of straight fibres", false, ValueKind::number, true},
        {"lambda_max", dimension::none, 1, 100, none, "λ_m, stretch at which the fibres are straight", false,
         ValueKind::number, true},
        {"direction", dimension::none, 0, 0, none, "direction of the fibres at rest", false, ValueKind::direction,
         true}};
    add_bulk_modulus(row);
    return row;
  }

  Shape shape(const Material& material) const {
    const ConstantsOf own(material, name);
    const double c4 = own.number("c4"), c5 = own.modulus("c5"), straight = own.number("lambda_max");
    const double c3 = own.has("c3") ? own.modulus("c3") : c5 / c4 * std::exp(-c4 * (straight - 1));
    if (c4 * (straight - 1) > 500)
      throw InputError("transversely_isotropic: c4 (lambda_max - 1) is " + std::to_string(c4 * (straight - 1)) +
                       "; at most 500, for the stress grows with its exponential");
    return {own.modulus("c1"), own.modulus("c2"), own.direction("direction"), {c3, c4, c5, straight}};
  }
};

}  // namespace elastin
