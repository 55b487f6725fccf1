#pragma once
#include <vector>

#include "core/base/dense.h"
#include "elastin/core/forces/tangent.h"

namespace elastin {

/// The motions as a whole that supports and forces leave to a body: up to three translations and three rotations.
class RigidMotions {
 public:
  /// `motions` and `forces` are room that the caller has no other use for yet.
  RigidMotions(const Tangent& tangent, const std::vector<Support>& supports, Positions& motions, Positions& forces);
  bool empty() const { return free_.cols() == 0; }
  /// Takes them out of the motions [m] of things at these positions [m], both 3 × n.
  void remove_from(const Positions& positions, Positions& motions) const;
  /// Size of what that would take out of vectors.
  double part_of(const Positions& positions, const Positions& vectors) const;

 private:
  using Six = Eigen::Matrix<double, 6, 1>;
  Vector3 motion(const Six& translation_and_rotation, const Vector3& position) const {
    return translation_and_rotation.head<3>() + translation_and_rotation.tail<3>().cross(place(position));
  }
  /// From the middle, in units of the body's size.
  Vector3 place(const Vector3& position) const { return (position - middle_) * per_size_; }
  VectorX products_with(const Positions& positions, const Positions& vectors) const;
  Vector3 middle_;
  double per_size_;  ///< [1/m]
  Eigen::Matrix<double, 6, Eigen::Dynamic> free_;
  MatrixX inverse_;  ///< pseudo-inverse of the products of each with each
};

}  // namespace elastin
