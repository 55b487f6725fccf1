#pragma once
#include "elastin/core/model/body.h"

namespace elastin {

/// The surface of a body: the faces of its tetrahedra, else of its cubes (each cut in two), and its triangles as they
/// are. Empty for molecules without cells.
Cells<3> surface_of(const Body& body);

}  // namespace elastin
