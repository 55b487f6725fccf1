#pragma once
#include <optional>
#include <vector>

#include "elastin/lab/run/experiment.h"
#include "lab/experiment/tension/tension.h"

namespace elastin::lab {

/// A part of the body, or its near end, moved without a turn onto what lies before it; the far one stays.
struct PressSetup {
  Vector3 axis = -Vector3::UnitZ();  ///< the way, unit
  /// Molecules, ascending; none given: those of the near, of the far end.
  std::optional<std::vector<int>> moved, fixed;
  std::optional<double> displacement;  ///< [m], > 0
  std::optional<double> force;         ///< or until this resists [N], > 0
  Grip grip = Grip::clamped;           ///< of both, across the axis
  double grip_depth = 0;
  int load_steps = 1;
};

/// Throws InputError on a setup that does not suit the body.
std::unique_ptr<StaticExperiment> make_press(const Body& body, const PressSetup& setup);

const MeasureList& press_measures();

}  // namespace elastin::lab
