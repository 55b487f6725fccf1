#include "lab/experiment/choice.h"

#include <utility>

namespace elastin::lab {

StrategyChoice with_volume(StrategyChoice choice) {
  choice.strategy = with_volume(choice.strategy);
  choice.label += "+volume";
  return choice;
}

StrategyChoice with_wrinkling(StrategyChoice choice) {
  choice.strategy = with_wrinkling(choice.strategy);
  choice.label += "+wrinkling";
  return choice;
}

StrategyChoice choose_strategy(const Catalog& catalog, const std::string& label) {
  Strategy found = catalog.find(label);
  if (found.calibrates) return {label, *found.calibrates, true, {}};
  return {label, std::move(found), false, {}};
}

std::vector<StrategyChoice> all_strategies(const Catalog& catalog) {
  std::vector<StrategyChoice> choices;
  for (const Strategy& strategy : catalog.strategies())
    if (strategy.kind != StrategyKind::wrapper) choices.push_back(choose_strategy(catalog, strategy.name));
  for (const Strategy& strategy : catalog.strategies())
    if (strategy.kind == StrategyKind::spring_rule && !strategy.calibrates)
      choices.push_back(choose_strategy(catalog, "calibrated:" + strategy.name));
  return choices;
}

}  // namespace elastin::lab
