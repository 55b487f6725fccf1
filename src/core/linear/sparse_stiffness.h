#pragma once
#include <Eigen/SparseCore>
#include <vector>

#include "elastin/core/forces/tangent.h"

namespace elastin {

/// K on the free directions, `scale` [N/m] on the fixed ones (so that it is as regular as the supported body is), plus
/// `shift` [N/m] on every free direction. Shape 3n × 3n, the lower half.
Eigen::SparseMatrix<double> sparse_stiffness(const Tangent& tangent, const std::vector<Support>& supports, double shift,
                                             double scale);

/// Mean diagonal entry of K over the molecules [N/m], by size: the scale against which a stiffness is zero.
double stiffness_scale(const Tangent& tangent);

}  // namespace elastin
