#include "lab/run/specimen.h"

#include <algorithm>
#include <cstdio>
#include <string>
#include <utility>

#include "core/base/stopwatch.h"
#include "core/base/unsuited_error.h"
#include "core/forces/volume.h"
#include "core/shapes/surfaces.h"
#include "core/simulation/fibres.h"
#include "core/simulation/warnings.h"
#include "core/solve/modes.h"
#include "core/solve/unloaded.h"
#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"
#include "elastin/core/forces/mullins.h"
#include "elastin/core/forces/prony.h"
#include "elastin/core/model/parts.h"
#include "elastin/core/model/share.h"
#include "elastin/core/simulation/parts.h"
#include "elastin/core/simulation/prepare.h"
#include "elastin/core/solve/engine.h"
#include "elastin/lab/run/experiment.h"
#include "elastin/mesh/voronoi.h"
#include "lab/run/contact_measures.h"
#include "lab/run/derivatives.h"
#include "lab/run/load_path.h"

namespace elastin::lab {
namespace {

/// Distance in the order between the catalog's own strategies and those that are made of them.
constexpr int kWithEnding = 1000, kCalibrated = 2000;

StrategyChoice chosen(const Catalog& catalog, const std::string& label, StrategyName name, Strategy found) {
  const std::vector<std::string> names = catalog.names();
  const int position = static_cast<int>(std::find(names.begin(), names.end(), name.rule) - names.begin()),
            order = position + (name.calibrated || name.fitted ? kCalibrated : 0) +
                    (name.volume || name.wrinkling ? kWithEnding : 0);
  if (name.calibrated && found.calibrates) found = Strategy(*found.calibrates);
  std::shared_ptr<const Strategy> rule;
  if (name.calibrated && found.has_history) {
    StrategyName bare = name;
    bare.relaxed = bare.softened = bare.calibrated = false;
    rule = std::make_shared<const Strategy>(catalog.find(bare));
  }
  return {label, std::move(name), std::move(found), {}, order, std::move(rule)};
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
  return strategy.law.empty() || strategy.own_law ||
         std::any_of(materials.begin(), materials.end(),
                     [&](const Material& material) { return material.law && material.law->law == strategy.law; });
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

namespace {

void note_lost_faces(const Body& body, const Strategy& strategy, Run& run) {
  if (!strategy.needs_faces) return;
  const auto note = [&](const std::string& name, double lost) {
    char percent[16];
    std::snprintf(percent, sizeof percent, "%.1f %%", 100 * lost);
    if (lost > 0.01)
      run.warnings.push_back(percent + (" of " + name) +
                             " hangs on faces between molecules that no connection joins, or on the surface");
  };
  if (body.parts.empty()) return note("the body", mesh::lost_share(body, *body.voronoi));
  for (const Part& part : body.parts)
    if (part.voronoi) note("body '" + part.name + "'", mesh::lost_share(part_alone(body, part).body, *part.voronoi));
}

void count_modes(const Specimen& specimen, const Model& model, const Experiment& experiment, const RunOptions& options,
                 Run& run) {
  std::vector<char> stiff;
  if (run.constants.size() > 0) {
    stiff.resize(static_cast<std::size_t>(run.constants.size()));
    for (Eigen::Index c = 0; c < run.constants.size(); ++c) stiff[c] = run.constants[c] != 0;
  }
  ModeReport report = find_modes_in_parts(model.body(), model.supports, stiff);
  if (report.out_of_plane > 0 && stays_in_plane(specimen, experiment, options.time ? options.time->duration : 0))
    report.zero_energy_modes -= std::exchange(report.out_of_plane, 0);
  run.zero_energy_modes = report.zero_energy_modes;
  if (report.zero_energy_modes > 0)
    run.warnings.push_back(warning_of_modes(report) + (options.statics.static_method == StaticMethod::newton
                                                           ? "; the load is solved in the range of the stiffness"
                                                           : "; counted without the load"));
}

/// The choice as it works on the specimen's body.
StrategyChoice on_body(StrategyChoice choice, const Specimen& specimen) {
  choice.strategy = in_parts(choice.strategy, specimen.body, specimen.materials, specimen.laws.get());
  return choice;
}

bool has_curve(const Specimen& specimen) {
  return specimen.material.curve || std::any_of(specimen.materials.begin(), specimen.materials.end(),
                                                [](const Material& material) { return material.curve.has_value(); });
}

/// Whether some molecule's place has another Poisson's ratio than the material.
bool ratio_varies(const Specimen& specimen) {
  const Material& material = specimen.material;
  for (int a = 0; material.field && a < specimen.body.size(); ++a)
    if (local_material(material, specimen.body.rest.col(a)).poissons_ratio != material.poissons_ratio) return true;
  return false;
}

/// Why one factor on all springs has no meaning here, or "".
std::string calibration_of_parts_unsuited(const Specimen& specimen) {
  if (specimen.body.parts.empty()) return "";
  if (specimen.materials.size() > 1) return "bodies of several materials have no one modulus to calibrate to";
  if (!specimen.body.ties.empty()) return "bodies tied where their molecules do not meet have no one modulus";
  const auto rigid = [](const Part& part) { return part.rigid; };
  if (std::any_of(specimen.body.parts.begin(), specimen.body.parts.end(), rigid)) return "bone has no modulus";
  return specimen.material.fibre ? "several bodies with fibres have no one modulus to calibrate to" : "";
}

/// Springs that are not calibrated, each part with its own; run.constants are for what is said of them.
std::optional<ElasticTerms> make_by_parts(const Specimen& specimen, const StrategyChoice& choice, Run& run) {
  if (choice.strategy.constants)
    run.constants = choice.strategy.constants(specimen.body, specimen.material, choice.values);
  if (!any_over(specimen.body, !run.constants.allFinite()))
    return choice.strategy.make(specimen.body, specimen.material, choice.values);
  run.outcome = Outcome::diverged;
  run.cause = "a spring constant is not finite";
  return std::nullopt;
}

void note_identified(const Identified& found, Run& run) {
  run.measures.set("identified_modulus", found.modulus(0));
  run.measures.set("identified_modulus_middle", found.modulus(found.up_to / 2));
  run.measures.set("identified_modulus_end", found.modulus(found.up_to));
  run.measures.set("identified_misfit", found.misfit);
}

}  // namespace

std::optional<Identification> identification_of(const Experiment& experiment) {
  return experiment.at_rest() ? experiment.at_rest()->identification() : std::nullopt;
}

std::vector<Material> materials_of(const Specimen& specimen) {
  return specimen.materials.empty() ? std::vector{specimen.material} : specimen.materials;
}

std::vector<StrategyChoice> all_strategies(const Catalog& catalog, const Specimen& specimen) {
  return all_strategies(catalog, specimen.body, materials_of(specimen));
}

StrategyChoice without_locking(const Catalog& catalog, StrategyChoice choice, const Specimen& specimen) {
  if (!may_lock(specimen.body, materials_of(specimen), choice.strategy)) return choice;
  return applicable_with_volume(catalog, choice, specimen.body, materials_of(specimen)).value_or(choice);
}

bool needs_cells(const Strategy& strategy, const Body& body) {
  if (body.triangles.empty() && body.tetrahedra.empty()) return false;
  const Body bare = without_cells(body);
  if (!strategy.by_parts && strategy.volume_modulus && !unsuited_for_volumes(bare).empty()) return true;
  return !strategy.unsuited(bare).empty() && !strategy.needs_voronoi(bare);
}

std::string unsuited(const Specimen& specimen, const Experiment& experiment, const StrategyChoice& any) {
  const StrategyChoice choice = on_body(any, specimen);
  std::string reason = choice.strategy.unsuited(specimen.body);
  if (reason.empty() && choice.name.calibrated) reason = calibration_of_parts_unsuited(specimen);
  if (reason.empty() && !choice.strategy.by_parts)
    reason = material_unsuited(choice.strategy, specimen.body, specimen.material);
  if (reason.empty() && choice.name.calibrated) reason = calibration_unsuited(experiment, specimen);
  if (reason.empty() && identification_of(experiment)) reason = identification_unsuited(choice);
  return reason;
}

namespace {

/// Springs of a rule that is calibrated as the scene says, and then relaxes or softens.
std::optional<ElasticTerms> make_calibrated_with_history(const Specimen& specimen, const Experiment& experiment,
                                                         const StrategyChoice& choice, const RunOptions& options,
                                                         Run& run) {
  StrategyChoice plain = choice;
  plain.strategy = *choice.rule;
  const Material& material = specimen.material;
  auto terms = make_rule(specimen, experiment, on_body(std::move(plain), specimen), options, run);
  if (terms && choice.name.softened) terms = make_mullins(std::move(*terms), *material.softening);
  if (terms && choice.name.relaxed) terms = make_prony(specimen.body, std::move(*terms), *material.relaxation);
  return terms;
}

}  // namespace

std::optional<ElasticTerms> make_elasticity(const Specimen& specimen, const Experiment& experiment,
                                            const StrategyChoice& any, const RunOptions& options, Run& run) {
  const StrategyChoice choice = on_body(any, specimen);
  auto elasticity = choice.rule ? make_calibrated_with_history(specimen, experiment, choice, options, run)
                    : choice.strategy.by_parts && !choice.name.calibrated ? make_by_parts(specimen, choice, run)
                    : choice.strategy.constants ? make_rule(specimen, experiment, choice, options, run)
                                                : choice.strategy.make(specimen.body, specimen.material, choice.values);
  if (!elasticity) return std::nullopt;
  if (std::string negative = warning_of_negative(specimen.body, run.constants); !negative.empty())
    run.warnings.push_back(std::move(negative));
  if (has_curve(specimen) && !specimen.material.law && !choice.strategy.follows_curve)
    run.warnings.push_back("does not follow the material's curve: it takes its slope at no strain alone");
  if (choice.strategy.kind != StrategyKind::cell_law && ratio_varies(specimen))
    run.warnings.push_back(
        "has the material's own Poisson's ratio everywhere: one by label or place is for laws of cells");
  return elasticity;
}

std::unique_ptr<Rig> add_surroundings(Model& model, const Specimen& specimen, const Experiment& experiment,
                                      const StrategyChoice& any) {
  const StrategyChoice choice = on_body(any, specimen);
  add_companions(model, choice.strategy, specimen.material);
  for (const SpecimenLoad& load : specimen.loads) load.add(model);
  if (specimen.contact) model.add(contact::make_contact(specimen.body, *specimen.contact));
  auto rig = experiment.rig(model);
  fix_rigid_parts(model);
  return rig;
}

std::optional<HeldModel> make_model(const Specimen& specimen, const Experiment& experiment,
                                    const StrategyChoice& choice, const RunOptions& options, Run& run) {
  if (specimen.given != GivenShape::at_rest) {
    run.cause = "its `rest` is to be found first, which `run` and `compare` do";
    run.suited = false;
    return std::nullopt;
  }
  auto elasticity = make_elasticity(specimen, experiment, choice, options, run);
  if (!elasticity) return std::nullopt;
  HeldModel held{std::make_unique<Model>(specimen.body), nullptr};
  if (options.keep_snapshots) held.model->keep_all_elements();
  if (specimen.body.share && experiment.in_time())
    held.model->complete_rows(options.statics.engine->spreading(specimen.body));
  held.model->add(std::move(*elasticity));
  try {
    held.rig = add_surroundings(*held.model, specimen, experiment, choice);
  } catch (const UnsuitedError& error) {
    run.cause = error.what();
    run.suited = false;
    return std::nullopt;
  }
  return held;
}

void prepare(Specimen& specimen, const Strategy& strategy) {
  elastin::prepare(specimen.body, strategy, materials_of(specimen), mesh::voronoi_cells);
}

namespace {

/// Of the body's size: how far from its given shape the loads may bring the unloaded one.
constexpr double kUnloadingError = 1e-6;
/// Of the prestrain: a run that keeps less warns.
constexpr double kMostLost = 0.5;

constexpr const char* kInPlaceInstead = "; `prestrain_in_place` keeps a shape by lengths that need not fit together";

/// A model of a specimen with another rest shape.
struct Reshaped {
  Specimen specimen;
  std::optional<HeldModel> held;
};

/// The run of a specimen whose rest is found first: the shape without loads, or the rest that keeps it in its shape.
Run run_found(const Specimen& specimen, const StaticExperiment& experiment, const StrategyChoice& choice,
              const RunOptions& options) {
  Run run;
  run.strategy = choice.label;
  const bool in_place = specimen.given == GivenShape::in_place;
  const std::string what = in_place ? "prestrain in place: " : "unloading: ";
  const Positions& wanted = specimen.body.rest;
  double factor = 0;  // of the experiment's load
  std::shared_ptr<Reshaped> last;
  const auto make = [&](const Body& body) -> std::shared_ptr<Model> {
    last = std::make_shared<Reshaped>(Reshaped{specimen, {}});
    last->specimen.body = body, last->specimen.given = GivenShape::at_rest;
    last->held = make_model(last->specimen, experiment, choice, options, run);
    if (!last->held) throw InputError(run.cause);
    set_load(*last->held->model, *last->held->rig->at_rest(), factor);
    return {last, last->held->model.get()};
  };
  const auto fail = [&](Outcome outcome, const std::string& cause) {
    run.outcome = outcome, run.cause = what + cause;
    return run;
  };
  const auto say = [&](int step, double error) {
    if (options.progress) options.progress(what + "step " + std::to_string(step) + ", " + number(error, 2) + " m off");
  };
  const auto loaded = [&] { return !make(specimen.body)->load_forces(state_at_rest(specimen.body)).isZero(0); };
  if (!loaded()) {
    factor = 1;
    if (!loaded()) factor = 0;
    if (factor == 0 && !in_place) return fail(Outcome::diverged, "no load acts on the given shape");
  }
  if (in_place) {
    const KeptShape kept = keep_in_place(specimen.body, make, options.statics, say);
    if (kept.outcome != Outcome::converged) return fail(kept.outcome, kept.cause);
    make(kept.body);
    run = run_strategy(last->specimen, experiment, choice, options);
    run.found = std::make_shared<const Body>(kept.body);
    run.measures.set("prestrain_error", kept.error);
    run.measures.set("prestrain_remaining", kept.remaining);
    run.measures.set("prestrain_steps", kept.steps + 1);
    if (kept.remaining < kMostLost)
      run.warnings.push_back("in the given shape " + number(100 * kept.remaining, 2) +
                             " % of the prestrain remain: no support and no load bears the rest of it");
    return run;
  }
  const UnloadedShape found = find_unloaded(specimen.body, make, options.statics, say);
  if (found.outcome != Outcome::converged)
    return fail(found.outcome, found.cause + (found.outcome == Outcome::interrupted ? "" : kInPlaceInstead));
  Model& model = *make(with_rest_shape(specimen.body, found.rest));
  State state = state_at_rest(model.body());
  StaticResult back;
  if (factor == 0) {
    back = solve_static(model, state, options.statics);
  } else {
    LoadPath path(model, *last->held->rig->at_rest(), options.statics, state);
    back = path.advance(1);
    state = path.state();
  }
  const double error = (state.positions - wanted).colwise().norm().maxCoeff(),
               size = (wanted.rowwise().maxCoeff() - wanted.rowwise().minCoeff()).norm();
  if (back.outcome != Outcome::converged)
    return fail(back.outcome, "the loads do not bring the unloaded shape back to the given one: " + back.cause);
  if (!(error <= kUnloadingError * size))
    return fail(Outcome::diverged, "the loads bring the unloaded shape to another equilibrium than the given one, " +
                                       number(error, 3) + " m from it: it buckles or snaps, and is not unique");
  Specimen unloaded = last->specimen;
  if (factor == 0)
    unloaded.start = [wanted, start = specimen.start](State& own) {
      own.positions = wanted;
      if (start) start(own);
    };
  run = run_strategy(unloaded, experiment, choice, options);
  run.found = std::make_shared<const Body>(unloaded.body);
  run.measures.set("unloaded_displacement", (wanted - found.rest).colwise().norm().maxCoeff());
  run.measures.set("unloading_error", error);
  run.measures.set("unloading_steps", found.steps);
  run.linear_iterations += found.steps;
  return run;
}

void make_run(const Specimen& specimen, const Experiment& experiment, const StrategyChoice& any,
              const RunOptions& given, Run& run) {
  const Stopwatch build;
  RunOptions options = given;
  if (experiment.at_rest()) options.statics.stop = options.stop;
  const StrategyChoice choice = on_body(any, specimen);
  if (lacks_voronoi(specimen.body, any.strategy, materials_of(specimen))) {
    Specimen prepared = specimen;
    prepare(prepared, any.strategy);
    const double seconds = build.seconds();
    make_run(prepared, experiment, any, given, run);
    run.build_seconds += seconds;
    return;
  }
  if (specimen.given != GivenShape::at_rest && experiment.at_rest() && unsuited(specimen, experiment, choice).empty()) {
    const auto derivatives = std::exchange(options.derivatives, nullptr);
    if (derivatives) derivatives->check(specimen, experiment, choice, options);
    run = run_found(specimen, *experiment.at_rest(), any, options);
    if (derivatives && run.outcome == Outcome::converged) derivatives->of_whole_runs(options, run);
    return;
  }
  run.strategy = choice.label;
  run.relaxes = choice.name.relaxed, run.wrinkles = choice.name.wrinkling;
  run.order = choice.order;
  if (options.progress) options.progress("building");
  run.cause = first_over(specimen.body, unsuited(specimen, experiment, choice));
  if (!run.cause.empty()) {
    run.suited = false;
    return;
  }
  if (options.derivatives) options.derivatives->check(specimen, experiment, choice, options);
  note_lost_faces(specimen.body, choice.strategy, run);
  if (std::string found = warning_of_locking(specimen.body, materials_of(specimen), any.strategy); !found.empty())
    run.warnings.push_back(std::move(found));
  run.uses_cells = any_over(specimen.body, needs_cells(choice.strategy, specimen.body));
  if (run.uses_cells) {
    std::string flat;
    if (const auto cells = flat_or_inverted_cells(specimen.body, specimen.body.rest); !cells.empty())
      flat = flat_or_inverted_text(cells, solid_cells(specimen.body)) + " at rest";
    else if (const auto triangles = flat_triangles(specimen.body, specimen.body.rest); !triangles.empty())
      flat = flat_or_inverted_text(triangles, specimen.body.triangles.size()) + " at rest";
    flat = first_over(specimen.body, flat);
    if (!flat.empty()) {
      run.outcome = Outcome::inverted;
      run.cause = flat;
      return;
    }
  }
  std::optional<Specimen> found;  // with the material identified
  if (const auto wanted = identification_of(experiment)) {
    found = specimen;
    if (!identify_material(*wanted, *found, *experiment.at_rest(), choice, options, run)) return;
  }
  const Specimen& at_work = found ? *found : specimen;
  const std::optional<HeldModel> held = make_model(at_work, experiment, choice, options, run);
  if (!held) return;
  Model& model = *held->model;
  if (options.statics.engine) {
    run.cause = options.statics.engine->unsuited(model);
    run.suited = run.cause.empty();
    if (!run.suited) return;
  }
  for (std::string& finding : findings_at_start(at_work, model, run.uses_cells))
    run.warnings.push_back(std::move(finding));
  run.build_seconds = build.seconds();
  const auto& share = specimen.body.share;
  const bool whole = !share || share->processes->count() == 1;
  if (whole && !experiment.stiffened_by_load() && !(specimen.material.bending_rigidity > 0))
    count_modes(at_work, model, experiment, options, run);

  std::shared_ptr<Derivatives> of_whole_runs;
  if (options.derivatives && Derivatives::by_whole_runs(experiment, *held->rig, choice, model, options))
    of_whole_runs = std::exchange(options.derivatives, nullptr);
  const Stopwatch solve;
  if (TimedRig* timed = held->rig->in_time())
    run_in_time(model, *experiment.in_time(), *timed, specimen, options, run);
  else
    solve_load_curve(model, *experiment.at_rest(), *held->rig->at_rest(), at_work.material, options, run,
                     specimen.start);
  run.solve_seconds = solve.seconds();
  if (of_whole_runs && run.outcome == Outcome::converged) of_whole_runs->of_whole_runs(options, run);
  measure_law(at_work, experiment, choice, options, run);
  for (std::string& finding : findings_at_end(specimen, experiment.measures(), model, run))
    run.warnings.push_back(std::move(finding));
  run.end.resize(3, 0);
  if (run.identified) note_identified(*run.identified, run);
}

}  // namespace

Run run_strategy(const Specimen& specimen, const Experiment& experiment, const StrategyChoice& choice,
                 const RunOptions& given) {
  // What was stopped is left out, counts as 0, or ends as an error: whatever asked, the run is not complete.
  bool stopped = false;
  RunOptions options = given;
  if (given.stop) options.stop = [&] { return stopped = stopped || given.stop(); };
  Run run;
  run.strategy = choice.label;
  try {
    make_run(specimen, experiment, choice, options, run);
  } catch (const InputError&) {
    if (!stopped) throw;
  }
  if (any_over(specimen.body, stopped) && run.outcome != Outcome::interrupted) interrupt(run);
  return run;
}

}  // namespace elastin::lab
