#include <cmath>

#include "core/base/dense.h"
#include "core/linear/assembled.h"
#include "core/linear/sparse_factor.h"
#include "core/linear/sparse_stiffness.h"
#include "core/parallel/parallel.h"
#include "elastin/core/linear/linear_solver.h"

namespace elastin {
namespace {

/// K⁻¹ of a factorised sparse part A and the wide parts: K = A + G C Gᵀ, K⁻¹ = A⁻¹ − Z S⁻¹ Zᵀ, Z = A⁻¹ G, S = C⁻¹ +
/// Gᵀ Z. [Woodbury 1950]
class Factor {
 public:
  Factor(const Tangent& tangent, const std::vector<Support>& supports, const Eigen::SparseMatrix<double>& shifted)
      : sparse_(shifted) {
    if (!sparse_.usable()) return;
    negative_modes_ = sparse_.negative_pivots();
    const std::vector<WideTerm> parts = tangent.wide_terms();
    if (parts.empty()) return;
    const auto count = static_cast<Eigen::Index>(parts.size());
    wide_.resize(parts.front().direction.size(), count);
    MatrixX border = MatrixX::Zero(count, count);
    for (Eigen::Index i = 0; i < count; ++i) {
      Positions direction = parts[i].direction;
      keep_free(supports, direction);
      wide_.col(i) = Eigen::Map<const VectorX>(direction.data(), direction.size());
      border(i, i) = 1 / parts[i].factor;
    }
    const auto positive = [](const MatrixX& matrix) {
      return static_cast<int>((symmetric_eigenvalues(matrix).array() > 0).count());
    };
    const int before = positive(border);
    solved_.resize(wide_.rows(), count);
    for (Eigen::Index i = 0; i < count; ++i) solved_.col(i) = sparse_.solve(wide_.col(i));
    border += transposed_product(wide_, solved_);
    negative_modes_ += positive(border) - before;  // the inertia of the bordered matrix, counted twice
    border_inverse_ = inverse(border);
  }

  bool usable() const { return sparse_.usable(); }
  int negative_modes() const { return negative_modes_; }
  VectorX solve(const Eigen::Ref<const VectorX>& rhs) const {
    VectorX x = sparse_.solve(rhs);
    if (wide_.size() > 0) x -= solved_ * (border_inverse_ * (wide_.transpose() * x));
    return x;
  }

 private:
  SparseFactor sparse_;
  MatrixX wide_, solved_, border_inverse_;
  int negative_modes_ = 0;
};

/// Mean diagonal entry of each molecule's block [N/m], by size; `scale` where nothing resists a molecule's motion.
VectorX own_stiffness(const Tangent& tangent, double scale) {
  VectorX own(tangent.model().body().size());
  for (Eigen::Index i = 0; i < own.size(); ++i) {
    own[i] = std::abs(tangent.diagonal(static_cast<int>(i)).trace()) / 3;
    if (own[i] == 0) own[i] = scale;
  }
  return own;
}

/// K with each molecule's rows shifted by a part of their own stiffness: soft parts keep it next to stiff ones.
Eigen::SparseMatrix<double> shifted_rows(const Tangent& tangent, const std::vector<Support>& supports, double part,
                                         double scale) {
  Eigen::SparseMatrix<double> matrix = sparse_stiffness(tangent, supports, 0, scale);
  const VectorX own = own_stiffness(tangent, scale);
  for (Eigen::Index row = 0; row < matrix.rows(); ++row) matrix.coeffRef(row, row) += part * own[row / 3];
  matrix.makeCompressed();
  return matrix;
}

/// One solve K x = b: the best answer so far and what it leaves of b.
class Refinement {
 public:
  Refinement(const Tangent& tangent, const std::vector<Support>& supports, const Positions& rhs, double tolerance,
             double scale, Positions& x)
      : tangent_(tangent),
        supports_(supports),
        rhs_(rhs),
        own_(own_stiffness(tangent, scale)),
        goal_(tolerance * ordered_norm(rhs)),
        x_(x),
        r_(rhs),
        left_(ordered_norm(rhs)) {
    x_.setZero(3, rhs.cols());
  }

