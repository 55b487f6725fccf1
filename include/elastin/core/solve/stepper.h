#pragma once
#include <functional>
#include <memory>
#include <string>

#include "elastin/core/base/table.h"
#include "elastin/core/forces/model.h"
#include "elastin/core/solve/statics.h"

namespace elastin {

class Stepper;

/// A row of the table of steppers: makes one, by the name that scenes, C and Python give.
struct StepperKind : Descriptor {
  bool is_explicit = false;  ///< whether steps must stay below the longest stable one; see find_stable_step
  int order = 1;             ///< of the error at a fixed time, in the length of a step
  /// `values` has all parameters, in range. `newton`: tolerance and linear solver of an implicit stepper.
  std::function<std::unique_ptr<Stepper>(const ParameterValues& values, const StaticOptions& newton)> make = {};
  /// Why it cannot step this model, in words, or "". Empty: it steps any.
  std::function<std::string(const Model& model)> unsuited = {};
  /// The parameter that says how many iterations a step takes; empty: none does.
  std::string effort = {};
  bool points_at_end = false;  ///< whether forces on single molecules limit no explicit step; see Load::visit_points
  bool of_shares = false;  ///< whether it steps a body of which several processes have shares (Model::complete_rows)
};

/// What loads with multipliers (Load::has_multipliers) need, and which steppers that are, in words.
std::string needs_implicit_steps();

/// Why a stepper cannot step this model, in words, or "".
std::string unsuited_for(const StepperKind& method, const Model& model);

/// The steppers that Elastin has, a row each.
const Table<StepperKind>& built_in_steppers();
using StepperMethod = Choice<StepperKind, built_in_steppers>;

struct StepperOptions {
  StepperMethod method = "newmark";
  ParameterValues parameters = {};  ///< of the method
  StaticOptions newton = {};        ///< tolerance and linear solver of the implicit steppers
};

/// How a step ended.
struct StepResult {
  Outcome outcome = Outcome::converged;
  std::string cause;  ///< why it did not get there; empty if it did
  /// Of Newton's method, or sweeps and iterations of the steppers that go without it.
  int newton_iterations = 0, linear_iterations = 0;
  int substeps = 1;  ///< in how many parts an implicit step had to go
  /// Estimate of the step's own error in position, largest over the molecules [m]; of the last part.
  double error = 0;
};

/// What explicit steps have seen of how fast a body vibrates.
struct SeenFrequency {
  double frequency = 0;  ///< [rad/s], never above the fastest vibration between the states that they came through
  int turn = 0;          ///< of the next step: they look now and then
  Positions positions = {}, elastic_forces = {};  ///< [m], [N], of the last step, where turn is 1
};

/// Brings a state forward in time.
class Stepper {
 public:
  virtual ~Stepper() = default;
  /// Steps by dt > 0 [s]. The supports are driven to the end of the step first (Model::drive). If the step fails the
  /// state stays where it was and the outcome says why: nothing in it is ever NaN. Steps of one model allocate nothing
  /// after the first, but where they fail or are bisected, where something would be passed through, where contact
  /// finds more than ever before, where a direct solver or multigrid was requested, under a pressure or wind on more
  /// than 50 000 triangles on several threads, and with rules that update their springs (angles_update). Never throws
  /// on numerical trouble.
  virtual StepResult advance(Model& model, State& state, double dt) = 0;
};

/// Throws InputError on parameters that the stepper has not, or out of range.
std::unique_ptr<Stepper> make_stepper(const StepperOptions& options);

/// a = M⁻¹ F of the state, zero in fixed directions [m/s²].
void set_accelerations(const Model& model, State& state);

}  // namespace elastin
