#pragma once
#include <string>

#include "lab/report/records.h"

namespace elastin::lab {

/// What a page needs to show a body in 3D, as one line of JSON without a line break: positions at rest, radii,
/// connections and surface. Bodies of more than some 60 000 connections are shown by their surface, and then by every
/// so many connections; "shown" says so.
std::string body_view(const Scene& scene, const Record& record);

/// The states that the run has kept, at most 25 of them, evenly spread, in the order of body_view: displacements of the
/// molecules [m], tensions of the connections [N], sizes of the outer forces on molecules [N]; where there are any, von
/// Mises' stress of the cell behind each side of the surface ([Pa]; of a membrane [N/m]), contact pressures of the
/// molecules [Pa]. Displacements to 2⁻²¹ of the largest of the state, all else to 2⁻¹³. "" if the run kept no state.
std::string states_view(const Scene& scene, const Record& record);

}  // namespace elastin::lab
