#include "experiment/faces.h"

#include <algorithm>

#include "elastin/base/error.h"

namespace elastin {

Eigen::Matrix<double, 3, 2> across(const Vector3& axis) {
  int least = 0;
  axis.cwiseAbs().minCoeff(&least);
  const Vector3 first = axis.cross(Vector3::Unit(least)).normalized();
  Eigen::Matrix<double, 3, 2> plane;
  plane << first, axis.cross(first);
  return plane;
}

Face end_face(const Body& body, const Vector3& direction, double depth) {
  const VectorX height = body.rest.transpose() * direction;
  const double low = height.minCoeff(), high = height.maxCoeff();
  depth = std::max(depth, 1e-6 * (high - low));
  if (!(high - low > 2 * depth)) throw InputError("the body has no length along the axis beyond its grips");
  Face face;
  for (int molecule = 0; molecule < body.size(); ++molecule)
    if (height[molecule] >= high - depth) face.molecules.push_back(molecule);
  const auto count = static_cast<Eigen::Index>(face.molecules.size());
  Points2 layer(2, count);
  const auto plane = across(direction);
  for (Eigen::Index i = 0; i < count; ++i)
    layer.col(i) = plane.transpose() * body.rest.col(face.molecules[static_cast<std::size_t>(i)]);
  const Points2 outline = convex_hull(layer);
  face.area = polygon_area(outline);
  face.share = VectorX::Constant(count, 1. / static_cast<double>(count));
  if (!(face.area > 0)) return face;
  const std::vector<double> areas = tributary_areas(layer, outline);
  for (Eigen::Index i = 0; i < count; ++i) face.share[i] = areas[static_cast<std::size_t>(i)] / face.area;
  return face;
}

}  // namespace elastin
