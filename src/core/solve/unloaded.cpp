#include "elastin/core/solve/unloaded.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/solve/mixing.h"
#include "core/solve/rest_samples.h"
#include "elastin/core/base/text.h"

namespace elastin {
namespace {

constexpr int kMostUnloadings = 200, kMixed = 20;
/// Of the body's size: how far from its given shape the loads may bring it.
constexpr double kNear = 1e-10;
/// A step that leads further away than this many times as far, to no equilibrium or to a flat cell is halved.
constexpr double kMostGrowth = 2;
constexpr int kMostHalvings = 12;

/// Where the loads would bring a body that rests in its given shape, to first order.
Positions first_motion(Model& model, const State& given, const StaticOptions& options) {
  const Positions forces = model.load_forces(given) + model.elastic_forces(given.positions);
  StaticOptions rough = options;
  rough.tolerance = 1e-3;
  return static_response(model, given.positions, forces, Positions::Zero(3, forces.cols()), rough).motion;
}

}  // namespace

KeptShape keep_in_place(const Body& given, const std::function<std::shared_ptr<Model>(const Body&)>& make,
                        const StaticOptions& options, const std::function<void(int, double)>& say) {
  KeptShape kept{given, {}, {}, 0, 0, 0};
  const double size = (given.rest.rowwise().maxCoeff() - given.rest.rowwise().minCoeff()).norm();
  const SampledRest first = sampled_rest(given, given.rest, 1);
  const auto set_rest = [&](SampledRest rest) {
    kept.body.unstressed = std::make_shared<const Rest>(rest_of(given, std::move(rest)));
  };
  set_rest(first);
  for (double last = std::numeric_limits<double>::infinity(); kept.steps < kMostUnloadings; ++kept.steps) {
    const std::shared_ptr<Model> model = make(kept.body);
    State state = state_at_rest(given);
    const StaticResult solved = solve_static(*model, state, options);
    kept.error = (state.positions - given.rest).colwise().norm().maxCoeff();
    if (solved.outcome != Outcome::converged) {
      kept.outcome = solved.outcome, kept.cause = solved.cause;
      return kept;
    }
    if (say) say(kept.steps + 1, kept.error);
    if (kept.error <= kNear * size) break;
    if (kept.error > kMostGrowth * last) {
      kept.outcome = Outcome::diverged;
      kept.cause = "the shape moves further with each change of the rest: it buckles, or the prestrain is too large";
      return kept;
    }
    if (const auto cells = flat_or_inverted_cells(given, state.positions);
        !cells.empty()) {  // springs do not guard them
      kept.outcome = Outcome::inverted;
      kept.cause = flat_or_inverted_text(cells, solid_cells(given)) + " where the prestrain leads";
      return kept;
    }
    last = kept.error;
    set_rest(sampled_rest(kept.body, state.positions, 1));
  }
  if (kept.steps == kMostUnloadings) {
    kept.outcome = Outcome::limit_reached;
    kept.cause = "not found within " + std::to_string(kMostUnloadings) + " steps: the shape still moves by " +
                 number(kept.error, 2) + " m";
  }
  const SampledRest found = sampled_rest(kept.body, given.rest, 1);
  double common = 0, all = 0;
  for (std::size_t c = 0; c < found.factors.size(); ++c) {
    const double length = given.connections.rest_length[c], before = 1 / first.factors[c] - 1,
                 now = 1 / found.factors[c] - 1;
    common += length * now * before, all += length * before * before;
  }
  kept.remaining = all > 0 ? common / all : 1;
  return kept;
}

Body with_rest_shape(Body body, const Positions& rest) {
  for (int c = 0; c < body.connections.size(); ++c) {
    const auto& [a, b] = body.connections.ends[c];
    const double before = (body.rest.col(b) - body.rest.col(a)).norm();
    if (before > 0) body.connections.rest_length[c] *= (rest.col(b) - rest.col(a)).norm() / before;
  }
  body.rest = rest;
  return body;
}

UnloadedShape find_unloaded(const Body& given, const std::function<std::shared_ptr<Model>(const Body&)>& make,
                            const StaticOptions& options, const std::function<void(int, double)>& say) {
  UnloadedShape found;
  const double size = (given.rest.rowwise().maxCoeff() - given.rest.rowwise().minCoeff()).norm();
  found.rest = given.rest;
  std::shared_ptr<Model> model;
  Mixing mixing(kMixed);
  mixing.begin(given.size());
  Positions motion = Positions::Zero(3, given.size());
  double last = std::numeric_limits<double>::infinity();
  for (int halvings = 0; found.steps < kMostUnloadings; ++found.steps) {
    if (model)
      for (const Support& support : model->supports)
        motion.col(support.molecule) = (support.free * motion.col(support.molecule)).eval();
    const Body body = with_rest_shape(given, found.rest + motion);
    StaticResult solved;
    if (flat_or_inverted_cells(body, body.rest).empty()) {
      model = make(body);
      State state = state_at_rest(body);
      state.positions = given.rest;
      solved = solve_static(*model, state, options);
      found.error = (state.positions - given.rest).colwise().norm().maxCoeff();
      if (solved.outcome == Outcome::converged && found.error <= kMostGrowth * last) {
        found.rest = body.rest;
        last = found.error;
        if (say) say(found.steps + 1, found.error);
        if (found.error <= kNear * size) return found;
        motion = given.rest - state.positions;
        mixing.mix(found.rest, motion);
        halvings = 0;
        continue;
      }
    } else {
      solved.outcome = Outcome::inverted, solved.cause = "any further step would invert a cell of the unloaded shape";
    }
    if (solved.outcome == Outcome::interrupted || ++halvings > kMostHalvings) {
      found.outcome = solved.outcome == Outcome::converged ? Outcome::diverged : solved.outcome;
      found.cause = solved.cause.empty() ? "no step leads nearer to the given shape" : solved.cause;
      return found;
    }
    if (std::isinf(last) && halvings == 1)  // the loads are too large for the given shape without stress
      motion = -first_motion(*make(given), state_at_rest(given), options);
    else
      motion /= 2;
    mixing.begin(given.size());
  }
  found.outcome = Outcome::limit_reached;
  found.cause = "not found within " + std::to_string(kMostUnloadings) + " steps: the loads lead " +
                number(found.error, 2) + " m past the given shape";
  return found;
}

}  // namespace elastin
