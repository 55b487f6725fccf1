#pragma once
#include <cstddef>
#include <vector>

#include "elastin/core/forces/elasticity.h"
#include "lab/run/run.h"

namespace elastin::lab {

/// How many triangles and tetrahedra of a body are cells of its own: none that stand for a part of a block's cell.
struct OwnSimplices {
  std::size_t triangles, tetrahedra;
  explicit OwnSimplices(const Body& body);
  std::size_t size() const { return triangles + tetrahedra; }
};

/// The state of each triangle and tetrahedron (OwnSimplices), then of each cell of the blocks. Where laws are at work
/// on blocks their cells have the state that these found. To this comes, of all cells, the virial of the force
/// densities q [N/m] of their sides, whatever rule or law they come from:
///   σ = Σ_ab w_ab q_ab d dᵀ / v,  d = x_b − x_a, v the present volume (or area),
/// w the cell's part of the rest volume of all cells that have a and b, so that Σ v σ = Σ q d dᵀ of the body holds
/// exactly where every connection has a cell. It says how the force densities are spread, and is smoother than the
/// law's own stress of each cell.                                                    [Hardy 1982; Admal & Tadmor 2010]
std::vector<CellState> cell_states(const Body& body, const Snapshot& shot);

/// Largest principal stretch less 1.
double largest_strain(const CellState& cell);
/// Von Mises' equivalent stress, in the unit of the stress.
double von_mises(const CellState& cell);

}  // namespace elastin::lab
