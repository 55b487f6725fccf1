#include "lab/experiment/choice.h"

#include <algorithm>

#include "elastin/core/base/error.h"

namespace elastin::lab {
namespace {

/// How far behind the catalog's own strategies those stand that are made of them.
constexpr int kWithEnding = 1000, kCalibrated = 2000;

/// The choice with a volume term, if it can have one on this body of these materials.
std::optional<StrategyChoice> applicable_with_volume(const StrategyChoice& choice, const Body& body,
                                                     const std::vector<Material>& materials) {
  try {
    StrategyChoice with = with_volume(choice);
    if (!with.strategy.unsuited(body).empty()) return std::nullopt;
    for (const Material& material : materials) with.strategy.volume_modulus(material);
    return with;
  } catch (const InputError&) {
    return std::nullopt;
  }
}

}  // namespace

StrategyChoice with_volume(StrategyChoice choice) {
  choice.strategy = with_volume(choice.strategy);
  choice.label += "+volume";
  choice.order += kWithEnding;
  return choice;
}

StrategyChoice with_wrinkling(StrategyChoice choice) {
  choice.strategy = with_wrinkling(choice.strategy);
  choice.label += "+wrinkling";
  choice.order += kWithEnding;
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
  const auto place = &strategy - catalog.strategies().data();
  StrategyChoice choice{label, strategy, calibrated, {}, static_cast<int>(place) + (calibrated ? kCalibrated : 0)};
  if (!calibrated) return choice;
  if (choice.strategy.kind != StrategyKind::spring_rule)
    throw InputError("'" + label + "': only a spring rule can be calibrated, and " + choice.strategy.name + " is a " +
                     name_of(choice.strategy.kind));
  return choice;
}

std::vector<StrategyChoice> all_strategies(const Catalog& catalog, const Body& body,
                                           const std::vector<Material>& materials) {
  std::vector<StrategyChoice> choices;
  const auto add = [&](const std::string& label) {
    choices.push_back(choose_strategy(catalog, label));
    if (auto with = applicable_with_volume(choices.back(), body, materials)) choices.push_back(std::move(*with));
  };
  for (const Strategy& strategy : catalog.strategies())
    if (strategy.kind != StrategyKind::wrapper) add(strategy.name);
  for (const Strategy& strategy : catalog.strategies())
    if (strategy.kind == StrategyKind::spring_rule) add("calibrated:" + strategy.name);
  std::stable_sort(choices.begin(), choices.end(),
                   [](const StrategyChoice& a, const StrategyChoice& b) { return a.order < b.order; });
  return choices;
}

}  // namespace elastin::lab
