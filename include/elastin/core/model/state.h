#pragma once
#include <array>
#include <vector>

#include "elastin/core/model/body.h"

namespace elastin {

/// What contact remembers of a place on the body that touches: where on the target it sticks, and how hard it was held
/// back beyond its penalty. Sorted by (sample, target).
struct ContactHistory {
  int sample = 0, target = 0;
  /// The anchor: offset + Σ weight · molecule of the target; on an obstacle (count 0) the offset is in its own frame.
  std::array<int, 3> molecules{-1, -1, -1};
  std::array<double, 3> weights{0, 0, 0};
  int count = 0;
  Vector3 offset = Vector3::Zero();  ///< [m]
  double multiplier = 0;             ///< [N]
};

/// The only thing that changes during a run.
struct State {
  Positions positions;   ///< [m]
  Positions velocities;  ///< [m/s]
  double time = 0;       ///< [s]
  /// [m/s²], of the last step's end; empty before the first step. Integrators that need it go on from there.
  Positions accelerations = {};
  std::vector<ContactHistory> contact_history = {};  ///< of the last state that was reached; empty without contact
};

/// The body at rest: its own positions, no velocity, time 0.
inline State state_at_rest(const Body& body) { return {body.rest, Positions::Zero(3, body.size())}; }

}  // namespace elastin
