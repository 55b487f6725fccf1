#pragma once
#include <array>
#include <vector>

#include "elastin/core/model/body.h"

namespace elastin {

/// The same matter with every side of every cell halved: each tetrahedron becomes eight, each triangle four. Of the
/// three ways to cut the inner octahedron of a tetrahedron the one along its shortest diagonal is taken, so that the
/// cells stay as regular as they are. Curved surfaces stay the polyhedra that they are. Connections are the sides of
/// the cells; radii are halved, masses are lumped from what each cell weighs, and keep their sum; factors of stiffness
/// pass on to the cells; Body::between says where the molecules came from, over all refinements. Throws InputError
/// where a body has no cells, and where it has parts, ties or cables.
///                                                                                                        [Bey 1995]
Body refined(const Body& body);

/// A lattice with tetrahedra in its cubes (Body::cubes): a molecule more in the middle of each, and four equal
/// tetrahedra about the line between the middles of two cubes that share a face; see BlockKind::body_centred.
/// Connections are the sides of the cells. Throws InputError where the body has no cubes.
Body with_tetrahedra_in_cubes(const Body& body);

/// Volume and its moments that tell whether two bodies of cells fill the same space: volume (or area) and, about the
/// origin, its three first and six second moments, in SI units.
std::array<double, 10> moments_of_cells(const Body& body);

}  // namespace elastin
