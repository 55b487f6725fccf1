#include "core/linear/mixed.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/forces/cell_pressures.h"
#include "core/linear/block_inverse.h"
#include "core/linear/multigrid.h"
#include "core/linear/rigid_motions.h"
#include "core/parallel/parallel.h"
#include "elastin/core/base/stop.h"

namespace elastin {
namespace {

/// Calls visit(pressures, first of them) for all that have some; returns their number.
template <class Visit>
Eigen::Index visit_pressures(const Tangent& tangent, Visit&& visit) {
  Eigen::Index count = 0;
  tangent.visit_points([&](const StiffPoints& points) {
    const auto* own = dynamic_cast<const CellPressures*>(&points);
    if (!own || own->pressures() == 0) return;
    visit(*own, count);
    count += own->pressures();
  });
  return count;
}

/// Displacements [m], or forces [N], and pressures [Pa], or volumes [m³].
struct Pair {
  Positions u;
  VectorX p;
};

/// factor · to + other
void scale_add(double factor, Pair& to, const Pair& other) {
  parallel_for(
      static_cast<int>(to.u.cols()), [&](int i) { to.u.col(i) = factor * to.u.col(i) + other.u.col(i); },
      kMoleculeThreshold);
  to.p = factor * to.p + other.p;
}

void add(double factor, const Pair& other, Pair& to) {
  parallel_for(
      static_cast<int>(to.u.cols()), [&](int i) { to.u.col(i) += factor * other.u.col(i); }, kMoleculeThreshold);
  to.p += factor * other.p;
}

/// With K = K̃ + (1 − part) Gᵀ Q G and pressures p = Q y that are unknowns of their own,
///   K̃ u + Gᵀ p = b,  G u − y / (1 − part) = 0,
/// indefinite, but as well conditioned near ν = ½ as far from it once preconditioned by a cycle for K̃ and by Q /
/// weight, near the inverse of what the pressures meet, G K̃⁻¹ Gᵀ + Q⁻¹ / (1 − part).  [Silvester & Wathen 1994]
class Problem {
 public:
  Problem(const Tangent& tangent, const std::vector<Support>& supports, const Positions& rhs)
      : soft_(tangent), supports_(supports), coarse_(soft_.tangent(), supports) {
    inverse_.compute(soft_.tangent(), supports);
    count_ = visit_pressures(soft_.tangent(),
                             [&](const CellPressures& own, Eigen::Index first) { terms_.emplace_back(&own, first); });
    const double ratio = SoftVolume::ratio(tangent);
    weight_ = 1 / (1 - soft_.part()) + ratio / (kSoftRatio + 4. / 3);
    Positions motions, forces;
    whole_ = std::make_unique<RigidMotions>(soft_.tangent(), supports, motions, forces);
    // Elsewhere the load works on a motion that nothing resists.
    solvable_ = coarse_.positive() && whole_->part_of(rest(), rhs) <= 1e-8 * ordered_norm(rhs);
  }
  bool solvable() const { return solvable_; }
  Pair zero() const { return {Positions::Zero(3, rest().cols()), VectorX::Zero(count_)}; }

  /// The left side for u and p = Q y.
  void apply(const Pair& at, const VectorX& y, Pair& result) {
    soft_.tangent().apply(at.u, result.u, workspace_);
    for (const auto& [term, first] : terms_) {
      term->add_forces_of(at.p.segment(first, term->pressures()), result.u, workspace_.force_pass);
      term->swell(at.u, result.p.segment(first, term->pressures()));
    }
    result.p -= y / (1 - soft_.part());
    keep_free(supports_, result.u);
  }
  /// z = nearly the inverse of the left side's size, times r; z.p = Q y with y = r.p / weight().
  void precondition(const Pair& r, Pair& z) {
    parallel_for(
        static_cast<int>(r.u.cols()), [&](int i) { z.u.col(i) = inverse_.times(i, r.u.col(i)); }, kMoleculeThreshold);
    if (const double size = ordered_norm(r.u); size > 0) coarse_.add(r.u, size, z.u);
    keep_free(supports_, z.u);
    whole_->remove_from(rest(), z.u);
    resist(r.p, z.p);
    z.p /= weight_;
  }
  /// p = Q y.
  void resist(const VectorX& y, VectorX& p) const {
    for (const auto& [term, first] : terms_)
      term->resist(y.segment(first, term->pressures()), p.segment(first, term->pressures()));
    p /= soft_.part();
  }
  double weight() const { return weight_; }
  /// uᵀ K̃ u, from what apply made of u, p and y.
  double soft_curvature(const Pair& at, const VectorX& y, const Pair& applied) const {
    return ordered_sum(
               static_cast<int>(at.u.cols()), [&](int i) { return at.u.col(i).dot(applied.u.col(i)); }, 0.,
               kMoleculeThreshold) -
           ordered_sum(
               static_cast<int>(y.size()), [&](int k) { return at.p[k] * (applied.p[k] + y[k] / (1 - soft_.part())); },
               0., kMoleculeThreshold);
  }
  double dot(const Pair& a, const Pair& b) const {
    return ordered_sum(
               static_cast<int>(a.u.cols()), [&](int i) { return a.u.col(i).dot(b.u.col(i)); }, 0.,
               kMoleculeThreshold) +
           ordered_sum(
               static_cast<int>(a.p.size()), [&](int k) { return a.p[k] * b.p[k]; }, 0., kMoleculeThreshold);
  }
  void take_out_rigid(Positions& motion) const { whole_->remove_from(rest(), motion); }

