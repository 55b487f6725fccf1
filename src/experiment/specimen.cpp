#include "experiment/specimen.h"

#include <chrono>
#include <cmath>
#include <cstdio>

#include "elastin/forces/volume.h"
#include "elastin/model/voronoi.h"
#include "elastin/solve/modes.h"
#include "experiment/calibration.h"
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

/// A model of the specimen, held by the experiment.
Model make_model(const Specimen& specimen, Experiment& experiment, std::unique_ptr<Elasticity> elasticity) {
  Model model(specimen.body);
  model.add(std::move(elasticity));
  for (const auto& make_load : specimen.loads) model.add(make_load(specimen.body));
  experiment.hold(model);
  return model;
}

/// The springs of a rule, calibrated if asked for, with their volume term if any. Null if that fails: the run says why.
/// `body` is the specimen's, with what the rule needs beside.
std::unique_ptr<Elasticity> make_rule(const Specimen& specimen, const Body& body, Experiment& experiment,
                                      const StrategyChoice& choice, const StaticOptions& options, Run& run) {
  run.constants = choice.strategy.constants(body, specimen.material, choice.values);
  if (choice.strategy.volume_modulus) run.volume_modulus = choice.strategy.volume_modulus(specimen.material);
  if (choice.calibrated) calibrate(specimen, experiment, choice, options, run);
  if (!run.constants.allFinite()) {
    run.outcome = Outcome::diverged;
    run.cause = "a spring constant is not finite: a connection of no length?";
  }
  if (!run.suited || run.outcome != Outcome::converged) return nullptr;
  return springs_of(specimen, choice, run, run.volume_modulus);
}

/// Whether the strategy needs the triangles or tetrahedra of a body that it suits.
bool needs_cells(const Strategy& strategy, const Body& body) {
  if (body.triangles.empty() && body.tetrahedra.empty()) return false;
  Body bare = body;
  bare.triangles.clear();
  bare.tetrahedra.clear();
  if (strategy.volume_modulus && !unsuited_for_volumes(bare).empty()) return true;
  return !strategy.unsuited(bare).empty() && !strategy.needs_voronoi(bare);
}

void note_negative_constants(Run& run) {
  const int negative = static_cast<int>((run.constants.array() < 0).count());
  if (negative > 0)
    run.warnings.push_back(counted(negative, "spring constant is", "spring constants are") + " negative (of " +
                           std::to_string(run.constants.size()) + "): the body may have no stable equilibrium");
}

void note_lost_faces(const Body& body, const Strategy& strategy, Run& run) {
  if (strategy.name != Voronoi::name) return;
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

/// Adds what one solve cost and said to the run; returns whether it converged.
bool note_solve(const StaticResult& solved, const std::string& where, Run& run) {
  run.solver = solved.solver;
  run.newton_iterations += solved.newton_iterations;
  run.linear_iterations += solved.linear_iterations;
  run.cut_steps += solved.cut_steps;
  run.residual = solved.residual;
  const std::string unstable = "the equilibrium is not stable: directions of negative stiffness";
  run.unstable |= solved.unstable;
  if (solved.unstable && (run.warnings.empty() || run.warnings.back() != unstable)) run.warnings.push_back(unstable);
  if (solved.outcome == Outcome::converged) return true;
  run.outcome = solved.outcome;
  run.cause = solved.cause + where;
  return false;
}

/// The body before the experiment's load: at rest, or in equilibrium with the scene's other loads. False if that fails.
bool find_start(Model& model, Experiment& experiment, const RunOptions& options, State& state, Start& start, Run& run) {
  start = {state.positions, Positions::Zero(3, static_cast<Eigen::Index>(model.supports.size()))};
  experiment.set_load(model, 0);
  if (model.load_forces(state).isZero(0)) return true;
  if (options.progress) options.progress("the scene's own loads");
  const StaticResult solved = solve_static(model, state, options.statics);
  start = {state.positions, solved.reactions};
  return note_solve(solved, " (under the scene's own loads)", run);
}

/// Where the last step's way leads if it goes on: a start near the next equilibrium, unless a cell turns over or, under
/// loads, the energy is higher than where the body stands (a bar that turns far would be torn).
State going_on(const Model& model, const State& state, const Positions& before) {
  State next = state;
  next.positions += state.positions - before;
  const double gain = model.elastic_energy(next.positions) + model.load_energy(next) -
                      model.elastic_energy(state.positions) - model.load_energy(state);
  const bool loaded = model.has_energy() && !model.load_forces(state).isZero(0);
  return std::isfinite(gain) && !(loaded && gain > 0) ? next : state;
}

/// Solves load step after load step, each started where the last two lead.
void solve_curve(Model& model, Experiment& experiment, const RunOptions& options, Run& run) {
  State state = state_at_rest(model.body());
  Start start;
  if (!find_start(model, experiment, options, state, start, run)) return;
  const auto keep = [&](double load_factor) {
    if (options.keep_snapshots)
      run.snapshots.push_back({load_factor, state.positions, model.force_densities(state.positions)});
  };
  keep(0);
  Positions before = state.positions;
  const int steps = experiment.load_steps();
  for (int step = 1; step <= steps; ++step) {
    const std::string place = steps > 1 ? "load step " + std::to_string(step) + " of " + std::to_string(steps) : "";
    if (options.progress) options.progress(place.empty() ? "solving" : place);
    const double load_factor = static_cast<double>(step) / steps;
    experiment.set_load(model, load_factor);
    State next = state;
    if (step > 1 && !options.statics.linear) next = going_on(model, state, before);
    StaticResult solved = solve_static(model, next, options.statics);
    Measures measures;
    if (solved.outcome == Outcome::converged)
      measures = experiment.measure(model, start, next, options.statics, solved);
    if (!note_solve(solved, place.empty() ? "" : " (" + place + ")", run)) return;
    if (measures.get("elongation") < 0 && measures.get("strain") <= -1) {
      run.outcome = Outcome::inverted;
      run.cause =
          "the load presses the body through itself: strain below −100 %" + (place.empty() ? "" : " (" + place + ")");
      return;
    }
    before = state.positions;
    state = next;
    run.curve.push_back({load_factor, measures, solved.newton_iterations, solved.linear_iterations, solved.residual});
    keep(load_factor);
  }
  run.measures = run.curve.back().measures;
  run.remark = experiment.remark(run.measures);
  if (steps > 1 && model.has_full_tangent()) {
    experiment.measure_end(model, state, options.statics, run.measures, run.linear_iterations);
    double sum = 0;
    for (const CurvePoint& point : run.curve) sum += point.measures.get("effective_modulus");
    run.measures.set("average_modulus", sum / steps);
  }
}

}  // namespace

