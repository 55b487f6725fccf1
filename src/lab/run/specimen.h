#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "elastin/core/forces/model.h"
#include "elastin/core/model/stress_strain.h"
#include "elastin/core/simulation/catalog.h"
#include "lab/run/run.h"

namespace elastin::lab {

/// A strategy as a scene or a command line names it: "standard", "lattice+volume", "calibrated:angles", with its
/// parameters.
struct StrategyChoice {
  std::string label;  ///< as it was named
  StrategyName name;
  Strategy strategy;  ///< the rule or law itself, with its volume term if any; for calibrated:RULE the rule
  ParameterValues values;
  int order = 0;  ///< among all_strategies, the simplest first: the catalog's, then with an ending, then calibrated
  std::shared_ptr<const Strategy> rule = {};  ///< of prony:calibrated:RULE and its like: the rule; else null
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

/// Prepares the specimen's body for a strategy and its materials (see elastin::prepare), with the Voronoi cells of
/// elastin::mesh.
void prepare(Specimen& specimen, const Strategy& strategy);

/// The choice, with a volume term where it is a law of solids that locks without one: where a Poisson's ratio is above
/// kLocking, and the law and the cells can have one.
StrategyChoice without_locking(const Catalog& catalog, StrategyChoice choice, const Specimen& specimen);

/// Whether the strategy needs the triangles or tetrahedra of a body that it suits.
bool needs_cells(const Strategy& strategy, const Body& body);

/// Whether the body is stressed in the shape that it is described in.
inline bool is_stressed(const Specimen& specimen) {
  return specimen.body.unstressed || specimen.given != GivenShape::at_rest;
}

/// Of the whole body, or of its parts.
std::vector<Material> materials_of(const Specimen& specimen);

/// Every strategy that there is for this specimen: all_strategies for its body and each of its materials.
std::vector<StrategyChoice> all_strategies(const Catalog& catalog, const Specimen& specimen);

/// The material that an experiment is there to find, if any.
std::optional<Identification> identification_of(const Experiment& experiment);

/// Why a strategy cannot run here, or "".
std::string unsuited(const Specimen& specimen, const Experiment& experiment, const StrategyChoice& choice);

/// The strategy at work on the specimen's body alone; nothing if that fails: the run says why. The body must be
/// prepared, and outlive it.
std::optional<ElasticTerms> make_elasticity(const Specimen& specimen, const Experiment& experiment,
                                            const StrategyChoice& choice, const RunOptions& options, Run& run);

/// Adds all other terms to a model of the specimen's body: fibres, bending, cables, ties, the scene's loads, its
/// contact, and the experiment's supports and load. The rig must not outlive the model.
std::unique_ptr<Rig> add_surroundings(Model& model, const Specimen& specimen, const Experiment& experiment,
                                      const StrategyChoice& choice);

/// A model in the rig that holds and loads it.
struct HeldModel {
  std::unique_ptr<Model> model;
  std::unique_ptr<Rig> rig;
};

/// Both: the strategy at work with the scene's loads, held by the experiment; nothing if that fails. Specimen and
/// experiment must outlive the model.
std::optional<HeldModel> make_model(const Specimen& specimen, const Experiment& experiment,
                                    const StrategyChoice& choice, const RunOptions& options, Run& run);

/// Builds the strategy on the specimen, solves every load step and measures. Numerical trouble is an outcome in the
/// result; wrong parameters throw InputError. A body that is not prepared is copied for the run.
Run run_strategy(const Specimen& specimen, const Experiment& experiment, const StrategyChoice& choice,
                 const RunOptions& options);

/// Sets what the law itself measures where the run has come to, on a small block in which every point is alike: of the
/// law that the material states, or else of the run's own where that works on cells. Nothing where no uniform strain
/// shows it, or all is linear.
void measure_law(const Specimen& specimen, const Experiment& experiment, const StrategyChoice& choice,
                 const RunOptions& options, Run& run);

/// The law that a material states, on such a body; null where it states E and ν alone.
std::shared_ptr<const StrategyChoice> stated_law(const Catalog& catalog, const Material& material, const Body& body);

/// The experiment in which rules are calibrated: the specimen's, or the one that it is used in. Null where there is
/// none.
const StaticExperiment* calibration_of(const Experiment& experiment, const Specimen& specimen);

/// Name of the measure to which an experiment calibrates: the first modulus that the material, without its fibres,
/// prescribes; "" without one.
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

/// Why no modulus of the scene's material is that of the whole specimen, or "".
std::string no_one_modulus(const Specimen& specimen);

/// What a user should know of a specimen before it is loaded, in sentences: cells that are given twice, overlap with
/// obstacles or between bodies, obstacles that fit between what they meet.
std::vector<std::string> findings_at_start(const Specimen& specimen, const Model& model, bool uses_cells);

/// What a user should know of a run that ended: a rebound faster than the impact, obstacles that something has passed
/// or may have passed through, a modulus that is of more than the material.
std::vector<std::string> findings_at_end(const Specimen& specimen, const MeasureList& list, const Model& model,
                                         const Run& run);

}  // namespace elastin::lab
