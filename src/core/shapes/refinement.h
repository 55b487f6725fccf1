#pragma once
#include <array>
#include <utility>
#include <vector>

#include "elastin/core/model/body.h"

namespace elastin {

/// The same matter with every edge of every cell halved: each tetrahedron, hexahedron and prism becomes eight of its
/// own shape and order, each triangle four. Of the three cuts of the inner octahedron of a tetrahedron the one
/// along its shortest diagonal is taken, so that the cells stay as regular as they are. Surfaces stay what they are,
/// facets or curved edges of second order. Connections are the sides of the cells; radii are halved, masses are lumped
/// by what the matter about each molecule weighed, and keep their sum; factors of stiffness pass on to the cells.
/// Throws InputError where a body has no cells, and where it has parts, ties or cables.                          [Bey
/// 1995]
Body refined(const Body& body);

/// What of the cells, or of a lattice's boxes, belongs to each molecule, lumped [m³]; of triangles their area [m²].
VectorX volumes_of_molecules(const Body& body);

/// Volume and its moments, which show whether two bodies of cells fill the same space: volume (or area) and, about the
/// origin, its three first and six second moments, in SI units.
std::array<double, 10> moments_of_cells(const Body& body);

}  // namespace elastin
