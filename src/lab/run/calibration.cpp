#include "lab/run/specimen.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "core/forces/volume.h"
#include "core/simulation/volume_fit.h"
#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"
#include "elastin/core/model/share.h"
#include "lab/run/common_measures.h"
#include "lab/run/load_path.h"
#include "lab/run/uniform_block.h"

namespace elastin::lab {
namespace {

Material without_fibres(const Material& material) {
  Material matrix = material;
  matrix.fibre.reset();
  return matrix;
}

/// The measure to which a rule is calibrated: the first modulus that the material prescribes a value for. A ratio does
/// not change with the springs' scale.
std::optional<MainMeasure> calibration_target(const StaticExperiment& experiment, const Material& material) {
  const MeasureList list = measures_of(experiment);
  for (const MainMeasure& measure : experiment.main_measures(without_fibres(material), {}))
    if (std::isfinite(measure.prescribed) && list.at(measure.name).unit != dimension::none) return measure;
  return std::nullopt;
}

/// The computed reference to which a rule is calibrated where the material's modulus shows on no body of this shape:
/// of the first main measure that has one and grows with the springs, a modulus or a force.
const Reference* calibrated_reference(const StaticExperiment& experiment, const Specimen& specimen) {
  const MeasureList list = measures_of(experiment);
  for (const MainMeasure& measure : experiment.main_measures(without_fibres(specimen.material), {}))
    for (const Reference& reference : specimen.references) {
      if (reference.measure != measure.name || !reference.certain()) continue;
      const Dimension& unit = list.at(reference.measure).unit;
      if (unit == dimension::pressure || unit == dimension::force) return &reference;
    }
  return nullptr;
}

void fail_calibration(Run& run, const std::string& cause) {
  if (run.outcome != Outcome::converged) return;  // the solve itself has said why
  run.outcome = Outcome::diverged;
  run.cause = "calibration: " + cause;
}

/// What one linear solve under a small load measures; nothing if it fails.
/// @param unstable whether an equilibrium with directions of negative stiffness counts
std::optional<Measures> measure_linear(const Specimen& specimen, const StaticExperiment& experiment,
                                       ElasticTerms elasticity, const StaticOptions& options, Run& run,
                                       bool unstable = true) {
  Model model(specimen.body);
  model.add(std::move(elasticity));
  model.set_rest(0);
  const auto rig = experiment.static_rig(model);
  rig->set_load(0x1p-10);
  State state = state_at_rest(specimen.body);
  StaticOptions linear = options;
  linear.linear = true;
  StaticResult solved = solve_static(model, state, linear);
  const Start rest{specimen.body.rest, Positions::Zero(3, solved.reactions.cols())};
  Measures measures;
  if (solved.outcome == Outcome::converged) measures = rig->measure(rest, state, linear, solved);
  run.linear_iterations += solved.linear_iterations;
  if (solved.unstable && !unstable) return std::nullopt;
  if (solved.outcome == Outcome::converged) return measures;
  run.outcome = solved.outcome;
  run.cause = "calibration: " + solved.cause;
  return std::nullopt;
}

/// Whether what was measured is rounding: the load meets a stiffness far below that of any single connection.
bool meets_nothing(const Body& body, const MeasureList& list, const Measures& measures, const VectorX& constants) {
  const double stiffness =
      std::abs(measures.get(list.named(MeasureRole::force)) / measures.get(list.named(MeasureRole::displacement)));
  return stiffness < 1e-9 * largest_over(body, constants.cwiseAbs().maxCoeff());
}

/// If so, the strategy does not suit the body.
bool note_mechanism(const Body& body, const MeasureList& list, const std::optional<Measures>& measures, Run& run) {
  if (!measures || !meets_nothing(body, list, *measures, run.constants)) return false;
  run.suited = false;
  run.cause = "nothing to calibrate: the body is a mechanism that does not resist this load";
  return true;
}

/// The springs of the run's constants, all on one curve if there is one, and a volume term of this modulus if the
/// strategy has one.
ElasticTerms assembled(const Specimen& specimen, const StrategyChoice& choice, const Run& run, double volume_modulus,
                       const std::optional<StressStrain>& curve = {}) {
  ElasticTerms terms = curve
                           ? make_curve_springs(specimen.body, run.constants / specimen.material.youngs_modulus, *curve)
                           : make_springs(specimen.body, run.constants);
  if (choice.strategy.volume_modulus) terms.add(make_volume(specimen.body, volume_modulus));
  return terms;
}

/// Beyond this factor a rule is not corrected but replaced.
constexpr double kMostScaled = 2;

void scale(Run& run, const StrategyChoice& choice, double factor, double volume_modulus) {
  run.calibration_factor = factor;
  if ((factor > kMostScaled || factor < 1 / kMostScaled) && !choice.strategy.takes_scale) {
    char text[120];
    std::snprintf(text, sizeof text,
                  "calibration multiplies the spring constants by %.4g; the rule alone is that far off on this body",
                  factor);
    run.warnings.emplace_back(text);
  }
  run.constants *= factor;
  run.volume_modulus = volume_modulus;
}

/// What the material's law itself measures in the experiment on a block, where it has directions: there E and ν are
/// means over them. Nothing for other materials.
std::optional<Measures> measured_of_law(const Specimen& specimen, const StaticExperiment& experiment,
                                        const Measures& measured) {
  const Material& material = specimen.material;
  if (!specimen.law || !material.law || material.law->directions.empty()) return std::nullopt;
  const std::optional<UniformTest> test = experiment.uniform(measured);
  if (!test) return std::nullopt;
  return measured_on_block(*test, specimen.body, specimen.law->strategy, without_fibres(material),
                           specimen.law->values);
}

void warn_of_mean(const Specimen& specimen, Run& run) {
  if (const auto& law = specimen.material.law; law && !law->directions.empty())
    run.warnings.push_back("calibrated to E = " + number(1e-3 * specimen.material.youngs_modulus, 4) +
                           " kPa, one value for all directions, where the law " + law->law + " has one for each");
}

/// Scales the run's stiffness to the modulus prescribed / measured.
void scale_to_modulus(const Specimen& specimen, const StaticExperiment& experiment, const StrategyChoice& choice,
                      const StaticOptions& options, Run& run) {
  const auto measures =
      measure_linear(specimen, experiment, assembled(specimen, choice, run, run.volume_modulus), options, run);
  if (note_mechanism(specimen.body, experiment.measures(), measures, run)) return;
  MainMeasure target = *calibration_target(experiment, specimen.material);
  if (const auto law = measures ? measured_of_law(specimen, experiment, *measures) : std::nullopt)
    target.prescribed = law->get(target.name);
  else
    warn_of_mean(specimen, run);
  const double factor = measures ? target.prescribed / measures->get(target.name) : 0;
  if (!(factor > 0)) return fail_calibration(run, "the linear solve measures no positive modulus");
  scale(run, choice, factor, factor * run.volume_modulus);
}

/// Fits the run's constants and volume term to E and ν.
void fit_springs_and_volume(const Specimen& specimen, const StaticExperiment& experiment, const StrategyChoice& choice,
                            const StaticOptions& options, Run& run) {
  const MeasureList list = experiment.measures();
  const auto fit = fit_volume(specimen.material, [&](double modulus) -> std::optional<std::pair<double, double>> {
    Run trial;  // a negative term that leaves the body unstable ends no more than the search on that side
    const auto measures =
        measure_linear(specimen, experiment, assembled(specimen, choice, run, modulus), options, trial, modulus >= 0);
    run.linear_iterations += trial.linear_iterations;
    if (modulus >= 0 || trial.outcome == Outcome::interrupted) run.outcome = trial.outcome, run.cause = trial.cause;
    if (!measures || (modulus >= 0 && note_mechanism(specimen.body, list, measures, run))) return std::nullopt;
    return std::pair{measures->get(list.named(MeasureRole::youngs_modulus)),
                     measures->get(list.named(MeasureRole::poissons_ratio))};
  });
  if (!run.suited || run.outcome == Outcome::interrupted) return;
  if (!fit) return fail_calibration(run, "the linear solves measure no positive E, or no Poisson's ratio");
  scale(run, choice, fit->spring_factor, fit->volume_modulus);
  warn_of_mean(specimen, run);
  if (!fit->met)
    run.warnings.push_back("calibration reaches no nearer Poisson's ratio than " + std::to_string(fit->poissons_ratio));
}

/// Scales the run's stiffness until the body measures what the solid itself does under the whole load: at once where
/// the load is a displacement, for then all forces are in proportion to the springs.
void scale_to_reference(const Specimen& specimen, const StaticExperiment& experiment, const StrategyChoice& choice,
                        const RunOptions& options, Run& run) {
  constexpr int most_runs = 12;
  constexpr double near = 1e-6;
  const Reference& target = *calibrated_reference(experiment, specimen);
  RunOptions quiet;
  quiet.statics = options.statics;
  double factor = 1, off = INFINITY;
  for (int trial = 0; trial < most_runs && std::abs(off) > near; ++trial) {
    if (options.progress) options.progress("calibrating to the computed reference");
    Model model(specimen.body);
    Run scaled = run;
    scaled.constants *= factor;
    model.add(assembled(specimen, choice, scaled, factor * run.volume_modulus, specimen.material.curve));
    const auto rig = add_surroundings(model, specimen, experiment, choice);
    Run found;
    solve_load_curve(model, experiment, *rig->at_rest(), specimen.material, quiet, found, specimen.start);
    run.linear_iterations += found.linear_iterations;
    const double measured = found.measures.get(target.measure);
    if (found.outcome != Outcome::converged || !(measured / target.value > 0)) {
      run.outcome = found.outcome == Outcome::converged ? Outcome::diverged : found.outcome;
      run.cause = "calibration to the computed reference: " +
                  (found.cause.empty() ? "the springs measure no positive " + target.measure : found.cause);
      return;
    }
    off = measured / target.value - 1;
    if (std::abs(off) > near) factor /= 1 + off;
  }
  if (std::abs(off) > 1e-3) return fail_calibration(run, "no factor of the springs reaches the computed reference");
  run.calibrated_to_reference = true;
  scale(run, choice, factor, factor * run.volume_modulus);
}

/// Whether an experiment measures both E and ν of a material.
bool measures_both(const StaticExperiment& experiment, const Material& material) {
  const MeasureList list = experiment.measures();
  int found = 0;
  for (const MainMeasure& measure : experiment.main_measures(material, {}))
    found += measure.name == list.named(MeasureRole::youngs_modulus) ||
             measure.name == list.named(MeasureRole::poissons_ratio);
  return found == 2;
}

/// A curve of the springs with which the body shows the material's.
StressStrain fitted_curve(const Specimen& specimen, const StaticExperiment& experiment, const StrategyChoice& choice,
                          const RunOptions& options, Run& run) {
  const Material matrix = without_fibres(specimen.material);
  const MeasureList list = experiment.measures();
  const std::string strain = list.named(MeasureRole::strain), stress = list.named(MeasureRole::stress);
  RunOptions quiet;
  quiet.statics = options.statics;
  const CurveFit fit = fit_curve(*matrix.curve, [&](const StressStrain& springs) {
    if (options.progress) options.progress("fitting the springs' curve");
    Model model(specimen.body);
    model.add(assembled(specimen, choice, run, run.volume_modulus, springs));
    const auto rig = experiment.static_rig(model);
    Run trial;
    solve_load_curve(model, experiment, *rig, matrix, quiet, trial);
    run.linear_iterations += trial.linear_iterations;
    std::vector<StressStrain::Point> shown;
    for (const CurvePoint& point : trial.curve)
      shown.push_back({point.measures.get(strain), point.measures.get(stress)});
    return shown;
  });
  if (fit.error > 0.01)
    run.warnings.push_back("the springs' curve could not be fitted: the body's is " +
                           std::to_string(static_cast<int>(std::round(100 * fit.error))) + " % off the material's");
  return fit.springs;
}

/// Names the first connection whose constant is not finite.
std::string non_finite_text(const Body& body, const VectorX& constants) {
  int connection = 0;
  while (std::isfinite(constants[connection])) ++connection;
  const auto& [a, b] = body.connections.ends[connection];
  return "the spring constant of connection " + std::to_string(connection) + " (molecules " + std::to_string(a) + ", " +
         std::to_string(b) + ") is not finite" +
         (body.connections.rest_length[connection] > 0 ? "" : ": it has no length");
}

}  // namespace

const StaticExperiment* calibration_of(const Experiment& experiment, const Specimen& specimen) {
  return specimen.calibration ? specimen.calibration.get() : experiment.calibration();
}

std::string calibrated_measure(const StaticExperiment& experiment, const Material& material) {
  const auto target = calibration_target(experiment, material);
  return target ? target->name : "";
}

std::string calibration_unsuited(const Experiment& experiment, const Specimen& specimen) {
  if (specimen.body.connection_stiffness.size())
    return "a body with regions, or with boxes that are filled in part, has no one modulus to calibrate to";
  const StaticExperiment* at_rest = calibration_of(experiment, specimen);
  if (at_rest && (calibration_target(*at_rest, specimen.material) || calibrated_reference(*at_rest, specimen)))
    return "";
  const std::string why = !at_rest              ? ""
                          : at_rest->apparent() ? "its modulus is apparent, of the body's shape as well as of the "
                                                  "material, and there is no computed reference"
                                                : at_rest->no_reference();
  return "the experiment " + experiment.name() + " measures on this body no modulus to calibrate to" +
         (why.empty() ? "" : ": " + why);
}

std::optional<ElasticTerms> make_rule(const Specimen& specimen, const Experiment& experiment,
                                      const StrategyChoice& choice, const RunOptions& options, Run& run) {
  const bool with_volume = static_cast<bool>(choice.strategy.volume_modulus);
  const StaticExperiment* calibration = calibration_of(experiment, specimen);
  if (choice.strategy.fit) {
    try {
      FittedSprings found = choice.strategy.fit(specimen.body, specimen.material, choice.values);
      run.constants = std::move(found.constants);
      run.volume_modulus = found.volume_modulus;
      if (!found.remains.empty()) run.warnings.push_back(std::move(found.remains));
    } catch (const InputError& error) {
      run.suited = false;
      run.cause = error.what();
      return std::nullopt;
    }
  } else {
    run.constants = choice.strategy.constants(specimen.body, specimen.material, choice.values);
    if (with_volume) run.volume_modulus = choice.strategy.volume_modulus(specimen.material);
  }
  const auto is_finite = [&] {
    const std::string found =
        first_over(specimen.body, run.constants.allFinite() ? "" : non_finite_text(specimen.body, run.constants));
    if (found.empty()) return true;
    run.outcome = Outcome::diverged;
    run.cause = found;
    return false;
  };
  if (!is_finite()) return std::nullopt;
  if (choice.name.calibrated) {
    const StaticExperiment& at_rest = *calibration;
    const bool both = with_volume && measures_both(at_rest, specimen.material);
    if (!calibration_target(at_rest, specimen.material))
      scale_to_reference(specimen, at_rest, choice, options, run);
    else
      (both ? fit_springs_and_volume : scale_to_modulus)(specimen, at_rest, choice, options.statics, run);
  }
  if (!is_finite()) return std::nullopt;
  if (!run.suited || run.outcome != Outcome::converged) return std::nullopt;
  std::optional<StressStrain> curve = specimen.material.curve;
  if (curve && choice.name.calibrated && !run.calibrated_to_reference && !options.statics.linear && calibration->axis())
    curve = fitted_curve(specimen, *calibration, choice, options, run);
  if (!curve && choice.name.softened)  // springs as rods of the material have an energy density
    curve = StressStrain::linear(specimen.material.youngs_modulus);
  return assembled(specimen, choice, run, run.volume_modulus, curve);
}

namespace {

/// Through the origin, the loaded side's points, and as many of the given curve on the other side.
std::vector<StressStrain::Point> with_other_side(const StressStrain& given,
                                                 const std::vector<StressStrain::Point>& loaded) {
  std::vector<StressStrain::Point> points{{0, 0}};
  for (const auto& point : loaded) {
    points.push_back(point);
    const double other = -point.strain;
    if (other > -0.9) points.push_back({other, given.stress(other)});
  }
  std::sort(points.begin(), points.end(), [](const auto& a, const auto& b) { return a.strain < b.strain; });
  return points;
}

double largest_error(const StressStrain& given, const std::vector<StressStrain::Point>& shown) {
  double difference = 0, largest = 0;
  for (const auto& [strain, stress] : shown) {
    difference = std::max(difference, std::abs(stress - given.stress(strain)));
    largest = std::max(largest, std::abs(given.stress(strain)));
  }
  return difference / largest;
}

}  // namespace

CurveFit fit_curve(const StressStrain& given, const MeasureCurve& measure) {
  constexpr int most_runs = 25;
  constexpr double tolerance = 1e-4;
  CurveFit best{given, 1};
  StressStrain springs = given;
  std::size_t steps = 0;
  for (int run = 0; run < most_runs && best.error > tolerance; ++run) {
    std::vector<StressStrain::Point> shown = measure(springs);
    if (run == 0) steps = shown.size();
    if (shown.empty() || shown.size() < steps) break;
    const double error = largest_error(given, shown);
    if (!(error < 100)) break;
    if (error < best.error) best = {springs, error};
    for (auto& [strain, stress] : shown) stress = springs.stress(strain) * given.stress(strain) / stress;
    const auto points = with_other_side(given, shown);
    if (StressStrain::fault(points)) break;
    springs = StressStrain::through(points);
  }
  return best;
}

}  // namespace elastin::lab
