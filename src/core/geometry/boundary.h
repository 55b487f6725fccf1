#pragma once
#include "elastin/core/geometry/cells.h"

namespace elastin {

/// All four faces of each tetrahedron, corners counter-clockwise seen from outside.
Cells<3> faces_of(const Cells<4>& tetrahedra);
/// All six faces of each cube, the same.
std::vector<std::array<int, 4>> faces_of(const Cells<8>& cubes);

/// Faces that only one cell has, in the order of their sorted corners; corners counter-clockwise seen from outside.
Cells<3> boundary_of(const Cells<4>& tetrahedra);
std::vector<std::array<int, 4>> boundary_of(const Cells<8>& cubes);

}  // namespace elastin
