#include "elastin/core/solve/unloaded.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/forces/unstressed_lengths.h"
#include "core/solve/mixing.h"
#include "elastin/core/base/text.h"

namespace elastin {
namespace {

constexpr int kMostUnloadings = 100, kMixed = 10;
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

/// The points at which laws of cells see F_g: the middles of simplices, and the points of the cells of blocks. With
/// F_g = `growth` of the given shape F⁻¹, F from there to `positions`; of sheets with the normal onto the normal.
std::vector<RestPoint> points_of(const Body& body, const Positions& positions,
                                 const std::function<Matrix3(const Vector3& place, const Vector3& middle)>& growth) {
  std::vector<RestPoint> points;
  const auto add = [&](const Vector3& place, const Vector3& middle, const Eigen::MatrixXd& before,
                       const Eigen::MatrixXd& now) {
    const auto whole = [](const Eigen::MatrixXd& edges) {
      Matrix3 all;
      all.leftCols(edges.cols()) = edges;
      if (edges.cols() == 2) all.col(2) = all.col(0).cross(all.col(1)).normalized();
      return all;
    };
    points.push_back({place, middle, growth(place, middle) * whole(before) * whole(now).inverse()});
  };
  const auto add_simplex = [&](const auto& cell) {
    const Eigen::MatrixXd before = body.rest(Eigen::all, cell), now = positions(Eigen::all, cell);
    const Eigen::Index edges = before.cols() - 1;
    const Vector3 middle = before.rowwise().mean();
    add(middle, middle, before.rightCols(edges).colwise() - before.col(0), now.rightCols(edges).colwise() - now.col(0));
  };
  for (const auto& cell : body.tetrahedra) add_simplex(cell);
  for (const auto& cell : body.triangles) add_simplex(cell);
  for (const CellBlock& block : body.blocks)
    for (int cell = 0; cell < block.size(); ++cell) {
      const std::vector<int> nodes(block.cell(cell).begin(), block.cell(cell).end());
      const Eigen::MatrixXd before = body.rest(Eigen::all, nodes), now = positions(Eigen::all, nodes);
      for (std::size_t g = 0; g < block.kind->slopes.size(); ++g) {
        const Eigen::MatrixXd slopes = block.kind->slopes[g].transpose();
        add(before * block.kind->values.col(static_cast<Eigen::Index>(g)), before.rowwise().mean(), before * slopes,
            now * slopes);
      }
    }
  return points;
}

}  // namespace

KeptShape keep_in_place(const Body& given, const std::function<std::shared_ptr<Model>(const Body&)>& make,
                        const StaticOptions& options, const std::function<void(int, double)>& say) {
  KeptShape kept{given, {}, {}, 0, 0, 0};
  const double size = (given.rest.rowwise().maxCoeff() - given.rest.rowwise().minCoeff()).norm();
  const UnstressedLengths first(given);
  std::vector<std::array<Vector3, 2>> ends;
  std::vector<double> lengths, factors;  // at rest [m]; unstressed over these
  for (int c = 0; c < given.connections.size(); ++c) {
    const auto& [a, b] = given.connections.ends[c];
    ends.push_back({given.rest.col(a), given.rest.col(b)});
    lengths.push_back((ends.back()[1] - ends.back()[0]).norm());
    factors.push_back(first[c] / given.connections.rest_length[c]);
  }
  const auto set_rest = [&](const Positions& positions) {
    Rest rest = rest_at(points_of(given, positions,
                                  [own = kept.body.unstressed](const Vector3& place, const Vector3& middle) {
                                    return own->at(place, middle, 1);
                                  }),
                        ends, factors);
    rest.part = [](double) { return 1; };
    kept.body.unstressed = std::make_shared<const Rest>(std::move(rest));
  };
  set_rest(given.rest);
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
    last = kept.error;
    for (std::size_t c = 0; c < factors.size(); ++c) {
      const auto& [a, b] = given.connections.ends[c];
      if (lengths[c] > 0) factors[c] *= lengths[c] / (state.positions.col(b) - state.positions.col(a)).norm();
    }
    set_rest(state.positions);
  }
  if (kept.steps == kMostUnloadings) {
    kept.outcome = Outcome::limit_reached;
    kept.cause = "not found within " + std::to_string(kMostUnloadings) + " steps: the shape still moves by " +
                 number(kept.error, 2) + " m";
  }
  const UnstressedLengths found(kept.body);
  double common = 0, all = 0;
  for (int c = 0; c < given.connections.size(); ++c) {
    const double before = lengths[c] / first[c] - 1, now = lengths[c] / found[c] - 1;
    common += lengths[c] * now * before, all += lengths[c] * before * before;
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
