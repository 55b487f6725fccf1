#pragma once
#include "elastin/core/model/body.h"

namespace elastin {

/// As set_simplices, with diagonals that go by the places of the nodes at rest, not by their numbers, which a file or a
/// host happens to give: z first, then y, then x, as lattices are numbered.
void set_simplices_by_place(Body& body);

}  // namespace elastin
