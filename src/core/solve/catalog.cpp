#include "core/solve/steppers.h"

namespace elastin {

const Table<Stepper>& built_in_steppers() {
  static const Table<Stepper> table = [] {
    Table<Stepper> rows("scheme");
    rows.add(symplectic_euler());
    rows.add(velocity_verlet());
    rows.add(backward_euler());
    rows.add(newmark());
    return rows;
  }();
  return table;
}

std::unique_ptr<Integrator> make_integrator(const IntegratorOptions& options) {
  const Stepper& scheme = *options.scheme;
  return scheme.make(complete_values(scheme.name, scheme.parameters, options.parameters), options.newton);
}

}  // namespace elastin
