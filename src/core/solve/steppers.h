#pragma once
#include "elastin/core/solve/integrator.h"

namespace elastin {

/// The rows of the table, each beside its code.
Stepper symplectic_euler();
Stepper velocity_verlet();
Stepper backward_euler();
Stepper newmark();

/// "cell 3 is flat or inverted", or the same without a number where no single cell is.
std::string inverted_text(const Body& body, const Positions& positions);

/// Gives supported molecules the velocities of their supports in the held directions.
void move_with_supports(const std::vector<Support>& supports, Positions& velocities);

}  // namespace elastin
