#include "lab/run/choice.h"

#include <algorithm>
#include <utility>

#include "elastin/core/base/error.h"
#include "elastin/core/simulation/fibres.h"

namespace elastin::lab {
namespace {

/// How far behind the catalog's own strategies those stand that are made of them.
constexpr int kWithEnding = 1000, kCalibrated = 2000;

}  // namespace

std::optional<StrategyChoice> applicable_with_volume(const StrategyChoice& choice, const Body& body,
                                                     const std::vector<Material>& materials) {
  try {
    StrategyChoice with = with_volume(choice);
    if (!with.strategy.unsuited(body).empty()) return std::nullopt;
    for (const Material& material : materials) {
      with.strategy.volume_modulus(material);
      if (!material_unsuited(with.strategy, body, material).empty()) return std::nullopt;
    }
    return with;
  } catch (const InputError&) {
    return std::nullopt;
  }
}

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
  Strategy found = catalog.find(label);
  const bool calibrated = found.calibrates != nullptr;
  const std::size_t from = calibrated ? label.find(':') + 1 : 0;  // "calibrated" alone: find gives −1, and all of it
  const std::string name = label.substr(from, label.find('+') - from);
  const std::vector<std::string> names = catalog.names();
  const int place = static_cast<int>(std::find(names.begin(), names.end(), name) - names.begin()),
            order = place + (calibrated ? kCalibrated : 0) + (label.find('+') != std::string::npos ? kWithEnding : 0);
  if (calibrated) return {label, *found.calibrates, true, {}, order};
  return {label, std::move(found), false, {}, order};
}

bool has_constants(const Strategy& strategy, const std::vector<Material>& materials) {
  return strategy.law.empty() || std::any_of(materials.begin(), materials.end(), [&](const Material& material) {
           return material.law && material.law->law == strategy.law;
         });
}

std::vector<StrategyChoice> all_strategies(const Catalog& catalog, const Body& body,
                                           const std::vector<Material>& materials) {
  std::vector<StrategyChoice> choices;
  const auto add = [&](const std::string& label) {
    choices.push_back(choose_strategy(catalog, label));
    if (auto with = applicable_with_volume(choices.back(), body, materials)) choices.push_back(std::move(*with));
  };
  for (const Strategy& strategy : catalog.strategies())
    if (strategy.kind != StrategyKind::wrapper && has_constants(strategy, materials)) add(strategy.name);
  for (const Strategy& strategy : catalog.strategies())
    if (strategy.kind == StrategyKind::spring_rule && !strategy.calibrates) add("calibrated:" + strategy.name);
  std::stable_sort(choices.begin(), choices.end(),
                   [](const StrategyChoice& a, const StrategyChoice& b) { return a.order < b.order; });
  return choices;
}

}  // namespace elastin::lab
