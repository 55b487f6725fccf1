#pragma once

namespace elastin {

/// Damping that grows with the stiffness of the model's laws, as that by their stiffness at rest does.
class GrowsWithStiffness {
 public:
  GrowsWithStiffness() = default;
  virtual ~GrowsWithStiffness() = default;
};

}  // namespace elastin
