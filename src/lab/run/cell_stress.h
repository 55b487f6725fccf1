#pragma once
#include <vector>

#include "elastin/core/forces/elasticity.h"

namespace elastin::lab {

/// The state of each triangle, then of each tetrahedron. The stress is the virial of the force densities q [N/m] of the
/// cell's sides, whatever law they come from:
///   σ = Σ_ab w_ab q_ab d dᵀ / v,  d = x_b − x_a, v the present volume (or area),
/// w the cell's part of the rest volume of all cells on that side, so that Σ v σ = Σ q d dᵀ of the body holds exactly.
/// It says how the force densities are spread, and is smoother than the law's own stress of each cell.
///                                                                             [Hardy 1982; Admal & Tadmor 2010]
std::vector<CellState> cell_states(const Body& body, const Positions& positions, const VectorX& force_densities);

/// Largest principal stretch less 1.
double largest_strain(const CellState& cell);
/// Von Mises' equivalent stress, in the unit of the stress.
double von_mises(const CellState& cell);

}  // namespace elastin::lab
