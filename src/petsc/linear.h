#pragma once
#include <memory>
#include <string>
#include <vector>

#include "elastin/core/linear/linear_solver.h"
#include "petsc/boxes.h"
#include "petsc/shared_model.h"

namespace elastin::petsc {

/// The stiffness of a shared model at one state.
class SharedTangent {
 public:
  /// `tangent`: of its local model; it must outlive this.
  SharedTangent(SharedModel& model, const Tangent& tangent);

  SharedModel& model() const { return model_; }
  const Tangent& local() const { return tangent_; }
  const Positions& positions() const { return tangent_.positions(); }
  /// K_aa [N/m] of each owned molecule.
  const std::vector<Matrix3>& diagonal() const { return diagonal_; }
  /// K motion [N] of owned molecules, from the motion of the subdomain's.
  void apply(const Positions& local, Vec result) const;
  /// K motion in the free directions.
  void apply(Vec motion, Vec result) const;
  /// The unbalanced force [N] that rounding of the positions alone makes; as elastin::rounding_floor.
  double rounding_floor() const;

 private:
  SharedModel& model_;
  const Tangent& tangent_;
  std::vector<Matrix3> diagonal_;
  mutable Positions motion_, forces_;
  mutable Tangent::ApplyWorkspace workspace_;
};

struct SharedLinearResult {
  LinearStatus status = LinearStatus::solved;
  int iterations = 0;
  double residual = 0;         ///< ‖b − K x‖ / ‖b‖
  std::string preconditioner;  ///< "pcg", "multigrid", "gamg" …
};

/// Solves K x = b in the free directions by conjugate gradients. `boxes` null: by the blocks of molecules alone. On a
/// negative mode x is a descent direction of ½ xᵀKx − bᵀx.
SharedLinearResult solve_linear(const SharedTangent& tangent, const BoxHierarchy* boxes, Vec rhs, double tolerance,
                                Vec solution);

/// A way out of an equilibrium that is no minimum: a direction of negative stiffness that conjugate gradients meet for
/// a load with a part in all of them. False without such a motion. Adds to `iterations`.
bool find_negative_direction(const SharedTangent& tangent, Vec direction, int& iterations);

}  // namespace elastin::petsc
