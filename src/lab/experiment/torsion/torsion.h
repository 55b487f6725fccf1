#pragma once
#include "lab/run/ends.h"

namespace elastin::lab {

/// A bar clamped at both ends, one of which is turned rigidly about the axis through its middle, at constant height.
struct TorsionSetup : GripSetup {
  Vector3 axis = Vector3::UnitZ();
  double angle = 0;       ///< [rad], of the whole load
  bool straight = false;  ///< small displacements: the end's displacements are those of an infinitesimal turn
  int load_steps = 1;
};

/// `thickness` [m] is that of a wall of triangles; 0: none is known. Throws InputError if the body does not suit.
std::unique_ptr<StaticExperiment> make_torsion(const Body& body, const TorsionSetup& setup, double thickness = 0);

}  // namespace elastin::lab
