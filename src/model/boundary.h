#pragma once
#include "elastin/model/body.h"

namespace elastin {

/// Faces that only one cell has, in the order of their sorted corners; corners counter-clockwise seen from outside.
Cells<3> boundary_of(const Cells<4>& tetrahedra);
std::vector<std::array<int, 4>> boundary_of(const Cells<8>& cubes);

/// The surface of a body: the faces of its tetrahedra, else of its cubes (each cut in two), and its triangles as they
/// are. Empty for molecules without cells.
Cells<3> surface_of(const Body& body);

}  // namespace elastin
