#include "contact/mesh_distance.h"

#include <cmath>
#include <limits>
#include <string>

#include "contact/box_tree.h"
#include "contact/surface_normals.h"
#include "contact/triangle.h"
#include "elastin/core/base/error.h"
#include "hull/convex_hull.h"

namespace elastin::contact {
namespace {

class MeshSolid final : public SignedDistance::Solid {
 public:
  MeshSolid(Positions points, Cells<3> triangles)
      : points_(std::move(points)),
        triangles_(std::move(triangles)),
        normals_(static_cast<int>(points_.cols()), triangles_) {
    std::vector<Box> boxes(triangles_.size());
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      const auto [a, b, c] = corners(static_cast<int>(t));
      boxes[t] = {a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c)};
    }
    tree_ = BoxTree(boxes, std::vector<int>(boxes.size(), 0));
  }

  Distance at(const Vector3& point) const override {
    Nearest best;
    visit(0, tree_.nodes()[0].box.distance(point), point, best);
    return normals_.distance(points_, best.triangle, best.position, point);
  }

 private:
  struct Nearest {
    double distance = std::numeric_limits<double>::infinity();
    int triangle = 0;
    NearestPoint position{Vector3::Zero(), {1, 0, 0}};
  };

  std::array<Vector3, 3> corners(int triangle) const {
    const auto& [a, b, c] = triangles_[static_cast<std::size_t>(triangle)];
    return {points_.col(a), points_.col(b), points_.col(c)};
  }

  void visit(int node, double at_least, const Vector3& point, Nearest& best) const {
    if (!(at_least < best.distance)) return;
    const BoxTree::Node& here = tree_.nodes()[static_cast<std::size_t>(node)];
    if (here.second < 0) {
      const NearestPoint position = nearest_point(point, corners(here.item));
      const double distance = (point - position.position).norm();
      if (distance < best.distance) best = {distance, here.item, position};
      return;
    }
    const double first = tree_.nodes()[static_cast<std::size_t>(node) + 1].box.distance(point);
    const double second = tree_.nodes()[static_cast<std::size_t>(here.second)].box.distance(point);
    if (first <= second) {
      visit(node + 1, first, point, best);
      visit(here.second, second, point, best);
    } else {
      visit(here.second, second, point, best);
      visit(node + 1, first, point, best);
    }
  }

  Positions points_;
  Cells<3> triangles_;
  SurfaceNormals normals_;
  BoxTree tree_;
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
