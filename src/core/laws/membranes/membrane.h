#pragma once
#include <algorithm>
#include <limits>

#include "core/laws/jet.h"
#include "elastin/core/laws/simplex.h"

namespace elastin {

/// The in-plane strain of a triangle as an isotropic law needs it: trace τ = tr(C − I) and ρ = (C₁ − C₂)², the squared
/// difference of the principal values of the right Cauchy–Green tensor C. Both vanish at rest and come without
/// cancellation from the changes of the squared lengths. det C = 1 + τ + (τ² − ρ)/4.
struct PlaneStrain {
  double trace, split;
};

/// L [1/m²] of (τ, u, v) = L (s − s⁰): with A = C − I in a frame of the triangle at rest, τ = A₁₁ + A₂₂, u = A₁₁ − A₂₂,
/// v = 2 A₁₂, and ρ = u² + v².
inline Matrix3 strains_of(const Simplex<3>& cell) {
  Matrix3 strains;
  for (int c = 0; c < 3; ++c) {
    const Eigen::Matrix2d B = cell.basis(c);
    strains.col(c) = Vector3(B.trace(), B(0, 0) - B(1, 1), 2 * B(0, 1));
  }
  return strains;
}

/// det C below which rounding decides whether a triangle is flat.
inline constexpr double kFlatTriangle = 1e-12;

/// det C − 1 as a jet in (τ, ρ); of a flat triangle its slopes, at kFlatTriangle.
inline Jet swelling(const PlaneStrain& strain) {
  const Jet trace = Jet::first(strain.trace), split = Jet::second(strain.split);
  Jet result = trace + 0.25 * (trace * trace - split);
  result.value = std::max(result.value, kFlatTriangle - 1);
  return result;
}

/// √(1 + change) − 1 without cancellation.
inline Jet root_minus_1(const Jet& change) { return change / (1 + sqrt(1 + change)); }

/// An energy per area at rest [J/m²] of an isotropic membrane: made from a material (thickness in it), gives w(τ, ρ)
/// with its derivatives. `resists_flattening` says whether a flat triangle has infinite energy.
template <class Density>
concept MembraneDensity = requires(const Density& density, const Material& material, const PlaneStrain& strain) {
  Density(material);
  { Density::follows_curve } -> std::convertible_to<bool>;
  { Density::resists_flattening } -> std::convertible_to<bool>;
  { density(strain) } -> std::convertible_to<Jet>;
  { Density::name } -> std::convertible_to<std::string_view>;
};

/// Any isotropic membrane as a cell law: the strain is linear in the changes of the squared lengths (strains_of), hence
///   q = 2 T Lᵀ g,  g = (w_τ, 2u w_ρ, 2v w_ρ);   ∂q/∂s = 2 T Lᵀ (∂g/∂(τ, u, v)) L,   T the area at rest.
/// No principal direction is needed, so equal stretches are no special case.
template <MembraneDensity Density>
struct IsotropicMembrane {
  static constexpr int corners = 3;
  static constexpr std::string_view name = Density::name;
  static constexpr std::string_view summary = Density::summary;
  static constexpr std::string_view source = Density::source;
  static constexpr bool follows_curve = Density::follows_curve;
  static std::string unsuited(const Body& body) { return body.triangles.empty() ? "needs triangles" : ""; }

  struct Constants {
    Matrix3 strains;             ///< L [1/m²]: (τ, u, v) = L (s − s⁰)
    CellVector<3> rest_squared;  ///< s⁰ [m²]
    double area;                 ///< T [m²]
    Density density;
  };

  /// @param rest corners [m], not flat. Throws InputError if the law does not take the material's Poisson's ratio.
  Constants constants(const Matrix3& rest, const Material& material) const {
    const Simplex<3> cell(rest);
    return {strains_of(cell), cell.squared_lengths, cell.measure, Density(material)};
  }

  /// q [N/m] from squared lengths s [m²].
  CellVector<3> force_densities(const Constants& k, const CellVector<3>& s) const {
    const Present now(k, s);
    const Vector3 g(now.w.x, 2 * now.strain[1] * now.w.y, 2 * now.strain[2] * now.w.y);
    return 2 * k.area * k.strains.transpose() * g;
  }

  /// ∂q/∂s [N/m³], symmetric.
  CellMatrix<3> slope(const Constants& k, const CellVector<3>& s) const {
    const Present now(k, s);
    const Vector3 split(0, 2 * now.strain[1], 2 * now.strain[2]);  // ∂ρ
    const Vector3 trace = Vector3::UnitX();
    Matrix3 H = now.w.xx * trace * trace.transpose() + now.w.yy * split * split.transpose() +
                now.w.xy * (trace * split.transpose() + split * trace.transpose());
    H(1, 1) += 2 * now.w.y;
    H(2, 2) += 2 * now.w.y;
    return 2 * k.area * k.strains.transpose() * H * k.strains;
  }

  /// W [J], ≥ 0; +∞ for a flat triangle of a law that resists it.
  double energy(const Constants& k, const CellVector<3>& s) const {
    const Present now(k, s);
    if constexpr (Density::resists_flattening)
      if (now.flat) return std::numeric_limits<double>::infinity();
    return k.area * now.w.value;
  }

 private:
  struct Present {
    Vector3 strain;  ///< τ, u, v
    bool flat;
    Jet w;

    Present(const Constants& k, const CellVector<3>& s) : strain(k.strains * (s - k.rest_squared)) {
      const PlaneStrain plane{strain[0], strain.tail<2>().squaredNorm()};
      flat = !(1 + plane.trace + (plane.trace * plane.trace - plane.split) / 4 > kFlatTriangle);
      w = k.density(plane);
    }
  };
};

}  // namespace elastin
