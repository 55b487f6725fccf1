#pragma once
#include <memory>
#include <vector>

#include "elastin/core/forces/elasticity.h"
#include "elastin/core/laws/point_laws.h"
#include "elastin/core/laws/volumetric.h"

namespace elastin {

/// A law on the cells of one block, by forces at their nodes, F S B, without a force density for each pair:
///   f_a = −Σ_g w_g F_g S_g B_a,   F = I + Σ_a u_a ⊗ B_a,   A = F ᵀF − I.
/// The body must outlive it.
/// @param laws one law, or one a cell of the block.
template <int dimensions>
std::unique_ptr<Elasticity> make_block_cells(const Body& body, const CellBlock& block,
                                             std::shared_ptr<const PointLaws<dimensions>> laws);

/// The same of a law that is split, W = W_shape(C) + U(J), with U taken on a volume that the whole cell shares: on the
/// projection θ of J to the cell's pressure functions φ (CellKind::pressures), W = ∫ W_shape + U(θ), against locking
/// near ν = ½. Where φ is constant that is the mean dilatation.                     [Simo, Taylor & Pister 1985]
/// @param laws W_shape; @param volume U, one or one a cell.
std::unique_ptr<Elasticity> make_block_cells(const Body& body, const CellBlock& block,
                                             std::shared_ptr<const PointLaws<3>> laws, std::vector<Volumetric> volume);

/// Mean of a cell's nodes at rest [m].
inline Vector3 middle_of(const Body& body, const CellBlock& block, int cell) {
  Vector3 sum = Vector3::Zero();
  for (const int node : block.cell(cell)) sum += body.rest.col(node);
  return sum / block.kind->nodes;
}

/// A law that sees C on all blocks of the body that have these dimensions.
/// @param at_work gives the law of a material, or if `split` its two terms as SplitPoint has them.
template <int dimensions, bool split = false, class AtWork>
std::unique_ptr<Elasticity> make_blocks(const Body& body, const Material& material, const AtWork& at_work) {
  std::vector<std::unique_ptr<Elasticity>> terms;
  for (const CellBlock& block : body.blocks) {
    if (block.kind->dimensions != dimensions) continue;
    std::vector<decltype(at_work(material))> laws;
    Material own = material;
    for (int cell = 0; cell < (block.stiffness.size() || material.varies() ? block.size() : 1); ++cell) {
      if (material.varies()) own = local_material(material, middle_of(body, block, cell));
      if (block.stiffness.size()) own.youngs_modulus = material.youngs_modulus * block.stiffness[cell];
      laws.push_back(at_work(own));
    }
    if constexpr (split) {
      std::vector<decltype(laws.front().shape)> shapes;
      std::vector<Volumetric> volumes;
      for (const auto& law : laws) shapes.push_back(law.shape), volumes.push_back(law.volume);
      terms.push_back(make_block_cells(body, block, make_point_laws<3>(std::move(shapes)), std::move(volumes)));
    } else {
      terms.push_back(make_block_cells<dimensions>(body, block, make_point_laws<dimensions>(std::move(laws))));
    }
  }
  if (terms.size() == 1) return std::move(terms.front());
  return make_sum(std::move(terms), nullptr);
}

}  // namespace elastin
