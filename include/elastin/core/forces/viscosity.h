#pragma once
#include <memory>
#include <span>

#include "elastin/core/forces/elasticity.h"
#include "elastin/core/model/body.h"

namespace elastin {

/// Internal damping of a body: resistance of its connections in addition to their law, as force densities q [N/m] from
/// the rates ṡ [m²/s] of the squared lengths s = |d|², ṡ = 2 d·ḋ. A rigid motion has no rates and is not damped;
/// momentum and angular momentum are kept, as with every force density. The power that it takes is −½ Σ q ṡ.
class Viscosity {
 public:
  virtual ~Viscosity() = default;
  /// Adds each connection's force density [N/m]. All vectors one a connection, and none of them the workspace's
  /// `scaled`.
  virtual void add_force_densities(const VectorX& squared_lengths, const VectorX& rates, VectorX& force_densities,
                                   Workspace& workspace) const = 0;
  /// Adds ∂q/∂s + rate_weight ∂q/∂ṡ of each connection's own s and ṡ.
  virtual void add_own_slopes(const VectorX& squared_lengths, const VectorX& rates, double rate_weight,
                              VectorX& slopes) const = 0;
  /// Whether connections influence each other; if not, the next two do nothing.
  virtual bool coupled() const { return false; }
  /// Adds the coupled part of δq from δṡ.
  virtual void add_change(const VectorX& /*change_of_rates*/, VectorX& /*change_of_force_densities*/,
                          Workspace&) const {}
  /// As EdgeSlopes', of slopes ∂q/∂ṡ.
  virtual void visit_cells(const EdgeSlopes::CellVisitor&) const {}
};

/// Of a Viscosity that grows with the stiffness of the model's laws, as that of make_stiffness_damping does.
class GrowsWithStiffness {
 public:
  GrowsWithStiffness() = default;
  virtual ~GrowsWithStiffness() = default;
};

/// Each connection resists its own lengthening, F = −b [(V_e − V_p)·u] u, b = `coefficient` [N s/m]: q = b ṡ/(2s).
/// [M03]
std::unique_ptr<Viscosity> make_damping(double coefficient);

/// Damping of tetrahedra: stress S = φ tr(Ė) I + 2ψ Ė of the Lagrangian strain rate Ė, φ = `bulk` and ψ = `shear`
/// [Pa s], ≥ 0: q = K(φ, ψ) ṡ, K that of st_venant_kirchhoff. [L03]
std::unique_ptr<Viscosity> make_cell_damping(const Body& body, double bulk, double shear);

/// Rayleigh's stiffness-proportional damping, C = β K with the body's stiffness K at rest, β = `time` [s]: q = β ∂q/∂s
/// ṡ of the law. In this form a turning body is not damped, unlike with a constant matrix. [Rayleigh 1877]
std::unique_ptr<Viscosity> make_stiffness_damping(const Body& body, const Elasticity& law, double time);

}  // namespace elastin
