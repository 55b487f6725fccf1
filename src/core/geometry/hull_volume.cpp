#include "core/geometry/hull_volume.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <map>
#include <utility>
#include <vector>

namespace elastin {
namespace {

class Hull {
 public:
  explicit Hull(const Positions& points) : points_(points) {
    const Vector3 low = points.rowwise().minCoeff(), high = points.rowwise().maxCoeff();
    slack_ = 1e-9 * (high - low).norm();
  }

  double volume() {
    if (!begin()) return 0;
    while (grow()) {
    }
    double sum = 0;
    const Vector3 origin = points_.col(facets_.front().corners[0]);
    for (const Facet& facet : facets_) {
      const auto corner = [&](std::size_t i) { return Vector3(points_.col(facet.corners[i]) - origin); };
      sum += corner(0).dot(corner(1).cross(corner(2))) / 6;
    }
    return sum;
  }

 private:
  struct Facet {
    std::array<int, 3> corners;  ///< counter-clockwise seen from outside
    Vector3 normal;
    double offset;
    std::vector<int> outside;  ///< points beyond it that no facet before it has
    double furthest = 0;
    int peak = -1;
  };

  double height(const Facet& facet, int point) const { return facet.normal.dot(points_.col(point)) - facet.offset; }

  Facet facet_of(int a, int b, int c) const {
    const Vector3 first = points_.col(a),
                  normal = Vector3(points_.col(b) - first).cross(Vector3(points_.col(c) - first)).normalized();
    return {{a, b, c}, normal, normal.dot(first), {}, 0, -1};
  }

  void offer(int point, std::vector<Facet>& facets, std::size_t from) const {
    for (std::size_t i = from; i < facets.size(); ++i) {
      Facet& facet = facets[i];
      const double above = height(facet, point);
      if (!(above > slack_)) continue;
      facet.outside.push_back(point);
      if (above > facet.furthest) facet.furthest = above, facet.peak = point;
      return;
    }
  }

  /// The tetrahedron of points far from each other; false where all lie in one plane.
  bool begin() {
    const int count = static_cast<int>(points_.cols());
    if (count < 4) return false;
    const auto furthest = [&](const auto& distance) {
      int best = 0;
      for (int i = 1; i < count; ++i)
        if (distance(i) > distance(best)) best = i;
      return best;
    };
    const int a = furthest([&](int i) { return -points_(0, i); });
    const Vector3 first = points_.col(a);
    int b = furthest([&](int i) { return (points_.col(i) - first).squaredNorm(); });
    const Vector3 along = (points_.col(b) - first).normalized();
    int c = furthest([&](int i) { return along.cross(Vector3(points_.col(i) - first)).squaredNorm(); });
    const Facet base = facet_of(a, b, c);
    const int d = furthest([&](int i) { return std::abs(height(base, i)); });
    if (!(std::abs(height(base, d)) > slack_)) return false;
    if (height(base, d) > 0) std::swap(b, c);
    facets_ = {facet_of(a, b, c), facet_of(a, d, b), facet_of(b, d, c), facet_of(c, d, a)};
    for (int i = 0; i < count; ++i) offer(i, facets_, 0);
    return true;
  }

  /// Takes the furthest point beyond a facet in; false where none is left.
  bool grow() {
    const auto open = std::find_if(facets_.begin(), facets_.end(), [](const Facet& f) { return f.peak >= 0; });
    if (open == facets_.end()) return false;
    const int peak = open->peak;
    std::map<std::pair<int, int>, int> sides;  // of the facets that the point sees; those that stand once are its rim
    std::vector<int> loose;
    std::vector<Facet> kept;
    for (Facet& facet : facets_) {
      if (!(height(facet, peak) > slack_)) {
        kept.push_back(std::move(facet));
        continue;
      }
      for (std::size_t i = 0; i < 3; ++i) ++sides[{facet.corners[i], facet.corners[(i + 1) % 3]}];
      loose.insert(loose.end(), facet.outside.begin(), facet.outside.end());
    }
    const std::size_t from = kept.size();
    for (const auto& [side, count] : sides)
      if (!sides.contains({side.second, side.first})) kept.push_back(facet_of(side.first, side.second, peak));
    facets_ = std::move(kept);
    for (const int point : loose)
      if (point != peak) offer(point, facets_, from);
    return true;
  }

  const Positions& points_;
  double slack_;
  std::vector<Facet> facets_;
};

}  // namespace

double hull_volume(const Positions& points) { return Hull(points).volume(); }

}  // namespace elastin
