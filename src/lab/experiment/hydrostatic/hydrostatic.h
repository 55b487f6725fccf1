#pragma once
#include "elastin/lab/run/experiment.h"

namespace elastin::lab {

enum class Walls { sliding, affine };  ///< on six smooth walls, or every molecule of the surface follows the motion

/// Equal strain along all directions.
struct HydrostaticSetup {
  double strain = 0;  ///< of each side, > −1; negative = compression
  Walls walls = Walls::sliding;
  double grip_depth = 0;  ///< [m]: molecules this close to a side belong to it
  int load_steps = 1;
};

/// Sliding walls need a box with sides along `axes` (orthonormal columns). Throws InputError if the body does not suit.
std::unique_ptr<StaticExperiment> make_hydrostatic(const Body& body, const HydrostaticSetup& setup,
                                                   const Matrix3& axes);

}  // namespace elastin::lab
