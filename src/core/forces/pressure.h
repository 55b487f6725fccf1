#pragma once
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "elastin/core/forces/loads.h"

namespace elastin {

/// Pressure over that outside, its slope and the work it has done, at one volume.
struct PressureState {
  double pressure = 0;  ///< p [Pa]
  double slope = 0;     ///< dp/dV [Pa/m³]
  double work = 0;      ///< ∫ p dV from the volume at rest [J]
};

/// What fills a surface: its pressure as a function of the enclosed volume [m³] and of that at rest.
using PressureLaw = std::function<PressureState(double volume, double rest_volume)>;

/// The same pressure [Pa] at every volume; may be negative.
PressureLaw constant_pressure(double pressure);

/// A closed amount of gas: (p + ambient) Vᵞ stays what it is at rest, `amount` V₀ᵞ⁻¹. γ = 1: constant temperature, with
/// amount = n R T; 1.4: air without exchange of heat. `amount` is absolute pressure times volume at rest [J], `ambient`
/// [Pa], both ≥ 0. A volume that is not above zero has infinite pressure.
PressureLaw enclosed_gas(double amount, double exponent, double ambient);

/// Volume control: p = pressure + stiffness (volume − V) keeps the volume [m³] within (p − pressure)/stiffness, however
/// the pressure must rise or fall for that: it leads past a pressure limit. Solved again with `pressure` = the p found,
/// the volume is met ever closer, and p is the multiplier of that constraint. [augmented Lagrangian; Hestenes 1969]
PressureLaw controlled_volume(double volume, double stiffness, double pressure);

/// Signed volume between the triangles and an apex [m³]: Σ (x0 − a)·((x1 − a) × (x2 − a))/6. That inside a closed
/// surface, wherever the apex; of an open one, that under it and the planes through the apex on which its rim lies.
double enclosed_volume(const Cells<3>& triangles, const Positions& positions, const Vector3& apex);

/// Sides of triangles that hinder a pressure.
struct SurfaceFindings {
  int rim_sides = 0;            ///< sides of one triangle alone: 0 = closed
  std::vector<int> turned;      ///< triangles turned against a neighbour of lower number: they have no common outside
  std::vector<int> branchings;  ///< triangles at a side that has more than two
};
SurfaceFindings inspect_surface(const Cells<3>& triangles);

/// The triangles of each piece; pieces share no molecule.
std::vector<Cells<3>> pieces_of(const Cells<3>& triangles, Eigen::Index molecules);

/// What each space within a closed surface is bounded by, of pieces of triangles that look outwards: the piece, and
/// the closed ones next within it, among all triangles of the body, turned so that they look into them. Throws
/// InputError where a piece is open, and where one that looks inwards, as the inner side of a double wall does, lies
/// within no other.
std::vector<Cells<3>> closed_spaces(const Cells<3>& triangles, const Body& body);

/// Pressure on some triangles of a body, on their present area and along their present normals: a third of p A n to
/// each corner of a triangle. The tangent is exact; it is symmetric, and energy() is that of the forces, on a closed
/// surface and on one whose rim is fixed or slides in planes through the apex (`rim_fixed`). Throws InputError where
/// the triangles have no common outside.
class Pressure final : public Load {
 public:
  Pressure(const Body& body, Cells<3> triangles, PressureLaw law, const Vector3& apex, bool rim_fixed);
  /// On all of them.
  Pressure(const Body& body, PressureLaw law, const Vector3& apex, bool rim_fixed)
      : Pressure(body, body.triangles, std::move(law), apex, rim_fixed) {}

  void set_law(PressureLaw law);
  double volume(const Positions& positions) const;
  PressureState pressure_state(const Positions& positions) const { return law_(volume(positions), rest_volume_); }
  double rest_volume() const { return rest_volume_; }

  void add_forces(const State& state, Positions& forces) const override;
  double energy(const State& state) const override;
  bool has_energy() const override { return conservative_; }
  /// Says that the law changes in time: what the pressure does is then work from outside.
  void set_varying() { steady_ = false; }
  bool steady() const override { return steady_ && has_energy(); }
  bool changes() const override { return true; }
  bool follows_surface() const override { return true; }
  void add_change(const State& state, const Positions& dx, const Positions& dv, Positions& forces) const override;
  void visit_blocks(const State& state, double velocity_weight, const BlockVisitor& visit) const override;
  std::vector<WideTerm> wide_terms(const State& state) const override;

 private:
  template <class OfTriangle>
  void add_to_corners(Positions& sums, OfTriangle&& of_triangle) const;

  const Body& body_;
  Cells<3> triangles_;
  PressureLaw law_;
  Vector3 apex_;
  double rest_volume_ = 0;
  bool conservative_ = false, constant_ = false, steady_ = true;
  std::vector<int> start_, slots_;  ///< of each molecule: its triangles, ascending
};

}  // namespace elastin
