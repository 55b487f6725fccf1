#include "experiment/specimen.h"

#include <chrono>
#include <cstdio>
#include <optional>
#include <string>

#include "elastin/forces/bending.h"
#include "elastin/forces/volume.h"
#include "elastin/model/surfaces.h"
#include "elastin/model/voronoi.h"
#include "elastin/simulation/fibres.h"
#include "elastin/solve/modes.h"
#include "experiment/calibration.h"
#include "experiment/load_curve.h"
#include "experiment/run_in_time.h"
#include "experiment/timed.h"
#include "stiffness/voronoi.h"

namespace elastin {
namespace {

class Stopwatch {
 public:
  double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

std::string counted(int count, const std::string& singular, const std::string& plural) {
  return std::to_string(count) + " " + (count == 1 ? singular : plural);
}

void note_negative_constants(Run& run) {
  const int negative = static_cast<int>((run.constants.array() < 0).count());
  if (negative > 0)
    run.warnings.push_back(counted(negative, "spring constant is", "spring constants are") + " negative (of " +
                           std::to_string(run.constants.size()) + "): the body may have no stable equilibrium");
}

void note_lost_faces(const Body& body, const Strategy& strategy, Run& run) {
  if (!strategy.name.starts_with(Voronoi::name)) return;  // with a volume term or without
  const double lost = lost_share(body, *body.voronoi);
  char percent[16];
  std::snprintf(percent, sizeof percent, "%.1f %%", 100 * lost);
  if (lost > 0.01)
    run.warnings.push_back(std::string(percent) +
                           " of the body hangs on faces between molecules that no connection joins, or on the surface");
}

void count_modes(const Model& model, Run& run) {
  std::vector<char> stiff;
  if (run.constants.size() > 0) {
    stiff.resize(static_cast<std::size_t>(run.constants.size()));
    for (Eigen::Index c = 0; c < run.constants.size(); ++c) stiff[static_cast<std::size_t>(c)] = run.constants[c] != 0;
  }
  const ModeReport report = find_zero_energy_modes(model.body(), model.supports, stiff);
  run.zero_energy_modes = report.zero_energy_modes;
  if (report.zero_energy_modes > 0)
    run.warnings.push_back("mechanism: " + std::string(report.counted ? "" : "at least ") +
                           counted(report.zero_energy_modes, "zero-energy mode", "zero-energy modes") +
                           "; the load is solved in the range of the stiffness");
}

bool needs_voronoi(const Body& body, const Strategy& strategy, const Material& material) {
  return !body.voronoi && (strategy.needs_voronoi(body) || fibres_need_voronoi(strategy, body, material));
}

void note_identified(const Identified& found, Run& run) {
  run.measures.set("identified_modulus", found.modulus(0));
  run.measures.set("identified_modulus_middle", found.modulus(found.up_to / 2));
  run.measures.set("identified_modulus_end", found.modulus(found.up_to));
  run.measures.set("identified_misfit", found.misfit);
}

}  // namespace

bool needs_cells(const Strategy& strategy, const Body& body) {
  if (body.triangles.empty() && body.tetrahedra.empty()) return false;
  Body bare = body;
  bare.triangles.clear();
  bare.tetrahedra.clear();
  if (strategy.volume_modulus && !unsuited_for_volumes(bare).empty()) return true;
  return !strategy.unsuited(bare).empty() && !strategy.needs_voronoi(bare);
}

std::string unsuited(const Specimen& specimen, Experiment& experiment, const StrategyChoice& choice) {
  std::string reason = choice.strategy.unsuited(specimen.body);
  if (reason.empty()) reason = fibres_unsuited(choice.strategy, specimen.body, specimen.material);
  if (reason.empty() && choice.calibrated && specimen.body.connection_stiffness.size())
    reason = "a body with regions has no one modulus to calibrate to";
  if (reason.empty() && choice.calibrated) reason = calibration_unsuited(experiment, specimen.material);
  if (reason.empty() && experiment.identification()) reason = identification_unsuited(choice);
  return reason;
}

std::optional<Model> make_model(const Specimen& specimen, Experiment& experiment, const StrategyChoice& choice,
                                const RunOptions& options, Run& run) {
  const auto& [body, material, loads, _, contact] = specimen;
  auto elasticity = choice.strategy.constants ? make_rule(specimen, experiment, choice, options, run)
                                              : choice.strategy.make(body, material, choice.values);
  if (!elasticity) return std::nullopt;
  note_negative_constants(run);
  if (material.curve && !choice.strategy.follows_curve)
    run.warnings.push_back("does not follow the material's curve: it takes its slope at no strain alone");
  std::optional<Model> model(body);
  model->add(std::move(elasticity));
  if (auto fibres = make_fibres(choice.strategy, body, material)) model->add(std::move(fibres));
  if (material.bending_rigidity > 0) model->add(make_bending(body, material.bending_rigidity, material.poissons_ratio));
  if (!body.cables.empty()) model->add(make_cables(body));
  for (const auto& add_load : loads) add_load(*model);
  if (contact) model->add(make_contact(body, *contact));
  experiment.hold(*model);
  return model;
}

void prepare(Body& body, const Strategy& strategy, const Material& material) {
  if (needs_voronoi(body, strategy, material)) body.voronoi = voronoi_cells(body);
}

Run run_strategy(const Specimen& specimen, Experiment& experiment, const StrategyChoice& choice,
                 const RunOptions& options) {
  const Stopwatch build;
  if (needs_voronoi(specimen.body, choice.strategy, specimen.material)) {
    Specimen prepared = specimen;
    prepare(prepared.body, choice.strategy, specimen.material);
    const double seconds = build.seconds();
    Run run = run_strategy(prepared, experiment, choice, options);
    run.build_seconds += seconds;
    return run;
  }
  Run run;
  run.strategy = choice.label;
  if (options.progress) options.progress("building");
  run.cause = unsuited(specimen, experiment, choice);
  if (!run.cause.empty()) {
    run.suited = false;
    return run;
  }
  note_lost_faces(specimen.body, choice.strategy, run);
  run.uses_cells = needs_cells(choice.strategy, specimen.body);
  if (run.uses_cells) {
    const std::vector<int> cells = flat_or_inverted_cells(specimen.body, specimen.body.rest);
    if (!cells.empty()) {
      run.outcome = Outcome::inverted;
      run.cause = flat_or_inverted_text(cells, specimen.body.tetrahedra.size()) + " at rest";
      return run;
    }
    const std::vector<int> triangles = flat_triangles(specimen.body, specimen.body.rest);
    if (!triangles.empty()) {
      run.outcome = Outcome::inverted;
      run.cause = flat_or_inverted_text(triangles, specimen.body.triangles.size()) + " at rest";
      return run;
    }
  }
  std::optional<Specimen> found;  // with the material identified
  if (const auto wanted = experiment.identification()) {
    found = specimen;
    if (!identify_material(*wanted, *found, experiment, choice, options, run)) return run;
  }
  const Specimen& at_work = found ? *found : specimen;
  std::optional<Model> model = make_model(at_work, experiment, choice, options, run);
  if (!model) return run;
  run.build_seconds = build.seconds();
  if (!experiment.stiffened_by_load() && !(specimen.material.bending_rigidity > 0)) count_modes(*model, run);

  const Stopwatch solve;
  if (TimedExperiment* timed = experiment.in_time())
    run_in_time(*model, *timed, specimen, options, run);
  else
    solve_load_curve(*model, experiment, at_work.material, options, run, specimen.start);
  if (run.identified) note_identified(*run.identified, run);
  run.solve_seconds = solve.seconds();
  return run;
}

}  // namespace elastin
