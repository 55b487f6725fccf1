#pragma once
#include <algorithm>
#include <cmath>

#include "elastin/core/laws/cell_kernel.h"

namespace elastin {

/// The material's fibres in a solid, to be added to any law of the matrix: W = ψ(λ − 1), ψ′ the fibres' nominal stress,
/// λ² = aᵀ C a the squared stretch along them, S = (ψ′/λ) a aᵀ.
/// [fibre term of Weiss, Maker & Govindjee 1996, without their matrix]
struct FibreLaw {
  static constexpr std::string_view name = "fibre";
  static constexpr std::string_view summary = "the material's fibres, added to the law of the matrix; solids";
  static constexpr std::string_view source = "fibre-reinforced solids";

  struct Solid {
    Vector3 direction;  ///< a, unit
    StressStrain curve;

    Matrix3 stress(const Matrix3& A) const {
      const double strain = strain_along(A);
      return curve.stress(strain) / (1 + strain) * direction * direction.transpose();
    }

    /// 1/(2 λ²) (ψ″ − ψ′/λ) a aᵀ a aᵀ.
    TangentModuli<3> tangent(const Matrix3& A) const {
      const double strain = strain_along(A), stretch = 1 + strain;
      const double change = (curve.modulus(strain) - curve.stress(strain) / stretch) / (2 * stretch * stretch);
      const Vector3& a = direction;
      Eigen::Matrix<double, 6, 1> along;
      along << a[0] * a[0], a[1] * a[1], a[2] * a[2], a[0] * a[1], a[0] * a[2], a[1] * a[2];
      return change * along * along.transpose();
    }

    double energy(const Matrix3& A) const { return curve.energy_density(strain_along(A)); }

   private:
    /// λ − 1 from λ² − 1, without cancellation; λ no smaller than 1e-7.
    double strain_along(const Matrix3& A) const {
      const double change = std::max(direction.dot(A * direction), 1e-14 - 1);
      return change / (1 + std::sqrt(1 + change));
    }
  };

  /// The material must have fibres.
  Solid solid(const Material& material) const { return {material.fibre->direction, material.fibre->curve}; }
};

}  // namespace elastin
