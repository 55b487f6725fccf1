#pragma once
#include <string_view>

#include "elastin/core/model/body.h"

namespace elastin {

/// The body with each cell of first order (a block's, else its tetrahedra, cubes, triangles) made one of `kind`, which
/// must have the same corners: nodes between the corners become molecules behind the others. Masses and radii are left
/// to set_matter, connections are the sides of the simplices that the nodes make. Throws InputError if there is no cell
/// with these corners, or on a body of several parts.
Body with_cells(const Body& body, const CellKind& kind);

/// The body with its cells of second order, tetrahedron10, hexahedron27 and triangle6; 1: with blocks of first order.
/// Cubes become hexahedra. Throws InputError as above, and for prisms, which have no second order here.
Body with_order(const Body& body, int order);

/// The body with each tetrahedron or hexahedron parted into 8 and each triangle into 4, all edges halved; cells of
/// first order. Of cells of second order the parts lie on their curved edges.
Body refined(const Body& body);

}  // namespace elastin
