#pragma once
#include "elastin/core/base/types.h"

namespace elastin {

/// A LocalElasticity that has the forces of one element in one go, without what add_blocks has for each molecule.
class ElementForces {
 public:
  virtual ~ElementForces() = default;
  /// Sets the force [N] of one element on each of its molecules, a column each.
  virtual void set_element_forces(const Positions& positions, int element, Eigen::Ref<Positions> forces) const = 0;
};

}  // namespace elastin
