#include "elastin/core/base/dense.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>

namespace elastin {

SymmetricEigen symmetric_eigen(const MatrixX& matrix) {
  const Eigen::SelfAdjointEigenSolver<MatrixX> solved(matrix);
  return {solved.eigenvalues(), solved.eigenvectors()};
}

SymmetricEigen3 symmetric_eigen3(const Matrix3& matrix) {
  const Eigen::SelfAdjointEigenSolver<Matrix3> solved(matrix);
  return {solved.eigenvalues(), solved.eigenvectors()};
}

VectorX symmetric_eigenvalues(const MatrixX& matrix) {
  return Eigen::SelfAdjointEigenSolver<MatrixX>(matrix, Eigen::EigenvaluesOnly).eigenvalues();
}

Vector3 symmetric_eigenvalues3(const Matrix3& matrix) {
  return Eigen::SelfAdjointEigenSolver<Matrix3>(matrix, Eigen::EigenvaluesOnly).eigenvalues();
}

MatrixX product(const MatrixX& left, const MatrixX& right) { return left * right; }
MatrixX transposed_product(const MatrixX& left, const MatrixX& right) { return left.transpose() * right; }

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
