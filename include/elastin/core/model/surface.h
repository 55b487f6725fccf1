#pragma once
#include "elastin/core/model/body.h"

namespace elastin {

/// The surface of a body, to be drawn or touched: the faces of its tetrahedra, else of its cubes (each cut in two), and
/// its triangles as they are; three molecules each, counter-clockwise seen from outside. Empty for molecules without
/// cells. A cut makes another body, with another surface.
Cells<3> surface_of(const Body& body);

}  // namespace elastin
