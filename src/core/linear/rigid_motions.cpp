#include "core/linear/rigid_motions.h"

#include <algorithm>
#include <cmath>

#include "core/base/dense.h"
#include "core/linear/sparse_stiffness.h"
#include "core/parallel/parallel.h"
#include "elastin/core/linear/linear_solver.h"

namespace elastin {

RigidMotions::RigidMotions(const Tangent& tangent, const std::vector<Support>& supports, Positions& motions,
                           Positions& forces) {
  const Positions& positions = tangent.positions();
  const int molecules = static_cast<int>(positions.cols());
  middle_ = ordered_sum<Vector3>(
                molecules, [&](int a) -> Vector3 { return positions.col(a); }, Vector3::Zero(), kMoleculeThreshold) /
            molecules;
  const double size = largest_of_ranges(
      molecules,
      [&](int begin, int end) {
        double most = 0;
        for (int a = begin; a < end; ++a) most = std::max(most, (positions.col(a) - middle_).squaredNorm());
        return most;
      },
      kMoleculeThreshold);
  per_size_ = size > 0 ? 1 / (2 * std::sqrt(size)) : 1;
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
    parallel_for(
        static_cast<int>(positions.cols()), [&](int i) { motions.col(i) = motion(candidate, positions.col(i)); },
        kMoleculeThreshold);
    tangent.apply(motions, forces);
    keep_free(supports, forces);
    if (ordered_norm(forces) > 1e-9 * stiffness * ordered_norm(motions)) continue;
    free_.conservativeResize(6, free_.cols() + 1);
    free_.rightCols(1) = candidate;
  }
  if (empty()) return;
  MatrixX products(free_.cols(), free_.cols());
  for (Eigen::Index i = 0; i < products.cols(); ++i) {
    const Six own = free_.col(i);
    parallel_for(
        static_cast<int>(positions.cols()), [&](int a) { motions.col(a) = motion(own, positions.col(a)); },
        kMoleculeThreshold);
    products.col(i) = products_with(positions, motions);
  }
  // Of molecules on a line the turn about it moves none: it is no motion to take out.
  inverse_ = symmetric_pseudoinverse(products);
}

/// Of the vectors v at places y, Σ v and Σ y × v say it all: (t + w × y) · v = t · v + w · (y × v).
VectorX RigidMotions::products_with(const Positions& positions, const Positions& vectors) const {
  const Six sums = ordered_sum_of_blocks<Six>(
      static_cast<int>(positions.cols()),
      [&](int begin, int end) {
        Six sum = Six::Zero();
        for (int a = begin; a < end; ++a) {
          const Vector3 v = vectors.col(a), y = place(positions.col(a));
          sum.head<3>() += v;
          sum.tail<3>() += y.cross(v);
        }
        return sum;
      },
      Six::Zero(), kMoleculeThreshold);
  return free_.transpose() * sums;
}

void RigidMotions::remove_from(const Positions& positions, Positions& motions) const {
  if (empty()) return;
  const Six whole = free_ * (inverse_ * products_with(positions, motions));
  parallel_for(
      static_cast<int>(positions.cols()), [&](int a) { motions.col(a) -= motion(whole, positions.col(a)); },
      kMoleculeThreshold);
}

double RigidMotions::part_of(const Positions& positions, const Positions& vectors) const {
  if (empty()) return 0;
  const VectorX products = products_with(positions, vectors);
  return std::sqrt(std::max(0., products.dot(inverse_ * products)));
}

}  // namespace elastin
