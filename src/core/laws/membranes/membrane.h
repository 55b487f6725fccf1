#pragma once
#include <algorithm>
#include <limits>

#include "core/laws/jet.h"
#include "elastin/core/laws/law.h"

namespace elastin {

/// The in-plane strain of a triangle as an isotropic law needs it: trace τ = tr(C − I) and ρ = (C₁ − C₂)², the squared
/// difference of the principal values of the right Cauchy–Green tensor C. Both vanish at rest.
/// det C = 1 + τ + (τ² − ρ)/4.
struct PlaneStrain {
  double trace, split;
};

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
  { Density::resists_flattening } -> std::convertible_to<bool>;
  { density(strain) } -> std::convertible_to<Jet>;
};

template <class Density>
struct TensionField;

/// Any isotropic membrane at work. With A = C − I, u = A₁₁ − A₂₂ and v = 2 A₁₂ it is ρ = u² + v², hence
///   S = 2 ∂w/∂C,  ∂w/∂(τ, u, v) = (w_τ, 2u w_ρ, 2v w_ρ).
/// No principal direction is needed, so equal stretches are no special case.
template <MembraneDensity Density>
struct IsotropicMembrane {
  Density density;

  IsotropicMembrane(const Material& material) : density(material) {}  // NOLINT: that is what a law does

  Eigen::Matrix2d stress(const Eigen::Matrix2d& A) const {
    const Present now(density, A);
    const Vector3 g = now.slopes();
    Eigen::Matrix2d S;
    S << g[0] + g[1], g[2], g[2], g[0] - g[1];
    return 2 * S;
  }

  TangentModuli<2> tangent(const Eigen::Matrix2d& A) const {
    const Present now(density, A);
    const Vector3 split(0, 2 * now.u, 2 * now.v), trace = Vector3::UnitX();  // ∂ρ, ∂τ
    Matrix3 H = now.w.xx * trace * trace.transpose() + now.w.yy * split * split.transpose() +
                now.w.xy * (trace * split.transpose() + split * trace.transpose());
    H(1, 1) += 2 * now.w.y;
    H(2, 2) += 2 * now.w.y;
    Matrix3 strains;  // (τ, u, v) of (A₁₁, A₂₂, 2 A₁₂)
    strains << 1, 1, 0, 1, -1, 0, 0, 0, 1;
    return 2 * strains.transpose() * H * strains;
  }

  double energy(const Eigen::Matrix2d& A) const {
    const Present now(density, A);
    if constexpr (Density::resists_flattening)
      if (now.flat()) return std::numeric_limits<double>::infinity();
    return now.w.value;
  }

  /// The law that bears no compression, of a material.
  static IsotropicMembrane<TensionField<Density>> without_compression(const Material& material) { return {material}; }

 private:
  struct Present {
    double u, v;
    PlaneStrain strain;
    Jet w;

    Present(const Density& density, const Eigen::Matrix2d& A)
        : u(A(0, 0) - A(1, 1)), v(2 * A(0, 1)), strain{A.trace(), u * u + v * v}, w(density(strain)) {}

    Vector3 slopes() const { return {w.x, 2 * u * w.y, 2 * v * w.y}; }
    bool flat() const { return !(1 + strain.trace + (strain.trace * strain.trace - strain.split) / 4 > kFlatTriangle); }
  };
};

}  // namespace elastin
