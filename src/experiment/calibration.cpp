#include "experiment/calibration.h"

#include <cmath>
#include <utility>

#include "elastin/forces/volume.h"
#include "experiment/volume_fit.h"

namespace elastin {
namespace {

/// What one linear solve of the experiment alone measures, without the scene's other loads; nothing if it fails. A
/// small load, so that ways which are curved (of torsion) are straight too.
std::optional<Measures> measure_linear(const Specimen& specimen, Experiment& experiment,
                                       std::unique_ptr<Elasticity> elasticity, const StaticOptions& options, Run& run) {
  Model model(specimen.body);
  model.add(std::move(elasticity));
  experiment.hold(model);
  experiment.set_load(model, 0x1p-10);
  State state = state_at_rest(specimen.body);
  StaticOptions linear = options;
  linear.linear = true;
  StaticResult solved = solve_static(model, state, linear);
  const Start rest{specimen.body.rest, Positions::Zero(3, solved.reactions.cols())};
  Measures measures;
  if (solved.outcome == Outcome::converged) measures = experiment.measure(model, rest, state, linear, solved);
  run.linear_iterations += solved.linear_iterations;
  if (solved.outcome == Outcome::converged) return measures;
  run.outcome = solved.outcome;
  run.cause = "calibration: " + solved.cause;
  return std::nullopt;
}

void fail_calibration(Run& run, const std::string& cause) {
  if (run.outcome != Outcome::converged) return;
  run.outcome = Outcome::diverged;
  run.cause = "calibration: " + cause;
}

void scale(Run& run, double factor, double volume_modulus) {
  run.calibration_factor = factor;
  run.constants *= factor;
  run.volume_modulus = volume_modulus;
}

/// Whether the load meets a stiffness so far below that of any single connection that what was measured is rounding.
bool meets_nothing(const Measures& measures, const VectorX& constants) {
  const double stiffness = std::abs(measures.get("force") / measures.get("elongation"));
  return stiffness < 1e-9 * constants.cwiseAbs().maxCoeff();
}

/// If so, the strategy does not suit the body.
bool note_mechanism(const std::optional<Measures>& measures, Run& run) {
  if (!measures || !meets_nothing(*measures, run.constants)) return false;
  run.suited = false;
  run.cause = "nothing to calibrate: the body is a mechanism that does not resist this load";
  return true;
}

/// Scales the run's stiffness to what the material prescribes for the experiment's modulus.
void scale_to_modulus(const Specimen& specimen, Experiment& experiment, const StrategyChoice& choice,
                      const StaticOptions& options, Run& run) {
  const MainMeasure target = *calibrated_measure(experiment, specimen.material);
  const auto measures =
      measure_linear(specimen, experiment, springs_of(specimen, choice, run, run.volume_modulus), options, run);
  if (note_mechanism(measures, run)) return;
  const double factor = measures ? target.prescribed / measures->get(target.name) : 0;
  if (!(factor > 0)) return fail_calibration(run, "the linear solve measures no positive modulus");
  scale(run, factor, factor * run.volume_modulus);
}

/// Fits the run's spring constants and volume term to E and ν.
void fit_springs_and_volume(const Specimen& specimen, Experiment& experiment, const StrategyChoice& choice,
                            const StaticOptions& options, Run& run) {
  const auto fit = fit_volume(specimen.material, [&](double modulus) -> std::optional<std::pair<double, double>> {
    const auto measures =
        measure_linear(specimen, experiment, springs_of(specimen, choice, run, modulus), options, run);
    if (note_mechanism(measures, run) || !measures) return std::nullopt;
    return std::pair{measures->get("effective_modulus"), measures->get("poissons_ratio")};
  });
  if (!run.suited) return;
  if (!fit) return fail_calibration(run, "the linear solves measure no positive modulus, or no Poisson's ratio");
  scale(run, fit->spring_factor, fit->volume_modulus);
  if (std::abs(fit->poissons_ratio - specimen.material.poissons_ratio) > 0.002)
    run.warnings.push_back("calibration reaches no nearer Poisson's ratio than " + std::to_string(fit->poissons_ratio));
}

/// Whether an experiment measures both E and ν of a material.
bool measures_both(const Experiment& experiment, const Material& material) {
  int found = 0;
  for (const MainMeasure& measure : experiment.main_measures(material))
    found += measure.name == "effective_modulus" || measure.name == "poissons_ratio";
  return found == 2;
}

}  // namespace

std::optional<MainMeasure> calibrated_measure(const Experiment& experiment, const Material& material) {
  for (const MainMeasure& measure : experiment.main_measures(material))
    if (std::isfinite(measure.prescribed)) return measure;
  return std::nullopt;
}

std::unique_ptr<Elasticity> springs_of(const Specimen& specimen, const StrategyChoice& choice, const Run& run,
                                       double volume_modulus) {
  auto springs = make_springs(specimen.body, run.constants);
  if (!choice.strategy.volume_modulus) return springs;
  return make_sum(std::move(springs), make_volume(specimen.body, volume_modulus));
}

void calibrate(const Specimen& specimen, Experiment& experiment, const StrategyChoice& choice,
               const StaticOptions& options, Run& run) {
  const bool both = choice.strategy.volume_modulus && measures_both(experiment, specimen.material);
  (both ? fit_springs_and_volume : scale_to_modulus)(specimen, experiment, choice, options, run);
}

}  // namespace elastin
