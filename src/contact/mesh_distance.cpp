#include "contact/mesh_distance.h"

#include <string>

#include "contact/surface_distance.h"
#include "core/geometry/triangle_tree.h"
#include "elastin/core/base/error.h"
#include "hull/convex_hull.h"

namespace elastin::contact {
namespace {

class MeshSolid final : public SignedDistance::Solid {
 public:
  MeshSolid(const Positions& points, const Cells<3>& triangles) : tree_(points, triangles) {}

  Distance at(const Vector3& point) const override {
    const TriangleTree::Nearest nearest = tree_.nearest(point);
    return distance_to_surface(tree_.normals(), tree_.points(), nearest.triangle, nearest.on, point);
  }

 private:
  TriangleTree tree_;
};

}  // namespace

std::unique_ptr<SignedDistance::Solid> make_mesh_distance(const Positions& points, const Cells<3>& triangles) {
  if (triangles.empty()) throw InputError("an obstacle's mesh has no triangles");
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (const int corner : triangles[t])
      if (corner < 0 || corner >= points.cols())
        throw InputError("triangle " + std::to_string(t) + " of an obstacle's mesh has point " +
                         std::to_string(corner) + "; allowed: 0 to " + std::to_string(points.cols() - 1));
  if (!points.allFinite()) throw InputError("an obstacle's mesh has points that are no finite numbers");
  return std::make_unique<MeshSolid>(points, triangles);
}

std::unique_ptr<SignedDistance::Solid> make_hull_distance(const Positions& points) {
  if (!points.allFinite()) throw InputError("a convex obstacle has points that are no finite numbers");
  Cells<3> facets;
  const auto add = [&](const hull::HullFacet& facet) {
    std::array<int, 3> corners{facet.corners[0], facet.corners[1], facet.corners[2]};
    const Vector3 a = points.col(corners[0]), b = points.col(corners[1]), c = points.col(corners[2]);
    if ((b - a).cross(c - a).dot(Eigen::Map<const Vector3>(facet.normal)) < 0) std::swap(corners[1], corners[2]);
    facets.push_back(corners);
  };
  std::string problem = "fewer than 4 points";
  if (points.cols() >= 4) problem = hull::visit_hull(3, {points.data(), points.data() + points.size()}, true, add);
  if (!problem.empty()) throw InputError("the points of a convex obstacle have no hull: " + problem);
  return make_mesh_distance(points, facets);
}

}  // namespace elastin::contact
