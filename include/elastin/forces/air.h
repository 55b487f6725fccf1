#pragma once
#include <memory>

#include "elastin/forces/loads.h"

namespace elastin {

/// How a body of triangles feels the air that it moves through.
struct Air {
  double density = 1.225;          ///< ρ [kg/m³] ≥ 0
  double drag_coefficient = 1.2;   ///< C of the flow across a triangle, ≥ 0; 1.1 to 1.3 of a flat plate, 2 of a strip
  double skin_coefficient = 0;     ///< C_f of the flow along it, ≥ 0
  Vector3 wind = Vector3::Zero();  ///< velocity of the air far away [m/s]
};

/// Quadratic drag on each triangle by itself, from its relative wind w = wind − mean velocity of its corners, split
/// into its part w_n along the normal and w_t across: F = ½ ρ A (C |w_n| w_n + C_f |w_t| w_t), a third to each corner.
/// [Hoerner 1965, of single plates]
/// No flow is solved: triangles do not shade each other, there is no added mass of air and no pressure inside a canopy
/// beyond that of its own relative wind. The tangent has the part of the velocities alone.
std::unique_ptr<Load> make_air(const Body& body, const Air& air);

}  // namespace elastin
