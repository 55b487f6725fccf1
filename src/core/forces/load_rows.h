#pragma once
#include "elastin/core/forces/load_table.h"

namespace elastin {

/// The rows of the table of loads.
LoadKind gravity();
LoadKind point();
LoadKind pressure();
LoadKind traction();
LoadKind gas();
LoadKind floor_plane();
LoadKind air();
LoadKind stokes_drag();
LoadKind quadratic_drag();
LoadKind damping();
LoadKind cell_damping();
LoadKind rayleigh();

}  // namespace elastin
