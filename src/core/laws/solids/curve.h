#pragma once
#include <algorithm>
#include <array>

#include "core/base/dense.h"
#include "core/laws/membranes/curve_membrane.h"
#include "core/laws/membranes/tension_field.h"
#include "core/laws/moduli.h"
#include "core/laws/solids/curve_size.h"
#include "core/laws/solids/principal.h"
#include "elastin/core/laws/cell_kernel.h"

namespace elastin {

/// An isotropic solid that shows exactly the material's nominal curve P(ε) in uniaxial stress, and ν at every strain.
/// Hooke's law between Biot stress and Biot strain U − I, with a secant modulus that depends on the size of the strain:
///   W = Φ(q),  Φ′ = P,  q² = (λ t² + 2μ |U − I|²)/E,  t = tr U − 3,   so that q = |ε| in uniaxial stress,
///   T = (P(q)/(E q)) (λ t I + 2μ (U − I)).             [deformation theory of Hencky 1924, in Biot's measures]
/// q is a norm and Φ convex and increasing, so W is convex in U for any increasing curve, stiffening or softening.
/// Without a curve it is linear elasticity in the frame that turns with the cell.
/// Where tension and compression differ, see CurveSize. In plane stress at constant thickness: CurveMembraneDensity.
struct Curve {
  static constexpr std::string_view name = "curve";
  static constexpr std::string_view summary =
      "the material's own nominal stress-strain curve, with its nu at every strain, tetrahedra";
  static constexpr std::string_view source = "deformation theory [Hencky 1924] in Biot's stress and strain";
  static constexpr std::string_view membrane_summary =
      "the material's nominal curve (or straight), triangles: engineering strain, constant thickness";
  static constexpr bool follows_curve = true;

  struct Solid {
    double lambda, mu;  ///< λ/E, μ/E
    StressStrain curve;

    Matrix3 stress(const Matrix3& A) const {
      const Vector3 values = principal_values(A);
      return principal_function(A, values, Present(*this, values).stress);
    }

    /// In the axes of C the diagonal of S changes with the diagonal of C, and S_ij with C_ij by
    /// (S_i − S_j)/(λ_i² − λ_j²), which needs no case for equal stretches.
    TangentModuli<3> tangent(const Matrix3& A) const {
      const SymmetricEigen3 solved = symmetric_eigen3(A);
      const Present now(*this, solved.values);
      const Matrix3 H = now.hessian(*this);
      const Vector3& stretch = now.stretch;
      Matrix3 direct;  // dS_ii/dC_jj
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
          direct(i, j) = (H(i, j) - (i == j ? now.stress[i] : 0)) / (2 * stretch[i] * stretch[j]);
      std::array<double, 3> turning;  // dS_ij/dC_ij
      for (int pair = 0; pair < 3; ++pair) {
        const auto [i, j] = kComponents[3 + pair];
        turning[pair] = -now.pressure / (stretch[i] * stretch[j] * (stretch[i] + stretch[j]));
      }
      return PrincipalAxes{solved.vectors}.tangent(direct, turning);
    }

    double energy(const Matrix3& A) const { return Present(*this, symmetric_eigen3(A).values).size.energy; }

   private:
    struct Present {
      Vector3 stretch, hooke, stress;  ///< λ_i ≥ 1e-7; linear stress over E; S_i [Pa]
      CurveSize size;
      double pressure;  ///< T_i = pressure + 2μ/E secant λ_i

      /// @param values of A
      Present(const Solid& law, const Vector3& values) {
        const Vector3 change = values.cwiseMax(1e-14 - 1);
        stretch = (1 + change.array()).sqrt();
        const Vector3 strain = change.array() / (1 + stretch.array());
        const double t = strain.sum();
        hooke = (law.lambda * t + 2 * law.mu * strain.array()).matrix();
        size = CurveSize(law.curve, std::sqrt(law.lambda * t * t + 2 * law.mu * strain.squaredNorm()), t,
                         3 * law.lambda + 2 * law.mu);
        const Vector3 biot = size.secant * hooke + Vector3::Constant(size.by_t);
        pressure = law.lambda * t * size.secant + size.by_t - 2 * law.mu * size.secant;
        stress = biot.cwiseQuotient(stretch);
      }

      /// ∂T_i/∂λ_j [Pa].
      Matrix3 hessian(const Solid& law) const {
        const Vector3 n = size.q > 0 ? Vector3(hooke / size.q) : Vector3(Vector3::Zero()), one = Vector3::Ones();
        Matrix3 H =
            (size.by_qq - size.secant) * n * n.transpose() + size.by_qt * (n * one.transpose() + one * n.transpose());
        H.array() += size.secant * law.lambda + size.by_tt;
        H.diagonal().array() += 2 * size.secant * law.mu;
        return H;
      }
    };
  };

  /// Throws InputError unless −1 < ν < ½.
  Solid solid(const Material& material) const {
    Material unit;
    unit.youngs_modulus = 1;
    unit.poissons_ratio = material.poissons_ratio;
    const auto [lambda, mu] = lame<3>(unit);
    return {lambda, mu, material.curve ? *material.curve : StressStrain::linear(material.youngs_modulus)};
  }
  /// Throws InputError unless −1 < ν ≤ ½.
  IsotropicMembrane<CurveMembraneDensity> membrane(const Material& material) const { return {material}; }
};

}  // namespace elastin
