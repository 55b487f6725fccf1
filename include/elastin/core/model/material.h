#pragma once
#include <optional>

#include "elastin/core/base/types.h"
#include "elastin/core/model/law_constants.h"
#include "elastin/core/model/stress_strain.h"

namespace elastin {

/// Fibres of one direction in a matrix: they add ψ to its energy density, ψ′ their nominal stress [Pa] per rest section
/// of the whole, over their own nominal strain. At small strain: E_f a a a a added to the stiffness.
struct Fibre {
  Vector3 direction = Vector3::UnitZ();  ///< a at rest, unit
  StressStrain curve;
};

/// What the body should behave like. A strategy turns it into the stiffness of each connection.
struct Material {
  double youngs_modulus = 0;     ///< E [Pa], > 0; the curve's modulus at no strain, where there is a curve
  double poissons_ratio = 0.25;  ///< ν, −1 < ν < ½. Springs alone give ¼ in an isotropic body, whatever is asked.
  double density = 1000;         ///< ρ [kg/m³], > 0
  double thickness = 0;          ///< t [m] of a membrane; only triangles use it
  /// D [N m] of a sheet that has a bending stiffness; 0 = no bending stiffness. A plate has E t³/(12 (1−ν²)).
  double bending_rigidity = 0;
  std::optional<StressStrain> curve = {};  ///< of the material in uniaxial stress, without its fibres; none = straight
  std::optional<Fibre> fibre = {};
  /// Of one law; E and ν above are then those that the law has at rest, and other strategies take these (see with_law).
  std::optional<LawConstants> law = {};
};

/// Turns what has a direction at rest: fibres, and a law's.
void rotate(Material& material, const Matrix3& rotation);

/// What uniaxial stress along a unit direction measures at small strain.
struct UniaxialResponse {
  double youngs_modulus;  ///< [Pa]
  double poissons_ratio;  ///< − mean strain across / strain along
};

/// Of the material with its fibres. With S⁰ the compliance of the matrix and a the fibres' direction, the compliance is
/// S⁰ − E_f (S⁰:aa)(aa:S⁰)/(1 + E_f/E) [Sherman & Morrison 1950]: E + E_f along the fibres.
UniaxialResponse uniaxial_response(const Material& material, const Vector3& direction);

/// Nominal stress [Pa] in uniaxial stress along a unit direction at a nominal strain of any size: the curve, and the
/// fibres' beside it. None where the fibres lie askew (their strain then depends on the matrix's), or where there is
/// neither a curve nor fibres.
std::optional<double> uniaxial_stress(const Material& material, const Vector3& direction, double strain);

}  // namespace elastin
