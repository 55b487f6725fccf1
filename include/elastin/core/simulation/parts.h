#pragma once
#include <vector>

#include "elastin/core/forces/model.h"
#include "elastin/core/simulation/catalog.h"

namespace elastin {

/// The strategy on a body of several parts, each by itself and with its own material, `materials[part.material]`,
/// fibres and volume terms included; the material that its functions are given counts no more. Rigid parts get no
/// stiffness. Rules see each part as a body of its own, so that a connection between molecules that two parts share has
/// the stiffness of both. A body without parts, or a strategy that is so already, is left as it is.
Strategy in_parts(const Strategy& strategy, const Body& body, std::vector<Material> materials);

/// Adds what a strategy's elasticity leaves to others: the material's fibres (but of a strategy that works by parts)
/// and bending, the body's cables and ties. Throws InputError as they do.
void add_companions(Model& model, const Strategy& strategy, const Material& material);

/// Supports all molecules of the body's rigid parts that have no support yet: bone stays where it is unless something
/// moves it.
void fix_rigid_parts(Model& model);

}  // namespace elastin
