#pragma once
#include <array>
#include <vector>

#include "elastin/core/forces/tangent.h"

namespace elastin {

/// Inverse of a symmetric block on the directions where it has stiffness, zero on the others. Blocks of negative
/// stiffness are taken by size, which keeps a preconditioner positive.
Matrix3 positive_inverse(const Matrix3& block);
/// That of what a support leaves free of it, a projector.
Matrix3 positive_inverse(const Matrix3& block, const Matrix3& free);

/// The inverse of each molecule's own block in its free directions, in single precision, to precondition with.
class BlockInverses {
 public:
  /// Allocates nothing where the body had as many molecules before.
  void compute(const Tangent& tangent, const std::vector<Support>& supports);
  /// Of other blocks than a tangent's own; `scale` is their size [N/m].
  void compute(double scale, const std::vector<Matrix3>& blocks, const std::vector<Support>& supports);
  int size() const { return static_cast<int>(blocks_.size()); }
  /// Of a force [N]; [m].
  [[gnu::always_inline]] Vector3 times(int molecule, const Vector3& force) const {
    const auto& [xx, xy, xz, yy, yz, zz] = blocks_[molecule];
    const Vector3 f = flexibility_ * force;
    return {xx * f.x() + xy * f.y() + xz * f.z(), xy * f.x() + yy * f.y() + yz * f.z(),
            xz * f.x() + yz * f.y() + zz * f.z()};
  }

 private:
  template <class BlockOf>
  void set(double scale, int count, BlockOf&& block_of, const std::vector<Support>& supports);
  double flexibility_ = 0;  ///< of the body's blocks in the mean [m/N]: what is kept is in parts of it
  std::vector<std::array<float, 6>> blocks_;  ///< xx xy xz yy yz zz
};

}  // namespace elastin
