#pragma once
#include <vector>

#include "core/forces/tangent.h"

namespace elastin {

/// The motions as a whole that supports and forces leave to a body: up to three ways and three turns.
class RigidMotions {
 public:
  RigidMotions(const Tangent& tangent, const std::vector<Support>& supports);
  bool empty() const { return free_.cols() == 0; }
  /// Takes them out of the motions [m] of things at these places [m], both 3 × n.
  void remove_from(const Positions& places, Positions& motions) const;

 private:
  using Six = Eigen::Matrix<double, 6, 1>;
  Vector3 motion(const Six& way_and_turn, const Vector3& place) const {
    return way_and_turn.head<3>() + way_and_turn.tail<3>().cross(Vector3((place - middle_) / size_));
  }
  Vector3 middle_;
  double size_;
  Eigen::Matrix<double, 6, Eigen::Dynamic> free_;
};

}  // namespace elastin
