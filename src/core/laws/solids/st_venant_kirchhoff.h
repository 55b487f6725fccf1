#pragma once
#include "core/laws/membranes/membrane.h"
#include "core/laws/membranes/tension_field.h"
#include "core/laws/moduli.h"
#include "elastin/core/laws/cell_kernel.h"
#include "elastin/core/shapes/simplices.h"

namespace elastin {

/// In plane stress, as an energy per area of the in-plane strain: tr E = τ/2, |E|² = (τ² + ρ)/8.
struct StVenantKirchhoffDensity {
  static constexpr bool resists_flattening = false;

  double lambda, mu;  ///< times t [N/m]

  /// Throws InputError unless −1 < ν ≤ ½.
  explicit StVenantKirchhoffDensity(const Material& m)
      : lambda(lame<2>(m).lambda * m.thickness), mu(lame<2>(m).mu * m.thickness) {}

  Jet operator()(const PlaneStrain& strain) const {
    const Jet trace = Jet::first(strain.trace);
    return 0.125 * (lambda + mu) * trace * trace + 0.125 * mu * Jet::second(strain.split);
  }
};

/// S = λ tr(E) I + 2μ E, E = ½ (C − I). [L03, D08] Exact linear elasticity at small strain; under strong compression it
/// softens, and it lets a cell fall flat (J → 0) at finite energy.
struct StVenantKirchhoff {
  static constexpr std::string_view name = "st_venant_kirchhoff";
  static constexpr std::string_view summary =
      "linear stress over Lagrangian strain, tetrahedra: small strain, large rotation";
  static constexpr std::string_view source = "[L03]";
  static constexpr std::string_view membrane_summary =
      "linear plane stress over Lagrangian strain, triangles (biquadratic springs)";
  static constexpr std::string_view membrane_source = "[D08]";

  struct Solid {
    double lambda, mu;  ///< [Pa]

    Matrix3 stress(const Matrix3& A) const { return lambda / 2 * A.trace() * Matrix3::Identity() + mu * A; }
    TangentModuli<3> tangent(const Matrix3&) const {
      TangentModuli<3> result = TangentModuli<3>::Zero();
      result.topLeftCorner<3, 3>().setConstant(lambda / 2);
      result.diagonal().head<3>().array() += mu;
      result.diagonal().tail<3>().setConstant(mu / 2);
      return result;
    }
    double energy(const Matrix3& A) const { return (lambda * A.trace() * A.trace() + 2 * mu * A.squaredNorm()) / 8; }
  };

  /// Throws InputError unless −1 < ν < ½.
  Solid solid(const Material& material) const {
    const auto [lambda, mu] = lame<3>(material);
    return {lambda, mu};
  }
  /// Throws InputError unless −1 < ν ≤ ½.
  IsotropicMembrane<StVenantKirchhoffDensity> membrane(const Material& material) const { return {material}; }
};

/// On first-order simplices, in closed form: S is linear in the squared lengths, so that q = K (s − s⁰) with the
/// constant symmetric slope K at rest.
template <int dimensions>
struct StVenantKirchhoffSimplex {
  using Shape = std::conditional_t<dimensions == 3, Tetrahedron4, Triangle3>;
  static constexpr int nodes = Shape::nodes;

  struct Constants {
    CellMatrix<nodes> stiffness;     ///< K [N/m³]
    CellVector<nodes> rest_squared;  ///< s⁰ [m²]
  };
  StVenantKirchhoff law = {};

  /// @param rest corners [m], not flat. Throws InputError if the law does not take the material.
  Constants constants(const NodePositions<nodes>& rest, const Material& material) const {
    const PointKernel<StVenantKirchhoff, Shape> at_points{law};
    const auto k = at_points.constants(rest, material);
    return {at_points.slope(k, k.rest.squared_lengths), k.rest.squared_lengths};
  }

  /// q [N/m] from squared lengths s [m²].
  CellVector<nodes> force_densities(const Constants& k, const CellVector<nodes>& s) const {
    return k.stiffness * (s - k.rest_squared);
  }

  /// ∂q/∂s [N/m³].
  CellMatrix<nodes> slope(const Constants& k, const CellVector<nodes>&) const { return k.stiffness; }

  /// W = ¼ (s − s⁰)ᵀ K (s − s⁰) [J].
  double energy(const Constants& k, const CellVector<nodes>& s) const {
    const CellVector<nodes> change = s - k.rest_squared;
    return change.dot(k.stiffness * change) / 4;
  }
};
template <>
struct CellKernel<StVenantKirchhoff, Tetrahedron4> : StVenantKirchhoffSimplex<3> {};
template <>
struct CellKernel<StVenantKirchhoff, Triangle3> : StVenantKirchhoffSimplex<2> {};

}  // namespace elastin
