#pragma once
#include <functional>
#include <utility>

#include "core/parallel/large_memory.h"
#include "elastin/core/forces/elasticity.h"

namespace elastin {

/// The slopes of a law whose connections do not influence each other.
class OwnSlopes final : public EdgeSlopes {
 public:
  /// Adds the slope of each connection at these positions.
  using Add = std::function<void(const Positions& positions, VectorX& slopes)>;
  /// @param connections of the body; 0 where no slope differs from 0
  OwnSlopes(int connections, Add add) : connections_(connections), add_(std::move(add)) {}

  void linearise_at(const Positions& positions) override {
    set_zero(slopes_, connections_);
    add_(positions, slopes_);
  }
  void add_own_slopes(VectorX& slopes) const override {
    if (connections_ > 0) slopes += slopes_;
  }

 private:
  int connections_;
  Add add_;
  VectorX slopes_;
};

}  // namespace elastin
