#include "core/linear/rigid_motions.h"

#include "core/linear/sparse_stiffness.h"
#include "core/parallel/parallel.h"
#include "elastin/core/base/dense.h"
#include "elastin/core/linear/linear_solver.h"

namespace elastin {

RigidMotions::RigidMotions(const Tangent& tangent, const std::vector<Support>& supports, Positions& motions,
                           Positions& forces) {
  const Positions& positions = tangent.positions();
  middle_ = positions.rowwise().mean();
  size_ = (positions.rowwise().maxCoeff() - positions.rowwise().minCoeff()).norm();
  if (!(size_ > 0)) size_ = 1;
  // First what no support minds, then what of that no force minds either.
  Eigen::Matrix<double, 6, 6> held = Eigen::Matrix<double, 6, 6>::Zero();
  for (const Support& support : supports) {
    Eigen::Matrix<double, 3, 6> part;
    for (int k = 0; k < 6; ++k) part.col(k) = motion(Six::Unit(k), positions.col(support.molecule));
    part -= (support.free * part).eval();
    held += part.transpose() * part;
  }
  const SymmetricEigen eigen = symmetric_eigen(held);
  free_.resize(6, 0);
  const double stiffness = stiffness_scale(tangent);
  motions.resize(3, positions.cols()), forces.resize(3, positions.cols());
  for (int k = 0; k < 6; ++k) {
    if (eigen.values[k] > 1e-12 * std::max<double>(1, static_cast<double>(supports.size()))) continue;
    const Six candidate = eigen.vectors.col(k);
    parallel_for(static_cast<int>(positions.cols()),
                 [&](int i) { motions.col(i) = motion(candidate, positions.col(i)); });
    tangent.apply(motions, forces);
    keep_free(supports, forces);
    if (ordered_norm(forces) > 1e-9 * stiffness * ordered_norm(motions)) continue;
    free_.conservativeResize(6, free_.cols() + 1);
    free_.rightCols(1) = candidate;
  }
}

void RigidMotions::remove_from(const Positions& positions, Positions& motions) const {
  if (empty()) return;
  const auto count = free_.cols();
  MatrixX products = MatrixX::Zero(count, count);
  VectorX parts = VectorX::Zero(count);
  const int n = static_cast<int>(positions.cols());
  for (Eigen::Index i = 0; i < count; ++i) {
    const Six own = free_.col(i);
    parts[i] = ordered_sum(n, [&](int a) { return motion(own, positions.col(a)).dot(motions.col(a)); });
    for (Eigen::Index j = 0; j <= i; ++j) {
      const Six other = free_.col(j);
      products(i, j) = products(j, i) =
          ordered_sum(n, [&](int a) { return motion(own, positions.col(a)).dot(motion(other, positions.col(a))); });
    }
  }
  // Of molecules on a line the turn about it moves none: it is no motion to take out.
  const Six whole = free_ * (symmetric_pseudoinverse(products) * parts);
  parallel_for(n, [&](int a) { motions.col(a) -= motion(whole, positions.col(a)); });
}

}  // namespace elastin
