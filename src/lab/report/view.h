#pragma once
#include <string>

#include "lab/report/records.h"

namespace elastin::lab {

/// What a page needs to show a body in 3D, as one line of JSON without a line break: positions at rest, radii,
/// connections and surface. Bodies of more than some 60 000 connections are shown by their surface, and then by every
/// so many connections; "shown" says so.
std::string body_view(const Scene& scene, const Record& record);

/// The states that the run has kept, at most 25 of them, evenly spread: displacements of the molecules [m] and tensions
/// of the connections [N] in the order of body_view. "" if it kept none.
std::string states_view(const Scene& scene, const Record& record);

}  // namespace elastin::lab