  bool done() const { return left_ <= goal_; }
  double left() const { return left_; }  ///< ‖b − K x‖
  const Positions& residual() const { return r_; }
  int iterations() const { return iterations_; }

  /// Corrections by a factor whose shift they take away again, as long as each at least halves the residual.
  void refine(const Factor& factor) {
    constexpr int limit = 30;
    bool progress = true;
    for (int i = 0; progress && !done() && i < limit; ++i) {
      const double before = left_;
      accept(x_ + solved(factor, r_));
      progress = left_ < 0.5 * before;
    }
  }

  /// Conjugate gradients behind a positive factor: each mode that is softer than the factor's shift takes one
  /// iteration. Ends where a direction has no stiffness to rounding: true then, and `mode` is that direction.
  bool conjugate(const Factor& factor, Positions& mode) {
    constexpr int limit = 100, restarts = 3;
    for (int restart = 0; restart < restarts && !done(); ++restart) {
      Positions x = x_, r = r_, z = solved(factor, r), p = z;
      double product = r.cwiseProduct(z).sum();
      const double before = left_;
      for (int i = 0; i < limit && r.norm() > 0.5 * goal_; ++i) {
        const Positions kp = stiffness_times(p);
        if (is_without_stiffness(p, kp)) {
          mode = p;
          return true;
        }
        const double step = product / p.cwiseProduct(kp).sum();
        x += step * p;
        r -= step * kp;
        ++iterations_;
        z = solved(factor, r);
        const double next = r.cwiseProduct(z).sum();
        if (!(next > 0)) break;
        p = z + next / product * p;
        product = next;
      }
      accept(x);
      if (!(left_ < 0.5 * before)) break;
    }
    return false;
  }

  /// K⁻¹ r by a factor, in the free directions.
  Positions solved(const Factor& factor, const Positions& r) const {
    const VectorX solution = factor.solve(Eigen::Map<const VectorX>(r.data(), r.size()));
    Positions result = Eigen::Map<const Positions>(solution.data(), 3, r.cols());
    keep_free(supports_, result);
    return result;
  }

  /// Whether rᵀK r is no more than rounding makes of it, against the molecules' own stiffness.
  bool is_without_stiffness(const Positions& r) const { return is_without_stiffness(r, stiffness_times(r)); }

 private:
  Positions stiffness_times(const Positions& motion) const {
    Positions forces(3, motion.cols());
    tangent_.apply(motion, forces);
    keep_free(supports_, forces);
    return forces;
  }
  bool is_without_stiffness(const Positions& r, const Positions& kr) const {
    return r.allFinite() && std::abs(r.cwiseProduct(kr).sum()) <= 1e-14 * r.colwise().squaredNorm().dot(own_);
  }
  void accept(const Positions& better) {
    const Positions left = rhs_ - stiffness_times(better);
    ++iterations_;
    if (!(ordered_norm(left) < left_)) return;
    x_ = better, r_ = left;
    left_ = ordered_norm(left);
  }

  const Tangent& tangent_;
  const std::vector<Support>& supports_;
  const Positions& rhs_;
  VectorX own_;
  double goal_;
  Positions &x_, r_;
  double left_;
  int iterations_ = 0;
};

class Direct final : public LinearSolver {
 public:
  const char* name() const override { return "direct"; }

