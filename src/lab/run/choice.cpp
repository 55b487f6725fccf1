#include "lab/run/specimen.h"

#include <algorithm>
#include <utility>

#include "elastin/core/base/error.h"
#include "elastin/core/simulation/fibres.h"

namespace elastin::lab {
namespace {

/// Distance in the order between the catalog's own strategies and those that are made of them.
constexpr int kWithEnding = 1000, kCalibrated = 2000;

StrategyChoice chosen(const Catalog& catalog, const std::string& label, StrategyName name, Strategy found) {
  const std::vector<std::string> names = catalog.names();
  const int position = static_cast<int>(std::find(names.begin(), names.end(), name.rule) - names.begin()),
            order = position + (name.calibrated ? kCalibrated : 0) + (name.volume || name.wrinkling ? kWithEnding : 0);
  if (found.calibrates) found = Strategy(*found.calibrates);
  return {label, std::move(name), std::move(found), {}, order};
}

}  // namespace

StrategyChoice choose_strategy(const Catalog& catalog, const std::string& label) {
  return chosen(catalog, label, StrategyName(label), catalog.find(label));
}

StrategyChoice choose_strategy(const Catalog& catalog, const StrategyName& name) {
  return chosen(catalog, name.text(), name, catalog.find(name));
}

std::optional<StrategyChoice> applicable_with_volume(const Catalog& catalog, const StrategyChoice& choice,
                                                     const Body& body, const std::vector<Material>& materials) {
  if (choice.strategy.volume_modulus) return std::nullopt;
  try {
    StrategyName name = choice.name;
    name.volume = true;
    StrategyChoice with = choose_strategy(catalog, name);
    if (!with.strategy.unsuited(body).empty()) return std::nullopt;
    for (const Material& material : materials) {
      with.strategy.volume_modulus(material);
      if (!material_unsuited(with.strategy, body, material).empty()) return std::nullopt;
    }
    with.values = choice.values;
    return with;
  } catch (const InputError&) {
    return std::nullopt;
  }
}

bool has_constants(const Strategy& strategy, const std::vector<Material>& materials) {
  return strategy.law.empty() || std::any_of(materials.begin(), materials.end(), [&](const Material& material) {
           return material.law && material.law->law == strategy.law;
         });
}

std::vector<StrategyChoice> all_strategies(const Catalog& catalog, const Body& body,
                                           const std::vector<Material>& materials) {
  std::vector<StrategyChoice> choices;
  const auto add = [&](const Strategy& strategy, bool calibrated) {
    StrategyName name(strategy.name);
    name.calibrated = calibrated;
    choices.push_back(choose_strategy(catalog, name));
    if (auto with = applicable_with_volume(catalog, choices.back(), body, materials))
      choices.push_back(std::move(*with));
  };
  for (const Strategy& strategy : catalog.strategies())
    if (strategy.kind != StrategyKind::wrapper && has_constants(strategy, materials)) add(strategy, false);
  for (const Strategy& strategy : catalog.strategies())
    if (strategy.kind == StrategyKind::spring_rule && !strategy.calibrates) add(strategy, true);
  std::stable_sort(choices.begin(), choices.end(),
                   [](const StrategyChoice& a, const StrategyChoice& b) { return a.order < b.order; });
  return choices;
}

}  // namespace elastin::lab
