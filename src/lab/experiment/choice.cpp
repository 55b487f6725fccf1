#include "lab/experiment/choice.h"

#include "elastin/core/base/error.h"

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
  const std::string prefix = "calibrated:", volume = "+volume", wrinkling = "+wrinkling";
  const auto before = [&](const std::string& suffix) {
    return choose_strategy(catalog, label.substr(0, label.size() - suffix.size()));
  };
  if (label.ends_with(volume)) return with_volume(before(volume));
  if (label.ends_with(wrinkling)) return with_wrinkling(before(wrinkling));
  if (const auto plus = label.find('+'); plus != std::string::npos) {
    const std::string ending = label.substr(plus);
    throw InputError("'" + label + "': unknown ending '" + ending + "'" + suggestion(ending, {volume, wrinkling}));
  }
  if (label == "calibrated") return choose_strategy(catalog, prefix + "standard");
  const bool calibrated = label.starts_with(prefix);
  if (const auto colon = label.find(':'); !calibrated && colon != std::string::npos) {
    const std::string beginning = label.substr(0, colon + 1);
    throw InputError("'" + label + "': unknown beginning '" + beginning + "'" + suggestion(beginning, {prefix}));
  }
  const Strategy& strategy = catalog.find(calibrated ? label.substr(prefix.size()) : label);
  if (!calibrated && strategy.kind == StrategyKind::wrapper)
    throw InputError("'" + label + "' goes with a " +
                     (label == "wrinkling" ? "membrane law: hencky_membrane+" : "rule: lattice+") + label);
  StrategyChoice choice{label, strategy, calibrated, {}};
  if (!calibrated) return choice;
  if (choice.strategy.kind != StrategyKind::spring_rule)
    throw InputError("'" + label + "': only a spring rule can be calibrated, and " + choice.strategy.name + " is a " +
                     name_of(choice.strategy.kind));
  return choice;
}

std::vector<StrategyChoice> all_strategies(const Catalog& catalog) {
  std::vector<StrategyChoice> choices;
  for (const Strategy& strategy : catalog.strategies())
    if (strategy.kind != StrategyKind::wrapper) choices.push_back({strategy.name, strategy, false, {}});
  for (const Strategy& strategy : catalog.strategies())
    if (strategy.kind == StrategyKind::spring_rule)
      choices.push_back(choose_strategy(catalog, "calibrated:" + strategy.name));
  return choices;
}

}  // namespace elastin::lab
