#pragma once
#include <memory>
#include <string>

#include "elastin/core/simulation/catalog.h"

namespace elastin {

/// Whether the material's fibres need the body's Voronoi cells to join this strategy.
bool fibres_need_voronoi(const Strategy& strategy, const Body& body, const Material& material);

/// Why the material's fibres, passive or active, cannot join this strategy on this body, or ""; always "" for a
/// material without fibres.
std::string fibres_unsuited(const Strategy& strategy, const Body& body, const Material& material);

/// Why this material cannot go with this strategy on this body, or "": for its fibres, or for want of constants.
std::string material_unsuited(const Strategy& strategy, const Body& body, const Material& material);

/// The material's fibres, passive and active ones, to be added to a model in addition to the strategy for the matrix:
/// in each solid cell with a cell law, as springs with a spring rule. None for a material without fibres. The body must
/// outlive them.
ElasticTerms make_fibres(const Strategy& strategy, const Body& body, const Material& material);

}  // namespace elastin
