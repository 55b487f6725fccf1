#pragma once
#include "elastin/lab/run/experiment.h"

namespace elastin::lab {

struct HomogenisationSetup {
  double grip_depth = 0;  ///< [m]: molecules this close to a side of a box without cells belong to its surface
};

/// The experiment `material`: the body's own 6×6 stiffness from six small strains of its surface, and what follows from
/// it. Every molecule of the surface follows a uniform strain, the others find their balance; the stress is the volume
/// mean that the surface forces give, Σ f xᵀ / V. Directions are the columns of `axes` (orthonormal). About the state
/// under the scene's own loads. Molecules within `grip_depth` [m] of a side of a box without cells belong to its
/// surface. Throws InputError if the body is neither of tetrahedra nor a box.
std::unique_ptr<StaticExperiment> make_homogenisation(const Body& body, const HomogenisationSetup& setup,
                                                      const Matrix3& axes);

}  // namespace elastin::lab
