#pragma once
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "elastin/core/forces/elasticity.h"

namespace elastin {

/// Bending stiffness of a sheet that is flat at rest, as constant force densities.
///
/// At each side e inside the sheet the gradient of the positions jumps across it by the hinge vector h_e, as long as
/// twice the sine of half the hinge's angle. A triangle's curvature is the vector-valued tensor Λ = Σ_e l_e/(2A) h_e
/// n_e n_eᵀ [after Grinspun, Gingold, Reisman & Zorin 2006], its energy that of a plate, ½ A D ((1−ν) |Λ|² + ν |tr
/// Λ|²). At the rim h_e is what makes that least: no moment on a free side. All this is quadratic in the positions and
/// blind to translation and rotation, so it is Σ ½ q s with a *constant* q for each pair of the up to six molecules of
/// a triangle and its neighbours [after Bergou et al. 2006], exact at any bending without stretching, and nothing in
/// any flat state. Exact for constant curvature where each triangle's neighbours are its images (one diagonal
/// throughout, equal sides); a twist of squares cut along alternating diagonals is 2.8 times too stiff. Two
/// neighbouring rows of fixed molecules clamp a sheet, half way between them.

/// Pairs of molecules between which make_bending works. Those that are no connections yet must be made so: see
/// add_cell_sides.
std::vector<std::array<int, 2>> bending_pairs(const Body& body);

/// Why a body cannot have bending stiffness, or "": it needs triangles that lie in one plane at rest.
std::string unsuited_for_bending(const Body& body);

/// How many times the energy of a plate such a sheet stores away from its rim where it is bent or twisted evenly, in
/// the direction that is worst; 1 where no triangle is away from the rim. It goes by how the triangles lie, not by
/// their size.
double bending_excess(const Body& body, double poissons_ratio);

/// @param rigidity D [N m]; E t³/(12 (1−ν²)) of a plate. Throws InputError if a pair is no connection.
std::unique_ptr<Elasticity> make_bending(const Body& body, double rigidity, double poissons_ratio);

}  // namespace elastin
