#pragma once
#include "contact/distance.h"
#include "core/geometry/surface_normals.h"
#include "core/geometry/triangle.h"

namespace elastin::contact {

/// How far a point is from a surface, if `nearest` on that triangle is the nearest point of all; below 0 behind it.
Distance distance_to_surface(const SurfaceNormals& normals, const Positions& positions, int triangle,
                             const NearestPoint& nearest, const Vector3& point);

}  // namespace elastin::contact
