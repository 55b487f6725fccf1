#include "core/solve/unloaded.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/solve/mixing.h"
#include "core/solve/responses.h"
#include "core/solve/rest_samples.h"
#include "elastin/core/base/stop.h"
#include "elastin/core/base/text.h"

namespace elastin {
namespace {

constexpr int kMostKeepings = 200, kMixed = 20;
/// Steps of mixing before Newton's method, its own, and the directions of each, of which this many numbers are kept.
constexpr int kMostMixings = 60, kMostNewtons = 15, kMostDirections = 200;
constexpr int kMostTrials = 1500;  ///< rest shapes of which Newton's method looks at the forces, in all
constexpr Eigen::Index kMostNumbers = 50'000'000;
/// Parts of the loads, from where Newton's method found nothing under all of them.
constexpr double kLeastFraction = 1.0 / 64;  ///< of a step
constexpr double kFirstPart = 0.25, kLeastPart = 1.0 / 64;
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

using MakeModel = std::function<std::shared_ptr<Model>(const Body&)>;

/// x of A x = b, by generalised conjugate residuals; empty where A has no value.      [Eisenstat, Elman & Schultz 1983]
template <class Apply>
Positions solved_by_residuals(const Apply& apply, const Positions& b) {
  struct Direction {
    Positions x, image;
  };
  std::vector<Direction> all;
  Positions x = Positions::Zero(3, b.cols()), left = b;
  const auto most =
      static_cast<std::size_t>(std::min<Eigen::Index>({kMostDirections, b.size(), 2 + kMostNumbers / b.size()}));
  while (all.size() < most && ordered_norm(left) > 1e-4 * ordered_norm(b)) {
    Direction next{left, apply(left)};
    if (next.image.size() == 0 || !next.image.allFinite()) return {};
    for (int twice = 0; twice < 2; ++twice)
      for (const Direction& other : all) {
        const double part = ordered_dot(other.image, next.image);
        next.x -= part * other.x, next.image -= part * other.image;
      }
    const double length = ordered_norm(next.image);
    if (!(length > 0)) break;
    next.x /= length, next.image /= length;
    const double part = ordered_dot(next.image, left);
    x += part * next.x, left -= part * next.image;
    all.push_back(std::move(next));
  }
  return x;
}

/// Newton's method for the rest shape X: K⁻¹ R is to vanish, R the forces that are left in the given shape, elastic and
/// a part of the loads', K the stiffness there. How it changes with X is known by differences.
///                                                                     [Govindjee & Mihalic 1996; Knoll & Keyes 2004]
class RestByNewton {
 public:
  RestByNewton(const Body& given, const MakeModel& make, const StaticOptions& options, double size,
               const std::function<void(int, double)>& say)
      : given_(given), make_(make), options_(options), size_(size), say_(say) {}

  /// From the rest shape of `found` to the one under a part of the loads; its cause says why it does not exist.
  UnloadedShape under(double part, UnloadedShape found) const {
    const auto end = [&](Outcome outcome, const std::string& cause) {
      found.outcome = outcome, found.cause = cause;
      return found;
    };
    for (int step = 0; step < kMostNewtons && trials_ <= kMostTrials; ++step, ++found.steps) {
      const auto left = left_from(found.rest, part);
      const std::shared_ptr<Model>& model = left.first;
      const Positions& forces = left.second;
      if (!model) return end(Outcome::inverted, "a cell of the unloaded shape is flat or inverted");
      const State state = state_at_rest(given_);
      Responses responses(*model, state, options_);
      const auto motion = [&](const Positions& by) { return responses.to(by, Positions::Zero(3, by.cols()), 1e-12); };
      const StaticResponse now = motion(forces);
      if (now.result.outcome != Outcome::converged) return end(now.result.outcome, now.result.cause);
      found.error = now.motion.colwise().norm().maxCoeff();
      if (say_) say_(found.steps + 1, found.error);
      if (found.error <= kNear / 2 * size_) return end(Outcome::converged, "");
      const Positions change = solved_by_residuals(
          [&](const Positions& along) -> Positions {
            const double length = 1e-7 * size_ / along.colwise().norm().maxCoeff();
            const Positions other = left_from(found.rest + length * along, part).second;
            return other.size() > 0 ? motion((other - forces) / length).motion : Positions();
          },
          now.motion);
      double fraction = change.size() > 0 ? 1 : 0;
      for (const double size = ordered_norm(now.motion);; fraction /= 2) {
        if (stop_requested() || (options_.stop && options_.stop())) return end(Outcome::interrupted, "");
        if (fraction < kLeastFraction) return end(Outcome::diverged, "no step leads nearer to the given shape");
        const Positions other = left_from(found.rest - fraction * change, part).second;
        if (other.size() > 0 && ordered_norm(motion(other).motion) < (1 - 1e-3 * fraction) * size) break;
      }
      found.rest -= fraction * change;
    }
    return end(Outcome::limit_reached, "Newton's method does not converge");
  }

