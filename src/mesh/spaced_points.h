#pragma once
#include <cstdint>
#include <vector>

#include "core/geometry/point_buckets.h"
#include "elastin/core/model/body.h"

namespace elastin::mesh {

/// Points that keep a distance from each other, O(1) a question.
class SpacedPoints {
 public:
  /// @param reach the largest distance that will be searched [m].
  explicit SpacedPoints(double reach) : buckets_(reach) {}

  /// Whether no point lies closer than `distance` [m] ≤ reach. A point whose normal is turned away from `normal` by
  /// more than a right angle stands on another side of a thin body and does not count; zero normals always do.
  bool is_free(const Vector3& position, double distance, const Vector3& normal = Vector3::Zero()) const;
  void add(const Vector3& position, const Vector3& normal = Vector3::Zero());

  int size() const { return static_cast<int>(positions_.size()); }
  const std::vector<Vector3>& positions() const { return positions_; }

 private:
  std::vector<Vector3> positions_, normals_;
  PointBuckets buckets_;
};

/// Points on a closed surface, about `spacing` [m] apart: first on its corners and along its sides that turn by more
/// than 40°, then at random on its triangles, no two closer than 0.85 of the spacing.
void add_surface_points(const Positions& points, const Cells<3>& triangles, double spacing, std::uint64_t seed,
                        SpacedPoints& found);

}  // namespace elastin::mesh
