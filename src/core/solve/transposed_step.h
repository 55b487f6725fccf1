#pragma once
#include <functional>
#include <memory>
#include <vector>

#include "elastin/core/forces/tangent.h"

namespace elastin {

/// What a function m of later states changes with: its derivatives by one state, history in the state's order.
struct StateSlopes {
  Positions positions, velocities, accelerations;
  std::vector<HistoryBlock> history;
};

/// The transpose of all forces of a model at one state of a step that begins elsewhere.
class TransposedForces {
 public:
  explicit TransposedForces(Model& model) : model_(model), tangent_(model), still_(model) {}
  /// Of a step from a state: forces at `at` are those at a time [s] of it. The states must outlive what follows.
  void begin(const State& from, double time, const State& at, double dt);
  /// Adds λᵀ ∂f/∂x and λᵀ ∂f/∂v, and λᵀ ∂f/∂(history of the state from which the step goes).
  void add(const Positions& lambda, StateSlopes& slopes);
  /// Adds λᵀ ∂f/∂x of damping, as far as Tangent leaves it out: its rates turn with the body.
  void add_turning(const Positions& lambda, Positions& of_positions) const;
  /// −λᵀ ∂f/∂v [by N s/m]; zero where no force depends on velocities.
  Positions damping(const Positions& lambda) const;
  void add_past(const Positions& lambda, StateSlopes& slopes) const;

 private:
  Model& model_;
  Tangent tangent_, still_;  ///< with the velocities' weight, and without
  const State *from_ = nullptr, *at_ = nullptr;
  double time_ = 0;
};

/// Slopes by the history at the end of a step become those by that at its beginning, and those by the end's positions.
void transpose_commit(const Model& model, const State& from, const State& to, StateSlopes& slopes);

/// A stepper that can go back through a step it has taken, with derivatives.
class TransposedStep {
 public:
  virtual ~TransposedStep() = default;
  /// Whether a step's forces are those at the state where it begins.
  virtual bool begins_with_forces() const { return false; }
  /// What changes forces and masses by δf and δM at the state `at` of a step changes m by λ·(δf − δM a).
  using Visit = std::function<void(const State& at, const Positions& lambda)>;
  /// Slopes by the state `to` in which a step that was not bisected has ended become those by the state `from`, in the
  /// free directions. Throws InputError where the step has no derivative.
  virtual void transpose(Model& model, const State& from, const State& to, StateSlopes& slopes, const Visit& visit) = 0;
};

}  // namespace elastin
