#include "contact/thickness.h"

#include <algorithm>
#include <limits>

namespace elastin::contact {

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
