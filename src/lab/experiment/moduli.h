#pragma once
#include "elastin/core/model/material.h"
#include "elastin/lab/experiment/measures.h"

namespace elastin::lab {

/// G = E / (2 (1 + ν)) [Pa].
double shear_modulus(const Material& material);
/// K = E / (3 (1 − 2ν)) [Pa].
double bulk_modulus(const Material& material);

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

/// Means of a stiffness and its inverse.                                             [Voigt 1928, Reuss 1929, Hill
/// 1952]
IsotropicMeans isotropic_means(const Stiffness6& stiffness, const Stiffness6& compliance);

/// Torsion constant J [m⁴] of a rectangle, T = G J θ/l, of a bar whose ends are free to warp.
/// J = a b³ (1/3 − 64 b/(π⁵ a) Σ tanh(nπa/2b)/n⁵), n odd.                                [Timoshenko & Goodier, §109]
double torsion_constant(double a, double b);

}  // namespace elastin::lab
