#pragma once
#include <string>

#include "elastin/contact/contact.h"
#include "elastin/lab/run/experiment.h"

namespace elastin::lab {

enum class SlidingKind {
  incline,    ///< on a slope: does it stay, and how does it go if not
  sled,       ///< thrown along a level floor: how it is slowed down
  threshold,  ///< on a slope that is tilted slowly: when it begins to go
};

/// A body on a plane.
struct SlidingSetup {
  SlidingKind kind = SlidingKind::incline;
  Vector3 up = Vector3::UnitZ();     ///< across the plane, unit
  Vector3 along = Vector3::UnitX();  ///< down the slope, unit, across `up`
  double gravity = 9.81;             ///< [m/s²], > 0
  double angle = 0;                  ///< of the slope; of a threshold, at time 0
  double rate = 0;                   ///< of a threshold [1/s], > 0
  double speed = 0;                  ///< of a sled at time 0 [m/s]
  std::string floor;                 ///< the obstacle it stands on; empty: a plane of its own under the body
};

/// Gravity tilts, the plane stays. The run begins where the body stands in equilibrium; on a slope too steep for that,
/// where it would stand on level ground. Adds its plane to the obstacles, just so deep in the body that this begins
/// with contact. Throws InputError if there is no such obstacle.
std::unique_ptr<TimedExperiment> make_sliding(const Body& body, const SlidingSetup& setup,
                                              contact::ContactOptions& contact);

const MeasureList& sliding_measures();

}  // namespace elastin::lab
