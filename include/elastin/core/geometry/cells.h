#pragma once
#include <array>
#include <vector>

#include "elastin/core/base/types.h"

namespace elastin {

/// Cells of one shape, each by the numbers of its corners.
template <int corners>
using Cells = std::vector<std::array<int, corners>>;

}  // namespace elastin
