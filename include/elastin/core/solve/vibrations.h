#pragma once
#include <string>
#include <vector>

#include "elastin/core/solve/statics.h"

namespace elastin {

/// The slowest free vibrations of a body about an equilibrium, small, without damping.
struct Vibrations {
  VectorX frequencies;            ///< [Hz], ascending; 0 = no stiffness (a mechanism), NaN = unstable
  std::vector<Positions> shapes;  ///< of unit modal mass, Σ m |u|² = 1 [1/√kg]
  int rigid_motions = 0;          ///< of the body, or of pieces that nothing joins, free of supports: none of the above
  int iterations = 0;
  Outcome outcome = Outcome::converged;
  std::string cause;
};

/// The `count` (≥ 1) lowest vibrations about `state`, or as many as the body has: K u = ω² M u with the stiffness of
/// everything that acts there. By blocks of conjugate gradients [Knyazev 2001], steered by the static linear solver,
/// with the rigid motions taken out; small bodies by a whole eigenproblem. `tolerance`: of the residual over ω².
/// `stop` is asked before each iteration; true ends it as `interrupted`, without vibrations. May be empty.
Vibrations find_vibrations(Model& model, const State& state, int count, double tolerance = 1e-5,
                           const std::function<bool()>& stop = {});

}  // namespace elastin
