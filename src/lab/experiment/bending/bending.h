#pragma once
#include "lab/run/ends.h"

namespace elastin::lab {

/// A cantilever: clamped at its root, bent by its own weight, by a force on its tip, or both.
struct BendingSetup : GripSetup {
  Vector3 axis = Vector3::UnitX();        ///< from the root to the tip
  Vector3 direction = -Vector3::UnitZ();  ///< of the load, perpendicular to the axis
  double gravity = 0;                     ///< [m/s²]
  double force = 0;                       ///< [N] on the tip, shared by area
  int load_steps = 1;
};

/// The tip is read at the middle of the end face: the molecule that sits there, else the mean of those nearest to it.
/// The effective modulus is that of the Timoshenko beam that sinks as far under the same weights and force, with
/// Cowper's shear coefficient of a rectangle for the material's ν; not measured where the tip sinks by more than a
/// tenth of the length, and the remark says so. Throws InputError if the body does not suit.
std::unique_ptr<StaticExperiment> make_bending(const Body& body, const BendingSetup& setup, const Material& material);

}  // namespace elastin::lab