 private:
  const Positions& rest() const { return soft_.tangent().positions(); }
  SoftVolume soft_;
  const std::vector<Support>& supports_;
  Multigrid coarse_;
  BlockInverses inverse_;
  std::unique_ptr<RigidMotions> whole_;
  std::vector<std::pair<const CellPressures*, Eigen::Index>> terms_;
  Eigen::Index count_ = 0;
  double weight_ = 1;
  bool solvable_ = false;
  Tangent::ApplyWorkspace workspace_;
};

/// One step of minimal residuals after the other, from nothing. [Paige & Saunders 1975; Elman, Silvester & Wathen 2014,
/// algorithm 4.1]
class MinimalResiduals {
 public:
  MinimalResiduals(Problem& problem, Pair rhs)
      : problem_(problem),
        v_(std::move(rhs)),
        before_(problem.zero()),
        z_(problem.zero()),
        next_z_(problem.zero()),
        product_(problem.zero()),
        w_(problem.zero()),
        w_before_(problem.zero()),
        sum(problem.zero()) {
    problem_.precondition(v_, z_);
    gamma_ = std::sqrt(std::max(0., problem_.dot(z_, v_)));
    first_ = eta_ = gamma_;
  }
  /// What is left, in the preconditioner's norm, over what there was.
  double left() const { return first_ > 0 ? std::abs(eta_) / first_ : 0; }
  /// False where there is no further one.
  bool step() {
    if (!(gamma_ > 0)) return false;
    z_.u /= gamma_, z_.p /= gamma_;
    const VectorX y = v_.p / (gamma_ * problem_.weight());
    problem_.apply(z_, y, product_);
    if (!(problem_.soft_curvature(z_, y, product_) > 0)) return false;
    const double delta = problem_.dot(product_, z_);
    add(-delta / gamma_, v_, product_);
    if (!start_) add(-gamma_ / gamma_before_, before_, product_);
    problem_.precondition(product_, next_z_);
    const double square = problem_.dot(next_z_, product_);
    if (!std::isfinite(square)) return false;
    const double next = std::sqrt(std::max(0., square));
    const double a0 = c_ * delta - c_before_ * s_ * gamma_, a1 = std::hypot(a0, next),
                 a2 = s_ * delta + c_before_ * c_ * gamma_, a3 = s_before_ * gamma_;
    if (!(a1 > 0)) return false;
    // The directions have y in the place of p = Q y: that is what the sum needs.
    z_.p = y;
    scale_add(-a3, w_before_, z_);
    add(-a2, w_, w_before_);
    w_before_.u /= a1, w_before_.p /= a1;
    std::swap(w_, w_before_);
    const double c = a0 / a1, s = next / a1;
    add(c * eta_, w_, sum);
    eta_ *= -s;
    c_before_ = c_, c_ = c, s_before_ = s_, s_ = s;
    gamma_before_ = gamma_, gamma_ = next;
    std::swap(before_, v_), std::swap(v_, product_), std::swap(z_, next_z_);
    start_ = false;
    return true;
  }

 private:
  Problem& problem_;
  Pair v_, before_, z_, next_z_, product_, w_, w_before_;
  double gamma_ = 0, gamma_before_ = 1, first_ = 0, eta_ = 0;
  double c_ = 1, c_before_ = 1, s_ = 0, s_before_ = 0;
  bool start_ = true;

 public:
  Pair sum;  ///< displacements and y
};

class Mixed final : public LinearSolver {
 public:
  const char* name() const override { return "mixed"; }

