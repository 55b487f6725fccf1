#include "contact/distance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

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

namespace {

/// Distance from a core (a point, a line) that is `radius` thick, at `away` [m] from the nearest point of the core;
/// `free` projects on the directions in which that position stays.
Distance around(const Vector3& away, double radius, const Matrix3& free, const Vector3& fallback) {
  const double length = away.norm();
  if (!(length > 1e-12 * radius)) return {length - radius, fallback, Matrix3::Zero()};
  const Vector3 normal = away / length;
  return {length - radius, normal, (free - normal * normal.transpose()) / length};
}

struct HalfSpace final : SignedDistance::Solid {
  Distance at(const Vector3& point) const override { return {point.z(), Vector3::UnitZ(), Matrix3::Zero()}; }
};

struct Ball final : SignedDistance::Solid {
  explicit Ball(double r) : radius(r) {}
  double radius;
  Distance at(const Vector3& point) const override {
    return around(point, radius, Matrix3::Identity(), Vector3::UnitZ());
  }
};

struct Rod final : SignedDistance::Solid {
  Rod(double r, double length) : radius(r), half(length / 2) {}
  double radius, half;
  Distance at(const Vector3& point) const override {
    const double along = std::clamp(point.z(), -half, half);
    Matrix3 free = Matrix3::Identity();
    if (along == point.z()) free(2, 2) = 0;
    return around(point - along * Vector3::UnitZ(), radius, free, Vector3::UnitX());
  }
};

struct Brick final : SignedDistance::Solid {
  explicit Brick(const Vector3& size) : half(size / 2) {}
  Vector3 half;
  Distance at(const Vector3& point) const override {
    const Vector3 beyond = point.cwiseAbs() - half;
    Vector3 away = beyond.cwiseMax(0);
    const double length = away.norm();
    if (!(length > 0)) {
      int axis = 0;
      const double depth = beyond.maxCoeff(&axis);
      return {depth, (point[axis] < 0 ? -1. : 1.) * Vector3::Unit(axis), Matrix3::Zero()};
    }
    Matrix3 free = Matrix3::Zero();
    for (int axis = 0; axis < 3; ++axis) {
      if (beyond[axis] > 0) free(axis, axis) = 1;
      if (point[axis] < 0) away[axis] = -away[axis];
    }
    const Vector3 normal = away / length;
    if ((beyond.array() > 0).count() == 1) return {length, normal, Matrix3::Zero()};
    return {length, normal, (free - normal * normal.transpose()) / length};
  }
};

/// A cylinder: in the plane through its axis and the point a rectangle. A normal that leans outwards by `radial` turns
/// with the point about the axis, by radial / ρ.
struct Drum final : SignedDistance::Solid {
  Drum(double r, double length) : radius(r), half(length / 2) {}
  double radius, half;
  Distance at(const Vector3& point) const override {
    const double from_axis = std::hypot(point.x(), point.y());
    const bool on_axis = !(from_axis > 1e-12 * radius);
    const Vector3 out = on_axis ? Vector3::UnitX() : Vector3(point.x() / from_axis, point.y() / from_axis, 0);
    const Vector3 up = (point.z() < 0 ? -1. : 1.) * Vector3::UnitZ(), round = up.cross(out);
    const double beyond_side = from_axis - radius, beyond_end = std::abs(point.z()) - half;
    if (beyond_side > 0 && beyond_end > 0) {
      const double length = std::hypot(beyond_side, beyond_end);
      const Vector3 normal = (beyond_side * out + beyond_end * up) / length;
      const Vector3 across = (beyond_end * out - beyond_side * up) / length;
      return {
          length, normal,
          across * across.transpose() / length + beyond_side / length / from_axis * Matrix3(round * round.transpose())};
    }
    if (beyond_end >= beyond_side) return {beyond_end, up, Matrix3::Zero()};
    if (on_axis) return {beyond_side, out, Matrix3::Zero()};
    return {beyond_side, out, round * round.transpose() / from_axis};
  }
};

void require_positive(double value, const char* what) {
  if (!(value > 0) || !std::isfinite(value))
    throw InputError(std::string("an obstacle's ") + what + " is " + std::to_string(value) +
                     " m; allowed: above 0, finite");
}

std::unique_ptr<SignedDistance::Solid> solid(const shape::Plane&) { return std::make_unique<HalfSpace>(); }
std::unique_ptr<SignedDistance::Solid> solid(const shape::Box& box) {
  require_positive(box.size.minCoeff(), "size");
  return std::make_unique<Brick>(box.size);
}
std::unique_ptr<SignedDistance::Solid> solid(const shape::Sphere& sphere) {
  require_positive(sphere.radius, "radius");
  return std::make_unique<Ball>(sphere.radius);
}
std::unique_ptr<SignedDistance::Solid> solid(const shape::Cylinder& cylinder) {
  require_positive(cylinder.radius, "radius");
  require_positive(cylinder.length, "length");
  return std::make_unique<Drum>(cylinder.radius, cylinder.length);
}
std::unique_ptr<SignedDistance::Solid> solid(const shape::Capsule& capsule) {
  require_positive(capsule.radius, "radius");
  require_positive(capsule.length, "length");
  return std::make_unique<Rod>(capsule.radius, capsule.length);
}
std::unique_ptr<SignedDistance::Solid> solid(const shape::Convex& convex) { return make_hull_distance(convex.points); }
std::unique_ptr<SignedDistance::Solid> solid(const shape::Mesh& mesh) {
  return make_mesh_distance(mesh.points, mesh.triangles);
}

}  // namespace

