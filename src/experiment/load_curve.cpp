#include "experiment/load_curve.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "elastin/forces/tension.h"
#include "experiment/load_path.h"

namespace elastin {
namespace {

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

/// Where the material says what stress belongs to a strain: the largest difference to it, over the largest such stress.
void note_curve_error(const Experiment& experiment, const Material& material, Run& run) {
  const auto axis = experiment.axis();
  double difference = 0, largest = 0;
  for (const CurvePoint& point : run.curve) {
    const auto given = axis ? uniaxial_stress(material, *axis, point.measures.get("strain")) : std::nullopt;
    if (!given) return;
    difference = std::max(difference, std::abs(point.measures.get("stress") - *given));
    largest = std::max(largest, std::abs(*given));
  }
  run.measures.set("curve_error", difference / largest);
}

void note_compression(const Model& model, const Positions& places, const Material& material, Run& run) {
  const Compression found = find_compression(model, places);
  const int all = static_cast<int>(model.body().triangles.size());
  if (found.triangles == 0) return;
  const auto& [a, b, c] = model.body().triangles[static_cast<std::size_t>(found.worst)];
  const Vector3 at = (places.col(a) + places.col(b) + places.col(c)) / 3;
  char text[240];
  std::snprintf(
      text, sizeof text,
      "%d of %d triangles in compression (most: triangle %d at %.4g, %.4g, %.4g m, %.3g Pa): a membrane would "
      "wrinkle there; `wrinkling: drop` leaves compression out",
      found.triangles, all, found.worst, at.x(), at.y(), at.z(), found.tension / material.thickness);
  run.warnings.push_back(text);
}

}  // namespace

void solve_load_curve(Model& model, Experiment& experiment, const Material& material, const RunOptions& options,
                      Run& run) {
  State at_start = state_at_rest(model.body());
  Start start;
  if (!find_start(model, experiment, options, at_start, start, run)) return;
  LoadPath path(model, experiment, options.statics, std::move(at_start));
  const auto keep = [&](double load_factor) {
    if (options.keep_snapshots)
      run.snapshots.push_back({load_factor, path.state().positions, model.force_densities(path.state().positions)});
  };
  keep(0);
  const int steps = experiment.load_steps();
  for (int step = 1; step <= steps; ++step) {
    const std::string place = steps > 1 ? "load step " + std::to_string(step) + " of " + std::to_string(steps) : "";
    if (options.progress) options.progress(place.empty() ? "solving" : place);
    const double load_factor = static_cast<double>(step) / steps;
    StaticResult solved = path.advance(load_factor);
    Measures measures;
    if (solved.outcome == Outcome::converged)
      measures = experiment.measure(model, start, path.state(), options.statics, solved);
    run.halved_load_steps = path.halvings();
    if (!note_solve(solved, place.empty() ? "" : " (" + place + ")", run)) return;
    if (measures.get("elongation") < 0 && measures.get("strain") <= -1) {
      run.outcome = Outcome::inverted;
      run.cause =
          "the load presses the body through itself: strain below −100 %" + (place.empty() ? "" : " (" + place + ")");
      return;
    }
    run.curve.push_back({load_factor, measures, solved.newton_iterations, solved.linear_iterations, solved.residual});
    keep(load_factor);
  }
  run.measures = run.curve.back().measures;
  run.remark = experiment.remark(run.measures);
  // What resists bending may bear compression.
  if (!model.body().triangles.empty() && !options.statics.linear && !(material.bending_rigidity > 0))
    note_compression(model, path.state().positions, material, run);
  note_curve_error(experiment, material, run);
  if (steps > 1 && model.has_full_tangent()) {
    experiment.measure_end(model, path.state(), options.statics, run.measures, run.linear_iterations);
    double sum = 0;
    for (const CurvePoint& point : run.curve) sum += point.measures.get("effective_modulus");
    run.measures.set("average_modulus", sum / steps);
  }
}

}  // namespace elastin
