#pragma once
#include <string>
#include <vector>

#include "elastin/core/model/parts.h"

namespace elastin {

/// As tie_parts; `numbers` becomes the present number of each molecule that there was, of one that was joined that of
/// the molecule which it is now. Empty: all have kept theirs.
TieReport tie_parts(Body& body, const std::string& first, const std::string& second, double within, double stiffness,
                    std::vector<int>& numbers);

}  // namespace elastin
