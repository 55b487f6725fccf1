#pragma once
#include <vector>

#include "core/solve/newton.h"

namespace elastin {

/// What an equilibrium leaves for linear solves about it (see make_last_solve): no more than where they begin, so that
/// their answers are the same within their tolerance.
class LastSolve {
 public:
  /// Another equilibrium is sought.
  void begin(const Model& model);
  /// All of it, where it is of this model and as many molecules; else nothing.
  LastSolve taken_for(const Model& model);
  /// A motion on the way to the equilibrium: of the last ones the sum is stored.
  void note(Positions motion, const std::vector<Support>& supports);
  /// The sum of these motions that is nearest to the x of K x = rhs, by energy [Galerkin]; rhs becomes what it leaves.
  Positions nearest(const Tangent& tangent, const std::vector<Support>& supports, Positions& rhs) const;

  CachedSolver solver;

 private:
  const Model* model_ = nullptr;
  std::vector<Positions> motions_;  ///< in the free directions
};

}  // namespace elastin
