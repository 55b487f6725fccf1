#pragma once
#include <string>
#include <vector>

#include "elastin/core/model/body.h"

namespace elastin::contact {

/// What keeps a surface of triangles from enclosing a volume, in words for a user; "" if nothing does: holes (sides of
/// one triangle alone, with where), sides of more than two, triangles turned against their neighbours, flat ones, parts
/// that cross each other (by FCL, with the first pair's place), inside out.
std::string check_surface(const Positions& points, const Cells<3>& triangles);

}  // namespace elastin::contact
