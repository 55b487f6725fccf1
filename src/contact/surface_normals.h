#pragma once
#include <array>

#include "contact/distance.h"
#include "contact/triangle.h"
#include "core/model/incidence.h"

namespace elastin::contact {

/// Outward normals of a surface of triangles at its faces, sides and corners, as it lies now. On a closed surface they
/// tell inside from outside at any nearest point. [Baerentzen & Aanaes 2005]
class SurfaceNormals {
 public:
  SurfaceNormals() = default;
  SurfaceNormals(int points, const Cells<3>& triangles);
  /// At the place of a triangle that the weights name: of its face; where one weight is 0 the sum of those on both
  /// sides of the side; where two are, that around the corner, weighted with the angles. Unit, whatever the surface.
  Vector3 at(const Positions& positions, int triangle, const std::array<double, 3>& weights) const;
  /// How far a point is from the surface, if `nearest` on that triangle is the nearest point of all; below 0 behind it.
  Distance distance(const Positions& positions, int triangle, const NearestPoint& nearest, const Vector3& point) const;

 private:
  Cells<3> triangles_;
  Rows around_;
};

}  // namespace elastin::contact
