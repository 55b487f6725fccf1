#pragma once
#include "elastin/core/geometry/cells.h"

namespace elastin {

/// Sides that only one triangle has, and the molecules on them, ascending.
std::vector<std::array<int, 2>> boundary_of(const Cells<3>& triangles);
std::vector<int> rim_of(const Cells<3>& triangles);

}  // namespace elastin
