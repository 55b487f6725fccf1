#pragma once
#include "lab/run/ends.h"

namespace elastin::lab {

enum class Sides { free, affine };  ///< what bounds the body between its ends: nothing, or the affine motion itself

/// Simple shear: planes across `axis` slide along `direction`, at constant height.
struct ShearSetup : GripSetup {
  Vector3 axis = Vector3::UnitZ(), direction = Vector3::UnitX();  ///< unit, perpendicular
  double displacement = 0;                                        ///< [m] of the loaded end; 0 = by strain
  double strain = 0;  ///< displacement over height, tan of the angle; used where there is no displacement
  double angle = 0;   ///< [rad] whose tan is the strain, where that is given so
  Sides sides = Sides::free;
  double cross_section = 0;  ///< [m²]; 0 = that of the cells, see find_section
  double thickness = 0;      ///< [m] of the body's triangles; 0 = they have no volume
  int load_steps = 1;
};

/// Free sides: both ends clamped to rigid plates, stress = force / cross-section. Affine sides: every molecule of the
/// body's surface follows the simple shear, stress = volume mean: exactly that of the law in a homogeneous body.
/// `axes` are those of a box without cells. Throws InputError if the body does not suit.
std::unique_ptr<StaticExperiment> make_shear(const Body& body, const ShearSetup& setup, const Matrix3& axes);

}  // namespace elastin::lab
