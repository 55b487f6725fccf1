#pragma once
#include <memory>

#include "elastin/core/solve/statics.h"

namespace elastin {

/// What a function m of an equilibrium changes with, to first order.
struct Adjoint {
  StaticResult result;     ///< how the linear solve ended
  Positions forces;        ///< ∂m/∂(force on each molecule), λ [m/N of a displacement], 3 × n; with them
                           ///< dm/dp = ∂m/∂p + λ·∂f/∂p of whatever changes the forces f at the same positions
  Positions displacement;  ///< ∂m/∂(displacement of its support) of each molecule in its fixed directions, 3 × n
};

/// Derivatives of equilibria, by the tangent and the linear solver of Newton's method: what one parameter makes of all
/// molecules (forward), and what all parameters make of one function m of positions and reactions (adjoint), each by
/// one linear solve. With K = −∂f/∂x and the free directions F:
///   K_FF dx_F = df_F − K_FS du_S,   K_FFᵀ λ_F = (∂m/∂x + Kᵀ ∂m/∂R)_F,   λ_S = −∂m/∂R
/// Loads that follow the surface make K unsymmetric: then Kᵀ is factorised. [Haftka & Adelman 1989]
class Sensitivity {
 public:
  /// About an equilibrium. Model, its supports and the state must stay. History counts as at rest, see solve_static.
  /// @param tolerance of the linear solves' residuals, as far as rounding allows it
  Sensitivity(Model& model, const State& state, const StaticOptions& options = {}, double tolerance = 1e-13);
  /// @param last of the solve_static that ended in this state, which it empties
  Sensitivity(Model& model, const State& state, const StaticOptions& options, double tolerance, LastSolve& last);
  ~Sensitivity();
  /// As static_response.
  StaticResponse forward(const Positions& force_change, const Positions& displacement);
  /// @param of_positions ∂m/∂x, 3 × n
  /// @param of_reactions ∂m/∂R of the reaction on each molecule in its fixed directions, 3 × n
  Adjoint adjoint(const Positions& of_positions, const Positions& of_reactions);
  /// ∂m/∂(ln stiffness) of each element of a law of the model: of the spring constants k_c, or of all moduli of cell c,
  /// ∂m/∂k_c = this / k_c. Empty for laws that are not sums of elements, such as those with a history.
  VectorX by_stiffness(const Elasticity& law, const Adjoint& adjoint) const;
  /// What changes of ln stiffness of each element of such a law make of all forces [N], for forward(). Throws
  /// InputError where the law has no elements, or another number of them.
  Positions forces_by_stiffness(const Elasticity& law, const VectorX& changes) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace elastin
