#pragma once
#include <string>
#include <vector>

#include "lab/report/records.h"

namespace elastin::lab {

/// The body of one scene with its states alone, as a page shows them in 3D: HTML that needs no other file.
/// @param views lines of body_view and states_view
std::string viewer_text(const std::vector<std::string>& views, const std::vector<Record>& records);

}  // namespace elastin::lab
