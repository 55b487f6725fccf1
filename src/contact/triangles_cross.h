#pragma once
#include <array>

#include "elastin/core/base/types.h"

namespace elastin::contact {

/// Whether two triangles have a point in common. [FCL]
bool triangles_cross(const std::array<Vector3, 3>& one, const std::array<Vector3, 3>& other);

}  // namespace elastin::contact
