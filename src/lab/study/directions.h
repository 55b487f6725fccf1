#pragma once
#include "lab/report/directions.h"
#include "lab/scene/scene.h"

namespace elastin::lab {

/// No larger body is measured in every direction: that takes six linear solves a strategy.
inline constexpr int kMostMeasuredMolecules = 20000;

/// Measures a strategy, calibrated as in the scene's own experiment, by six small strains of the body's surface at rest
/// (see make_homogenisation), without the scene's loads; where that is the scene's experiment, `run` has measured it.
/// The scene's body must be prepared for it. Says why where that has no meaning: no solid, or no one isotropic
/// material.
DirectionErrors measure_directions(const Scene& scene, const StrategyChoice& choice, const RunOptions& options,
                                   const Run& run);

}  // namespace elastin::lab
