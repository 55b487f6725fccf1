#include "elastin/core/solve/unloaded.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/solve/mixing.h"
#include "core/solve/newton.h"
#include "elastin/core/base/text.h"
#include "elastin/core/forces/tangent.h"

namespace elastin {
namespace {

constexpr int kMostUnloadings = 200, kMixed = 10;
/// A step that makes the force grow by more than this is halved, as is one that inverts a cell.
constexpr double kMostGrowth = 2;
constexpr int kMostHalvings = 12;

/// The unbalanced force of the given shape, and its size over that of loads and reactions.
struct Imbalance {
  Positions forces;
  double norm, scale;
};

Imbalance imbalance_of(const Model& model, const State& at) {
  const Positions loads = model.load_forces(at);
  Imbalance found{loads + model.elastic_forces(at.positions), 0, 0};
  found.scale = ordered_norm(loads) + fixed_components(model.supports, found.forces).norm() + model.rest_force();
  keep_free(model.supports, found.forces);
  found.norm = ordered_norm(found.forces);
  return found;
}

}  // namespace

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
  found.rest = given.rest;
  const State at = state_at_rest(given);
  Mixing mixing(kMixed);
  mixing.begin(given.size());
  Positions motion = Positions::Zero(3, given.size());
  double last = std::numeric_limits<double>::infinity();
  int halvings = 0;
  for (; found.steps <= kMostUnloadings; ++found.steps) {
    if (options.stop && options.stop()) {
      found.outcome = Outcome::interrupted, found.cause = "stopped";
      return found;
    }
    const Body body = with_rest_shape(given, found.rest);
    const bool flat = !flat_or_inverted_cells(body, body.rest).empty();
    const std::shared_ptr<Model> model = flat ? nullptr : make(body);
    const Imbalance now = flat ? Imbalance{{}, INFINITY, 0} : imbalance_of(*model, at);
    if (!(now.norm <= kMostGrowth * last) || !std::isfinite(now.norm)) {
      if (++halvings > kMostHalvings) {
        found.outcome = flat ? Outcome::inverted : Outcome::diverged;
        found.cause = flat ? "any further step would invert a cell of the unloaded shape"
                           : "no step lowers the unbalanced force of the given shape";
        return found;
      }
      motion /= 2;
      found.rest -= motion;
      mixing.begin(given.size());
      continue;
    }
    halvings = 0;
    last = now.norm;
    found.residual = now.scale > 0 ? now.norm / now.scale : 0;
    if (say) say(found.steps, found.residual);
    if (found.residual <= options.tolerance || now.norm <= 4 * rounding_floor(Tangent(*model, at), at.positions))
      return found;
    StaticOptions rough = options;
    rough.tolerance = 1e-3;
    const StaticResponse response =
        static_response(*model, at.positions, -now.forces, Positions::Zero(3, given.size()), rough);
    if (!response.motion.allFinite() || response.result.outcome == Outcome::mechanism) {
      found.outcome = Outcome::mechanism;
      found.cause = response.result.cause;
      return found;
    }
    motion = response.motion;
    mixing.mix(found.rest, motion);
    for (const Support& support : model->supports)
      motion.col(support.molecule) = (support.free * motion.col(support.molecule)).eval();
    found.rest += motion;
  }
  found.outcome = Outcome::limit_reached;
  found.cause = "not found within " + std::to_string(kMostUnloadings) + " steps: the given shape leaves " +
                number(found.residual, 2) + " of its loads unbalanced";
  return found;
}

}  // namespace elastin
