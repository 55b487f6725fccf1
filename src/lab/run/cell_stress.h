#pragma once
#include <cstddef>
#include <span>
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

/// The molecules of all cells: OwnSimplices, then the cells of the blocks. The body must outlive it.
class CellNodes {
 public:
  explicit CellNodes(const Body& body);
  std::size_t size() const { return cells_.size(); }
  std::span<const int> of(std::size_t cell) const { return cells_[cell]; }

 private:
  std::vector<std::span<const int>> cells_;
};

/// The state of each cell, in the order of CellNodes: that of the laws which have a stress in it, and of the force
/// densities q [N/m] that are in none of these, as those of spring rules, the virial of its sides:
///   σ = Σ_ab w_ab q_ab d dᵀ / v,  d = x_b − x_a, v the present volume (or area),
/// w the cell's part of the rest volume of all cells that have a and b, so that Σ v σ = Σ q d dᵀ of the body holds
/// exactly where every connection has a cell. It says how they are spread; in a uniform field it need not be uniform.
///                                                                           [Hardy 1982; Admal & Tadmor 2010]
std::vector<CellState> cell_states(const Body& body, const Snapshot& shot);

/// Has the states of laws in single precision, a third of the memory.
void keep_states(Snapshot& shot);

/// Largest principal stretch less 1.
double largest_strain(const CellState& cell);
/// Von Mises' equivalent stress, in the unit of the stress.
double von_mises(const CellState& cell);

}  // namespace elastin::lab
