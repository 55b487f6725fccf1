#pragma once
#include "elastin/core/model/body.h"

namespace elastin::mesh {

/// The Voronoi cells of the body's molecules at rest, clipped by their convex hull. `problem` is set where the hull is
/// not the body: molecules in one plane, membranes, and bodies whose tetrahedra do not fill their hull; of a body
/// without tetrahedra they cannot be known. In elastin::lab, by Voro++ [Rycroft 2009].
VoronoiCells voronoi_cells(const Body& body);

/// The part of the hull's volume [0 … 1] that stands on faces between molecules that no connection joins, or on the
/// hull: 1 − Σ A L/(3 V). The voronoi rule lacks it.
double lost_share(const Body& body, const VoronoiCells& cells);

}  // namespace elastin::mesh
