#pragma once
#include <functional>
#include <optional>
#include <vector>

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

/// Muscle: a force along fibres that is there without strain, T = T_max · activation(t) · f(λ), λ the stretch along
/// them.
struct ActiveFibre {
  Vector3 direction = Vector3::UnitZ();  ///< a at rest, unit
  double stress = 0;                     ///< T_max [Pa], > 0: force over the present section
  double optimal_stretch = 1;            ///< λ of the largest force, > 0
  /// Of the time [s], ≥ 0; 1 = all fibres at work. None = 1 at all times.
  std::function<double(double)> activation = {};
};

/// How rubber softens where it has been strained before (strategies `mullins:NAME`; see make_mullins).
struct Softening {
  double r = 0;     ///< > 1; the least stiffness left is 1 − 1/r
  double m = 0;     ///< [Pa], ≥ 0
  double beta = 0;  ///< ≥ 0; one of m and beta above 0
};

/// How stress relaxes, G(t) = g₀ + Σ gᵢ e^(−t/τᵢ) times the elastic law (quasi-linear; strategies `prony:NAME`).
struct Relaxation {
  struct Term {
    double share;  ///< gᵢ, > 0
    double time;   ///< τᵢ [s], > 0
  };
  std::vector<Term> terms;
  /// Whether the law has the instantaneous moduli, g₀ = 1 − Σ gᵢ; else the long-term ones, g₀ = 1.
  bool instantaneous = false;
  /// θ [s], ≥ 0: adds the stress θ dσ/dt, a dashpot in parallel to the law. [Kelvin, Voigt]
  double retardation = 0;

  /// g₀
  double long_term() const {
    double rest = 1;
    if (instantaneous)
      for (const Term& term : terms) rest -= term.share;
    return rest;
  }
};

/// A line about which directions turn.
struct RoundAxis {
  Vector3 point = Vector3::Zero();       ///< [m]
  Vector3 direction = Vector3::UnitZ();  ///< unit
};

/// Radius, circumference and axis at a position [m], a unit column each. On the axis itself the radius is any one.
Matrix3 frame_at(const RoundAxis& axis, const Vector3& place);

struct Material;

/// What of a material varies over a body at rest.
struct MaterialField {
  /// Sets the material's own numbers and directions to those of a position [m]: both as the body was described.
  std::function<void(Material& own, const Vector3& place)> set;
  Matrix3 rotation = Matrix3::Identity();  ///< since then: what was at X is at rotation X + shift
  Vector3 shift = Vector3::Zero();         ///< [m]
};

/// What the body should behave like. A strategy turns it into the stiffness of each connection.
struct Material {
  double youngs_modulus = 0;     ///< E [Pa], > 0; the curve's modulus at no strain, where there is a curve
  double poissons_ratio = 0.25;  ///< ν, −1 < ν < ½. Springs alone give ¼ in an isotropic body, whatever the target.
  double density = 1000;         ///< ρ [kg/m³], > 0
  double thickness = 0;          ///< t [m] of a membrane; only triangles use it
  /// D [N m] of a sheet that has a bending stiffness; 0 = no bending stiffness. A plate has E t³/(12 (1−ν²)).
  double bending_rigidity = 0;
  std::optional<StressStrain> curve = {};  ///< of the material in uniaxial stress, without its fibres; none = straight
  std::optional<Fibre> fibre = {};
  std::optional<ActiveFibre> active = {};
  /// Of one law; E and ν above are then those that the law has at rest, and other strategies take these (see with_law).
  std::optional<LawConstants> law = {};
  std::optional<Relaxation> relaxation = {};
  std::optional<Softening> softening = {};
  /// Axis around which directions turn: none = all directions are those of space; else their components are along the
  /// radius, along the circumference and along the axis, at the middle of each cell.
  std::optional<RoundAxis> around = {};
  /// Numbers, or directions, that vary over the body: cells have those of their middle.
  std::optional<MaterialField> field = {};

  /// Whether cells have materials of their own; see local_material.
  bool varies() const { return around || field; }
};

/// Turns what has a direction at rest: fibres, and a law's; of directions around an axis, the axis. Fields turn too.
void rotate(Material& material, const Matrix3& rotation);

/// The material at a position [m] of the body at rest, directions in space.
Material local_material(const Material& material, const Vector3& place);

/// What uniaxial stress along a unit direction measures at small strain.
struct UniaxialResponse {
  double youngs_modulus;  ///< [Pa]
  double poissons_ratio;  ///< − mean strain across / strain along
};

/// Of the material with its fibres. With S⁰ the compliance of the matrix and a the fibres' direction, the compliance is
/// S⁰ − E_f (S⁰:aa)(aa:S⁰)/(1 + E_f/E) [Sherman & Morrison 1950]: E + E_f along the fibres. NaN where that is not the
/// same everywhere (directions around an axis), or muscle is at work.
UniaxialResponse uniaxial_response(const Material& material, const Vector3& direction);

/// Nominal stress [Pa] in uniaxial stress along a unit direction at a nominal strain of any size: the curve or what the
/// law's constants say, and the fibres' in addition. None where the fibres lie askew (their strain then depends on the
/// matrix's), where there is neither a curve nor a law nor fibres, and where uniaxial_response has none.
std::optional<double> uniaxial_stress(const Material& material, const Vector3& direction, double strain);

}  // namespace elastin
