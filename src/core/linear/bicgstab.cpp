#include <algorithm>
#include <cmath>
#include <utility>

#include "core/linear/block_inverse.h"
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

class BiCgStab final : public LinearSolver {
 public:
  const char* name() const override { return "bicgstab"; }

  LinearResult solve(const Tangent& tangent, const std::vector<Support>& supports, const Positions& rhs,
                     double tolerance, Positions& x) override {
    const int n = static_cast<int>(rhs.cols());
    inverse_.compute(tangent, supports);
    const auto precondition = [&](const Positions& from, Positions& to) {
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
  // Kept from one solve to the next, so that steps in time allocate no memory.
  BlockInverses inverse_;
  Positions r_, shadow_, p_, v_, t_, ready_, best_x_;
  Tangent::ApplyWorkspace workspace_;
};

}  // namespace

std::unique_ptr<LinearSolver> make_bicgstab() { return std::make_unique<BiCgStab>(); }

}  // namespace elastin
