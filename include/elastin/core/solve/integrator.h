#pragma once
#include <memory>
#include <string>

#include "elastin/core/forces/model.h"
#include "elastin/core/solve/statics.h"

namespace elastin {

enum class Scheme {
  symplectic_euler,  ///< explicit, order 1: v += dt a(x, v), x += dt v
  velocity_verlet,   ///< explicit, order 2: kick, drift, kick
  backward_euler,    ///< implicit, order 1: never gains energy
  newmark,           ///< implicit, order 2 with γ = ½
};
const char* name_of(Scheme scheme);
bool is_explicit(Scheme scheme);

struct IntegratorOptions {
  Scheme scheme = Scheme::newmark;
  double beta = 0.25,
         gamma = 0.5;  ///< of newmark: 0 < β ≤ 1, 0.5 ≤ γ ≤ 1; unconditionally stable if 2β ≥ γ. [Newmark 1959]
  /// Newton iterations a step; 0 = until it converges. 1 is Labelle's mode: what is left over goes into the next step.
  int newton_iterations = 0;
  StaticOptions newton = {};  ///< tolerance and linear solver of the implicit schemes
};

/// How a step ended.
struct StepResult {
  Outcome outcome = Outcome::converged;
  std::string cause;  ///< why it did not get there; empty if it did
  int newton_iterations = 0, linear_iterations = 0;
  int substeps = 1;  ///< in how many parts an implicit step had to go
  /// Estimate of the step's own error in position, largest over the molecules [m]; of the last part.
  double error = 0;
};

/// Brings a state forward in time.
class Integrator {
 public:
  virtual ~Integrator() = default;
  virtual Scheme scheme() const = 0;
  /// Steps by dt > 0 [s]. The supports are driven to the end of the step first (Model::drive). If the step fails the
  /// state stays where it was and the outcome says why: nothing in it is ever NaN. Steps of one model allocate nothing
  /// after the first, but where they go wrong or in halves, where something would be passed through, where contact
  /// finds more than ever before, where a direct solver or multigrid was asked for, under a pressure or wind on more
  /// than 50 000 triangles on several threads, and with rules that set their springs anew (angles_update). Never throws
  /// on numerical trouble.
  virtual StepResult advance(Model& model, State& state, double dt) = 0;
};

/// Throws InputError on parameters out of range.
std::unique_ptr<Integrator> make_integrator(const IntegratorOptions& options);

/// a = M⁻¹ F of the state, zero in held directions [m/s²].
void set_accelerations(const Model& model, State& state);

}  // namespace elastin
