#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "config/scene_text.h"
#include "elastin/core/base/error.h"
#include "lab/run/derivatives.h"
#include "lab/study/study.h"

namespace elastin::lab {
namespace {

constexpr double kStep = 1e-5, kCalibratedStep = 1e-3;  ///< of a number, or of what is large for its unit where it is 0

/// What is large for a unit: of the body's size, modulus and density, in their powers.
double large_for(const Dimension& unit, const Specimen& specimen) {
  const Positions& rest = specimen.body.rest;
  const double size = (rest.rowwise().maxCoeff() - rest.rowwise().minCoeff()).norm(),
               density = specimen.material.density > 0 ? specimen.material.density : 1000;
  const double of_modulus = -unit.time / 2., of_density = unit.mass - of_modulus;
  return std::pow(size, unit.length + of_modulus + 3 * of_density) *
         std::pow(specimen.material.youngs_modulus, of_modulus) * std::pow(density, of_density);
}

}  // namespace

std::shared_ptr<Derivatives> derivatives_by(const std::vector<std::string>& keys, const Scene& scene,
                                            const StrategyChoice& choice, const Catalog& catalog,
                                            const std::vector<std::string>& overrides,
                                            const ExperimentCatalog& experiments) {
  std::vector<SceneNumber> numbers;
  std::vector<std::string> all = keys;
  for (const UncertainNumber& uncertain : scene.uncertain) all.push_back(uncertain.key);
  for (auto key = all.begin(); key != all.end();) key = std::count(all.begin(), key, *key) ? all.erase(key) : key + 1;
  for (const std::string& key : all) {
    const config::StatedNumber stated = config::stated_number(scene.source, overrides, key);
    const auto at = [=, source = scene.source, label = choice.label, references = scene.specimen.references,
                     &catalog](double value) -> VariedProblem {
      std::vector<std::string> changed = overrides;
      changed.push_back(key + "=" + stated.with(value));
      try {
        const std::shared_ptr<Scene> varied = load_scene(source, catalog, changed, kMostMolecules, experiments);
        const StrategyChoice its = choose_strategy(*varied, catalog, label);
        varied->specimen.references = references;
        prepare(varied->specimen, its.strategy);
        return {varied, &varied->specimen, varied->experiment.get(), its, varied->time};
      } catch (const InputError& error) {
        throw InputError("no derivative by " + key + ": " + error.what());
      }
    };
    const double size = stated.value != 0 ? std::abs(stated.value) : large_for(stated.unit, scene.specimen);
    const double step = (choice.name.calibrated ? kCalibratedStep : kStep) * size;
    numbers.push_back({key, stated.value, step, choice.name.calibrated, at});
  }
  return numbers.empty() ? nullptr : std::make_shared<Derivatives>(std::move(numbers));
}

void check_deviations(const Scene& scene, const RunOptions& options, Run& run) {
  if (!options.derivatives || run.outcome != Outcome::converged) return;
  std::vector<std::pair<std::string, double>> deviations;
  for (const auto& [key, deviation] : scene.uncertain) deviations.emplace_back(key, deviation);
  options.derivatives->check_deviations(deviations, options, run);
}

}  // namespace elastin::lab
