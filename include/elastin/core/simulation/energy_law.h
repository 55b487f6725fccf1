#pragma once
#include "elastin/core/laws/energy_expression.h"
#include "elastin/core/simulation/catalog.h"

namespace elastin {

/// A law of solids that a program makes as it runs, from its energy density, on cells of any shape of three dimensions.
/// Of the expression's parameters E, nu, mu, lam and kappa (= λ + ⅔ μ) follow from the material; the others are those
/// of `parameters`. In stiffer regions of a body all of W is larger. Throws InputError on a parameter that is neither.
Strategy make_energy_law(const std::string& name, EnergyExpression energy, std::vector<ParameterInfo> parameters = {});

}  // namespace elastin
