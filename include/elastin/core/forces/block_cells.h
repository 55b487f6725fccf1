#pragma once
#include <functional>
#include <memory>
#include <vector>

#include "elastin/core/forces/elasticity.h"
#include "elastin/core/laws/any_law.h"
#include "elastin/core/laws/point_laws.h"
#include "elastin/core/laws/volumetric.h"

namespace elastin {

/// A law on the cells of one block, by forces at their nodes, F S B, without a force density for each pair:
///   f_a = −Σ_g w_g F_g S_g B_a,   F = I + Σ_a u_a ⊗ B_a,   A = F ᵀF − I.
/// The body must outlive it. With `volume` of a law that is split, W = W_shape(C) + U(J), U is taken on a volume that
/// the whole cell shares, against locking near ν = ½: on the projection θ of J to the cell's pressure functions φ
/// (CellKind::pressures), W = ∫ W_shape + U(θ). Where φ is constant that is the mean dilatation.
///                                                                                         [Simo, Taylor & Pister 1985]
/// @param laws at the points of each cell: all, or W_shape; @param volume U of solids, one or one a cell; empty: none.
template <int dimensions>
std::unique_ptr<NodalForces> make_block_cells(const Body& body, const CellBlock& block,
                                              std::shared_ptr<const PointLaws<dimensions>> laws,
                                              std::vector<Volumetric> volume = {});

/// The same with one law for all cells, or one a cell, and their U(J) where they are split.
template <int dimensions>
std::unique_ptr<NodalForces> make_block_cells(const Body& body, const CellBlock& block,
                                              std::vector<AnyPoint<dimensions>> laws,
                                              std::vector<Volumetric> volume = {});

/// Mean of a cell's nodes at rest [m].
inline Vector3 middle_of(const Body& body, const CellBlock& block, int cell) {
  Vector3 sum = Vector3::Zero();
  for (const int node : block.cell(cell)) sum += body.rest.col(node);
  return sum / block.kind->nodes;
}

/// A law that sees C on all blocks of the body that have these dimensions.
template <int dimensions>
ElasticTerms make_blocks(const Body& body, const Material& material, const AnyAtWork<dimensions>& at_work);
/// The same of a law that is split, with the volume kept by pressures of the whole cell.
ElasticTerms make_mixed_blocks(const Body& body, const Material& material,
                               const std::function<SplitPoint<AnyPoint<3>>(const Material&)>& at_work);

}  // namespace elastin
