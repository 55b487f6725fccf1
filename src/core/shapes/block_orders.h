#pragma once
#include <utility>
#include <vector>

#include "core/model/block_geometry.h"
#include "elastin/core/model/body.h"

namespace elastin {

/// The cells of a body as blocks, of first order where it has no blocks: its tetrahedra, else its cubes, else its
/// triangles. Throws InputError without such cells.
std::vector<CellBlock> blocks_of(const Body& body);

/// The kind of first order with the same corners.
const CellKind& first_order_of(const CellKind& kind);

/// Sets radii and masses of a body whose first molecules are those of another, with the same cells or finer ones over
/// the same matter: each molecule has the density that is interpolated to it, and the sum stays. `between`: the
/// new ones.
void carry_matter(const Body& from, const std::vector<MoleculeBetween>& between, Body& to);

}  // namespace elastin
