#pragma once
#include <optional>
#include <string>
#include <vector>

#include "elastin/core/simulation/catalog.h"

namespace elastin::lab {

/// A strategy as a scene or a command line names it: "standard", "lattice+volume", "calibrated:angles", with its
/// parameters.
struct StrategyChoice {
  std::string label;  ///< as it was named
  StrategyName name;
  Strategy strategy;  ///< the rule or law itself, with its volume term if any; for calibrated:RULE the rule
  ParameterValues values;
  int order = 0;  ///< among all_strategies, the simplest first: the catalog's, then with an ending, then calibrated
};

/// The strategy of this name in the catalog. Throws InputError as Catalog::find does.
StrategyChoice choose_strategy(const Catalog& catalog, const std::string& label);
StrategyChoice choose_strategy(const Catalog& catalog, const StrategyName& name);

/// The same choice with a volume term, if it can have one on this body of these materials.
std::optional<StrategyChoice> applicable_with_volume(const Catalog& catalog, const StrategyChoice& choice,
                                                     const Body& body, const std::vector<Material>& materials);

/// Whether a law that has constants of its own finds them in one of the materials; true of all others.
bool has_constants(const Strategy& strategy, const std::vector<Material>& materials);

/// Every strategy of the catalog whose constants one of the materials has, every spring rule calibrated too, and both
/// with "+volume" where the body has the cells and each of the materials the Poisson's ratio that this takes; ascending
/// in `order`.
std::vector<StrategyChoice> all_strategies(const Catalog& catalog, const Body& body,
                                           const std::vector<Material>& materials);

}  // namespace elastin::lab
