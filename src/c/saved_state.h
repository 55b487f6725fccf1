#pragma once
#include <cstddef>
#include <vector>

#include "elastin/core/simulation/simulation.h"

namespace elastin::c {

/// A simulation's state as bytes, every number with all its bits, as this machine writes them.
std::vector<char> bytes_of(const SimulationState& state);

/// Throws InputError where the bytes are no state, of another version or machine, cut off or longer than that.
SimulationState state_of(const void* bytes, std::size_t size);

}  // namespace elastin::c
