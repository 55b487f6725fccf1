#pragma once
#include "elastin/core/model/material.h"

namespace elastin::lab {

/// G = E / (2 (1 + ν)) [Pa].
double shear_modulus(const Material& material);
/// K = E / (3 (1 − 2ν)) [Pa].
double bulk_modulus(const Material& material);

/// Torsion constant J [m⁴] of a rectangle, T = G J θ/l, of a bar whose ends are free to warp.
/// J = a b³ (1/3 − 64 b/(π⁵ a) Σ tanh(nπa/2b)/n⁵), n odd.                                [Timoshenko & Goodier, §109]
double torsion_constant(double a, double b);

}  // namespace elastin::lab
