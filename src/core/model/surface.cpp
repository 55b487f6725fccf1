#include "elastin/core/model/surface.h"

#include "core/geometry/boundary.h"

namespace elastin {

Cells<3> surface_of(const Body& body) {
  Cells<3> surface = boundary_of(body.tetrahedra);
  if (body.tetrahedra.empty())
    for (const auto& [a, b, c, d] : boundary_of(body.cubes)) surface.push_back({a, b, c}), surface.push_back({a, c, d});
  surface.insert(surface.end(), body.triangles.begin(), body.triangles.end());
  return surface;
}

}  // namespace elastin
