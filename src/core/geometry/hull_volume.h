#pragma once
#include "elastin/core/base/types.h"

namespace elastin {

/// Volume of the convex hull of points [m³]; 0 where they lie in one plane. Points within 1e-9 of the outline of the
/// hull count as on it. Cost O(n h) at most for h points on the hull; of lattices O(n).     [Barber 1996, quickhull]
double hull_volume(const Positions& points);

}  // namespace elastin
