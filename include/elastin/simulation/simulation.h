#pragma once
#include <functional>
#include <memory>
#include <string>

#include "elastin/forces/model.h"
#include "elastin/model/material.h"
#include "elastin/simulation/catalog.h"
#include "elastin/solve/integrator.h"

namespace elastin {

/// Names a grip (see Simulation::grab); never used again after let_go.
using GripId = int;

struct SimulationOptions {
  IntegratorOptions integrator = {Scheme::symplectic_euler};
  ParameterValues parameters = {};  ///< of the strategy
  /// Explicit schemes part a step so that each part is at most this share of the body's stable step; see stable_step.
  double safety = 0.8;
  /// A step that would take more parts ends as limit_reached and leaves the state as it was: real time has a limit.
  int most_parts = 1000;
};

/// Everything that a simulation changes while it runs; restoring it goes on with the same bits.
struct SimulationState {
  State state;
  std::vector<Support> supports;
  Positions host_forces;  ///< [N]
};

/// A body that moves: what a simulator embeds. Any number may run in as many threads, each in one at a time.
///
///   Simulation tissue(make_lattice(…), catalog.find("lattice"), material);
///   tissue.model().add(make_gravity(tissue.body(), {0, 0, -9.81}));
///   const GripId tool = tissue.grab(17, place, 200);
///   while (…) { tissue.move_grip(tool, place); tissue.step(1e-3); push(-tissue.grip_force(tool)); }
///
/// The views (positions, velocities, forces, tensions) keep their address as long as the simulation lives. step(), the
/// views and the calls that are noexcept allocate nothing after the first step, throw nothing, lock nothing and print
/// nothing. Functions that throw InputError do so before they change anything.
class Simulation {
 public:
  /// The strategy at work on the body. Throws InputError where it cannot run there or a parameter is out of range.
  Simulation(Body body, const Strategy& strategy, const Material& material, SimulationOptions options = {});
  /// An elastic law that the host makes itself from the body, which stays where it is.
  using MakeElasticity = std::function<std::unique_ptr<Elasticity>(const Body&)>;
  Simulation(Body body, const MakeElasticity& make, SimulationOptions options = {});
  ~Simulation();
  Simulation(Simulation&&) noexcept;
  Simulation& operator=(Simulation&&) noexcept;

  const Body& body() const noexcept;
  /// What acts on the body: loads, damping and contact are added here before the first step.
  Model& model() noexcept;
  const Model& model() const noexcept;

  /// Brings the body forward by dt > 0 [s]; numerical trouble is an outcome, and the state then stays as it was.
  StepResult step(double dt) noexcept;
  double time() const noexcept;  ///< [s]

  const Positions& positions() const noexcept;   ///< [m], 3 × n
  const Positions& velocities() const noexcept;  ///< [m/s], 3 × n
  /// All forces of the state reached [N], 3 × n; what holds a held molecule is minus its part in the held directions.
  const Positions& forces() const noexcept;
  /// Force of each connection [N], pulling is positive.
  const VectorX& tensions() const noexcept;

  /// The host's own forces [N], 3 × n: act from the next step on until they are changed.
  Positions& host_forces() noexcept;

  /// Holds a molecule at its present place in all directions, or in those that `free` (a projector) leaves; again: with
  /// the new ones. Throws InputError on a number that is no molecule.
  void hold(int molecule, const Matrix3& free = Matrix3::Zero());
  void release(int molecule);
  /// Where a held molecule is to be at the end of the next step [m]: it goes there at one speed. Throws InputError if
  /// it is not held.
  void move_to(int molecule, const Vector3& place);
  /// Force by which the support of a held molecule acts on it [N]; zero where nothing holds it.
  Vector3 reaction(int molecule) const noexcept;

  /// A spring of length 0 and a damper between a molecule and a place [m]: a tool, a mouse. stiffness > 0 [N/m],
  /// damping ≥ 0 [N s/m]. Throws InputError.
  GripId grab(int molecule, const Vector3& place, double stiffness, double damping = 0);
  void move_grip(GripId grip, const Vector3& place, const Vector3& velocity = Vector3::Zero()) noexcept;
  /// Force of the grip on its molecule [N] in the state reached; a haptic device gets its opposite.
  Vector3 grip_force(GripId grip) const noexcept;
  void let_go(GripId grip) noexcept;

  /// Calls `see` after every so many steps that went well. It must not step; what it throws ends in std::terminate.
  void observe(int every, std::function<void(const Simulation&)> see);

  /// The state to go on from; with the same model the steps after it have the same bits.
  SimulationState save() const;
  /// Throws InputError where it is another body's.
  void restore(const SimulationState& saved);

 private:
  struct Inside;
  std::unique_ptr<Inside> inside_;
};

}  // namespace elastin
