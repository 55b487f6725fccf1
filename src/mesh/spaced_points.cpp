#include "mesh/spaced_points.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <utility>

#include "core/base/random.h"

namespace elastin::mesh {
namespace {

/// Cosine of the turn above which a side, or a corner between two sides, is sharp: 40°.
constexpr double kSharp = 0.766;
/// Candidates for each point that finds room: enough to leave few gaps.
constexpr int kTrials = 30;

/// The sharp sides of a surface, as a graph.
class SharpSides {
 public:
  SharpSides(const Positions& points, const Cells<3>& triangles) : points_(points) {
    std::map<std::array<int, 2>, Vector3> normals;
    for (const auto& triangle : triangles) {
      const Vector3 normal = (points.col(triangle[1]) - points.col(triangle[0]))
                                 .cross(points.col(triangle[2]) - points.col(triangle[0]))
                                 .normalized();
      for (std::size_t i = 0; i < 3; ++i) {
        const int a = triangle[i], b = triangle[(i + 1) % 3];
        const auto [other, fresh] = normals.try_emplace({std::min(a, b), std::max(a, b)}, normal);
        if (!fresh && other->second.dot(normal) < kSharp) ends_[a].push_back(b), ends_[b].push_back(a);
      }
    }
  }

  /// Where sides end, meet or turn.
  std::vector<int> corners() const {
    std::vector<int> found;
    for (const auto& [point, others] : ends_)
      if (is_corner(point)) found.push_back(point);
    return found;
  }

  /// Lines of points from corner to corner, and closed ones.
  std::vector<std::vector<int>> lines() const {
    std::map<std::array<int, 2>, bool> passed;
    std::vector<std::vector<int>> found;
    const auto follow = [&](int from, int to) {
      if (std::exchange(passed[{std::min(from, to), std::max(from, to)}], true)) return;
      std::vector<int> line{from, to};
      while (!is_corner(line.back()) && line.back() != line.front()) {
        const auto& next = ends_.at(line.back());
        const int on = next[0] == line[line.size() - 2] ? next[1] : next[0];
        passed[{std::min(line.back(), on), std::max(line.back(), on)}] = true;
        line.push_back(on);
      }
      found.push_back(std::move(line));
    };
    for (const bool from_corners : {true, false})
      for (const auto& [point, others] : ends_)
        if (is_corner(point) == from_corners)
          for (const int other : others) follow(point, other);
    return found;
  }

 private:
  bool is_corner(int point) const {
    const auto& others = ends_.at(point);
    if (others.size() != 2) return true;
    const Vector3 to = points_.col(point) - points_.col(others[0]), on = points_.col(others[1]) - points_.col(point);
    return to.normalized().dot(on.normalized()) < kSharp;
  }

  const Positions& points_;
  std::map<int, std::vector<int>> ends_;
};

/// Even points on a line between its ends; on a closed line its first point too.
void add_line(const Positions& points, const std::vector<int>& line, double spacing, SpacedPoints& found) {
  double length = 0;
  for (std::size_t i = 1; i < line.size(); ++i) length += (points.col(line[i]) - points.col(line[i - 1])).norm();
  const bool closed = line.front() == line.back();
  const int parts = std::max(closed ? 3 : 1, static_cast<int>(std::lround(length / spacing)));
  double passed = 0;
  int next = closed ? 0 : 1;
  for (std::size_t i = 1; i < line.size(); ++i) {
    const Vector3 from = points.col(line[i - 1]), segment = points.col(line[i]) - from;
    for (; next < parts && next * length / parts <= passed + segment.norm(); ++next) {
      const Vector3 position = from + (next * length / parts - passed) / segment.norm() * segment;
      if (found.is_free(position, 0.5 * spacing)) found.add(position);
    }
    passed += segment.norm();
  }
}

}  // namespace

bool SpacedPoints::is_free(const Vector3& position, double distance, const Vector3& normal) const {
  return !buckets_.visit_near(position, [&](int other) {
    return (positions_[other] - position).squaredNorm() < distance * distance && !(normals_[other].dot(normal) < 0);
  });
}

void SpacedPoints::add(const Vector3& position, const Vector3& normal) {
  buckets_.add(position, size());
  positions_.push_back(position);
  normals_.push_back(normal);
}

void add_surface_points(const Positions& points, const Cells<3>& triangles, double spacing, std::uint64_t seed,
                        SpacedPoints& found) {
  const SharpSides sharp(points, triangles);
  for (const int corner : sharp.corners())
    if (found.is_free(points.col(corner), 0.5 * spacing)) found.add(points.col(corner));
  for (const auto& line : sharp.lines()) add_line(points, line, spacing, found);

  std::vector<double> areas;  // summed up to each triangle
  std::vector<Vector3> normals;
  for (const auto& [a, b, c] : triangles) {
    const Vector3 area = (points.col(b) - points.col(a)).cross(points.col(c) - points.col(a)) / 2;
    areas.push_back((areas.empty() ? 0 : areas.back()) + area.norm());
    normals.push_back(area.normalized());
  }
  std::mt19937_64 generator(seed);
  const auto candidates = static_cast<long>(kTrials * areas.back() / (spacing * spacing));
  for (long candidate = 0; candidate < candidates; ++candidate) {
    const double at = areas.back() * unit_random(generator);
    const auto t = static_cast<std::size_t>(
        std::min<std::ptrdiff_t>(std::upper_bound(areas.begin(), areas.end(), at) - areas.begin(),
                                 static_cast<std::ptrdiff_t>(areas.size()) - 1));
    double u = unit_random(generator), v = unit_random(generator);
    if (u + v > 1) u = 1 - u, v = 1 - v;
    const auto& [a, b, c] = triangles[t];
    const Vector3 position = points.col(a) + u * (points.col(b) - points.col(a)) + v * (points.col(c) - points.col(a));
    if (found.is_free(position, 0.85 * spacing, normals[t])) found.add(position, normals[t]);
  }
}

}  // namespace elastin::mesh
