#pragma once
#include "elastin/core/forces/loads.h"

namespace elastin::testing {

/// What a load alone does to each molecule [N].
inline Positions forces_of(const Load& load, const State& state) {
  Positions forces = Positions::Zero(3, state.positions.cols());
  load.add_forces(state, forces);
  return forces;
}

}  // namespace elastin::testing