 private:
  /// A model on a rest shape, and the forces that are left in the given one; nothing where a cell is flat or inverted.
  std::pair<std::shared_ptr<Model>, Positions> left_from(const Positions& rest, double part) const {
    ++trials_;
    const Body body = with_rest_shape(given_, rest);
    if (!flat_or_inverted_cells(body, rest).empty()) return {};
    std::shared_ptr<Model> model = make_(body);
    State state = state_at_rest(given_);
    model->declare_history(state);
    model->begin_step(state, std::numeric_limits<double>::infinity());
    Positions forces = model->elastic_forces(state.positions) + part * model->load_forces(state);
    keep_free(model->supports, forces);
    return {std::move(model), std::move(forces)};
  }

  const Body& given_;
  const MakeModel& make_;
  const StaticOptions& options_;
  double size_;
  const std::function<void(int, double)>& say_;
  mutable int trials_ = 0;
};

/// Where mixing found none: Newton's method, under all loads and then under ever more of them from the given shape.
UnloadedShape found_by_newton(const Body& given, const RestByNewton& newton, const UnloadedShape& mixed) {
  UnloadedShape found = newton.under(1, mixed), last = found;
  const auto ends = [&] { return found.outcome == Outcome::converged || found.outcome == Outcome::interrupted; };
  last.rest = given.rest;
  double part = 0;
  for (double step = kFirstPart; step >= kLeastPart && !ends();) {
    const double next = std::min(1.0, part + step);
    UnloadedShape more = newton.under(next, last);
    const bool done = more.outcome == Outcome::converged;
    if (next == 1 || more.outcome == Outcome::interrupted) found = more;
    last.steps = more.steps;
    if (done) part = next, last = std::move(more);
    step *= done ? 1.5 : 0.5;
  }
  if (ends()) return found;
  found = mixed;
  found.steps = last.steps;
  if (part == 0) return found;
  found.outcome = Outcome::diverged;
  found.cause = "an unloaded shape is found under " + number(100 * part, 2) +
                " % of the loads, and none close to it under more: it does not exist or is not unique";
  return found;
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
  for (double last = std::numeric_limits<double>::infinity(); kept.steps < kMostKeepings; ++kept.steps) {
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
  if (kept.steps == kMostKeepings) {
    kept.outcome = Outcome::limit_reached;
    kept.cause = "not found within " + std::to_string(kMostKeepings) + " steps: the shape still moves by " +
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

UnloadedShape find_unloaded(const Body& given, const MakeModel& make, const StaticOptions& options,
                            const std::function<void(int, double)>& say) {
  UnloadedShape found;
  const double size = (given.rest.rowwise().maxCoeff() - given.rest.rowwise().minCoeff()).norm();
  found.rest = given.rest;
  std::shared_ptr<Model> model;
  Mixing mixing(kMixed);
  mixing.begin(given.size());
  Positions motion = Positions::Zero(3, given.size());
  double last = std::numeric_limits<double>::infinity();
  for (int halvings = 0; found.steps < kMostMixings; ++found.steps) {
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
      break;
    }
    if (std::isinf(last) && halvings == 1)  // the loads are too large for the given shape without stress
      motion = -first_motion(*make(given), state_at_rest(given), options);
    else
      motion /= 2;
    mixing.begin(given.size());
  }
  if (found.outcome == Outcome::interrupted) return found;
  if (found.outcome == Outcome::converged) {
    found.outcome = Outcome::limit_reached;
    found.cause = "not found: the loads lead " + number(found.error, 2) + " m past the given shape";
  }
  return found_by_newton(given, RestByNewton(given, make, options, size, say), found);
}

}  // namespace elastin
