#pragma once
#include <optional>
#include <string_view>
#include <utility>

#include "elastin/core/base/units.h"

namespace elastin {

/// Factor to SI and dimension of one unit, with its prefix: "kPa", "mm", "%". Nothing for an unknown name.
std::optional<std::pair<double, Dimension>> find_unit(std::string_view name);

}  // namespace elastin
