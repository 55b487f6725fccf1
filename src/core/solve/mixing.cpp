#include "core/solve/mixing.h"

#include <algorithm>
#include <cmath>

#include "elastin/core/linear/linear_solver.h"

namespace elastin {
namespace {

/// Puts the x of A x = b in b's place, of the first `count` rows of a positive definite A, whose lower half is lost
/// [Cholesky]; false if A is not positive definite. Eigen's own of this size takes seconds to compile, and one of any
/// size allocates memory.
template <class Matrix, class Vector>
bool solve_positive(Matrix& A, Vector& b, int count) {
  for (int j = 0; j < count; ++j) {
    for (int i = j; i < count; ++i)
      for (int k = 0; k < j; ++k) A(i, j) -= A(i, k) * A(j, k);
    if (!(A(j, j) > 0)) return false;
    const double root = std::sqrt(A(j, j));
    for (int i = j; i < count; ++i) A(i, j) /= root;
    for (int k = 0; k < j; ++k) b[j] -= A(j, k) * b[k];
    b[j] /= A(j, j);
  }
  for (int j = count - 1; j >= 0; --j) {
    for (int i = j + 1; i < count; ++i) b[j] -= A(i, j) * b[i];
    b[j] /= A(j, j);
  }
  return true;
}

}  // namespace

void Mixing::begin(Eigen::Index molecules) {
  used_ = 0, known_ = false;
  for (Past& past : pasts_) past.end.resize(3, molecules), past.motion.resize(3, molecules);
  last_from_.resize(3, molecules), last_motion_.resize(3, molecules);
}

bool Mixing::mix(const Positions& from, Positions& motion) {
  if (pasts_.empty()) return false;
  if (known_) {
    Past& past = pasts_[static_cast<std::size_t>(used_++) % pasts_.size()];
    past.motion = motion - last_motion_;
    past.end = (from - last_from_) + past.motion;
  }
  last_from_ = from, last_motion_ = motion, known_ = true;
  const int count = std::min(used_, static_cast<int>(pasts_.size()));
  if (count == 0) return false;
  Eigen::Matrix<double, kMost, kMost> products;
  Eigen::Matrix<double, kMost, 1> shares;
  for (int i = 0; i < count; ++i) {
    const Positions& own = pasts_[i].motion;
    for (int j = 0; j <= i; ++j) products(i, j) = ordered_dot(own, pasts_[j].motion);
    products(i, i) *= 1 + 1e-12;
    shares[i] = ordered_dot(own, motion);
  }
  if (!solve_positive(products, shares, count)) return false;
  for (int i = 0; i < count; ++i) motion -= shares[i] * pasts_[i].end;
  return true;
}

}  // namespace elastin
