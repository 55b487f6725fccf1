#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include "core/linear/assembled.h"
#include "core/linear/block_inverse.h"
#include "core/linear/linear_choice.h"
#include "core/linear/multigrid.h"
#include "core/linear/rigid_motions.h"
#include "core/linear/smoothing.h"
#include "core/linear/sparse_stiffness.h"
#include "core/linear/volume_smoother.h"
#include "core/parallel/large_memory.h"
#include "core/parallel/parallel.h"
#include "elastin/core/base/stop.h"
#include "elastin/core/linear/linear_solver.h"

namespace elastin {
namespace {

/// A grid hierarchy that serves takes some 15 iterations, one of a thin or porous body up to 150; each costs about four
/// without one. After as many as that it has to find a digit in each kForADigit.
int most_coarse_iterations(double expected) { return static_cast<int>(std::clamp(expected / 2, 100., 400.)); }
constexpr int kForADigit = 100;

/// Iterations after which the caller is asked first, the number to come from which it is worth asking, and that for
/// each one before, beyond which a pace is not trusted.
constexpr int kAsked = 30;
constexpr double kWorthAsking = 60, kTrusted = 6;
/// Iterations after which the pace of the W-cycle is known, and the number to come from which grids are searched
/// instead: porous bodies gain, while a solid of 10⁶ molecules with a stiff lump takes 115 iterations instead of 21.
constexpr int kPaced = 12;
constexpr double kWorthSearching = 14;
/// Of a thin body, whose factor is likely to be quicker, it is asked before the first.
constexpr double kLeastOfThin = 24;

/// Without smoothing around it a cycle needs two products less: where these are the price (of cells), an iteration
/// costs as many of those with it. So it begins without; where kTried iterations show that more than kWorthSmoothing
/// are to come, it is tried for as many, and the better one stays.
constexpr int kTried = 8;
constexpr double kWorthSmoothing = 30, kPlainCost = 1.3, kSmoothedCost = 3.3;

/// Of smoothing on the grids, where no volumes resist more than shape: more take longer than the iterations they save.
constexpr int kStepsOfShape = 3;

/// A grid hierarchy of another stiffness serves until it takes as many times the iterations that it took when new.
constexpr double kServes = 1.5;
constexpr int kServesAnyway = 10;  ///< iterations that are worth no new one

/// Molecules whose part of five vectors is in a processor's nearest cache.
constexpr int kInCache = 128;

/// Part of a load on the motions that nothing resists, below which it is rounding.
constexpr double kApart = 1e-8;

/// Whether a product takes longer than a cycle: not that of springs, and not that of first-order hexahedra at rest,
/// which share their stiffness.
bool is_costly(const Tangent& tangent) {
  const Model& model = tangent.model();
  const auto& edges = model.edge_laws();
  if (std::any_of(edges.begin(), edges.end(), [](auto* law) { return law->coupled(); })) return true;
  if (model.nodal_laws().empty()) return false;
  const auto& blocks = model.body().blocks;
  return std::any_of(blocks.begin(), blocks.end(), [](const CellBlock& block) { return block.kind->order > 1; }) ||
         tangent.positions() != model.body().rest;
}

class Pcg final : public LinearSolver, public KeepsWay {
 public:
  explicit Pcg(bool multigrid, GivesUp gives_up = {}) : multigrid_(multigrid), gives_up_(std::move(gives_up)) {}
  explicit Pcg(int most_iterations) : multigrid_(false), most_(most_iterations) {}
  void forget() override { coarse_.reset(); }
  const char* name() const override { return multigrid_ ? "multigrid" : "pcg"; }

