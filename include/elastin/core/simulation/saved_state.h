#pragma once
#include <cstddef>
#include <vector>

#include "elastin/core/simulation/simulation.h"

namespace elastin {

/// A simulation's state as bytes, every number with all its bits, as this machine writes them; with a version, its
/// length and a checksum.
std::vector<char> bytes_of(const SimulationState& state);

/// Throws InputError where the bytes are no state, of another version or machine, cut off, followed by others, or where
/// a single one has changed.
SimulationState simulation_state_of(const void* bytes, std::size_t size);

}  // namespace elastin
