#include "core/solve/steppers.h"

namespace elastin {

const Table<Stepper>& built_in_steppers() {
  static const Table<Stepper> table = [] {
    Table<Stepper> rows("scheme");
    rows.add(symplectic_euler());
    rows.add(velocity_verlet());
    rows.add(backward_euler());
    rows.add(newmark());
    rows.add(energy_momentum());
    rows.add(block_descent());
    rows.add(xpbd());
    rows.add(projective());
    return rows;
  }();
  return table;
}

std::string unsuited_for(const Stepper& scheme, const Model& model) {
  return scheme.unsuited ? scheme.unsuited(model) : "";
}

std::unique_ptr<Integrator> make_integrator(const IntegratorOptions& options) {
  const Stepper& scheme = *options.scheme;
  return scheme.make(complete_values(scheme.name, scheme.parameters, options.parameters), options.newton);
}

}  // namespace elastin
