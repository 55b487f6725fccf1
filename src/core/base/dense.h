#pragma once
#include <span>

#include "elastin/core/base/types.h"

/// Decompositions and products of small dense matrices, each compiled once: Eigen's templates take seconds for every
/// type and size that a source file uses.
namespace elastin {

using MatrixX = Eigen::MatrixXd;

/// What a symmetric matrix stretches: ascending eigenvalues, and a column of `vectors`, of length 1, for each.
struct SymmetricEigen {
  VectorX values;
  MatrixX vectors;
};
struct SymmetricEigen3 {
  Vector3 values;
  Matrix3 vectors;
};
/// Of a symmetric matrix; only its lower triangle is read.
SymmetricEigen symmetric_eigen(const MatrixX& matrix);
SymmetricEigen3 symmetric_eigen3(const Matrix3& matrix);
VectorX symmetric_eigenvalues(const MatrixX& matrix);
Vector3 symmetric_eigenvalues3(const Matrix3& matrix);

MatrixX product(const MatrixX& left, const MatrixX& right);
MatrixX transposed_product(const MatrixX& left, const MatrixX& right);  ///< leftᵀ right

/// Sets y = factor · A x, of 24 rows and columns, A by columns: what the 8 nodes of a hexahedron feel by their motion.
void multiply24(const double* A, const double* x, double factor, double* y);
/// The ways to do it that this machine has, the plain one first, multiply24's last: the same bits by any.
using Multiply24 = void (*)(const double* A, const double* x, double factor, double* y);
std::span<const Multiply24> ways_to_multiply24();

/// Of a regular square matrix.
MatrixX inverse(const MatrixX& matrix);
/// The x of least |A x − b|, by QR with pivoting.
VectorX least_squares(const MatrixX& A, const VectorX& b);
/// A⁺ of a symmetric matrix: of the x that make |A x − b| least, A⁺ b is the shortest.
MatrixX symmetric_pseudoinverse(const MatrixX& matrix);

/// The rotation by the least angle that turns one direction into the other.
Matrix3 rotation_between(const Vector3& from, const Vector3& to);

}  // namespace elastin
