#pragma once
#include <string_view>

#include "elastin/core/model/body.h"

namespace elastin {

/// The body with each cell of first order (a block's, else its tetrahedra, cubes, triangles) made one of `kind`, which
/// must have the same corners: nodes between the corners become molecules behind the others. Masses keep their sum and
/// what is heavier about a molecule, radii stay; where nodes between corners are left out both are left to set_matter.
/// Connections are the sides of the simplices that the nodes make. Throws InputError if there is no cell with these
/// corners, or on a body of several parts.
Body with_cells(const Body& body, const CellKind& kind);

/// The body with its cells of second order, tetrahedron10, hexahedron27 and triangle6; 1: with blocks of first order.
/// Cubes become hexahedra. A body of blocks that has this order is left as it is. Throws InputError as above, and for
/// prisms, which have no second order here.
Body with_order(const Body& body, int order);

}  // namespace elastin
