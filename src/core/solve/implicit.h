#pragma once
#include <optional>

#include "core/solve/newton.h"
#include "core/solve/steppers.h"
#include "core/solve/transposed_step.h"
#include "elastin/core/solve/stepper.h"

namespace elastin {

/// What loads that change with the state do in one of its moments.
struct Push {
  Positions forces;   ///< [N]
  Positions elastic;  ///< of them, those that come from the energy [N]
  double energy = 0;  ///< [J]
};

/// Makes loads that may push count as they are at a step's end, while it lives: of a balance at a `share` of the step
/// from `start`, times a factor.
class PushesAtEnd {
 public:
  PushesAtEnd(Model& model, const State& start, double share, double factor);
  ~PushesAtEnd();
  PushesAtEnd(const PushesAtEnd&) = delete;
  PushesAtEnd& operator=(const PushesAtEnd&) = delete;

 private:
  Model& model_;
};

/// How far within a step its balance is: the end's shares in positions, velocities and forces, and in accelerations;
/// the beginning has the rest.
struct EndShares {
  double forces = 1, inertia = 1;  ///< α_f, α_m; the first in (0, 1]
};

/// A step of backward Euler's, Newmark's or the generalised-α method: velocities and accelerations follow from the
/// positions at its end, or within it, which balance() finds; here by Newton's method, in steppers that derive from it
/// in other ways. A step that fails is bisected.
class Implicit : public Stepper, public HasEffort {
 public:
  /// Newmark's, or backward Euler where beta is 0, which is balanced at its end.
  Implicit(const StaticOptions& newton, double beta, double gamma, EndShares shares = {})
      : newton_(newton), beta_(beta), gamma_(gamma), shares_(shares) {}
  StepResult advance(Model& model, State& state, double dt) override;

  /// Number of Newton iterations after which a step ends, balanced or not; 0: no limit.
  void cut_short(int iterations);
  void set_effort(int effort) override { cut_short(effort); }

 protected:
  /// Brings `next` from a first guess to where forces and inertia balance, `kinematics` being that of the step. Where
  /// it fails the outcome says so, and `next` may be anything.
  virtual StaticResult balance(Model& model, State& next, const Kinematics& kinematics);
  /// One step; the state stays if it fails, and the result then says why.
  virtual void try_step(Model& model, State& state, double dt, StepResult& result);

  /// Of a balance by sweeps: all that follows from the positions that they reached, and whether these can be an end.
  static void end_sweeps(const Model& model, const Kinematics& kinematics, State& next, StaticResult& result);

  void set_kinematics(const State& state, const Positions& accelerations, double dt);
  bool newmark() const { return beta_ > 0; }
  bool within() const { return shares_.forces != 1 || shares_.inertia != 1; }

  /// Energy [J], above rounding, that contact has made in a step in which it opens or sets in; none in any other step.
  /// Its forces are those at this share of the step; of share 1 Newmark's, half of the beginning's and the end's.
  std::optional<double> made_by_pushes(const Model& model, const State& from, const State& to, double share);

  StaticOptions newton_;
  NewtonWorkspace workspace_;
  double beta_, gamma_;
  EndShares shares_;
  Kinematics kinematics_;

 private:
  void advance(Model& model, State& state, double dt, double smallest, StepResult& result);
  StaticResult balance_at_end(Model& model, const State& state, double dt);
  void set_first_guess(const Model& model, const State& state, double dt);
  void balance_as_one(const Model& model);
  void hold_accelerations(const Model& model);
  StaticResult balance_within(Model& model, const State& state, double dt);
  StaticResult balance_once_within(Model& model, const State& state, double dt);
  void go_on_to_end(const Model& model, const State& state, double dt);

  // Kept from one step to the next, so that steps allocate no memory.
  State next_, before_;
  std::vector<Support> ends_;  // of the step's supports
  Positions forces_;
  Push push_, pushed_, push_within_;  // at the step's beginning, at its end, and where its balance is
  State within_;
  Positions withheld_;  // the accelerations at its beginning without what pushes
};

/// Those that Newton's method balances. One that ends after a number of iterations has the derivatives of a balanced
/// step.
class ImplicitByNewton final : public Implicit, public TransposedStep {
 public:
  using Implicit::Implicit;
  void transpose(Model& model, const State& from, const State& to, StateSlopes& slopes, const Visit& visit) override;

 private:
  Positions transposed_balance(const TransposedForces& forces, const Positions& rhs);
};

}  // namespace elastin
