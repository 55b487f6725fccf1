#pragma once
#include <functional>
#include <memory>
#include <vector>

#include "elastin/core/solve/stepper.h"

namespace elastin {

/// A number by which forces and masses change: the model's with a value below its own, and with one above, on bodies
/// with the same molecules and positions at rest.
struct VariedModels {
  Model *below, *above;
  double difference;  ///< of the two values
};

/// What a function m of the states of a run in time changes with, to first order.
struct TrajectoryAdjoint {
  Positions positions, velocities;  ///< ∂m/∂(those at the start) in the free directions, 3 × n
  Positions forces;                 ///< ∂m/∂(a force on each molecule that acts throughout) [by N], 3 × n
  /// Of each elastic law ∂m/∂(ln stiffness) of each element, of a spring k ∂m/∂k, of a cell E ∂m/∂E; empty of laws that
  /// are no sums of elements, such as those with a history, and where the model has damping by its laws' stiffness
  /// (`rayleigh`), which grows with them: take `numbers`.
  std::vector<VectorX> stiffness;
  std::vector<double> numbers;  ///< ∂m/∂ each number that was given as models, to the differences' error
};

/// A run of equal steps that can be differentiated by everything at once: one sweep backward through the steps, each by
/// the transpose of what the stepper has done. States are stored about every √N steps, and between two of them as the
/// sweep comes by, so that a sweep takes each of the N steps a second time. [Griewank & Walther 2008]
/// Steppers: symplectic_euler, velocity_verlet, backward_euler, newmark, generalized_alpha. Histories: of what
/// relaxes or softens. Contact without friction counts as in the steps taken: what touches goes on touching.
class Trajectory {
 public:
  /// Takes the steps by dt [s] from a state, as the stepper does. Model and supports must stay. Throws InputError where
  /// the stepper, a law or a load has no such derivatives, where explicit steps are longer than the longest stable one
  /// about the start, and where a step fails or has to be bisected.
  Trajectory(Model& model, State start, double dt, int steps, const StepperOptions& stepper);
  ~Trajectory();
  Trajectory(Trajectory&&) noexcept;

  const State& end() const;
  int steps() const;
  /// Numbers in the states that are stored at the same time, at most.
  std::size_t stored_numbers() const;
  /// Called for each state from the last to the first, number `steps` to 0: adds ∂m/∂x and ∂m/∂v of it.
  using AddSlopes =
      std::function<void(int number, const State& state, Positions& of_positions, Positions& of_velocities)>;
  /// Throws InputError where a step has no derivative, `varied` has other molecules, or is of what softens, by
  /// symplectic_euler.
  TrajectoryAdjoint adjoint(const AddSlopes& add_slopes, const std::vector<VariedModels>& varied = {});

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace elastin
