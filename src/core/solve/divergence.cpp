#include "core/solve/divergence.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Eigenvalues>

#include "core/base/dense.h"
#include "core/linear/assembled.h"
#include "core/linear/block_inverse.h"
#include "core/linear/linear_choice.h"
#include "core/linear/sparse_factor.h"
#include "core/linear/sparse_stiffness.h"
#include "core/solve/newton.h"

namespace elastin {
namespace {

constexpr double kTolerance = 1e-5;  ///< of what conjugate gradients leave of their load
constexpr double kProducts = 100;    ///< of a factorisation that take as long as an iteration of a molecule
constexpr int kShifts = 12;          ///< that are tried
constexpr int kMotions = 24;         ///< of Arnoldi's iteration, at most
constexpr double kSettled = 0.1;     ///< of an eigenvalue's distance from 0: how far it may still be off
constexpr double kRounding = 1e-6;   ///< of σ: nearer to 0 a stiffness is none
constexpr double kSolved = 1e-8, kUsable = 1e-4;
constexpr double kProbed = 1e-3;  ///< of the connections' mean length: how far on the forces are looked at
constexpr double kPushed = 0.1;   ///< of it: where a divergence is followed from
constexpr int kSteps = 400;       ///< that follow it, at most
constexpr double kStepTolerance = 1e-2;

/// ½ (K + Kᵀ) of a tangent, with the inertia of its weights: K less ½ (K − Kᵀ), which has blocks where loads, or laws
/// without an energy, have.
class SymmetricPart {
 public:
  SymmetricPart(const Model& model, const State& state, const Tangent& tangent) : rest_(model.body().size()) {
    const auto add = [&](int a, int b, const Matrix3& block) {
      rest_[a].add(b, block / 2);
      rest_[b].add(a, -block.transpose() / 2);
    };
    if (!model.has_energy())
      tangent.visit_blocks(add);
    else
      for (const auto& load : model.loads())
        if (!load->symmetric()) load->visit_blocks(state, 0, add);
  }

  /// A direction that the part is negative along, met on the way to the answer for `load`; or no columns.
  Positions negative_direction(const Tangent& tangent, const std::vector<Support>& supports, const Positions& load,
                               int& iterations) const {
    const Body& body = tangent.model().body();
    BlockInverses inverse;
    inverse.compute(tangent, supports);
    SparseFactor factor;
    const double scale = stiffness_scale(tangent);
    const bool factorises = factor_is_quicker(body, supports, kProducts * expected_iterations(body, kTolerance));
    if (factorises) factor.compute(sparse_stiffness(tangent, supports, 1e-9 * scale, scale));
    const bool by_factor = factorises && factor.usable() && factor.positive();
    Positions r = load, z(3, r.cols()), p, kp(3, r.cols());
    const auto precondition = [&] {
      if (by_factor)
        Eigen::Map<VectorX>(z.data(), z.size()) = factor.solve(Eigen::Map<const VectorX>(r.data(), r.size()));
      else
        for (int i = 0; i < body.size(); ++i) z.col(i) = inverse.times(i, r.col(i));
      keep_free(supports, z);
    };
    precondition();
    p = z;
    double now = ordered_dot(r, z), size = now;
    const double goal = kTolerance * ordered_norm(load);
    const int limit = 10000 + 3 * body.size() / 10;
    for (int iteration = 0; iteration < limit && ordered_norm(r) > goal; ++iteration, ++iterations) {
      apply(tangent, p, kp);
      keep_free(supports, kp);
      const double curvature = ordered_dot(p, kp);
      if (curvature < -1e-10 * size) return p;
      if (!(curvature > 1e-13 * size)) break;
      r -= now / curvature * kp;
      precondition();
      const double next = ordered_dot(r, z), ratio = next / std::exchange(now, next);
      p = z + ratio * p;
      size = now + ratio * ratio * size;
    }
    return {};
  }

  double quotient(const Tangent& tangent, const Positions& direction) const {
    Positions forces(3, direction.cols());
    apply(tangent, direction, forces);
    const VectorX& mass = tangent.model().body().mass;
    return ordered_dot(direction, forces) / direction.colwise().squaredNorm().dot(mass);
  }

 private:
  void apply(const Tangent& tangent, const Positions& motion, Positions& forces) const {
    tangent.apply(motion, forces, workspace_);
    for (std::size_t a = 0; a < rest_.size(); ++a)
      for (const auto& [molecule, block] : rest_[a])
        forces.col(static_cast<Eigen::Index>(a)) -= block * motion.col(molecule);
  }

