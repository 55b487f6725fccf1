#include <cmath>

#include "core/linear/sparse_factor.h"
#include "core/linear/sparse_stiffness.h"
#include "elastin/core/base/dense.h"
#include "elastin/core/linear/linear_solver.h"

namespace elastin {
namespace {

/// K⁻¹ of a factorised sparse part A and the wide parts: K = A + G C Gᵀ, K⁻¹ = A⁻¹ − Z S⁻¹ Zᵀ, Z = A⁻¹ G, S = C⁻¹ +
/// Gᵀ Z. [Woodbury 1950]
class Factor {
 public:
  Factor(const Tangent& tangent, const std::vector<Support>& supports, double shift, double scale)
      : sparse_(sparse_stiffness(tangent, supports, shift, scale)) {
    if (!sparse_.usable()) return;
    negative_modes_ = sparse_.negative_pivots();
    const std::vector<WideTerm> parts = tangent.wide_terms();
    if (parts.empty()) return;
    const auto count = static_cast<Eigen::Index>(parts.size());
    wide_.resize(parts.front().direction.size(), count);
    MatrixX border = MatrixX::Zero(count, count);
    for (Eigen::Index i = 0; i < count; ++i) {
      Positions direction = parts[static_cast<std::size_t>(i)].direction;
      keep_free(supports, direction);
      wide_.col(i) = Eigen::Map<const VectorX>(direction.data(), direction.size());
      border(i, i) = 1 / parts[static_cast<std::size_t>(i)].factor;
    }
    const auto positive = [](const MatrixX& matrix) {
      return static_cast<int>((symmetric_eigenvalues(matrix).array() > 0).count());
    };
    const int before = positive(border);
    solved_.resize(wide_.rows(), count);
    for (Eigen::Index i = 0; i < count; ++i) solved_.col(i) = sparse_.solve(wide_.col(i));
    border += transposed_product(wide_, solved_);
    negative_modes_ += positive(border) - before;  // the inertia of the bordered matrix, counted in two ways
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

class Direct final : public LinearSolver {
 public:
  const char* name() const override { return "direct"; }

  LinearResult solve(const Tangent& tangent, const std::vector<Support>& supports, const Positions& rhs,
                     double tolerance, Positions& x) override {
    const int n = static_cast<int>(rhs.cols());
    x.setZero(3, n);
    LinearResult result;
    const double size = ordered_norm(rhs);
    if (size == 0) return result;
    // A tiny shift lets the factorisation pass zero-energy modes; refinement with the true K takes its effect away
    // again.
    const double scale = stiffness_scale(tangent), shift = 1e-9 * scale;
    const Factor factor(tangent, supports, shift, scale);
    if (!factor.usable()) {
      result.status = LinearStatus::zero_mode;
      x = rhs / scale;
      result.residual = 1;
      return result;
    }
    result.negative_modes = factor.negative_modes();
    Positions r = rhs, better = x, kx(3, n);
    double now = size;
    constexpr int limit = 30;
    for (bool progress = true; progress && now > tolerance * size && result.iterations < limit; ++result.iterations) {
      const VectorX correction = factor.solve(Eigen::Map<const VectorX>(r.data(), r.size()));
      better = x + Eigen::Map<const Positions>(correction.data(), 3, n);
      keep_free(supports, better);
      tangent.apply(better, kx);
      keep_free(supports, kx);
      const Positions left = rhs - kx;
      const double then = ordered_norm(left);
      progress = then < 0.5 * now;
      if (!(then < now)) continue;
      x = better;
      r = left;
      now = then;
    }
    result.residual = now / size;
    if (result.residual > std::max(tolerance, 1e-6)) {
      // A right-hand side in the range of K would have got there: what is left works on directions without stiffness.
      result.status = LinearStatus::zero_mode;
      x += r / scale;
    } else if (result.residual > tolerance) {
      result.status = LinearStatus::limit_reached;
    }
    if (result.negative_modes > 0 && result.status == LinearStatus::solved) result.status = LinearStatus::negative_mode;
    return result;
  }
};

}  // namespace

double stiffness_scale(const Tangent& tangent) {
  const int n = tangent.model().body().size();
  double sum = 0;
  for (int i = 0; i < n; ++i) sum += std::abs(tangent.diagonal(i).trace()) / 3;
  return sum == 0 ? 1 : sum / n;
}

Eigen::SparseMatrix<double> sparse_stiffness(const Tangent& tangent, const std::vector<Support>& supports, double shift,
                                             double scale) {
  const int n = tangent.model().body().size();
  std::vector<const Support*> support_of(n, nullptr);
  for (const Support& support : supports) support_of[support.molecule] = &support;
  std::vector<Eigen::Triplet<double>> entries;
  const auto add = [&](int a, int b, const Matrix3& block) {
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        if (block(i, j) != 0) entries.emplace_back(3 * a + i, 3 * b + j, block(i, j));
  };
  tangent.visit_blocks([&](int a, int b, const Matrix3& term) {
    Matrix3 block = term;
    if (support_of[a]) block = (support_of[a]->free * block).eval();
    if (support_of[b]) block = (block * support_of[b]->free).eval();
    add(a, b, block);
  });
  for (int molecule = 0; molecule < n; ++molecule) {
    const Matrix3 free = support_of[molecule] ? support_of[molecule]->free : Matrix3::Identity();
    add(molecule, molecule, shift * free + scale * (Matrix3::Identity() - free));
  }
  Eigen::SparseMatrix<double> matrix(3 * n, 3 * n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

std::unique_ptr<LinearSolver> make_direct() { return std::make_unique<Direct>(); }

}  // namespace elastin