  LinearResult solve(const Tangent& tangent, const std::vector<Support>& supports, const Positions& rhs,
                     double tolerance, Positions& x) override {
    const double scale = stiffness_scale(tangent);
    Refinement refinement(tangent, supports, rhs, tolerance, scale, x);
    LinearResult result;
    const double size = ordered_norm(rhs);
    if (size == 0) return result;
    // A tiny shift lets the factorisation pass zero-energy modes; refinement with the true K takes its effect away
    // again.
    {
      const Factor factor(tangent, supports, sparse_stiffness(tangent, supports, 1e-9 * scale, scale));
      if (factor.usable()) {
        result.negative_modes = factor.negative_modes();
        refinement.refine(factor);
      }
    }
    // Where stiff and soft parts meet, that shift may be stiffer than what is soft.
    bool mode = false;
    if (!refinement.done()) {
      const Factor factor(tangent, supports, shifted_rows(tangent, supports, 1e-9, scale));
      if (factor.usable()) mode = refine_by_rows(factor, refinement, result);
    }
    result.iterations = refinement.iterations();
    result.residual = refinement.left() / size;
    if (mode && result.residual > std::max(tolerance, 1e-6)) {
      // A right-hand side in the range of K would have got there: what is left works on directions without stiffness.
      result.status = LinearStatus::zero_mode;
      x += refinement.residual() / scale;
    } else if (result.residual > tolerance) {
      result.status = LinearStatus::limit_reached;
      if (refinement.left() == size) x = rhs / scale;  // no factor served: downhill at least
    }
    if (result.negative_modes > 0 && result.status == LinearStatus::solved) result.status = LinearStatus::negative_mode;
    return result;
  }

 private:
  /// Whether what is left of the residual works on a direction without stiffness.
  static bool refine_by_rows(const Factor& factor, Refinement& refinement, LinearResult& result) {
    result.negative_modes = factor.negative_modes();
    Positions mode;
    if (result.negative_modes == 0) return refinement.conjugate(factor, mode);
    refinement.refine(factor);
    return !refinement.done() && refinement.is_without_stiffness(refinement.solved(factor, refinement.residual()));
  }
};

}  // namespace

double stiffness_scale(const Tangent& tangent) {
  const int n = tangent.model().body().size();
  const double sum = ordered_sum(
      n, [&](int i) { return std::abs(tangent.diagonal(i).trace()) / 3; }, 0., kMoleculeThreshold);
  return sum == 0 ? 1 : sum / n;
}

Eigen::SparseMatrix<double> sparse_stiffness(const Tangent& tangent, const std::vector<Support>& supports, double shift,
                                             double scale) {
  const int n = tangent.model().body().size();
  std::vector<const Support*> support_of(n, nullptr);
  for (const Support& support : supports) support_of[support.molecule] = &support;
  std::vector<BlockRow> columns(n);
  tangent.visit_blocks([&](int a, int b, const Matrix3& term) {
    if (a < b) return;
    Matrix3 block = term;
    if (support_of[a]) block = (support_of[a]->free * block).eval();
    if (support_of[b]) block = (block * support_of[b]->free).eval();
    columns[b].add(a, block);
  });
  Eigen::VectorXi counts(3 * n);
  for (int molecule = 0; molecule < n; ++molecule) {
    const Matrix3 free = support_of[molecule] ? support_of[molecule]->free : Matrix3::Identity();
    columns[molecule].add(molecule, shift * free + scale * (Matrix3::Identity() - free));
    counts.segment<3>(3 * molecule).setConstant(3 * static_cast<int>(columns[molecule].size()));
  }
  Eigen::SparseMatrix<double> matrix(3 * n, 3 * n);
  matrix.reserve(counts);
  for (int column = 0; column < 3 * n; ++column)
    for (const auto& [molecule, block] : columns[column / 3])
      for (int i = 0; i < 3; ++i)
        if (const int row = 3 * molecule + i; row >= column && block(i, column % 3) != 0)
          matrix.insert(row, column) = block(i, column % 3);
  matrix.makeCompressed();
  return matrix;
}

std::unique_ptr<LinearSolver> make_direct() { return std::make_unique<Direct>(); }

}  // namespace elastin
