#include "febio/load_controller.h"

#include <algorithm>
#include <cmath>

namespace elastin::febio {
namespace {

using Point = std::array<double, 2>;

double line(double time, const Point& a, const Point& b) {
  return a[1] + (b[1] - a[1]) * (time - a[0]) / (b[0] - a[0]);
}

double parabola(double time, const Point& a, const Point& b, const Point& c) {
  const double ab = (b[1] - a[1]) / (b[0] - a[0]), bc = (c[1] - b[1]) / (c[0] - b[0]);
  return a[1] + (time - a[0]) * (ab + (time - b[0]) * (bc - ab) / (c[0] - a[0]));
}

}  // namespace

double LoadController::value(double time) const {
  if (formula) return formula(time);
  const Point &first = points.front(), &last = points.back();
  if (points.size() == 1) return first[1];
  if (time >= first[0] && time <= last[0]) return inside(time);
  const double span = last[0] - first[0];
  const bool before = time < first[0];
  if (extension == Extension::repeat) return inside(time - span * std::floor((time - first[0]) / span));
  if (extension == Extension::constant || interpolation == Interpolation::step) return before ? first[1] : last[1];
  const std::size_t n = points.size();
  if (interpolation == Interpolation::linear)
    return before ? line(time, first, points[1]) : line(time, points[n - 2], last);
  const double near = 1e-3 * span;
  return before ? line(time, first, {first[0] + near, inside(first[0] + near)})
                : line(time, {last[0] - near, inside(last[0] - near)}, last);
}

double LoadController::inside(double time) const {
  const auto found =
      std::lower_bound(points.begin(), points.end(), time, [](const Point& point, double at) { return point[0] < at; });
  const auto n = static_cast<std::size_t>(std::min(found - points.begin(), std::ptrdiff_t(points.size()) - 1));
  if (points[n][0] == time || n == 0) return points[n][1];
  if (interpolation == Interpolation::step) return points[n][1];
  const Point &before = points[n - 1], &after = points[n];
  const std::size_t size = points.size();
  if (interpolation == Interpolation::linear || size == 2) return line(time, before, after);
  if (n == 1) return parabola(time, before, after, points[2]);
  if (n == size - 1) return parabola(time, points[n - 2], before, after);
  const double left = parabola(time, points[n - 2], before, after),
               right = parabola(time, before, after, points[n + 1]);
  return line(time, {before[0], left}, {after[0], right});
}

}  // namespace elastin::febio
