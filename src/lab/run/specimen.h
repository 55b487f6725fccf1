#pragma once
#include <optional>

#include "lab/run/choice.h"
#include "lab/run/run.h"

namespace elastin::lab {

/// Prepares the specimen's body for a strategy and its materials (see elastin::prepare), with the Voronoi cells of
/// elastin::mesh.
void prepare(Specimen& specimen, const Strategy& strategy);

/// The choice, with a volume term where it is a law of solids that locks without one: where a Poisson's ratio is above
/// kLocking, and the law and the cells can have one.
StrategyChoice without_locking(const Catalog& catalog, StrategyChoice choice, const Specimen& specimen);

/// Whether the strategy needs the triangles or tetrahedra of a body that it suits.
bool needs_cells(const Strategy& strategy, const Body& body);

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

}  // namespace elastin::lab
