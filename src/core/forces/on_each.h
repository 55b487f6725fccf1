#pragma once
#include "core/parallel/parallel.h"
#include "elastin/core/forces/loads.h"

namespace elastin {

/// Load::add_forces of a load that says on_each().
inline void add_forces_on_all(const Load& load, const State& state, Positions& forces) {
  parallel_ranges(
      static_cast<int>(forces.cols()), [&](int begin, int end) { load.add_forces_on(state, begin, end, forces); },
      kMoleculeThreshold);
}

}  // namespace elastin