  LinearResult solve(const Tangent& tangent, const std::vector<Support>& supports, const Positions& rhs,
                     double tolerance, Positions& x) override {
    LinearResult result;
    if (SoftVolume::ratio(tangent) > 2 * kSoftRatio) result = solve_mixed(tangent, supports, rhs, tolerance, x);
    // Of a stiffness that is not positive this one does not know what leads down.
    const auto leads_down = [&] {
      return ordered_sum(static_cast<int>(rhs.cols()), [&](int i) { return x.col(i).dot(rhs.col(i)); }) > 0;
    };
    if (result.iterations > 0 && result.status == LinearStatus::solved && leads_down()) return result;
    LinearResult alone = make_multigrid()->solve(tangent, supports, rhs, tolerance, x);
    alone.iterations += result.iterations;
    return alone;
  }

 private:
  static LinearResult solve_mixed(const Tangent& tangent, const std::vector<Support>& supports, const Positions& rhs,
                                  double tolerance, Positions& x) {
    constexpr int look = 5, limit = 1000, restarts = 8;
    constexpr double precise = 1e-6;  // single precision leads no further at once
    LinearResult result;
    result.status = LinearStatus::limit_reached;
    x.setZero(3, rhs.cols());
    const double first = ordered_norm(rhs);
    if (first == 0) return {};
    Problem problem(tangent, supports, rhs);
    if (!problem.solvable()) return result;
    Tangent::ApplyWorkspace workspace;
    Pair solution = problem.zero(), residual = problem.zero(), trial = residual;
    Positions forces(3, rhs.cols());
    residual.u = rhs;
    for (int start = 0; start < restarts && result.iterations < limit; ++start) {
      MinimalResiduals search(problem, residual);
      bool further = true;
      while (further && result.iterations < limit && !stop_requested()) {
        further = search.step();
        ++result.iterations;
        if (further && search.left() > precise && result.iterations % look) continue;
        trial = solution;
        add(1, search.sum, trial);
        tangent.apply(trial.u, forces, workspace);
        keep_free(supports, forces);
        result.residual = ordered_norm(rhs - forces) / first;
        if (result.residual <= tolerance) {
          x = trial.u;
          problem.take_out_rigid(x);
          result.status = LinearStatus::solved;
          return result;
        }
        if (search.left() <= precise) break;
      }
      if (!further) return result;  // the softened stiffness is not positive here
      add(1, search.sum, solution);
      const VectorX y = solution.p;
      trial.u = solution.u;
      problem.resist(y, trial.p);
      problem.apply(trial, y, residual);
      residual.u = rhs - residual.u;
      residual.p = -residual.p;
    }
    return result;
  }
};

/// The same laws, without loads.
Model without_loads(const Model& other) {
  Model model(other.body());
  for (const auto& law : other.elasticity()) model.add(law->clone());
  return model;
}

State state_at(const Tangent& tangent) {
  State state = state_at_rest(tangent.model().body());
  state.positions = tangent.positions();
  return state;
}

}  // namespace

double SoftVolume::ratio(const Tangent& tangent) {
  const Model& model = tangent.model();
  const bool still = tangent.weights().velocity == 0 && tangent.weights().acceleration == 0;
  const bool alone =
      std::none_of(model.loads().begin(), model.loads().end(), [](const auto& load) { return load->changes(); });
  if (!still || !alone || !model.has_energy()) return 0;
  double most = 0;
  visit_pressures(tangent,
                  [&](const CellPressures& own, Eigen::Index) { most = std::max(most, own.stiffness_ratio()); });
  return most;
}

bool SoftVolume::pays(const Tangent& tangent) {
  constexpr double stiff = 100;  // ν = 0.495
  // Elsewhere than at rest pressures out of balance may leave the softened stiffness indefinite.
  if (!(ratio(tangent) > stiff) || tangent.positions() != tangent.model().body().rest) return false;
  bool linear = true;
  visit_pressures(tangent, [&](const CellPressures& own, Eigen::Index) { linear &= own.of_each_cell() > 1; });
  return linear;
}

SoftVolume::SoftVolume(const Tangent& tangent)
    : model_(without_loads(tangent.model())),
      state_(state_at(tangent)),
      part_(kSoftRatio / ratio(tangent)),
      tangent_(std::make_unique<Tangent>(model_)) {
  visit_pressures(*tangent_, [&](const CellPressures& own, Eigen::Index) {
    const_cast<CellPressures&>(own).take_part(part_);  // of this tangent alone
  });
  tangent_->linearise_at(state_, {});
}

std::unique_ptr<LinearSolver> make_mixed() { return std::make_unique<Mixed>(); }

}  // namespace elastin