SignedDistance::SignedDistance(const ObstacleShape& shape)
    : solid_(std::visit([](const auto& one) { return solid(one); }, shape)) {}
SignedDistance::~SignedDistance() = default;
SignedDistance::SignedDistance(SignedDistance&&) noexcept = default;
Distance SignedDistance::at(const Vector3& point) const { return solid_->at(point); }

Distance distance_to_surface(const SurfaceNormals& normals, const Positions& positions, int triangle,
                             const NearestPoint& nearest, const Vector3& point) {
  const Vector3 outward = normals.at(positions, triangle, nearest.weights), away = point - nearest.position;
  const auto zeros = std::count(nearest.weights.begin(), nearest.weights.end(), 0);
  if (zeros == 0) return {away.dot(outward), outward, Matrix3::Zero()};
  const auto& [a, b, c] = normals.triangles()[triangle];
  const std::array<Vector3, 3> corners{positions.col(a), positions.col(b), positions.col(c)};
  const double length = away.norm(), sign = away.dot(outward) < 0 ? -1 : 1;
  // Rounding has a say in the direction of what is short; there it comes from the surface.
  const double size = std::max((corners[1] - corners[0]).norm(), (corners[2] - corners[0]).norm());
  if (!(length > 1e-9 * size)) return {sign * length, outward, Matrix3::Zero()};
  const Vector3 normal = sign / length * away;
  Matrix3 free = Matrix3::Identity() - normal * normal.transpose();
  if (zeros == 1) {
    const int out = nearest.weights[0] == 0 ? 0 : nearest.weights[1] == 0 ? 1 : 2;
    const Vector3 side = corners[(out + 2) % 3] - corners[(out + 1) % 3];
    const double side_length = side.norm();
    if (side_length > 0) free -= (side / side_length) * (side / side_length).transpose();
  }
  return {sign * length, normal, sign / length * free};
}

double half_thickness(const ObstacleShape& obstacle) {
  struct Visitor {
    double operator()(const shape::Plane&) const { return std::numeric_limits<double>::infinity(); }
    double operator()(const shape::Box& box) const { return box.size.minCoeff() / 2; }
    double operator()(const shape::Sphere& sphere) const { return sphere.radius; }
    double operator()(const shape::Cylinder& cylinder) const { return std::min(cylinder.radius, cylinder.length / 2); }
    double operator()(const shape::Capsule& capsule) const { return capsule.radius; }
    double operator()(const shape::Convex& convex) const { return of(convex.points); }
    double operator()(const shape::Mesh& mesh) const { return of(mesh.points); }
    static double of(const Positions& points) {
      return (points.rowwise().maxCoeff() - points.rowwise().minCoeff()).minCoeff() / 2;
    }
  };
  return std::visit(Visitor{}, obstacle);
}

}  // namespace elastin::contact
