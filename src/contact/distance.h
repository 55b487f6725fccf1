#pragma once
#include <memory>

#include "core/geometry/surface_normals.h"
#include "core/geometry/triangle.h"
#include "elastin/contact/obstacle.h"

namespace elastin::contact {

/// How far a point is from a solid.
struct Distance {
  double value;     ///< [m], below 0 inside
  Vector3 normal;   ///< unit, ∂value/∂point: outwards from the nearest point of the surface
  Matrix3 turning;  ///< ∂normal/∂point [1/m], symmetric; 0 in front of what is flat
};

/// Signed distance to a shape, in its own frame. Where several places are equally near (on an axis, at a centre) one of
/// them counts: the normal is always a unit vector.
class SignedDistance {
 public:
  /// Throws InputError on sizes that are not above 0, on points without a hull and on meshes without triangles.
  explicit SignedDistance(const ObstacleShape& shape);
  ~SignedDistance();
  SignedDistance(SignedDistance&&) noexcept;
  Distance at(const Vector3& point) const;

  /// A shape's own test.
  struct Solid {
    virtual ~Solid() = default;
    virtual Distance at(const Vector3& point) const = 0;
  };

 private:
  std::unique_ptr<Solid> solid_;
};

/// Of a closed surface of triangles, normals outwards: the nearest point by a tree of boxes, inside or outside by its
/// angle-weighted normal [Baerentzen & Aanaes 2005]. Throws InputError without triangles or on corners that are no
/// points.
std::unique_ptr<SignedDistance::Solid> make_mesh_distance(const Positions& points, const Cells<3>& triangles);

/// Of the convex hull of points. Throws InputError where they have none: too few, or all in one plane.
std::unique_ptr<SignedDistance::Solid> make_hull_distance(const Positions& points);

/// How far a point is from a surface, if `nearest` on that triangle is the nearest point of all; below 0 behind it.
Distance distance_to_surface(const SurfaceNormals& normals, const Positions& positions, int triangle,
                             const NearestPoint& nearest, const Vector3& point);

/// How deep a point may get into an obstacle before the shortest way out is another than it came [m]; infinite of a
/// plane.
double half_thickness(const ObstacleShape& obstacle);

}  // namespace elastin::contact
