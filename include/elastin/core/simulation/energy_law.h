#pragma once
#include "elastin/core/laws/energy_expression.h"
#include "elastin/core/simulation/catalog.h"

namespace elastin {

/// A law that a program makes as it runs, from its energy density, on cells of any shape: of solids, or with
/// `dimensions` 2 of membranes, which thin so that there is no stress across (W is per volume there too). Of the
/// expression's parameters E, nu, mu, lam and kappa (= λ + ⅔ μ) follow from the material; the others are those of
/// `parameters`. In stiffer regions of a body all of W is larger. A solid is a material law too (Strategy::own_law): a
/// material may state its constants, which E and ν follow from where W takes no number of the material, and `direction`
/// of the fibres of I₄ and I₅. Throws InputError on a parameter that is neither, and on fibres of a membrane.
Strategy make_energy_law(const std::string& name, EnergyExpression energy, std::vector<ParameterInfo> parameters = {},
                         int dimensions = 3);

}  // namespace elastin
