#include "experiment/specimen.h"

#include <chrono>
#include <cmath>
#include <cstdio>

#include "elastin/model/voronoi.h"
#include "elastin/solve/modes.h"
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

/// E / E measured by one linear solve of the experiment alone, without the scene's other loads.
double calibration_factor(const Specimen& specimen, Experiment& experiment, const VectorX& constants,
                          const StaticOptions& options, Run& run) {
  Model model(specimen.body);
  model.add(make_springs(specimen.body, constants));
  experiment.hold(model);
  experiment.set_load(model, 1);
  State state = state_at_rest(specimen.body);
  StaticOptions linear = options;
  linear.linear = true;
  const StaticResult solved = solve_static(model, state, linear);
  run.linear_iterations += solved.linear_iterations;
  if (solved.outcome != Outcome::converged) {
    run.outcome = solved.outcome;
    run.cause = "calibration: " + solved.cause;
    return 1;
  }
  const Start rest{specimen.body.rest, Positions::Zero(3, solved.reactions.cols())};
  const double measured = experiment.measure(model, rest, state, solved).get("effective_modulus");
  if (measured > 0) return specimen.material.youngs_modulus / measured;
  run.outcome = Outcome::diverged;
  run.cause = "calibration: the linear solve measures no positive modulus";
  return 1;
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
  run.residual = solved.residual;
  const std::string unstable = "the equilibrium is not stable: directions of negative stiffness";
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
    if (step > 1 && !options.statics.linear) {
      next.positions += state.positions - before;
      if (!std::isfinite(model.elastic_energy(next.positions))) next = state;
    }
    const StaticResult solved = solve_static(model, next, options.statics);
    if (!note_solve(solved, place.empty() ? "" : " (" + place + ")", run)) return;
    const Measures measures = experiment.measure(model, start, next, solved);
    if (measures.get("strain") <= -1) {
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
  if (steps > 1 && model.has_full_tangent()) {
    run.measures.set("tangent_modulus",
                     experiment.tangent_modulus(model, state, options.statics, run.linear_iterations));
    double sum = 0;
    for (const CurvePoint& point : run.curve) sum += point.measures.get("effective_modulus");
    run.measures.set("average_modulus", sum / steps);
  }
}

}  // namespace

StrategyChoice choose_strategy(const Catalog& catalog, const std::string& label) {
  const std::string prefix = "calibrated:";
  if (label == "calibrated") return choose_strategy(catalog, prefix + "standard");
  if (!label.starts_with(prefix)) return {label, catalog.find(label), false, {}};
  StrategyChoice choice{label, catalog.find(label.substr(prefix.size())), true, {}};
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
  if (!run.cause.empty()) {
    run.suited = false;
    return run;
  }
  note_lost_faces(*body, choice.strategy, run);
  std::unique_ptr<Elasticity> elasticity;
  if (choice.strategy.constants) {
    run.constants = choice.strategy.constants(*body, specimen.material, choice.values);
    if (choice.calibrated)
      run.constants *= calibration_factor(specimen, experiment, run.constants, options.statics, run);
    if (!run.constants.allFinite()) {
      run.outcome = Outcome::diverged;
      run.cause = "a spring constant is not finite: a connection of no length?";
    }
    if (run.outcome != Outcome::converged) return run;
    note_negative_constants(run);
    elasticity = make_springs(specimen.body, run.constants);
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
