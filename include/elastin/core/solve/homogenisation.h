#pragma once
#include <optional>
#include <vector>

#include "elastin/core/solve/statics.h"

namespace elastin {

/// Elastic stiffness, Voigt's order xx yy zz yz xz xy with engineering shear strains [Pa].
using Stiffness6 = Eigen::Matrix<double, 6, 6>;

/// Σ f (x − middle)ᵀ [N m] of forces [N], one a molecule of the list, at `positions` [m]: of all forces on a body in
/// balance, its volume times its mean stress, whatever the `middle`; one near theirs has small arms and little
/// rounding.
Matrix3 virial(const Positions& forces, const std::vector<int>& molecules, const Positions& positions,
               const Vector3& middle);

/// The displacement [m] of each molecule, 3 × n, under the strain whose Voigt number `load_case` (0 … 5) is 1, in the
/// directions of `axes` (orthonormal columns).
Positions uniformly_strained(const Body& body, int load_case, const Matrix3& axes = Matrix3::Identity());

/// What six small strains of a body's surface say of its stiffness.
struct Homogenised {
  Stiffness6 stiffness = Stiffness6::Zero();  ///< not made symmetric; zero where a solve fails
  StaticResult result;  ///< of the first solve that fails; else the largest residual and all linear iterations
};

/// The body's mean stiffness about the state `at`, in the directions of `axes` (orthonormal columns): the molecules of
/// its `surface`, which the model's first supports must fix in all directions and in this order, follow a uniform
/// strain, the others find their balance, and the surface's forces give the mean stress Σ f xᵀ / volume [m³]. Exact for
/// a homogeneous solid of any form.                                                   [Hill 1963, kinematic conditions]
Homogenised homogenise(Model& model, const std::vector<int>& surface, double volume, const Positions& at,
                       const Matrix3& axes = Matrix3::Identity(), const StaticOptions& options = {});

/// The inverse of its symmetric part [1/Pa]; nothing where that is singular or not positive.
std::optional<Stiffness6> compliance_of(const Stiffness6& stiffness);

/// What one number can say of an anisotropic solid: moduli averaged over all directions, [Pa].
struct IsotropicMeans {
  double bulk_voigt, bulk_reuss, shear_voigt, shear_reuss;       ///< equal strain, equal stress
  double bulk() const { return (bulk_voigt + bulk_reuss) / 2; }  ///< [Hill 1952]
  double shear() const { return (shear_voigt + shear_reuss) / 2; }
  double youngs() const { return 9 * bulk() * shear() / (3 * bulk() + shear()); }
  double poissons_ratio() const { return (3 * bulk() - 2 * shear()) / (2 * (3 * bulk() + shear())); }
  /// 0 for an isotropic solid.                                       [Ranganathan & Ostoja-Starzewski 2008, eq. 9]
  double anisotropy_index() const { return 5 * shear_voigt / shear_reuss + bulk_voigt / bulk_reuss - 6; }
};

/// Means of a symmetric stiffness and its inverse.                             [Voigt 1928, Reuss 1929, Hill 1952]
IsotropicMeans isotropic_means(const Stiffness6& stiffness, const Stiffness6& compliance);

}  // namespace elastin
