#pragma once
#include <memory>

#include "elastin/core/geometry/cells.h"

namespace elastin {

/// Triangles in a tree of boxes, for what is nearest to a point. Cost O(log n) a point. Safe to share between threads.
class TriangleTree {
 public:
  struct Nearest {
    int triangle = -1;
    Vector3 position;     ///< [m]
    Vector3 weights;      ///< of the triangle's corners, ≥ 0, sum 1
    double distance = 0;  ///< [m]
  };
  /// The triangles must have an area.
  TriangleTree(Positions points, Cells<3> triangles);
  ~TriangleTree();
  TriangleTree(TriangleTree&&) noexcept;

  Nearest nearest(const Vector3& point) const;
  /// Distance [m], below 0 inside; of a closed surface with outward normals that does not cross itself. The sign is
  /// that of the nearest point's pseudonormal, which is exact. [Bærentzen & Aanæs 2005]
  double signed_distance(const Vector3& point) const;
  const Positions& points() const;
  const Cells<3>& triangles() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace elastin
