#pragma once
#include <functional>
#include <string>
#include <vector>

#include "elastin/core/model/stress_strain.h"
#include "lab/run/choice.h"
#include "lab/run/run.h"

namespace elastin::lab {

/// The experiment in which rules are calibrated: the specimen's, or the one that it is used in. Null where there is
/// none.
const StaticExperiment* calibration_of(const Experiment& experiment, const Specimen& specimen);

/// Name of the measure to which an experiment calibrates: the first modulus that the material, without its fibres,
/// prescribes; "" where there is none.
std::string calibrated_measure(const StaticExperiment& experiment, const Material& material);

/// Why a rule cannot be calibrated in this experiment, or "".
std::string calibration_unsuited(const Experiment& experiment, const Specimen& specimen);

/// The springs of a rule, with their volume term if any, without the material's fibres. A choice that is `calibrated`
/// is fitted to the material by solves of the experiment alone, without the scene's other loads and without fibres:
///   * the constants to the first modulus that the experiment measures, by one linear solve of a small load (so that
///     paths which are curved are straight too);
///   * with a volume term, and where the experiment measures both E and ν, constants and term to both, by two linear
///     solves and at most two more;
///   * where the material prescribes no such modulus (a body that is no prism), constants and term by one factor with
///     which the body measures the specimen's computed reference under the whole load;
///   * where the material has a stress–strain curve, then the springs' own curve to it (see curve_fit.h).
/// Sets the run's constants and what calibration found. Null if a solve fails: the run says why.
std::optional<ElasticTerms> make_rule(const Specimen& specimen, const Experiment& experiment,
                                      const StrategyChoice& choice, const RunOptions& options, Run& run);

/// Runs the body with springs that follow a curve; gives the nominal strain and stress that it shows at each load step,
/// ascending in size; fewer than there are load steps if a step failed.
using MeasureCurve = std::function<std::vector<StressStrain::Point>(const StressStrain&)>;

struct CurveFit {
  StressStrain springs;  ///< what each spring must follow
  double error;          ///< largest |stress shown − given| over the largest given; 1 if nothing could be measured
};

/// The curve of the springs with which the whole body shows the given one: a spring along the load has the strain of
/// the whole, so its stress there is multiplied by given/shown until they agree to 1e-4, or for 25 runs. On the side
/// that is not loaded the springs keep the given curve. The best of all runs is returned.
CurveFit fit_curve(const StressStrain& given, const MeasureCurve& measure);

}  // namespace elastin::lab