  LinearResult solve(const Tangent& tangent, const std::vector<Support>& supports, const Positions& rhs,
                     double tolerance, Positions& x) override {
    const int n = static_cast<int>(rhs.cols());
    inverse_.compute(tangent, supports);
    const bool kept = coarse_ != nullptr;
    if (multigrid_ && !kept) coarse_ = std::make_unique<Multigrid>(tangent, supports);
    if (gives_up_ && coarse_ && coarse_->thin() && gives_up_(kLeastOfThin)) {
      LinearResult none;
      none.status = LinearStatus::limit_reached;
      return none;
    }
    if (coarse_ && !coarse_->positive()) coarse_.reset();
    Multigrid* coarse = coarse_.get();
    const auto expected = [&] { return expected_iterations(tangent.model().body(), tolerance); };
    int coarse_limit = coarse ? most_coarse_iterations(expected()) : 0;
    double at_limit = std::numeric_limits<double>::infinity();  // r·r at the limit before
    // Single precision makes a little of any motion that nothing resists; its size would then be whatever it is.
    std::optional<RigidMotions> whole;
    // What a preconditioner makes of r stands where K p stood: each molecule's is read before it is written.
    Positions &r = r_, &p = p_, &kp = kp_, &z = kp_, &unresolved = left_;
    for (Positions* vectors : {&r, &p, &kp, &x}) resize(*vectors, n);
    if (coarse) whole.emplace(tangent, supports, p, kp);
    // Where no force works on these motions they stay out of every direction: the grid hierarchy, for which next to
    // nothing resists them, would drown the others in them.
    const bool apart =
        whole && !whole->empty() && whole->part_of(tangent.positions(), rhs) <= kApart * ordered_norm(rhs);
    r = rhs;
    x.setZero();
    // r·z and r·r in one pass; moved = 0 leaves x and r as they are.
    const auto advance = [&](double step) {
      const auto products = ordered_sum_of_blocks<Eigen::Vector2d>(
          n,
          [&](int begin, int end) {
            double with_z = 0, squares = 0;
            for (int first = begin; first < end; first += kInCache) {
              const int size = std::min(kInCache, end - first);
              if (step != 0) {
                x.middleCols(first, size) += step * p.middleCols(first, size);
                if (coarse) change_.middleCols(first, size) = step * kp.middleCols(first, size);
                r.middleCols(first, size) -= step * kp.middleCols(first, size);
              }
              for (int i = first; i < first + size; ++i) {
                const Vector3 own = r.col(i), motion = inverse_.times(i, own);
                z.col(i) = motion;
                with_z += own.dot(motion), squares += own.squaredNorm();
              }
            }
            return Eigen::Vector2d(with_z, squares);
          },
          Eigen::Vector2d(0, 0), kMoleculeThreshold);
      keep_free(supports, z);  // single precision leads a little out of slanted supports
      return products;
    };
    bool assembled = false;
    const auto apply = [&](const Positions& motion, Positions& forces) {
      assembled ? rows_.apply(motion, forces) : tangent.apply(motion, forces, workspace_);
      keep_free(supports, forces);
    };
    // From this step on, z being what the ones before made of r.
    const auto smooth = [&](int step) {
      for (; step <= steps_; ++step) {
        apply(z, unresolved);
        if (volume_) {
          parallel_for(
              n, [&](int i) { unresolved.col(i) = r.col(i) - unresolved.col(i); }, kMoleculeThreshold);
          volume_->apply(unresolved);
        }
        const SmoothingStep factors = smoothing_step(step);
        parallel_for(
            n,
            [&](int i) {
              const Vector3 left = r.col(i) - unresolved.col(i),
                            motion = volume_ ? Vector3(unresolved.col(i)) : inverse_.times(i, left);
              step_.col(i) = factors.before * step_.col(i) + factors.now / largest_ * motion;
              z.col(i) += step_.col(i);
            },
            kMoleculeThreshold);
        keep_free(supports, z);
      }
    };
    // From what the first step makes of r: smoothed, corrected by the grid hierarchy and smoothed the same way back,
    // which is symmetric.
    const auto add_coarse = [&](Eigen::Vector2d& products) {
      if (!coarse || !(products[1] > 0)) return;
      if (!smooths_) {
        coarse->add(r, std::sqrt(products[1]), z);
        keep_free(supports, z);
        if (apart) whole->remove_from(tangent.positions(), z);
        products[0] = ordered_dot(r, z);
        return;
      }
      if (volume_) volume_->apply(z = r);
      parallel_for(
          n, [&](int i) { step_.col(i) = z.col(i) *= smoothing_step(1).now / largest_; }, kMoleculeThreshold);
      smooth(2);
      apply(z, unresolved);
      parallel_for(
          n, [&](int i) { unresolved.col(i) = r.col(i) - unresolved.col(i); }, kMoleculeThreshold);
      coarse->add(unresolved, std::sqrt(products[1]), z);
      keep_free(supports, z);
      if (apart) whole->remove_from(tangent.positions(), z);
      smooth(1);
      products[0] = ordered_dot(r, z);
    };
    // Overwrites z, which stands where K p does.
    const auto set_smoothing = [&] {
      smooths_ = true;
      if (!volume_ && is_of_resisting_links(tangent)) {
        largest_ = kLargestOfLinks, steps_ = 1;
        return;
      }
      const auto [of_most, bound] =
          largest_eigenvalue(n, kp, unresolved, step_, [&](const Positions& from, Positions& to) {
            apply(from, to);
            if (volume_) return volume_->apply(to);
            parallel_for(
                n, [&](int i) { to.col(i) = inverse_.times(i, to.col(i)); }, kMoleculeThreshold);
          });
      largest_ = bound;
      steps_ = !volume_ && of_most > kOneStep ? 2 : 1;
    };
    Eigen::Vector2d now = advance(0);
    const double first = now[1];
    LinearResult result;
    if (first == 0) return result;
    assembled = AssembledStiffness::pays(tangent, expected);
    if (assembled) rows_.assemble(tangent);
    if (coarse) {
      for (Positions* vectors : {&unresolved, &step_, &change_}) resize(*vectors, n);
      if (!kept) {
        volume_ = VolumeSmoother::of(tangent, supports);
        if (!volume_) coarse->limit_steps(kStepsOfShape);
        tried_ = volume_ || !is_costly(tangent);
        smooths_ = false;
        if (tried_) set_smoothing(), now = advance(0);
      }
    }
    add_coarse(now);
    p = z;
    double size_of_p = now[0];  // pᵀ M p, M the preconditioner: what pᵀ K p is small or large against
    const int limit = std::min(most_, 10000 + 3 * n / 10);
    // On a stiffness that is not symmetric the search gets stuck: the best iterate is its result.
    const bool symmetric = tangent.model().has_energy();
    constexpr int patience = 100;
    double best = first;
    int best_at = 0;
    int asked_before = 0, asked = kAsked;  // iterations at which the caller may give up
    double when_asked = first;
    int mode_from = 0;  // iteration from which on it smooths, or does not
    double when_mode = first, plain_pace = 0;
    while (true) {
      apply(p, kp);
      const double curvature = ordered_dot(p, kp);
      if (!(curvature > 1e-13 * size_of_p)) {
        result.status = curvature < -1e-10 * size_of_p ? LinearStatus::negative_mode : LinearStatus::zero_mode;
        if (result.status == LinearStatus::negative_mode) result.negative_direction = p;
        // The direction to go on: down the negative direction, or along what is left of the force where there is no
        // stiffness.
        if (result.status == LinearStatus::zero_mode)
          x += r / stiffness_scale(tangent);
        else if (result.iterations == 0)
          x = p;
        break;
      }
      const double before = now[0];
      now = advance(before / curvature);
      ++result.iterations;
      if (now[1] <= tolerance * tolerance * first) break;
      if (!symmetric && now[1] < best) best = now[1], best_at = result.iterations, best_x_ = x;
      if (!symmetric && result.iterations - best_at > patience) {
        if (best_at > 0) x = best_x_;
        now[1] = best;
        result.status = best < 0.25 * first ? LinearStatus::solved : LinearStatus::limit_reached;
        break;
      }
      const double left = std::log(now[1] / first) - 2 * std::log(tolerance);
      const int since = result.iterations - mode_from;
      const double gained = std::max(1e-3, std::log(when_mode / now[1]));
      if (coarse && !tried_ && since == kTried) {
        const double pace = gained / (kTried * (smooths_ ? kSmoothedCost : kPlainCost));
        tried_ = smooths_ || kTried * left / gained <= kWorthSmoothing;
        if (!tried_) {
          set_smoothing(), now = advance(0);
          plain_pace = pace, when_mode = now[1], mode_from = result.iterations;
        } else if (smooths_) {
          smooths_ = pace >= plain_pace;
        }
      }
      if (coarse && smooths_ && since == kPaced && kPaced * left > kWorthSearching * gained) coarse->search();
      if (gives_up_ && result.iterations == asked) {
        const double found = std::max(1e-3, std::log(when_asked / now[1]));
        const double to_come = std::min((asked - asked_before) * left / found, kTrusted * asked);
        if (to_come > kWorthAsking && gives_up_(to_come)) {
          result.status = LinearStatus::limit_reached;
          break;
        }
        when_asked = now[1], asked_before = asked, asked *= 2;
      }
      if (result.iterations >= limit || !std::isfinite(now[1]) || stop_requested()) {
        result.status = LinearStatus::limit_reached;
        break;
      }
      add_coarse(now);
      // Not positive after all, or blind to what this body is slow at (stiff lumps that share boxes with soft tissue):
      // go on without, from here.
      const bool further = result.iterations == coarse_limit && now[1] < 0.01 * std::exchange(at_limit, now[1]);
      if (further) coarse_limit += kForADigit;
      if (coarse && (!(now[0] > 0) || result.iterations == coarse_limit)) {
        coarse = nullptr;
        now = advance(0);
        p = z;
        size_of_p = now[0];
        continue;
      }
      // A search makes the preconditioner another one at each step: what it makes of r has to leave out the direction
      // before.
      const double beta = (coarse ? -ordered_dot(z, change_) : now[0]) / before;
      parallel_ranges(
          n,
          [&](int begin, int end) {
            p.middleCols(begin, end - begin) =
                z.middleCols(begin, end - begin) + beta * p.middleCols(begin, end - begin);
          },
          kMoleculeThreshold);
      size_of_p = now[0] + beta * beta * size_of_p;
    }
    result.residual = std::sqrt(now[1] / first);
    // Iterations for a digit: how far each solve has to go is another matter.
    const double pace = result.iterations / std::max(0.5, -std::log10(result.residual));
    if (!kept) pace_ = pace;
    const bool serves = coarse && result.status == LinearStatus::solved &&
                        (pace <= kServes * pace_ || result.iterations <= kServesAnyway);
    if (!serves) coarse_.reset();
    if (whole) whole->remove_from(tangent.positions(), x);
    return result;
  }

