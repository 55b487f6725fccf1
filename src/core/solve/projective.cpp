#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "core/linear/block_inverse.h"
#include "core/linear/multigrid.h"
#include "core/linear/sparse_factor.h"
#include "core/linear/sparse_stiffness.h"
#include "core/parallel/parallel.h"
#include "core/solve/implicit.h"
#include "core/solve/steppers.h"

namespace elastin {
namespace {

/// Above this number of molecules the matrix is not factorised: a solve with the factor of 2744 takes 13.6 ms, since it
/// leaves the caches, and a cycle of multigrid on 4096 takes 0.8.
constexpr int kFactorLimit = 1000;

/// (K at rest + w_a M + w_v C)⁻¹, exactly or nearly, made once for a step length and a set of supports.
class RestInverse {
 public:
  /// Makes it again where it is another's: that of a step from rest, whatever went before, and of couplings as they
  /// are. Returns false where it is not positive. @param next of the step that is under way
  bool prepare(Model& model, const Weights& weights, const State& next) {
    std::vector<Point>& points = new_points_;
    points.clear();
    for (const auto& load : model.loads())
      load->visit_points([&](int molecule, double stiffness, double damping) {
        points.push_back({molecule, stiffness, damping});
      });
    const bool same = model_ == &model && weights_.acceleration == weights.acceleration &&
                      weights_.velocity == weights.velocity && same_supports(model.supports) && points == points_;
    if (same) return positive_;
    points_ = points;
    model_ = &model;
    weights_ = weights;
    supports_ = model.supports;
    rest_ = state_at_rest(model.body());
    model.declare_history(rest_);
    model.begin_step(rest_, 1 / weights.velocity);
    tangent_.emplace(model, rest_, weights);
    factor_.reset(), multigrid_.reset();
    if (model.body().size() <= kFactorLimit) {
      factor_.emplace(sparse_stiffness(*tangent_, supports_, 0, stiffness_scale(*tangent_)));
      positive_ = factor_->positive();
    } else {
      multigrid_.emplace(*tangent_, supports_);
      blocks_.compute(*tangent_, supports_);
      positive_ = multigrid_->positive();
    }
    model.begin_step(next, next.time);
    return positive_;
  }
  const Tangent& tangent() const { return *tangent_; }
  const char* name() const { return factor_ ? "factorised" : "multigrid"; }

  void apply(const Positions& forces, Positions& motion) {
    const auto n = forces.cols();
    if (factor_) {
      factor_->solve(Eigen::Map<const VectorX>(forces.data(), forces.size()), spare_, solution_);
      motion = Eigen::Map<const Positions>(solution_.data(), 3, n);
    } else {
      motion.resize(3, n);
      for (int i = 0; i < n; ++i) motion.col(i) = blocks_.times(i, forces.col(i));
      const double size = ordered_norm(forces);
      if (size > 0) multigrid_->add(forces, size, motion);
    }
    keep_free(supports_, motion);
  }

 private:
  struct Point {
    int molecule;
    double stiffness, damping;
    bool operator==(const Point&) const = default;
  };
  bool same_supports(const std::vector<Support>& now) const {
    return std::equal(now.begin(), now.end(), supports_.begin(), supports_.end(),
                      [](const auto& a, const auto& b) { return a.molecule == b.molecule && a.free == b.free; });
  }

  Model* model_ = nullptr;
  Weights weights_;
  std::vector<Support> supports_;
  std::vector<Point> points_, new_points_;  // so that steps allocate no memory
  State rest_;
  std::optional<Tangent> tangent_;
  std::optional<SparseFactor> factor_;
  std::optional<Multigrid> multigrid_;
  BlockInverses blocks_;
  VectorX spare_, solution_;
  bool positive_ = false;
};

/// Newton's method with one constant matrix, that of the body at rest, and its corrections from the last motions
/// (L-BFGS); with line search, so that it takes any law.            [Bouaziz et al. 2014; Liu, Bouaziz & Kavan 2017]
class Projective final : public Implicit {
 public:
  Projective(const StaticOptions& options, int memory) : Implicit(options, 0, 0), pairs_(memory) {}

 private:
  struct Pair {
    Positions motion, change;  ///< s and y: how far, and what that did to the unbalanced force
    double product = 0;        ///< s·y
  };

  StaticResult balance(Model& model, State& next, const Kinematics& kinematics) override {
    StaticResult result;
    if (!inverse_.prepare(model, kinematics.weights, next)) {
      result.outcome = Outcome::diverged;
      result.cause = "the stiffness at rest is not positive";
      return result;
    }
    for (Pair& pair : pairs_) {  // at once: later steps may use more of them
      pair.motion.resize(3, next.positions.cols());
      pair.change.resize(3, next.positions.cols());
    }
    weights_.reserve(pairs_.size());
    balance_with_multipliers(model, next, kinematics.cut_short, result,
                             [&] { descend(model, next, kinematics, result); });
    return result;
  }

