#pragma once
#include <string>

namespace elastin::testing {

/// A scene whose three strategies take no time.
inline const std::string kCube = R"(title: A small cube
body:
  lattice: {kind: cubic, molecules: [3, 3, 3], spacing: 7.5 mm, connections: [axis, face]}
material: {youngs_modulus: 5 kPa}
stiffness: lattice
strategies: [standard, lattice, angles]
experiment: {kind: tension, axis: z, force: 11.25 uN}
)";

}  // namespace elastin::testing
