#pragma once
#include <memory>

#include "elastin/core/forces/loads.h"

namespace elastin {

/// How a body of triangles feels the air that it moves through.
struct Air {
  double density = 1.225;         ///< ρ [kg/m³] ≥ 0
  double drag_coefficient = 1.2;  ///< C of the flow across a triangle, ≥ 0; 1.1 to 1.3 of a flat plate, 2 of a strip
  double skin_coefficient = 0;    ///< C_f of the flow along it, ≥ 0
  double pressure_coefficient = 0;  ///< C_p of air that a canopy has caught, ≥ 0; about 1 is full stagnation
  Vector3 wind = Vector3::Zero();   ///< velocity of the air far away [m/s]
};

/// Quadratic drag on each triangle by itself, from its relative wind w = wind − mean velocity of its corners, split
/// into its part w_n along the normal and w_t across: F = ½ ρ A (C |w_n| w_n + C_f |w_t| w_t), a third to each corner.
/// [Hoerner 1965, of single plates]
/// With C_p, a canopy that has caught the wind is under the same pressure everywhere, p = ½ ρ C_p |w̄|² along the
/// normals with the stream, w̄ the mean relative wind by area; it fades out where the outline that the wind meets is
/// below a twentieth of the area. Without it lines pull a canopy shut: nothing pushes its folds apart.
/// No flow is solved: triangles do not shade each other, there is no wake and no added mass of air. The tangent has the
/// part of the velocities in each triangle's own drag alone.
std::unique_ptr<Load> make_air(const Body& body, const Air& air);

}  // namespace elastin
