#pragma once
#include <algorithm>
#include <optional>

#include "core/laws/membranes/curve_membrane.h"
#include "core/laws/membranes/membrane.h"
#include "core/laws/moduli.h"
#include "elastin/core/shapes/simplices.h"

namespace elastin {

/// L [1/m²] of (τ, u, v) = L (s − s⁰): with A = C − I in a frame of the triangle at rest, τ = A₁₁ + A₂₂, u = A₁₁ − A₂₂,
/// v = 2 A₁₂, and ρ = u² + v².
inline Matrix3 strains_of(const RestCell<Triangle3>& cell) {
  static constexpr auto pairs = node_pairs<3>();
  Matrix3 strains;
  for (int c = 0; c < 3; ++c) {
    const Eigen::Vector2d a = cell.gradients[0].col(pairs[c][0]), b = cell.gradients[0].col(pairs[c][1]);
    strains.col(c) = -Vector3(a.dot(b), a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]);
  }
  return strains;
}

/// Membrane by the strains along and across each side. [TP, eqs 5–17, in force form: nothing is divided by a strain]
/// Tension of side b, a and c the other two:  F_b = Q b₀ (a₀² q_a − b₀² q_b + c₀² q_c),
///   Q = E t/(8 (1−ν²) |T₀|),  q_s = ε_n(s) + ν ε_τ(s),  ε_τ = s/s₀ − 1,  ε_n = h/h₀ − 1, h the height on side s.
/// At small strain it is plane stress, on any triangle; at finite strain it has no energy: ∂q/∂s is not symmetric.
/// Where the material has a curve, E is its secant modulus at the size of the triangle's strain, see
/// CurveMembraneDensity. A law of triangles' sides: it sees lengths, not C. A triangle falling flat has finite forces,
/// but its heights change ever faster: below an area of 2.5e-8 (a²+b²+c²) the slope is the one at that area. A side
/// shorter than 1e-8 of its rest length counts as that long.
struct TwoParameter {
  using Shape = Triangle3;
  static constexpr std::string_view name = "two_parameter";
  static constexpr std::string_view summary = "membrane from the strain along and across each side; not conservative";
  static constexpr std::string_view source = "[TP] eqs. 5-17";
  static constexpr bool follows_curve = true;

  struct Constants {
    CellMatrix<3> weight;        ///< F = weight · q: −Q b₀³ on the diagonal, Q b₀ a₀² off it [N]
    CellVector<3> rest_squared;  ///< [m²]
    Matrix3 strains;             ///< [1/m²], see strains_of
    double rest_area, nu;        ///< [m²], 1
    std::optional<CurveMembraneDensity> curve;
    double modulus;  ///< E at no strain [Pa]
  };

  /// @param rest corners [m], not flat; the material's thickness t [m] counts. Throws InputError unless −1 < ν ≤ ½.
  Constants constants(const NodePositions<3>& rest, const Material& material) const {
    const RestCell<Triangle3> cell(rest);
    const auto [lambda, mu] = lame<2>(material);
    const double Q = (lambda + 2 * mu) * material.thickness / (8 * cell.weights[0]);  // λ + 2μ = E/(1−ν²)
    const CellVector<3>& s0 = cell.squared_lengths;
    const CellMatrix<3> sign = CellMatrix<3>::Ones() - 2 * CellMatrix<3>::Identity();
    return {Q * s0.cwiseSqrt().asDiagonal() * sign * s0.asDiagonal(),
            s0,
            strains_of(cell),
            cell.weights[0],
            material.poissons_ratio,
            material.curve ? std::optional(CurveMembraneDensity(material)) : std::nullopt,
            material.youngs_modulus};
  }

  /// q [N/m] from squared lengths s [m²]: each tension over the present length.
  CellVector<3> force_densities(const Constants& k, const CellVector<3>& s) const {
    const Present now(k, s);
    return now.force_densities(k) * now.softening(k).value;
  }

  /// ∂q/∂s [N/m³], not symmetric away from rest.
  CellMatrix<3> slope(const Constants& k, const CellVector<3>& s) const {
    const Present now(k, s);
    const CellVector<3> plain = now.force_densities(k);
    // det C = 1 + τ + (τ² − u² − v²)/4, and the area over that at rest is its root.
    const double ratio = std::max(now.ratio, 2.5e-8 * now.s.sum() / k.rest_area);
    const CellVector<3> area_slope =
        k.strains.transpose() * Vector3(2 + now.strain[0], -now.strain[1], -now.strain[2]) / (4 * ratio);
    const CellVector<3> stretch_slope = (2 * now.stretch.cwiseProduct(k.rest_squared)).cwiseInverse();
    CellMatrix<3> strain_slope = now.stretch.cwiseInverse() * area_slope.transpose();
    strain_slope.diagonal().array() += (k.nu - now.ratio / now.stretch.array().square()) * stretch_slope.array();
    CellMatrix<3> result = now.s.cwiseSqrt().cwiseInverse().asDiagonal() * k.weight * strain_slope;
    result.diagonal() -= plain.cwiseQuotient(2 * now.s);
    if (!k.curve) return result;
    const Jet E = now.softening(k);
    const Vector3 by_strain(E.x, 2 * now.strain[1] * E.y, 2 * now.strain[2] * E.y);
    return E.value * result + plain * (k.strains.transpose() * by_strain).transpose();
  }

 private:
  struct Present {
    CellVector<3> s, stretch, lengthening;  ///< [m²]; stretch of each side, and what it is more than 1
    Vector3 strain;                         ///< τ, u, v
    double ratio, growth;                   ///< area over that at rest, and what it is more than 1

    Present(const Constants& k, const CellVector<3>& squared) : s(squared.cwiseMax(1e-16 * k.rest_squared)) {
      const CellVector<3> change = (s - k.rest_squared).cwiseQuotient(k.rest_squared);
      stretch = s.cwiseQuotient(k.rest_squared).cwiseSqrt();
      lengthening = change.array() / (1 + stretch.array());
      strain = k.strains * (s - k.rest_squared);
      const double swelling = strain[0] + (strain[0] * strain[0] - strain.tail<2>().squaredNorm()) / 4;
      ratio = std::sqrt(std::max(0., 1 + swelling));
      growth = ratio > 0 ? swelling / (1 + ratio) : -1;
    }

    CellVector<3> force_densities(const Constants& k) const {
      const CellVector<3> across = (growth - lengthening.array()) / stretch.array();
      return (k.weight * (across + k.nu * lengthening)).cwiseQuotient(s.cwiseSqrt());
    }

    /// E at this strain over that at none.
    Jet softening(const Constants& k) const {
      if (!k.curve) return 1;
      return k.curve->secant({strain[0], strain.tail<2>().squaredNorm()}) / k.modulus;
    }
  };
};

}  // namespace elastin
