#pragma once
#include "core/laws/membranes/tension_field.h"
#include "elastin/core/laws/simplex.h"

namespace elastin {

/// The same membrane as an energy per area of the in-plane strain: tr E = τ/2, |E|² = (τ² + ρ)/8.
struct StVenantKirchhoffDensity {
  static constexpr std::string_view name = "st_venant_kirchhoff_membrane";
  static constexpr std::string_view summary = "linear plane stress over Lagrangian strain, triangles";
  static constexpr std::string_view source = "[D08]";
  static constexpr bool follows_curve = false;
  static constexpr bool resists_flattening = false;

  double lambda, mu;  ///< times t [N/m]

  /// Throws InputError unless −1 < ν ≤ ½.
  explicit StVenantKirchhoffDensity(const Material& m)
      : lambda(lame<3>(m).lambda * m.thickness), mu(lame<3>(m).mu * m.thickness) {}

  Jet operator()(const PlaneStrain& strain) const {
    const Jet trace = Jet::first(strain.trace);
    return 0.125 * (lambda + mu) * trace * trace + 0.125 * mu * Jet::second(strain.split);
  }
};

/// S = λ tr(E) I + 2μ E, E = ½ (C − I): linear in the squared lengths, so that q = K (s − s⁰) with a constant symmetric
/// K, K_cd = V/2 (λ tr B_c tr B_d + 2μ B_c : B_d), V the volume, or thickness times area. [L03, D08] Exact linear
/// elasticity at small strain; under strong compression it softens, and it lets a cell fall flat (J → 0) at finite
/// energy.
template <int cell_corners>
struct StVenantKirchhoffCell {
  static constexpr int corners = cell_corners;
  static constexpr std::string_view name = corners == 4 ? "st_venant_kirchhoff" : "st_venant_kirchhoff_membrane";
  static constexpr std::string_view summary =
      corners == 4 ? "linear stress over Lagrangian strain, tetrahedra: small strain, large rotation"
                   : "linear plane stress over Lagrangian strain, triangles (biquadratic springs)";
  static constexpr std::string_view source = corners == 4 ? "[L03]" : "[D08]";

  static std::string unsuited(const Body& body) {
    if constexpr (corners == 4) return body.tetrahedra.empty() ? "needs tetrahedra" : "";
    return body.triangles.empty() ? "needs triangles" : "";
  }

  struct Constants {
    CellMatrix<corners> stiffness;     ///< K [N/m³]
    CellVector<corners> rest_squared;  ///< s⁰ [m²]
  };

  /// @param rest corners [m], not flat. Throws InputError unless −1 < ν < ½.
  Constants constants(const Eigen::Matrix<double, 3, corners>& rest, const Material& material) const {
    const Simplex<corners> cell(rest);
    const auto [lambda, mu] = lame<corners>(material);
    const double volume = cell.measure * (corners == 4 ? 1 : material.thickness);
    return {stiffness(cell, volume, lambda, mu), cell.squared_lengths};
  }

  /// K [N/m³] from λ and μ [Pa].
  static CellMatrix<corners> stiffness(const Simplex<corners>& cell, double volume, double lambda, double mu) {
    CellMatrix<corners> K;
    for (int c = 0; c < K.rows(); ++c)
      for (int d = 0; d < K.cols(); ++d) {
        const auto Bc = cell.basis(c), Bd = cell.basis(d);
        K(c, d) = volume / 2 * (lambda * Bc.trace() * Bd.trace() + 2 * mu * Bc.cwiseProduct(Bd).sum());
      }
    return K;
  }

  /// q [N/m] from squared lengths s [m²].
  CellVector<corners> force_densities(const Constants& k, const CellVector<corners>& s) const {
    return k.stiffness * (s - k.rest_squared);
  }

  /// ∂q/∂s [N/m³].
  CellMatrix<corners> slope(const Constants& k, const CellVector<corners>&) const { return k.stiffness; }

  /// W = ¼ (s − s⁰)ᵀ K (s − s⁰) [J].
  double energy(const Constants& k, const CellVector<corners>& s) const {
    const CellVector<corners> change = s - k.rest_squared;
    return change.dot(k.stiffness * change) / 4;
  }
};

using StVenantKirchhoff = StVenantKirchhoffCell<4>;
struct StVenantKirchhoffMembrane : StVenantKirchhoffCell<3> {
  using WithoutCompression = IsotropicMembrane<TensionField<StVenantKirchhoffDensity>>;
};

}  // namespace elastin
