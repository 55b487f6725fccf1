#pragma once
#include <memory>

#include "elastin/core/linear/linear_solver.h"

namespace elastin {

/// A model whose cells resist changes of volume no more than a soft material does, at one state: a stiffness K̃ ≤ K on
/// which a hierarchy of grids does not lock.
class SoftVolume {
 public:
  /// λ / μ at rest, the largest among pressures of whole cells; 0 where no pressure is one, or where a load or time has
  /// a part in the stiffness, which cannot be taken along.
  static double ratio(const Tangent& tangent);
  /// Whether displacements and pressures together are found sooner than displacements alone: at rest. Measured:
  /// hexahedra of 27 nodes, whose pressures are linear, 7 times at ν = 0.499; with one pressure a cell no sooner.
  static bool pays(const Tangent& tangent);
  /// Of a tangent with a ratio above kSoftRatio.
  explicit SoftVolume(const Tangent& tangent);

  const Tangent& tangent() const { return *tangent_; }
  /// What of the pressures' stiffness it has.
  double part() const { return part_; }

 private:
  Model model_;
  State state_;
  double part_;
  std::unique_ptr<Tangent> tangent_;
};

/// λ / μ of a soft volume.
constexpr double kSoftRatio = 1;

/// Displacements and the pressures of cells together, by minimal residuals with a hierarchy over the soft volume: where
/// the material keeps its volume nearly. Anything else is left to multigrid.
std::unique_ptr<LinearSolver> make_mixed();

}  // namespace elastin
