#pragma once
#include <cmath>
#include <string>

#include "elastin/core/shapes/shapes.h"
#include "elastin/core/simulation/simulation.h"

namespace elastin::testing {

inline const Material kTissue{.youngs_modulus = 10e3, .poissons_ratio = 0.25, .density = 1000};

/// A cube of n³ molecules, 2 mm apart; soft tissue.
inline Body tissue_cube(int n) {
  constexpr double spacing = 2e-3;
  Body body = cubic_lattice({n, n, n}, spacing, {true, true, false});
  set_matter(body, spacing / 2, 1000, 0, std::pow((n - 1) * spacing, 3));
  return body;
}

inline Body tissue_block() {
  Body body = tetrahedral_block(BlockKind::kuhn, {3, 3, 3}, Vector3::Constant(6e-3));
  set_matter(body, 1e-3, 1000, 0, 0);
  return body;
}

inline Simulation simulation_of(Body body, StepperMethod method = "symplectic_euler",
                                const std::string& strategy = "lattice", SimulationOptions options = {}) {
  const Catalog catalog = built_in_catalog();
  options.stepper.method = method;
  Material material = kTissue;
  if (strategy.ends_with("+volume")) material.poissons_ratio = 0.45;
  return Simulation(std::move(body), catalog.find(strategy), material, std::move(options));
}

inline const std::vector<StepperMethod> kSteppers{built_in_steppers().begin(), built_in_steppers().end()};

/// Whether the stepper has a form for the strategy's law.
inline bool suits(const StepperMethod& method, const std::string& strategy) {
  const Body body = strategy[0] == 'n' ? tissue_block() : tissue_cube(3);
  Model model(body);
  model.add(built_in_catalog().find(strategy).make(body, {.youngs_modulus = 1e4, .poissons_ratio = 0.3}, {}));
  return unsuited_for(*method, model).empty();
}

}  // namespace elastin::testing
