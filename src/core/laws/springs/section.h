#pragma once
#include "elastin/core/model/body.h"

namespace elastin {

/// Cross-section of a molecule (2 r)² [m²]: the square that reproduces the tables of [M03]; see README.
inline double section(const Body& body, int molecule) { return 4 * body.radius[molecule] * body.radius[molecule]; }

/// Cross-section of a connection [m²]: the mean of its two molecules'.
inline double connection_section(const Body& body, int connection) {
  const auto& [a, b] = body.connections.ends[connection];
  return (section(body, a) + section(body, b)) / 2;
}

}  // namespace elastin
