#pragma once
#include "elastin/lab/run/experiment.h"

namespace elastin::lab {

/// A canopy with a load on cables that falls through air: how it opens. The air is a load of the scene.
struct ParachuteSetup {
  Vector3 direction = -Vector3::UnitZ();  ///< down
  double gravity = 9.81;                  ///< [m/s²], ≥ 0
  double speed = 0;                       ///< [m/s] down at time 0
};
/// Throws InputError for a body without cables.
std::unique_ptr<TimedExperiment> make_parachute(const Body& body, const ParachuteSetup& setup);

}  // namespace elastin::lab
