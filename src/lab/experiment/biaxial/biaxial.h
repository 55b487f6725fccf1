#pragma once
#include "elastin/lab/run/experiment.h"

namespace elastin::lab {

/// A block or sheet stretched along two directions at once between smooth plane grips, free along the third.
struct BiaxialSetup {
  Vector3 first = Vector3::UnitX(), second = Vector3::UnitY();  ///< unit, perpendicular
  double first_strain = 0, second_strain = 0;  ///< nominal, of the distance of opposite end layers, > −1; 0 = kept
  double thickness = 0;                        ///< [m] of the body's triangles; 0 = they have no volume
  double grip_depth = 0;                       ///< [m]: see TensionSetup
  int load_steps = 1;
};

/// Equibiaxial tension where both strains are one, planar tension (pure shear) where the second is 0. E and ν are those
/// of a linear isotropic material that shows the same: with σ₃ = 0
///     ν = −ε₃ / (ε₁ + ε₂ − ε₃),  E = σ₁ (1 − ν²) / (ε₁ + ν ε₂).              [Timoshenko & Goodier 1970, section 6]
/// Throws InputError where the body has no opposite ends along the two directions.
std::unique_ptr<StaticExperiment> make_biaxial(const Body& body, const BiaxialSetup& setup, const std::string& name);

const MeasureList& biaxial_measures();

}  // namespace elastin::lab
