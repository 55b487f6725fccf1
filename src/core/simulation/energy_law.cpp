#include "elastin/core/simulation/energy_law.h"

#include <algorithm>
#include <utility>

#include "elastin/core/base/error.h"
#include "elastin/core/forces/cells.h"
#include "elastin/core/laws/any_law.h"
#include "elastin/core/laws/moduli.h"

namespace elastin {
namespace {

const std::vector<std::string> kOfMaterial{"E", "nu", "mu", "lam", "kappa"};

double of_material(const std::string& name, const Material& material) {
  if (name == "E") return material.youngs_modulus;
  if (name == "nu") return material.poissons_ratio;
  if (name == "mu") return material.youngs_modulus / (2 * (1 + material.poissons_ratio));
  const auto [lambda, mu] = lame<3>(material);
  return name == "lam" ? lambda : lambda + 2 * mu / 3;
}

bool comes_from_material(const std::string& name) {
  return std::find(kOfMaterial.begin(), kOfMaterial.end(), name) != kOfMaterial.end();
}

}  // namespace

Strategy make_energy_law(const std::string& name, EnergyExpression energy, std::vector<ParameterInfo> parameters) {
  std::vector<std::string> known = kOfMaterial;
  for (const ParameterInfo& parameter : parameters) {
    if (comes_from_material(parameter.name))
      throw InputError("law '" + name + "': '" + parameter.name + "' comes from the material");
    known.push_back(parameter.name);
  }
  for (const std::string& wanted : energy.parameters())
    if (std::find(known.begin(), known.end(), wanted) == known.end())
      throw InputError("law '" + name + "': there is no parameter '" + wanted + "'" + suggestion(wanted, known));
  Strategy law;
  law.name = name;
  law.parameters = std::move(parameters);
  law.kind = StrategyKind::cell_law;
  law.dimensions = 3;
  law.unsuited = &no_cells<3>;
  law.make = [name, energy, described = law.parameters](const Body& body, const Material& material,
                                                        const ParameterValues& given) {
    const ParameterValues own = complete_values(name, described, given);
    std::vector<double> values;
    for (const std::string& parameter : energy.parameters())
      values.push_back(comes_from_material(parameter) ? of_material(parameter, material) : own.at(parameter));
    const auto make = [name, energy, values, modulus = material.youngs_modulus](const Material& here) {
      try {
        return SplitPoint<AnyPoint<3>>{AnyPoint<3>(energy.at(values, here.youngs_modulus / modulus)), {}};
      } catch (const InputError& error) {
        throw InputError("law '" + name + "': " + error.what());
      }
    };
    return make_cells<3>(body, material, AnySolid{make});
  };
  return law;
}

}  // namespace elastin