  std::vector<BlockRow> rest_;
  mutable Tangent::ApplyWorkspace workspace_;
};

/// The motion of a real λ < 0 of K x = λ M x, `shifted` being K + σ M; or no columns.
Positions growing_motion(const Tangent& shifted, const std::vector<Support>& supports, const Positions& start,
                         int& iterations) {
  const double shift = shifted.weights().acceleration;
  const VectorX& mass = shifted.model().body().mass;
  const auto solver = make_bicgstab();
  MatrixX motions(start.size(), kMotions + 1), steps = MatrixX::Zero(kMotions + 1, kMotions);
  motions.col(0) = start.reshaped().normalized();
  for (int count = 1; count <= kMotions; ++count) {
    Positions load = motions.col(count - 1).reshaped(3, start.cols()) * mass.asDiagonal(), next;
    keep_free(supports, load);
    const LinearResult solved = solver->solve(shifted, supports, load, kSolved, next);
    iterations += solved.iterations;
    if (!next.allFinite() || solved.residual > kUsable) return {};
    VectorX left = next.reshaped();
    for (int pass = 0; pass < 2; ++pass)
      for (int i = 0; i < count; ++i) {
        const double part = motions.col(i).dot(left);
        steps(i, count - 1) += part;
        left -= part * motions.col(i);
      }
    const double further = steps(count, count - 1) = left.norm();
    const Eigen::EigenSolver<MatrixX> eigen(steps.topLeftCorner(count, count));
    int best = -1;  // 1 / (λ + σ)
    for (int i = 0; i < count; ++i)
      if (eigen.eigenvalues()[i].imag() == 0 &&
          (best < 0 || eigen.eigenvalues()[i].real() > eigen.eigenvalues()[best].real()))
        best = i;
    if (best >= 0) {
      const double found = eigen.eigenvalues()[best].real();
      const VectorX parts = eigen.eigenvectors().col(best).real().eval().normalized();
      if (std::abs(further * parts[count - 1]) < kSettled * std::abs(found - 1 / shift) || further < 1e-12 * found) {
        if (!(found * shift > 1 + kRounding)) return {};
        return (motions.leftCols(count) * parts).reshaped(3, start.cols());
      }
    }
    if (!(further > 0)) return {};
    motions.col(count) = left / further;
  }
  return {};
}

/// Whether the forces drive the body away from `now` along a direction, on both sides.
bool drives_away(const Problem& problem, const Positions& direction, const Trial& now, TrialWorkspace& workspace) {
  const double length = kProbed * mean_length(problem.whole()) / furthest(problem, direction);
  Trial trial;
  for (const double factor : {length, -length}) {
    set_state(now.state, factor, direction, trial.state);
    if (problem.model.max_step_fraction(now.state, trial.state) < 1) return false;
    evaluate(problem, false, trial, workspace);
    if (!std::isfinite(trial.energy)) return false;
    if (!(factor * problem.dot(trial.forces.unbalanced - now.forces.unbalanced, direction) > 0)) return false;
  }
  return true;
}

/// Brings a trial on along a motion, as far as that inverts no cell; false where it does at once.
bool go_on(const Problem& problem, const Positions& motion, Trial& at, TrialWorkspace& workspace) {
  Trial& trial = workspace.next;
  set_state(at.state, 1, motion, trial.state);
  for (double step = problem.model.max_step_fraction(at.state, trial.state); step > 1e-3; step /= 2) {
    set_state(at.state, step, motion, trial.state);
    evaluate(problem, false, trial, workspace);
    if (!std::isfinite(trial.energy) || !std::isfinite(trial.forces.norm)) continue;
    std::swap(at, trial);
    return true;
  }
  return false;
}

}  // namespace

Divergence find_divergence(const Problem& problem, const Trial& now, const Positions& load, int& iterations,
                           TrialWorkspace& workspace) {
  const Model& model = problem.model;
  const Tangent tangent(model, now.state);
  const SymmetricPart part(model, now.state, tangent);
  const Positions start = part.negative_direction(tangent, model.supports, load, iterations);
  Positions down = start;
  Divergence found;
  for (int tries = 0; down.size() > 0; ++tries) {
    if (tries == kShifts || !model.body().mass.allFinite() || !(model.body().mass.minCoeff() > 0)) return {};
    found.shift = std::max(4 * found.shift, -2 * part.quotient(tangent, down));
    const Tangent shifted(model, now.state, {0, found.shift});
    down = part.negative_direction(shifted, model.supports, load, iterations);
    if (down.size() > 0) continue;
    found.direction = growing_motion(shifted, model.supports, start, iterations);
  }
  if (found.direction.size() > 0 && !drives_away(problem, found.direction, now, workspace)) return {};
  return found;
}

bool follow_divergence(const Problem& problem, const Divergence& divergence, const StaticOptions& options, double floor,
                       Trial& now, TrialWorkspace& workspace, StaticResult& result) {
  const Model& model = problem.model;
  const double size = mean_length(problem.whole());
  const double length = kPushed * size / furthest(problem, divergence.direction);
  const auto solver = make_bicgstab();
  Positions motion;
  for (const double factor : {length, -length}) {
    Trial at = now;
    if (!go_on(problem, factor * divergence.direction, at, workspace)) continue;
    double peak = 0;  // of the force on along the direction: where that has fallen, the steps are Newton's
    for (int step = 0; step < kSteps && !is_interrupted(options, result); ++step) {
      if (at.forces.norm <= std::max(options.tolerance * at.forces.scale, 2 * floor)) {
        if (!(furthest(problem, at.state.positions - now.state.positions) > kProbed * size)) break;
        std::swap(now, at);
        return true;
      }
      const double along = std::copysign(1., factor) * problem.dot(at.forces.unbalanced, divergence.direction);
      peak = std::max(peak, along);
      const double part = peak > 0 ? std::min(1., std::abs(along) / peak) : 1;
      const Tangent tangent(model, at.state, {0, divergence.shift * part});
      result.linear_iterations +=
          solver->solve(tangent, model.supports, at.forces.unbalanced, kStepTolerance, motion).iterations;
      ++result.newton_iterations;
      if (!motion.allFinite()) break;
      if (const double own = furthest(problem, motion); own > size) motion *= size / own;
      if (!go_on(problem, motion, at, workspace)) break;
    }
    if (result.outcome == Outcome::interrupted) return false;
  }
  return false;
}

}  // namespace elastin
