#pragma once
#include <vector>

#include "elastin/simulation/catalog.h"

namespace elastin {

/// The strategy on a body of several parts, each by itself and with its own material, `materials[part.material]`,
/// fibres and volume terms included; the material that its functions are given counts no more. Rigid parts get no
/// stiffness. Rules see each part as a body of its own, so that a connection between molecules that two parts share has
/// the stiffness of both. A body without parts, or a strategy that is so already, is left as it is.
Strategy in_parts(const Strategy& strategy, const Body& body, std::vector<Material> materials);

}  // namespace elastin
