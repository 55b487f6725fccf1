#include "core/base/dense.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace elastin {

SymmetricEigen symmetric_eigen(const MatrixX& matrix) {
  const Eigen::SelfAdjointEigenSolver<MatrixX> solved(matrix);
  return {solved.eigenvalues(), solved.eigenvectors()};
}

/// In closed form but for a root: with D = (A − m I)/p, m = tr A/3 and D:D = 6, its eigenvalues are 2t of
/// 8t³ − 6t = det D, t = cos. The one of largest size has a distance of at least √3 from both others, so that Newton's
/// method and the cross product of two rows find it and its vector to rounding; the other two are those of a 2 × 2
/// matrix across it, by one rotation. An eigenvalue's error is some roundings of |D| p, whatever the distances.
/// [Smith 1961; Eberly 2014]
SymmetricEigen3 symmetric_eigen3(const Matrix3& matrix) {
  const double mean = matrix.trace() / 3;
  Matrix3 D = matrix.selfadjointView<Eigen::Lower>();
  D.diagonal().array() -= mean;
  const double largest = D.cwiseAbs().maxCoeff();
  if (!(largest > std::numeric_limits<double>::min())) return {Vector3::Constant(mean), Matrix3::Identity()};
  D /= largest;
  const double p = std::sqrt(D.squaredNorm() / 6);
  D /= p;
  const double half = std::clamp(D.determinant() / 2, -1., 1.), sign = half < 0 ? -1 : 1, r = std::abs(half);
  // 4t³ − 3t = r on [cos 30°, 1]: the cubic is within 4e-5 of t, Newton's method within 3e-9 and then 1e-16.
  double t = 0.8660663295 + r * (0.1653303502 + r * (0.0093196839 * r - 0.0406911974));
  for (int step = 0; step < 2; ++step) t -= (t * (4 * t * t - 3) - r) / (12 * t * t - 3);

  Matrix3 shifted = D;
  shifted.diagonal().array() -= 2 * sign * t;
  const Vector3 products[3] = {Vector3(shifted.col(0)).cross(shifted.col(1)),
                               Vector3(shifted.col(1)).cross(shifted.col(2)),
                               Vector3(shifted.col(2)).cross(shifted.col(0))};
  Vector3 alone = products[0];
  for (const Vector3& other : products)
    if (other.squaredNorm() > alone.squaredNorm()) alone = other;
  alone.normalize();
  const Vector3 first = alone.unitOrthogonal(), second = alone.cross(first), of_first = D * first,
                of_second = D * second;
  const double a = first.dot(of_first), b = first.dot(of_second), c = second.dot(of_second);
  // The rotation by half the angle of (a − c, 2b) makes b zero.
  const double x = (a - c) / 2, size = std::sqrt(x * x + b * b), middle = (a + c) / 2;
  double cosine = 1, sine = 0;
  if (size > 0) {
    const double larger = std::sqrt((1 + std::abs(x) / size) / 2), smaller = b / (2 * size * larger);
    cosine = x >= 0 ? larger : smaller, sine = x >= 0 ? smaller : larger;
  }
  SymmetricEigen3 result;
  const double own = alone.dot(D * alone);
  const int at = sign > 0 ? 2 : 0, low = sign > 0 ? 0 : 1, high = low + 1;
  result.values[at] = mean + largest * p * own;
  result.values[low] = mean + largest * p * (middle - size);
  result.values[high] = mean + largest * p * (middle + size);
  result.vectors.col(at) = alone;
  result.vectors.col(high) = cosine * first + sine * second;
  result.vectors.col(low) = cosine * second - sine * first;
  return result;
}

VectorX symmetric_eigenvalues(const MatrixX& matrix) {
  return Eigen::SelfAdjointEigenSolver<MatrixX>(matrix, Eigen::EigenvaluesOnly).eigenvalues();
}

Vector3 symmetric_eigenvalues3(const Matrix3& matrix) {
  return Eigen::SelfAdjointEigenSolver<Matrix3>(matrix, Eigen::EigenvaluesOnly).eigenvalues();
}

MatrixX product(const MatrixX& left, const MatrixX& right) { return left * right; }
MatrixX transposed_product(const MatrixX& left, const MatrixX& right) { return left.transpose() * right; }

namespace {

/// The sums of all rows stay in registers; a row's terms are added in the order of the columns.
[[gnu::always_inline]] inline void by_columns(const double* A, const double* x, double factor, double* y) {
  using Four [[gnu::vector_size(32), gnu::aligned(8), gnu::may_alias]] = double;
  const Four* column = reinterpret_cast<const Four*>(A);  // of `auto` g++ would forget the alignment
  Four sums[6];
  for (int k = 0; k < 6; ++k) sums[k] = column[k] * x[0];
  for (int j = 1; j < 24; ++j) {
    column += 6;
    for (int k = 0; k < 6; ++k) sums[k] += column[k] * x[j];
  }
  for (int k = 0; k < 6; ++k) reinterpret_cast<Four*>(y)[k] = factor * sums[k];
}

void multiply24_plain(const double* A, const double* x, double factor, double* y) { by_columns(A, x, factor, y); }
#if defined(__x86_64__) && defined(__GNUC__)
[[gnu::target("avx2")]] void multiply24_avx2(const double* A, const double* x, double factor, double* y) {
  by_columns(A, x, factor, y);
}
#endif

}  // namespace

std::span<const Multiply24> ways_to_multiply24() {
  static constexpr std::array all {
    multiply24_plain,
#if defined(__x86_64__) && defined(__GNUC__)
        multiply24_avx2
#endif
  };
#if defined(__x86_64__) && defined(__GNUC__)
  if (!__builtin_cpu_supports("avx2")) return {all.data(), 1};
#endif
  return all;
}

void multiply24(const double* A, const double* x, double factor, double* y) {
  static const Multiply24 best = ways_to_multiply24().back();
  best(A, x, factor, y);
}

MatrixX inverse(const MatrixX& matrix) { return matrix.inverse(); }
VectorX least_squares(const MatrixX& A, const VectorX& b) { return A.colPivHouseholderQr().solve(b); }

MatrixX symmetric_pseudoinverse(const MatrixX& matrix) {
  const SymmetricEigen eigen = symmetric_eigen(matrix);
  const double threshold = 1e-13 * eigen.values.cwiseAbs().maxCoeff();
  MatrixX scaled = eigen.vectors;
  for (Eigen::Index i = 0; i < scaled.cols(); ++i)
    scaled.col(i) *= std::abs(eigen.values[i]) > threshold ? 1 / eigen.values[i] : 0;
  return product(scaled, eigen.vectors.transpose());
}

Matrix3 rotation_between(const Vector3& from, const Vector3& to) {
  const Vector3 a = from.normalized(), b = to.normalized();
  // Half a turn about one direction, then about the one half way to the other; between opposite ones any will do.
  const Vector3 sum = a + b, middle = sum.norm() > 1e-8 ? sum.normalized() : a.unitOrthogonal();
  const auto half_turn = [](const Vector3& axis) -> Matrix3 {
    return 2 * axis * axis.transpose() - Matrix3::Identity();
  };
  return half_turn(middle) * half_turn(a);
}

}  // namespace elastin
