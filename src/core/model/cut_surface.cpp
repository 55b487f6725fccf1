
#include "elastin/core/base/error.h"
#include "elastin/core/model/topology.h"

namespace elastin {

CutSurface CutSurface::plane(const Vector3& point, const Vector3& normal) {
  if (!point.allFinite() || !normal.allFinite() || !(normal.norm() > 0))
    throw InputError("cut: a plane needs a finite point and a normal that is not zero");
  CutSurface surface;
  surface.plane_ = Plane{point, normal.normalized()};
  return surface;
}

CutSurface CutSurface::blade(const std::array<Vector3, 2>& from, const std::array<Vector3, 2>& to) {
  CutSurface surface;
  surface.add(from[0], from[1], to[1]);
  surface.add(from[0], to[1], to[0]);
  return surface;
}

CutSurface CutSurface::triangles(const Positions& points, const Cells<3>& triangles) {
  CutSurface surface;
  for (std::size_t number = 0; number < triangles.size(); ++number) {
    for (const int corner : triangles[number])
      if (corner < 0 || corner >= points.cols())
        throw InputError("cut: triangle " + std::to_string(number) + " has corner " + std::to_string(corner) +
                         "; there are " + std::to_string(points.cols()) + " points, from 0");
    const auto& [a, b, c] = triangles[number];
    surface.add(points.col(a), points.col(b), points.col(c));
  }
  return surface;
}

void CutSurface::add(const Vector3& a, const Vector3& b, const Vector3& c) {
  if (!a.allFinite() || !b.allFinite() || !c.allFinite())
    throw InputError("cut: a corner of the surface is not finite");
  const Vector3 normal = (b - a).cross(c - a);
  if (!(normal.norm() > 0)) return;  // a blade that stands still sweeps nothing
  triangles_.push_back({a, b - a, c - a, normal, a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c)});
}

bool CutSurface::crosses(const Vector3& from, const Vector3& to) const {
  if (plane_) return (plane_->normal.dot(from - plane_->point) >= 0) != (plane_->normal.dot(to - plane_->point) >= 0);
  constexpr double round = 1e-9;  // of a triangle's sides: nothing slips through between two of them
  for (const Triangle& t : triangles_) {
    const Vector3 low = from.cwiseMin(to), high = from.cwiseMax(to);
    if ((low.array() > t.high.array()).any() || (high.array() < t.low.array()).any()) continue;
    const double start = t.normal.dot(from - t.corner), end = t.normal.dot(to - t.corner);
    if ((start >= 0) == (end >= 0)) continue;
    const Vector3 there = from + start / (start - end) * (to - from) - t.corner;
    const double square = t.normal.squaredNorm(), first = t.normal.dot(there.cross(t.second)) / square,
                 second = t.normal.dot(t.first.cross(there)) / square;
    if (first >= -round && second >= -round && first + second <= 1 + round) return true;
  }
  return false;
}

}  // namespace elastin