StrategyChoice with_volume(StrategyChoice choice) {
  choice.strategy = with_volume(choice.strategy);
  choice.label += "+volume";
  return choice;
}

StrategyChoice choose_strategy(const Catalog& catalog, const std::string& label) {
  const std::string prefix = "calibrated:", suffix = "+volume";
  if (label.ends_with(suffix))
    return with_volume(choose_strategy(catalog, label.substr(0, label.size() - suffix.size())));
  if (label == "calibrated") return choose_strategy(catalog, prefix + "standard");
  const bool calibrated = label.starts_with(prefix);
  const Strategy& strategy = catalog.find(calibrated ? label.substr(prefix.size()) : label);
  if (!calibrated && strategy.kind == StrategyKind::wrapper)
    throw InputError("'" + label + "' goes with a rule: lattice+" + label);
  if (!calibrated) return {label, strategy, false, {}};
  StrategyChoice choice{label, strategy, true, {}};
  if (choice.strategy.kind != StrategyKind::spring_rule)
    throw InputError("'" + label + "': only a spring rule can be calibrated, and " + choice.strategy.name + " is a " +
                     name_of(choice.strategy.kind));
  return choice;
}

std::vector<StrategyChoice> all_strategies(const Catalog& catalog) {
  std::vector<StrategyChoice> choices;
  for (const Strategy& strategy : catalog.strategies())
    if (strategy.kind != StrategyKind::wrapper) choices.push_back({strategy.name, strategy, false, {}});
  for (const Strategy& strategy : catalog.strategies())
    if (strategy.kind == StrategyKind::spring_rule)
      choices.push_back(choose_strategy(catalog, "calibrated:" + strategy.name));
  return choices;
}

void prepare(Body& body, const Strategy& strategy) {
  if (!body.voronoi && strategy.needs_voronoi(body)) body.voronoi = voronoi_cells(body);
}

/// The body, or a copy with what the strategy needs of it.
static std::shared_ptr<const Body> prepared(const Body& body, const Strategy& strategy) {
  if (body.voronoi || !strategy.needs_voronoi(body)) return {std::shared_ptr<void>(), &body};
  auto copy = std::make_shared<Body>(body);
  prepare(*copy, strategy);
  return copy;
}

Run run_strategy(const Specimen& specimen, Experiment& experiment, const StrategyChoice& choice,
                 const RunOptions& options) {
  Run run;
  run.strategy = choice.label;
  if (options.progress) options.progress("building");
  const Stopwatch build;
  const std::shared_ptr<const Body> body = prepared(specimen.body, choice.strategy);
  run.cause = choice.strategy.unsuited(*body);
  if (choice.calibrated && run.cause.empty() && !calibrated_measure(experiment, specimen.material))
    run.cause = "a " + experiment.name() + " experiment on this body measures no modulus to calibrate to";
  if (!run.cause.empty()) {
    run.suited = false;
    return run;
  }
  note_lost_faces(*body, choice.strategy, run);
  run.uses_cells = needs_cells(choice.strategy, specimen.body);
  if (run.uses_cells) {
    const std::vector<int> cells = flat_or_inverted_cells(specimen.body, specimen.body.rest);
    if (!cells.empty()) {
      run.outcome = Outcome::inverted;
      run.cause = flat_or_inverted_text(cells, specimen.body.tetrahedra.size()) + " at rest";
      return run;
    }
  }
  std::unique_ptr<Elasticity> elasticity;
  if (choice.strategy.constants) {
    elasticity = make_rule(specimen, *body, experiment, choice, options.statics, run);
    if (!elasticity) return run;
    note_negative_constants(run);
  } else {
    elasticity = choice.strategy.make(specimen.body, specimen.material, choice.values);
  }
  Model model = make_model(specimen, experiment, std::move(elasticity));
  run.build_seconds = build.seconds();
  count_modes(model, run);

  const Stopwatch solve;
  solve_curve(model, experiment, options, run);
  run.solve_seconds = solve.seconds();
  return run;
}

}  // namespace elastin