  void descend(Model& model, State& next, const Kinematics& kinematics, StaticResult& result) {
    const Problem problem(model, &kinematics);
    Trial& now = workspace_.now;
    now.state = next;
    used_ = 0;
    evaluate(problem, problem.with_energy, now, workspace_.trials);
    if (!std::isfinite(now.energy)) {
      result.outcome = Outcome::inverted;
      result.cause = inverted_text(model.body(), now.state.positions) + " at the start of the step";
      return;
    }
    const double floor = rounding_floor(inverse_.tangent(), now.state.positions);
    for (int iteration = 0; true; ++iteration) {
      if (!std::isfinite(now.forces.norm + now.forces.scale)) {
        result.outcome = Outcome::diverged;
        result.cause = "the forces are too large for numbers";
        return;
      }
      result.residual = now.forces.scale > 0 ? now.forces.norm / now.forces.scale : 0;
      result.outcome = Outcome::converged;
      if (now.forces.norm <= std::max(newton_.tolerance * now.forces.scale, 2 * floor)) break;
      result.outcome = Outcome::limit_reached;
      if (iteration == newton_.newton_limit) {
        if (!kinematics.cut_short)
          result.cause = "no balance within " + std::to_string(newton_.newton_limit) + " iterations";
        break;
      }
      ++result.newton_iterations;
      if (!advance(problem, now)) {
        result.outcome = Outcome::diverged;
        result.cause = "no step lowers the unbalanced force";
        break;
      }
    }
    next = now.state;
  }

  /// One search; without what was learnt where that leads nowhere.
  bool advance(const Problem& problem, Trial& now) {
    for (const bool again : {false, true}) {
      if (again && used_ == 0) return false;
      if (again) used_ = 0;
      set_direction(now.forces.unbalanced);
      from_ = now.state.positions;
      before_ = now.forces.unbalanced;
      bool inverted = false;
      if (direction_.allFinite() &&
          line_search(problem, direction_, problem.with_energy, now, inverted, workspace_.trials)) {
        learn(now);
        return true;
      }
    }
    return false;
  }

  void learn(const Trial& now) {
    if (pairs_.empty()) return;
    Pair& pair = pairs_[static_cast<std::size_t>(used_) % pairs_.size()];
    pair.motion = now.state.positions - from_;
    pair.change = before_ - now.forces.unbalanced;
    pair.product = ordered_dot(pair.motion, pair.change);
    if (pair.product > 0) ++used_;
  }

  /// The two loops of L-BFGS about the constant matrix.                                         [Nocedal 1980]
  void set_direction(const Positions& unbalanced) {
    const int count = std::min(used_, static_cast<int>(pairs_.size()));
    const auto pair = [&](int back) -> const Pair& {  // 0 is the last
      return pairs_[static_cast<std::size_t>(used_ - 1 - back) % pairs_.size()];
    };
    weights_.resize(count);
    rest_ = unbalanced;
    for (int back = 0; back < count; ++back) {
      const double weight = ordered_dot(pair(back).motion, rest_) / pair(back).product;
      weights_[back] = weight;
      rest_ -= weight * pair(back).change;
    }
    inverse_.apply(rest_, direction_);
    for (int back = count - 1; back >= 0; --back) {
      const double weight = ordered_dot(pair(back).change, direction_) / pair(back).product;
      direction_ += (weights_[back] - weight) * pair(back).motion;
    }
  }

  RestInverse inverse_;
  std::vector<Pair> pairs_;  ///< in a ring
  int used_ = 0;
  std::vector<double> weights_;
  Positions direction_, rest_, from_, before_;
};

}  // namespace

StepperKind projective() {
  return {{"projective",
           "backward Euler's step by the constant matrix of the body at rest, factorised once",
           "[Bouaziz et al. 2014; Liu et al. 2017]",
           {{"solves", dimension::none, 0, 1000, 10,
             "most solves with the matrix in each step; 0: until the forces balance", false, ValueKind::whole},
            {"memory", dimension::none, 0, 20, 5, "last motions that correct the matrix (L-BFGS)", false,
             ValueKind::whole}}},
          false,
          1,
          [](const ParameterValues& values, const StaticOptions& newton) {
            auto projective = std::make_unique<Projective>(newton, static_cast<int>(values.at("memory")));
            projective->cut_short(static_cast<int>(values.at("solves")));
            return projective;
          },
          {},
          "solves"};
}

}  // namespace elastin
