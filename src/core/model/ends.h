#pragma once
#include <vector>

#include "elastin/core/model/body.h"

namespace elastin {

/// What of a body's surface looks along a direction and is joined to what lies furthest along it.
struct EndSides {
  std::vector<int> molecules;        ///< corners, ascending; of a process's share those that it has
  Vector3 normal = Vector3::Zero();  ///< their mean by area, unit; zero without sides
};

/// The sides of the surface (triangles of a solid, edges at the rim of a membrane) at one end of a body: those whose
/// outward normals lie within 45° of `direction` (unit), and which are joined, by molecules that they share, to the
/// furthest of them. Of several such patches those count whose heights overlap: two legs that end nearly at one height.
/// Empty of a body without cells.
EndSides end_sides(const Body& body, const Vector3& direction);

/// Whether molecules in a plane across `direction` are an end: some sides of the surface lie in that plane, and most of
/// those around them turn away from it by at least 30°. False where it merely touches a rough, tilted or rounded end.
bool is_plane_end(const Body& body, const std::vector<int>& molecules, const Vector3& direction);

}  // namespace elastin
