#include "core/geometry/tributary.h"

#include <algorithm>
#include <cmath>

namespace elastin {
namespace {

using Point = Eigen::Vector2d;

double cross(const Point& a, const Point& b) { return a.x() * b.y() - a.y() * b.x(); }

/// What is left of a convex polygon on the side nearer to `mine` than to `other`.
std::vector<Point> nearer_half(const std::vector<Point>& polygon, const Point& mine, const Point& other) {
  const Point normal = other - mine, middle = (mine + other) / 2;
  std::vector<Point> left;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Point &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const double da = normal.dot(a - middle), db = normal.dot(b - middle);
    if (da <= 0) left.push_back(a);
    if ((da < 0 && db > 0) || (da > 0 && db < 0)) left.push_back(a + (b - a) * (da / (da - db)));
  }
  return left;
}

double area(const std::vector<Point>& polygon) {
  double twice = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) twice += cross(polygon[i], polygon[(i + 1) % polygon.size()]);
  return twice / 2;
}

/// Points sorted into square buckets of about two points each, so that neighbours are found ring by ring.
class Buckets {
 public:
  explicit Buckets(const Points2& points) : low_(points.rowwise().minCoeff()) {
    const Point spread = points.rowwise().maxCoeff() - low_;
    side_ = std::max(spread.maxCoeff() * 1e-6,
                     std::sqrt(2 * std::max(spread.prod(), 1e-300) / static_cast<double>(points.cols())));
    nx_ = static_cast<int>(spread.x() / side_) + 1;
    ny_ = static_cast<int>(spread.y() / side_) + 1;
    members_.resize(static_cast<std::size_t>(nx_) * ny_);
    for (int i = 0; i < points.cols(); ++i) members_[index(column(points.col(i)), row(points.col(i)))].push_back(i);
  }
  double side() const { return side_; }
  int rings() const { return std::max(nx_, ny_); }
  /// Calls visit(point) for every point whose bucket is `ring` buckets away from the centre's.
  template <class Visit>
  void ring(const Point& centre, int ring, Visit visit) const {
    const int cx = column(centre), cy = row(centre);
    for (int y = std::max(0, cy - ring); y <= std::min(ny_ - 1, cy + ring); ++y)
      for (int x = std::max(0, cx - ring); x <= std::min(nx_ - 1, cx + ring); ++x)
        if (std::max(std::abs(x - cx), std::abs(y - cy)) == ring)
          for (const int i : members_[index(x, y)]) visit(i);
  }

 private:
  int column(const Point& p) const { return std::clamp(static_cast<int>((p.x() - low_.x()) / side_), 0, nx_ - 1); }
  int row(const Point& p) const { return std::clamp(static_cast<int>((p.y() - low_.y()) / side_), 0, ny_ - 1); }
  std::size_t index(int x, int y) const { return static_cast<std::size_t>(y) * nx_ + x; }
  Point low_;
  double side_ = 0;
  int nx_ = 0, ny_ = 0;
  std::vector<std::vector<int>> members_;
};

/// Only once the hull is closed: while its chains grow, points of one upright side that rounding has put out of order
/// would take its true corners away.
void drop_straight_corners(std::vector<Point>& hull, double flat) {
  for (std::size_t i = 0; i < hull.size() && hull.size() > 2;) {
    const Point &before = hull[(i + hull.size() - 1) % hull.size()], &after = hull[(i + 1) % hull.size()];
    const Point to = hull[i] - before, on = after - hull[i];
    if (cross(to, on) <= flat && to.dot(on) >= 0) {
      hull.erase(hull.begin() + static_cast<std::ptrdiff_t>(i));
      if (i > 0) --i;
    } else {
      ++i;
    }
  }
}

}  // namespace

Points2 convex_hull(const Points2& points) {
  std::vector<Point> sorted;
  for (int i = 0; i < points.cols(); ++i) sorted.push_back(points.col(i));
  std::sort(sorted.begin(), sorted.end(),
            [](const Point& a, const Point& b) { return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y()); });
  const double spread = sorted.empty() ? 0 : (points.rowwise().maxCoeff() - points.rowwise().minCoeff()).norm();
  std::vector<Point> hull;
  for (int side = 0; side < 2; ++side) {  // lower chain, then upper [Andrew 1979]
    const std::size_t start = hull.size();
    for (const Point& p : sorted) {
      while (hull.size() >= start + 2 && cross(hull.back() - hull[hull.size() - 2], p - hull.back()) <= 0)
        hull.pop_back();
      hull.push_back(p);
    }
    if (!hull.empty()) hull.pop_back();
    std::reverse(sorted.begin(), sorted.end());
  }
  drop_straight_corners(hull, 1e-9 * spread * spread);
  Points2 corners(2, static_cast<Eigen::Index>(hull.size()));
  for (std::size_t i = 0; i < hull.size(); ++i) corners.col(static_cast<Eigen::Index>(i)) = hull[i];
  return corners;
}

double polygon_area(const Points2& polygon) {
  std::vector<Point> points;
  for (int i = 0; i < polygon.cols(); ++i) points.push_back(polygon.col(i));
  return points.size() < 3 ? 0 : area(points);
}

Eigen::Matrix2d polygon_second_moments(const Points2& polygon) {
  double twice_area = 0;
  Point first = Point::Zero();
  Eigen::Matrix2d second = Eigen::Matrix2d::Zero();
  const Point start = polygon.cols() > 0 ? Point(polygon.col(0)) : Point(0, 0);  // near the polygon: fewer digits lost
  for (int i = 0; i < polygon.cols(); ++i) {
    const Point a = polygon.col(i) - start, b = polygon.col((i + 1) % polygon.cols()) - start, sum = a + b;
    const double part = cross(a, b);
    twice_area += part;
    first += part * sum / 6;
    second += part * (a * a.transpose() + b * b.transpose() + sum * sum.transpose()) / 24;
  }
  if (twice_area == 0) return Eigen::Matrix2d::Zero();
  return second - 2 * first * first.transpose() / twice_area;
}

std::vector<double> tributary_areas(const Points2& points, const Points2& polygon) {
  std::vector<Point> outline;
  for (int i = 0; i < polygon.cols(); ++i) outline.push_back(polygon.col(i));
  const Buckets buckets(points);
  std::vector<double> areas(points.cols(), 0);
  for (int i = 0; i < points.cols(); ++i) {
    std::vector<Point> part = outline;
    const Point mine = points.col(i);
    for (int ring = 0; ring <= buckets.rings(); ++ring) {
      double reach = 0;  // a point further away than twice this cannot cut the part any more
      for (const Point& corner : part) reach = std::max(reach, (corner - mine).norm());
      if ((ring - 1) * buckets.side() > 2 * reach) break;
      buckets.ring(mine, ring, [&](int other) {
        if (other != i) part = nearer_half(part, mine, points.col(other));
      });
    }
    areas[i] = part.size() < 3 ? 0 : area(part);
  }
  return areas;
}

}  // namespace elastin
