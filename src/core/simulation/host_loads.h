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
  void add_forces(const State&, Positions& forces) const override { forces += forces_; }
  double energy(const State& state) const override { return -forces_.cwiseProduct(state.positions - body_.rest).sum(); }
  bool steady() const override { return false; }

 private:
  const Body& body_;
  const Positions& forces_;
};

/// Force of a grip on its molecule [N]: −k (x − p) − c (v − w).
inline Vector3 force_of(const Grip& grip, const State& state) {
  return grip.stiffness * (grip.place - state.positions.col(grip.molecule)) +
         grip.damping * (grip.velocity - state.velocities.col(grip.molecule));
}

/// Grips that the host makes, moves and takes away between steps; the list must outlive the load.
class Grips final : public Load {
 public:
  explicit Grips(const std::vector<Grip>& grips) : grips_(grips) {}
  void add_forces(const State& state, Positions& forces) const override {
    for (const Grip& grip : grips_) forces.col(grip.molecule) += force_of(grip, state);
  }
  double energy(const State& state) const override {
    double sum = 0;
    for (const Grip& grip : grips_)
      sum += grip.stiffness / 2 * (state.positions.col(grip.molecule) - grip.place).squaredNorm();
    return sum;
  }
  bool changes() const override { return !grips_.empty(); }
  void add_change(const State&, const Positions& motion, const Positions& sped, Positions& forces) const override {
    for (const Grip& grip : grips_)
      forces.col(grip.molecule) -= grip.stiffness * motion.col(grip.molecule) + grip.damping * sped.col(grip.molecule);
  }
  void visit_blocks(const State&, double velocity_weight, const BlockVisitor& visit) const override {
    for (const Grip& grip : grips_)
      visit(grip.molecule, grip.molecule, (grip.stiffness + velocity_weight * grip.damping) * Matrix3::Identity());
  }
  bool steady() const override { return false; }
  bool feels_velocity() const override { return resists(); }
  bool resists() const override {
    return std::any_of(grips_.begin(), grips_.end(), [](const Grip& grip) { return grip.damping > 0; });
  }
  void add_resistance(const State& state, Positions& forces) const override {
    for (const Grip& grip : grips_)
      forces.col(grip.molecule) += grip.damping * (grip.velocity - state.velocities.col(grip.molecule));
  }

 private:
  const std::vector<Grip>& grips_;
};

}  // namespace elastin
