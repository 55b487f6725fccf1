#pragma once
#include "elastin/model/body.h"

namespace elastin {

/// The only thing that changes during a run.
struct State {
  Positions positions;   ///< [m]
  Positions velocities;  ///< [m/s]
  double time = 0;       ///< [s]
  /// [m/s²], of the last step's end; empty before the first step. Integrators that need it go on from there.
  Positions accelerations = {};
};

/// The body at rest: its own places, no velocity, time 0.
inline State state_at_rest(const Body& body) { return {body.rest, Positions::Zero(3, body.size())}; }

}  // namespace elastin
