#pragma once
#include <vector>

#include "elastin/core/model/material.h"

namespace elastin::lab {

/// A sum Σ share e^(−t/time) by which a quantity is from its end, as part of what it is compared with.
using DecayingTerms = std::vector<Relaxation::Term>;

/// Of the force under a displacement that grows evenly within `ramp` [s] and is held, t from the end of the ramp on, as
/// part of the force there: share g τ/ramp (1 − e^(−ramp/τ)) of a term of the relaxation.
DecayingTerms terms_of_force(const Relaxation& relaxation, double ramp);

/// Of the displacement under a force that is put on at once and stays, t from then on, as part of the displacement in
/// the end: the retardation times are where the complex modulus vanishes, g₀ + Σ g s/(s + 1/τ) + θ s = 0 at
/// s = −1/time.                                                                        [Tschoegl 1989, section 8.1]
DecayingTerms terms_of_displacement(const Relaxation& relaxation);

/// Σ share e^(−t/time).
double sum_at(const DecayingTerms& terms, double t);

/// The time [s], ≥ 0, from which on the sum is at most `share`, > 0.
double time_until(const DecayingTerms& terms, double share);

}  // namespace elastin::lab
