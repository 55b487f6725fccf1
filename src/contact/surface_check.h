#pragma once
#include <array>
#include <functional>
#include <string>
#include <vector>

#include "elastin/core/model/body.h"

namespace elastin::contact {

/// Pairs of triangles that cut each other though they are no neighbours, or elsewhere than at the corner that they
/// share. [FCL]
struct Crossings {
  std::size_t count = 0;
  std::array<int, 2> first{};  ///< of all pairs the least
};
/// @param counts which pairs of triangles count; all, if empty
Crossings find_crossings(const Positions& points, const Cells<3>& triangles,
                         const std::function<bool(int, int)>& counts = {});

/// What keeps a surface of triangles from enclosing a volume, in words for a user; "" if nothing does: holes (sides of
/// one triangle alone, with where), sides of more than two, triangles turned against their neighbours, flat ones, parts
/// that cross each other (by FCL, with the first pair's place), inside out.
std::string check_surface(const Positions& points, const Cells<3>& triangles);

}  // namespace elastin::contact
