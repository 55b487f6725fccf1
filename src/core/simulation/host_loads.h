#pragma once
#include <algorithm>
#include <vector>

#include "elastin/core/forces/loads.h"
#include "elastin/core/simulation/simulation.h"

namespace elastin {

/// Dead forces [N] that the host changes between steps; they must outlive the load.
class HostForces final : public Load {
 public:
  HostForces(const Body& body, const Positions& forces) : body_(body), forces_(forces) {}
  void add_forces(const State&, Positions& forces) const override {
    if (fit()) forces += forces_;
  }
  double energy(const State& state) const override {
    return fit() ? -forces_.cwiseProduct(state.positions - body_.rest).sum() : 0;
  }
  bool steady() const override { return false; }

 private:
  /// A host may have made the array another size, which the next step says.
  bool fit() const { return forces_.cols() == body_.size(); }

  const Body& body_;
  const Positions& forces_;
};

/// Force of a coupling on its molecule [N]: −k (x − p) − c (v − w).
inline Vector3 force_of(const Coupling& coupling, const State& state) {
  return coupling.stiffness * (coupling.position - state.positions.col(coupling.molecule)) +
         coupling.damping * (coupling.velocity - state.velocities.col(coupling.molecule));
}

/// Virtual couplings that the host makes, moves and takes away between steps; the list must outlive the load.
class Couplings final : public Load {
 public:
  explicit Couplings(const std::vector<Coupling>& couplings) : couplings_(couplings) {}
  void add_forces(const State& state, Positions& forces) const override {
    for (const Coupling& coupling : couplings_) forces.col(coupling.molecule) += force_of(coupling, state);
  }
  double energy(const State& state) const override {
    double sum = 0;
    for (const Coupling& coupling : couplings_)
      sum += coupling.stiffness / 2 * (state.positions.col(coupling.molecule) - coupling.position).squaredNorm();
    return sum;
  }
  bool changes() const override { return !couplings_.empty(); }
  void add_change(const State&, const Positions& motion, const Positions& sped, Positions& forces) const override {
    for (const Coupling& coupling : couplings_)
      forces.col(coupling.molecule) -=
          coupling.stiffness * motion.col(coupling.molecule) + coupling.damping * sped.col(coupling.molecule);
  }
  void visit_blocks(const State&, double velocity_weight, const BlockVisitor& visit) const override {
    for (const Coupling& coupling : couplings_)
      visit(coupling.molecule, coupling.molecule,
            (coupling.stiffness + velocity_weight * coupling.damping) * Matrix3::Identity());
  }
  void visit_points(const PointVisitor& visit) const override {
    for (const Coupling& coupling : couplings_) visit(coupling.molecule, coupling.stiffness, coupling.damping);
  }
  bool steady() const override { return false; }
  bool feels_velocity() const override { return resists(); }
  bool resists() const override {
    return std::any_of(couplings_.begin(), couplings_.end(),
                       [](const Coupling& coupling) { return coupling.damping > 0; });
  }
  void add_resistance(const State& state, Positions& forces) const override {
    for (const Coupling& coupling : couplings_)
      forces.col(coupling.molecule) += coupling.damping * (coupling.velocity - state.velocities.col(coupling.molecule));
  }

 private:
  const std::vector<Coupling>& couplings_;
};

}  // namespace elastin
