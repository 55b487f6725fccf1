#include <algorithm>

#include "core/base/named.h"
#include "core/solve/steppers.h"
#include "elastin/core/base/error.h"
#include "elastin/core/solve/engine.h"

namespace elastin {

// The steppers, each next to its code. The order is that of lists and documents.
StepperKind symplectic_euler(), velocity_verlet(), backward_euler(), newmark(), generalized_alpha(), energy_momentum(),
    block_descent(), xpbd(), projective();

StaticResult StaticEngine::balance_step(Model&, State&, const StaticOptions&, const Kinematics&) {
  throw InputError("this engine takes no steps in time");
}

const Table<StaticEngineKind>& built_in_engines() {
  static const Table<StaticEngineKind> table = [] {
    Table<StaticEngineKind> rows("engine");
    rows.add({{"threads", "this process by itself, on its threads", ""}});
    rows.add({{"petsc", "processes that mpiexec starts together: each computes and solves for its part of the body",
               "PETSc [Balay 1997]"},
              {},
              "this program was built without PETSc and MPI: install libpetsc-real-dev and openmpi-bin, and build it "
              "again"});
    return rows;
  }();
  return table;
}

const Table<StepperKind>& built_in_steppers() {
  static const Table<StepperKind> table = [] {
    Table<StepperKind> rows("stepper");
    for (StepperKind (*row)() : {symplectic_euler, velocity_verlet, backward_euler, newmark, generalized_alpha,
                                 energy_momentum, block_descent, xpbd, projective})
      rows.add(row());
    return rows;
  }();
  return table;
}

std::string needs_implicit_steps() {
  std::vector<std::string> able;
  for (const auto& row : built_in_steppers())
    if (!row->is_explicit) able.push_back(row->name);
  return "explicit steps do not keep contact's `penetration`; leave it out and take a larger `stiffness`, or a stepper "
         "that keeps it: " +
         joined(able);
}

std::string unsuited_for(const StepperKind& method, const Model& model) {
  if (method.is_explicit &&
      std::any_of(model.loads().begin(), model.loads().end(), [](const auto& load) { return load->has_multipliers(); }))
    return needs_implicit_steps();
  if (model.body().share && !method.of_shares) {
    std::vector<std::string> able;
    for (const auto& row : built_in_steppers())
      if (row->of_shares) able.push_back(row->name);
    return method.name + " steps whole bodies alone, and each process has its share; those that step shares are " +
           joined(able);
  }
  return method.unsuited ? method.unsuited(model) : "";
}

std::unique_ptr<Stepper> make_stepper(const StepperOptions& options) {
  const StepperKind& method = *options.method;
  return method.make(complete_values(method.name, method.parameters, options.parameters), options.newton);
}

}  // namespace elastin
