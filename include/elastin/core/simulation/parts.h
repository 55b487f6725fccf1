#pragma once
#include <vector>

#include "elastin/core/forces/model.h"
#include "elastin/core/simulation/catalog.h"

namespace elastin {

/// The strategy on a body of several parts, each by itself and with its own material, `materials[part.material]`,
/// fibres and volume terms included; the material that its functions are given counts no more. Rigid parts get no
/// stiffness. Rules see each part as a body of its own, so that a connection between molecules that two parts share has
/// the stiffness of both. A body without parts, or a strategy that is so already, is left as it is.
/// @param laws where given, and the strategy is a law of cells, a part whose material states_own_law is computed by
/// that law, found there with the strategy's beginnings and endings; without `+volume` where its cells cannot have
/// that. Throws InputError where it cannot have the others.
Strategy in_parts(const Strategy& strategy, const Body& body, std::vector<Material> materials,
                  const Catalog* laws = nullptr);

/// Whether a part's material has constants of a law that the first of the materials has not.
bool states_own_law(const Material& material, const std::vector<Material>& materials);

/// Adds what a strategy's elasticity leaves to others: the material's fibres (but of a strategy that works by parts)
/// and bending, the body's cables and ties. Throws InputError as they do.
void add_companions(Model& model, const Strategy& strategy, const Material& material);

/// Supports all molecules of the body's rigid parts in all directions: bone stays where it is unless something moves
/// it, and along what a support leaves free it stays, too.
void fix_rigid_parts(Model& model);

}  // namespace elastin
