#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "core/linear/block_inverse.h"
#include "core/linear/linear_choice.h"
#include "core/linear/sparse_factor.h"
#include "core/linear/sparse_stiffness.h"
#include "core/parallel/parallel.h"
#include "elastin/core/base/stop.h"
#include "elastin/core/linear/linear_solver.h"

namespace elastin {
namespace {

/// result = a + factor b
void combine(const Positions& a, double factor, const Positions& b, Positions& result) {
  parallel_for(
      static_cast<int>(a.cols()), [&](int i) { result.col(i) = a.col(i) + factor * b.col(i); }, kMoleculeThreshold);
}

/// Behind the inverse of each molecule's block, or behind a factor of the lower half of the stiffness, from which the
/// whole differs by what is not symmetric: a pressure's part, or that of a law without an energy.
class BiCgStab final : public LinearSolver, public KeepsWay {
 public:
  explicit BiCgStab(bool by_factor) : asked_(by_factor), by_factor_(by_factor) {}
  const char* name() const override { return "bicgstab"; }
  void forget() override { by_factor_ = asked_, factor_.reset(); }

  LinearResult solve(const Tangent& tangent, const std::vector<Support>& supports, const Positions& rhs,
                     double tolerance, Positions& x) override {
    const int n = static_cast<int>(rhs.cols());
    inverse_.compute(tangent, supports);
    factor_.reset();
    if (by_factor_) factorise(tangent, supports);
    const auto precondition = [&](const Positions& from, Positions& to) {
      if (factor_)
        Eigen::Map<VectorX>(to.data(), to.size()) = factor_->solve(Eigen::Map<const VectorX>(from.data(), from.size()));
      else
        parallel_for(
            n, [&](int i) { to.col(i) = inverse_.times(i, from.col(i)); }, kMoleculeThreshold);
      keep_free(supports, to);  // single precision leads a little out of slanted supports
    };
    const auto apply = [&](const Positions& motion, Positions& result) {
      tangent.apply(motion, result, workspace_);
      keep_free(supports, result);
    };
    x.setZero(3, n);
    Positions &r = r_, &shadow = shadow_, &p = p_, &v = v_, &t = t_, &ready = ready_, &best_x = best_x_;
    r = shadow = p = rhs;
    best_x = x;
    v.resize(3, n), t.resize(3, n), ready.resize(3, n);
    const double first = ordered_norm(rhs);
    LinearResult result;
    if (first == 0) return result;
    double rho = first * first, best = first;
    const int limit = 10000 + 3 * n / 10;
    int best_at = 0;
    for (result.status = LinearStatus::limit_reached; result.iterations < limit && !stop_requested();) {
      ++result.iterations;
      precondition(p, ready);
      apply(ready, v);
      const double curvature = ordered_dot(shadow, v);
      if (curvature == 0 || !std::isfinite(curvature)) break;
      const double alpha = rho / curvature;
      combine(x, alpha, ready, x);
      combine(r, -alpha, v, r);
      precondition(r, ready);
      apply(ready, t);
      const double size = ordered_dot(t, t), omega = size > 0 ? ordered_dot(t, r) / size : 0;
      combine(x, omega, ready, x);
      combine(r, -omega, t, r);
      const double norm = ordered_norm(r);
      if (!std::isfinite(norm)) break;
      if (norm < best) best = norm, best_at = result.iterations, best_x = x;
      if (norm <= tolerance * first) {
        result.status = LinearStatus::solved;
        break;
      }
      if (!by_factor_ && result.iterations % kTried == 0) {
        const double gained = std::max(1e-3, std::log(first / best)), left = std::log(best / (tolerance * first));
        const double to_come = std::min(left / gained, kTrusted) * result.iterations;
        by_factor_ = factor_is_quicker(tangent.model().body(), supports, kProducts * to_come);
        if (by_factor_ && factorise(tangent, supports)) {
          x = best_x;
          apply(x, r);
          combine(rhs, -1, r, r);
          shadow = p = r;
          rho = ordered_dot(r, r);
          best_at = result.iterations;
          continue;
        }
      }
      if (result.iterations - best_at > kPatience) break;
      const double last = std::exchange(rho, ordered_dot(shadow, r));
      if (omega == 0 || std::abs(rho) < 1e-30 * first * first || std::abs(rho) < 1e-8 * norm * ordered_norm(shadow)) {
        shadow = p = r;  // the two sequences have come apart: restart from here
        rho = norm * norm;
        continue;
      }
      combine(p, -omega, v, p);
      combine(r, rho / last * alpha / omega, p, p);
    }
    x = best_x;
    result.residual = best / first;
    // What lowers the unbalanced force is a step worth trying.
    if (result.status != LinearStatus::solved && result.residual < 0.25) result.status = LinearStatus::solved;
    return result;
  }

 private:
  static constexpr int kPatience = 200;
  static constexpr int kTried = 25;  ///< iterations between two looks at how many are to come
  static constexpr double kTrusted = 10;
  static constexpr double kProducts = 100;  ///< of a factorisation that take as long as an iteration of a molecule

  /// Whether there is a factor.
  bool factorise(const Tangent& tangent, const std::vector<Support>& supports) {
    const double scale = stiffness_scale(tangent);
    factor_ = std::make_unique<SparseFactor>(sparse_stiffness(tangent, supports, 1e-9 * scale, scale));
    if (!factor_->usable()) factor_.reset();
    return factor_ != nullptr;
  }

  bool asked_, by_factor_;  ///< from the first iteration on; now
  std::unique_ptr<SparseFactor> factor_;
  // Kept from one solve to the next, so that steps in time allocate no memory.
  BlockInverses inverse_;
  Positions r_, shadow_, p_, v_, t_, ready_, best_x_;
  Tangent::ApplyWorkspace workspace_;
};

}  // namespace

std::unique_ptr<LinearSolver> make_bicgstab() { return std::make_unique<BiCgStab>(false); }
std::unique_ptr<LinearSolver> make_bicgstab_by_factor() { return std::make_unique<BiCgStab>(true); }

}  // namespace elastin
