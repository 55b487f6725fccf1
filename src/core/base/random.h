#pragma once
#include <random>

namespace elastin {

/// A number in [0, 1) from the top 53 bits: std::uniform_real_distribution differs between standard libraries.
inline double unit_random(std::mt19937_64& generator) { return static_cast<double>(generator() >> 11) * 0x1.0p-53; }

}  // namespace elastin
