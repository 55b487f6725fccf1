#pragma once
#include <vector>

#include "elastin/core/forces/model.h"
#include "elastin/core/forces/tangent.h"

namespace elastin {

/// Loads and internal damping as steppers see them that move one molecule, or one constraint, at a time: their forces
/// at one state, and of each molecule a block D that bounds how they answer to its motion u,
///   F_a(u) ≈ F_a − D_a (u_a − those of that state).
/// Stiffness and damping between molecules are added to D, so that to go from one such state to the next leads to where
/// the true forces balance; loads that act on each molecule by itself (drag, a grip) are exact in one pass.
class OuterForces {
 public:
  /// Blocks and forces at a state, of a step with these weights. Allocates nothing but in its first call.
  void begin(const Model& model, const State& state, const Weights& weights);
  /// The same where they change with the state, but for the blocks of internal damping: contact that sets in meanwhile
  /// would be met by forces alone, and forces without a block throw molecules far. No block is less than at the states
  /// before: where contact is left at one and met at the next, neither would end it.
  void update(const Model& model, const State& state, const Weights& weights);

  bool vary() const { return vary_; }
  const Positions& forces() const { return forces_; }        ///< [N]
  const Positions& positions() const { return positions_; }  ///< of the state at which they are these [m]
  /// D of a molecule [N/m].
  const Matrix3& block(int molecule) const { return blocks_[molecule]; }

 private:
  void add_viscous_blocks(const Model& model, const State& state, const Weights& weights);
  bool vary_ = false;
  Positions forces_, positions_;
  std::vector<Matrix3> blocks_, viscous_, loaded_, kept_;  ///< kept: of the loads at the state before
  VectorX slopes_, squared_lengths_, rates_;
  Workspace workspace_;
};

}  // namespace elastin
