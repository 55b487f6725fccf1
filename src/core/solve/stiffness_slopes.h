#pragma once
#include "elastin/core/laws/local.h"

namespace elastin {

/// What the stiffness of each element of a law makes of all forces at one state: ∂f/∂(ln k_c), which is what element c
/// adds to the forces. The law must outlive it.
class StiffnessSlopes {
 public:
  StiffnessSlopes(const LocalElasticity& law, const Positions& at);
  /// Adds Σ_c changes_c ∂f/∂(ln k_c) [N].
  void add_forces(const VectorX& changes, Positions& forces) const;
  /// λ·∂f/∂(ln k_c) of each element, for λ of any unit, 3 × n.
  VectorX work(const Positions& motion) const;

 private:
  const LocalElasticity& law_;
  std::vector<int> starts_{0};  ///< of element c the columns from starts_[c] to starts_[c + 1]
  Positions forces_;            ///< of each element on each of its molecules
};

/// StiffnessSlopes(law, at).work(motion), for one motion: nothing is stored.
VectorX work_by_stiffness(const LocalElasticity& law, const Positions& at, const Positions& motion);

}  // namespace elastin
