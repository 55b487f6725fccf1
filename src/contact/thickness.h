#pragma once
#include "elastin/contact/obstacle.h"

namespace elastin::contact {

/// How deep a point may get into an obstacle before the shortest way out is another than it came [m]; infinite of a
/// plane.
double half_thickness(const ObstacleShape& obstacle);

}  // namespace elastin::contact
