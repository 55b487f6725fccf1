#pragma once
#include "contact/distance.h"

namespace elastin::contact {

/// Of a closed surface of triangles, normals outwards: the nearest point by a tree of boxes, inside or outside by its
/// angle-weighted normal [Baerentzen & Aanaes 2005]. Throws InputError without triangles or on corners that are no
/// points.
std::unique_ptr<SignedDistance::Solid> make_mesh_distance(const Positions& points, const Cells<3>& triangles);

/// Of the convex hull of points. Throws InputError where they have none: too few, or all in one plane.
std::unique_ptr<SignedDistance::Solid> make_hull_distance(const Positions& points);

}  // namespace elastin::contact
