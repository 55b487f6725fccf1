#include "lab/study/study.h"

#include <memory>
#include <string>

#include "core/solve/trial.h"
#include "elastin/core/base/error.h"
#include "lab/experiment/homogenisation/homogenisation.h"
#include "lab/run/load_path.h"
#include "lab/run/section.h"

namespace elastin::lab {
namespace {

/// Why a body has no one E and G, or none that is affordable, or "".
std::string unsuited(const Scene& scene, bool known) {
  const Specimen& specimen = scene.specimen;
  const Body& body = specimen.body;
  if (!body.parts.empty()) return "the scene has several bodies";
  if (std::string why = no_isotropic_moduli(specimen.material); !why.empty()) return why;
  if (!body.cables.empty()) return "the body has cables";
  if (specimen.material.field || is_stressed(specimen) || body.connection_stiffness.size() > 0 ||
      body.cell_stiffness.size() > 0)
    return "the stiffness changes from place to place";
  if (identification_of(*scene.experiment)) return "the experiment is there to find the material";
  if (!known && body.size() > kMostMeasuredMolecules)
    return "the body has more than " + std::to_string(kMostMeasuredMolecules) + " molecules";
  return "";
}

/// Where molecules of a box lie behind its sides, as in a packing, those within half a mean connection belong to them.
std::unique_ptr<StaticExperiment> six_strains(const Body& body, const Matrix3& axes) {
  try {
    return make_homogenisation(body, {}, axes);
  } catch (const InputError& no_box) {
    if (!body.tetrahedra.empty() || !body.triangles.empty() || body.connections.size() == 0) throw;
    try {
      return make_homogenisation(body, {mean_length(body) / 2}, axes);
    } catch (const InputError&) {
      throw no_box;
    }
  }
}

}  // namespace

DirectionErrors measure_directions(const Scene& scene, const StrategyChoice& choice, const RunOptions& options,
                                   const Run& run) {
  DirectionErrors errors;
  const Specimen& specimen = scene.specimen;
  const auto& known = run.measures.stiffness_matrix;
  errors.trouble = unsuited(scene, known.has_value());
  if (!errors.measured()) return errors;
  Material target = specimen.material;
  if (target.relaxation && (scene.experiment->at_rest() || choice.name.relaxed))
    target.youngs_modulus *= target.relaxation->long_term();
  if (!(target.youngs_modulus > 0)) {
    errors.trouble = "at rest the material bears nothing";
    return errors;
  }
  if (known) return direction_errors(*known, target);
  std::unique_ptr<StaticExperiment> strains;
  try {
    strains = six_strains(specimen.body, scene.rotation);
  } catch (const InputError& error) {
    errors.trouble = error.what();
    errors.trouble.erase(std::min(errors.trouble.find(':'), errors.trouble.size()));
    return errors;
  }
  RunOptions small;
  small.statics = options.statics;
  small.statics.linear = true;
  small.statics.stop = options.stop;
  Run found;
  auto elasticity = make_elasticity(specimen, *scene.experiment, choice, small, found);
  if (elasticity) {
    Model model(specimen.body);
    model.add(std::move(*elasticity));
    const auto rig = strains->static_rig(model);
    solve_load_curve(model, *strains, *rig, specimen.material, small, found);
  }
  if (const auto& matrix = found.measures.stiffness_matrix) return direction_errors(*matrix, target);
  errors.trouble = found.cause.empty() ? "nothing was measured" : found.cause;
  return errors;
}

}  // namespace elastin::lab
