#pragma once
#include <memory>

#include "elastin/core/forces/elasticity.h"

namespace elastin {

/// The material's active fibres (Material::active) in the solid cells of a body, to be added to a law of the
/// matrix: the stress T a aᵀ along the fibres as they lie now, T = T_max · activation(t) · f(λ/λ_opt), with
///   f(r) = 1 − 4 (1 − r)²  for 0.6 < r < 1.4,  9 (r − 0.4)² below,  9 (r − 1.6)² above,  0 from 0.4 down and 1.6 up.
/// T is Kirchhoff's stress, which is Cauchy's where the volume stays: so that it has an energy.  [Blemker et al. 2005]
/// An equilibrium sees the activation of its state's time, a step in time that at its end.
/// Throws InputError on a fault. The body must outlive it.
ElasticTerms make_muscle(const Body& body, const Material& material);

/// f above, its slope, and ∫ f/r dr from 0.4: what is left of the largest force at a stretch r, ≥ 0, over the best one.
struct ForceLength {
  double value, slope, work;
};
ForceLength force_length(double stretch);

/// Throws InputError unless T_max and the best stretch are above 0.
void check_active_fibre(const ActiveFibre& active);

}  // namespace elastin
