#pragma once
#include <array>

#include "core/base/rows.h"
#include "elastin/core/geometry/cells.h"

namespace elastin {

/// Outward normals of a surface of triangles at its faces, sides and corners, as it lies now. On a closed surface they
/// distinguish inside from outside at any nearest point. [Bærentzen & Aanæs 2005]
class SurfaceNormals {
 public:
  SurfaceNormals() = default;
  SurfaceNormals(int points, const Cells<3>& triangles);
  /// At the position of a triangle that the weights name: of its face; where one weight is 0 the sum of those on both
  /// sides of the side; where two are, that around the corner, weighted with the angles. Unit, whatever the surface.
  Vector3 at(const Positions& positions, int triangle, const std::array<double, 3>& weights) const;
  const Cells<3>& triangles() const { return triangles_; }

 private:
  Cells<3> triangles_;
  Rows around_;
};

}  // namespace elastin