 private:
  bool multigrid_;
  int most_ = std::numeric_limits<int>::max();
  GivesUp gives_up_;
  std::unique_ptr<Multigrid> coarse_;
  double pace_ = 0;                       ///< iterations a digit with it when new
  std::optional<VolumeSmoother> volume_;  ///< in the place of D⁻¹
  double largest_ = 1;                    ///< eigenvalue of either times K, then
  int steps_ = 1;                         ///< of smoothing
  bool smooths_ = true, tried_ = true;    ///< around the cycles; whether that is settled
  // Kept from one solve to the next, so that steps in time allocate no memory.
  BlockInverses inverse_;
  AssembledStiffness rows_;
  Positions r_, p_, kp_, left_, step_, change_, best_x_;
  Tangent::ApplyWorkspace workspace_;
};

}  // namespace

bool is_of_resisting_links(const Tangent& tangent) {
  if (!tangent.is_of_links() || !tangent.linked()) return tangent.is_of_links();
  return largest_of_ranges(tangent.model().body().connections.size(), [&](int begin, int end) {
           for (int c = begin; c < end; ++c) {
             const auto [d, density, slope] = tangent.link(c);
             if (density >= 0 && (slope >= 0 || density + slope * d.squaredNorm() >= 0)) continue;
             return 1.;
           }
           return 0.;
         }) == 0;
}

Positions scattered_directions(int molecules) {
  Positions directions(3, molecules);
  for (int i = 0; i < molecules; ++i) directions.col(i) = scattered_direction(i);
  return directions;
}

Vector3 scattered_direction(std::int64_t molecule) {
  Vector3 direction;
  for (int k = 0; k < 3; ++k) direction[k] = std::sin(1.0 + 12.9898 * static_cast<double>(molecule) + 78.233 * k);
  return direction;
}

void keep_free(const std::vector<Support>& supports, Positions& vectors) {
  for (const Support& support : supports) vectors.col(support.molecule) = support.free * vectors.col(support.molecule);
}

double ordered_dot(const Positions& a, const Positions& b) {
  return ordered_sum_of_blocks(
      static_cast<int>(a.cols()),
      [&](int begin, int end) {
        // Four sums side by side, which a compiler may add as vectors; their order is the same on every machine.
        std::array<double, 4> sums{};
        int k = 3 * begin;
        for (; k + 4 <= 3 * end; k += 4)
          for (int lane = 0; lane < 4; ++lane) sums[lane] += a.data()[k + lane] * b.data()[k + lane];
        for (; k < 3 * end; ++k) sums[0] += a.data()[k] * b.data()[k];
        return (sums[0] + sums[2]) + (sums[1] + sums[3]);
      },
      0., kMoleculeThreshold);
}

double ordered_norm(const Positions& vectors) {
  return std::sqrt(ordered_sum(static_cast<int>(vectors.cols()), [&](int i) { return vectors.col(i).squaredNorm(); }));
}

std::unique_ptr<LinearSolver> make_pcg() { return std::make_unique<Pcg>(false); }
std::unique_ptr<LinearSolver> make_pcg(int most_iterations) { return std::make_unique<Pcg>(most_iterations); }
std::unique_ptr<LinearSolver> make_multigrid() { return std::make_unique<Pcg>(true); }
std::unique_ptr<LinearSolver> make_multigrid(GivesUp gives_up) {
  return std::make_unique<Pcg>(true, std::move(gives_up));
}

}  // namespace elastin
