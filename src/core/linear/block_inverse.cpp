#include "core/linear/block_inverse.h"

#include "core/base/dense.h"
#include "core/linear/sparse_stiffness.h"
#include "core/parallel/parallel.h"

namespace elastin {

Matrix3 positive_inverse(const Matrix3& block) {
  // Nearly all blocks are well-conditioned and positive, and then minors say so and give the inverse.
  const double xx = block(0, 0), yy = block(1, 1), zz = block(2, 2), xy = block(0, 1), xz = block(0, 2),
               yz = block(1, 2);
  const double first = yy * zz - yz * yz, second = xx * yy - xy * xy, third = xx * zz - xz * xz;
  const double xy_minor = xz * yz - xy * zz, xz_minor = xy * yz - xz * yy, yz_minor = xy * xz - xx * yz;
  const double determinant = xx * first + xy * xy_minor + xz * xz_minor, size = xx + yy + zz;
  if (xx > 0 && second > 0 && determinant > 1e-4 * size * size * size) {
    Matrix3 inverse;
    inverse << first, xy_minor, xz_minor, xy_minor, third, yz_minor, xz_minor, yz_minor, second;
    return inverse / determinant;
  }
  const SymmetricEigen3 eigen = symmetric_eigen3(block);
  const Vector3 values = eigen.values.cwiseAbs();
  const double threshold = 1e-10 * values.maxCoeff();
  const Vector3 inverse = (values.array() > threshold).select(values.cwiseInverse(), 0);
  return eigen.vectors * inverse.asDiagonal() * eigen.vectors.transpose();
}

Matrix3 positive_inverse(const Matrix3& block, const Matrix3& free) {
  // What a slanted support leaves where the block resists in none of its free directions. As a stiffness it would move
  // a molecule where that is held: a corner of a flat sheet, both of whose sides are pulled.
  constexpr double rounding = 1e-13;
  const Matrix3 left = free * block * free;
  return left.cwiseAbs().maxCoeff() > rounding * block.cwiseAbs().maxCoeff() ? positive_inverse(left)
                                                                             : Matrix3(Matrix3::Zero());
}

template <class BlockOf>
void BlockInverses::set(double scale, int count, BlockOf&& block_of, const std::vector<Support>& supports) {
  flexibility_ = 1 / scale;
  blocks_.resize(count);
  const auto set = [&](int molecule, const Matrix3& flexibility) {
    const Eigen::Matrix3f inverse = (flexibility / flexibility_).cast<float>();
    blocks_[molecule] = {inverse(0, 0), inverse(0, 1), inverse(0, 2), inverse(1, 1), inverse(1, 2), inverse(2, 2)};
  };
  parallel_for(
      count, [&](int molecule) { set(molecule, positive_inverse(block_of(molecule))); }, kMoleculeThreshold);
  for (const Support& support : supports)
    set(support.molecule, positive_inverse(block_of(support.molecule), support.free));
}

void BlockInverses::compute(const Tangent& tangent, const std::vector<Support>& supports) {
  set(
      stiffness_scale(tangent), tangent.model().body().size(), [&](int a) { return tangent.diagonal(a); }, supports);
}

void BlockInverses::compute(double scale, const std::vector<Matrix3>& blocks, const std::vector<Support>& supports) {
  set(
      scale, static_cast<int>(blocks.size()), [&](int a) { return blocks[a]; }, supports);
}

}  // namespace elastin
