#pragma once
#include <vector>

#include "core/solve/trial.h"
#include "elastin/core/solve/statics.h"

namespace elastin {

struct NewtonWorkspace;

/// What makes an equilibrium unstable that has no energy to be no minimum of: static divergence.
struct Divergence {
  Positions direction;  ///< that the forces drive the body away along, either way; no columns without one
  double shift = 0;     ///< σ [1/s²], with which the symmetric part of K + σ M is positive there
};

/// The divergence of an equilibrium whose stiffness K is not symmetric. Where its symmetric part is positive, which
/// conjugate gradients find out, no eigenvalue has a negative real part; else K x = λ M x is asked for a real λ < 0, by
/// Arnoldi's iteration with (K + σ M)⁻¹. [Saad 2011] A direction counts only where the forces a little further on lead
/// away on both sides: what sticks holds one of them. None where an answer cannot be found.
/// @param load scattered over the free directions, without motions that nothing resists
Divergence find_divergence(const Problem& problem, const Trial& now, const Positions& load, int& iterations,
                           TrialWorkspace& workspace);

/// Follows a divergence from `now` to another equilibrium, by steps with the stiffness K + σ M, σ falling with the
/// unbalanced force along the direction: pseudo-transient continuation. [Kelley & Keyes 1998] False, and `now` stays,
/// where none is found.
/// @param floor what rounding leaves unbalanced [N]
bool follow_divergence(const Problem& problem, const Divergence& divergence, const StaticOptions& options, double floor,
                       Trial& now, TrialWorkspace& workspace, StaticResult& result);

}  // namespace elastin
