#pragma once
#include "core/geometry/box_tree.h"
#include "core/geometry/surface_normals.h"
#include "core/geometry/triangle.h"

namespace elastin {

/// Triangles at rest in a tree of boxes, for what is nearest to a point. Cost O(log n) a point, and no allocation. Safe
/// to share between threads.
class TriangleTree {
 public:
  struct Nearest {
    int triangle = -1;
    NearestPoint on;      ///< its weights are ≥ 0, sum 1
    double distance = 0;  ///< [m]
  };
  /// There must be a triangle.
  TriangleTree(Positions points, Cells<3> triangles);

  /// Where several triangles are equally near, any of them, the same each time.
  Nearest nearest(const Vector3& point) const;
  /// Distance [m], below 0 inside; of a closed surface with outward normals that does not cross itself. The sign is
  /// that of the nearest point's pseudonormal, which is exact. [Bærentzen & Aanæs 2005]
  double signed_distance(const Vector3& point) const;
  const Positions& points() const { return points_; }
  const Cells<3>& triangles() const { return normals_.triangles(); }
  const SurfaceNormals& normals() const { return normals_; }

 private:
  std::array<Vector3, 3> corners(int triangle) const;

  Positions points_;
  SurfaceNormals normals_;
  BoxTree tree_;
};

}  // namespace elastin
