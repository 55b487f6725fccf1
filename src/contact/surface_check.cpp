#include "contact/surface_check.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <vector>

#include "contact/triangles_cross.h"
#include "core/geometry/box_tree.h"
#include "core/shapes/surfaces.h"

namespace elastin::contact {
namespace {

using Triangle = std::array<int, 3>;

std::string text(const Vector3& position) {
  char words[100];
  std::snprintf(words, sizeof words, "(%.6g, %.6g, %.6g) m", position.x(), position.y(), position.z());
  return words;
}

std::string count_text(std::size_t count, const char* one, const char* many) {
  return count == 1 ? std::string("one ") + one : std::to_string(count) + " " + many;
}

/// A side of a triangle.
struct Edge {
  std::array<int, 2> ends;  ///< ascending
  bool forwards;            ///< whether the triangle goes round in that order
  int triangle;
};

std::vector<Edge> sorted_edges(const Cells<3>& triangles) {
  std::vector<Edge> sides;
  sides.reserve(3 * triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const int a = triangles[t][k], b = triangles[t][(k + 1) % 3];
      sides.push_back({{std::min(a, b), std::max(a, b)}, a < b, static_cast<int>(t)});
    }
  std::stable_sort(sides.begin(), sides.end(), [](const Edge& x, const Edge& y) { return x.ends < y.ends; });
  return sides;
}

/// Sides that have not two triangles which go along them in opposite ways.
struct OddSides {
  std::vector<Edge> alone, crowded, turned;
  explicit OddSides(const Cells<3>& triangles) {
    const std::vector<Edge> sides = sorted_edges(triangles);
    for (std::size_t i = 0, next; i < sides.size(); i = next) {
      for (next = i + 1; next < sides.size() && sides[next].ends == sides[i].ends;) ++next;
      if (next == i + 1) alone.push_back(sides[i]);
      if (next > i + 2) crowded.push_back(sides[i]);
      if (next == i + 2 && sides[i].forwards == sides[i + 1].forwards) turned.push_back(sides[i]);
    }
  }
};

using Corners = std::array<Vector3, 3>;

/// Of a triangle's size: triangles that meet by less than that touch, but for rounding, and do not cross.
constexpr double kTouching = 1e-9;

/// The triangle, smaller by kTouching about its middle.
Corners without_rim(const Corners& corners) {
  const Vector3 middle = (corners[0] + corners[1] + corners[2]) / 3;
  Corners inner;
  for (int k = 0; k < 3; ++k) inner[k] = corners[k] + kTouching * (middle - corners[k]);
  return inner;
}

Vector3 normal_of(const Corners& corners) {
  return (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized();
}

/// The least and the largest of what the corners have along a direction.
std::array<double, 2> range_along(const Vector3& direction, const Corners& corners, const Vector3& from) {
  const double a = direction.dot(corners[0] - from), b = direction.dot(corners[1] - from),
               c = direction.dot(corners[2] - from);
  return {std::min({a, b, c}), std::max({a, b, c})};
}

/// Whether triangles in one plane share a part of it.
bool overlap_in_plane(const Corners& one, const Corners& other) {
  const Vector3 normal = normal_of(one);
  for (const Corners* corners : {&one, &other})
    for (int k = 0; k < 3; ++k) {
      const Vector3 across = normal.cross((*corners)[(k + 1) % 3] - (*corners)[k]);
      const auto own = range_along(across, one, one[0]), others = range_along(across, other, one[0]);
      if (own[1] <= others[0] || others[1] <= own[0]) return false;
    }
  return true;
}

/// Whether triangles without a shared corner cross each other, and do not only touch but for rounding.
bool cross_apart(const Corners& one, const Corners& other) {
  const auto flat = [](const Corners& corners) {
    return kTouching * std::max((corners[1] - corners[0]).norm(), (corners[2] - corners[0]).norm());
  };
  const auto sides = [](const Corners& corners, const Corners& plane) {
    return range_along(normal_of(plane), corners, plane[0]);
  };
  const auto [one_least, one_most] = sides(one, other);
  const auto [other_least, other_most] = sides(other, one);
  const double one_flat = flat(one), other_flat = flat(other);
  if (std::max(-one_least, one_most) <= one_flat) return overlap_in_plane(without_rim(one), without_rim(other));
  const bool through =
      one_least < -one_flat && one_most > one_flat && other_least < -other_flat && other_most > other_flat;
  return through && triangles_cross(without_rim(one), without_rim(other));
}

/// Goes through the pairs of triangles whose boxes meet.
class CrossingSearch {
 public:
  CrossingSearch(const Positions& points, const Cells<3>& triangles, const std::function<bool(int, int)>& counts)
      : points_(points), triangles_(triangles), counts_(counts) {
    std::vector<Box> boxes;
    for (const auto& [a, b, c] : triangles)
      boxes.push_back({points.col(a).cwiseMin(points.col(b)).cwiseMin(points.col(c)),
                       points.col(a).cwiseMax(points.col(b)).cwiseMax(points.col(c))});
    tree_ = BoxTree(boxes);
    visit(0);
  }
  Crossings found{0, {std::numeric_limits<int>::max(), 0}};

 private:
  Vector3 point(int number) const { return points_.col(number); }

  void visit(int node) {
    const int second = tree_.nodes()[node].second;
    if (second < 0) return;
    visit(node + 1);
    visit(second);
    visit_pairs(node + 1, second);
  }
  void visit_pairs(int node, int other) {
    const BoxTree::Node& one = tree_.nodes()[node];
    const BoxTree::Node& two = tree_.nodes()[other];
    if (one.box.distance(two.box) > 0) return;
    if (one.second < 0 && two.second < 0) return look_at(std::min(one.item, two.item), std::max(one.item, two.item));
    if (two.second < 0 || (one.second >= 0 && one.box.half_diagonal() > two.box.half_diagonal())) {
      visit_pairs(node + 1, other);
      visit_pairs(one.second, other);
    } else {
      visit_pairs(node, other + 1);
      visit_pairs(node, two.second);
    }
  }

  void look_at(int a, int b) {
    if (counts_ && !counts_(a, b)) return;
    const Triangle &one = triangles_[a], &other = triangles_[b];
    std::vector<int> shared;
    for (const int corner : one)
      if (std::find(other.begin(), other.end(), corner) != other.end()) shared.push_back(corner);
    bool crossed = false;
    if (shared.empty())
      crossed = cross_apart({point(one[0]), point(one[1]), point(one[2])},
                            {point(other[0]), point(other[1]), point(other[2])});
    else if (shared.size() == 1)
      crossed = far_side_cuts(one, other, shared[0]) || far_side_cuts(other, one, shared[0]);
    if (!crossed) return;
    ++found.count;
    found.first = std::min(found.first, {a, b});
  }

  /// Six times the volume of a tetrahedron.
  double volume(int a, int b, int c, int d) const {
    return (point(b) - point(a)).cross(point(c) - point(a)).dot(point(d) - point(a));
  }
  /// Whether the side of `one` across from the shared corner goes through the inside of `other`, and not only through
  /// its rim or along its plane but for rounding.
  bool far_side_cuts(const Triangle& one, const Triangle& other, int shared) const {
    const int k = one[0] == shared ? 0 : one[1] == shared ? 1 : 2;
    const int from = one[(k + 1) % 3], to = one[(k + 2) % 3];
    const auto& [a, b, c] = other;
    const Vector3 twice_area = (point(b) - point(a)).cross(point(c) - point(a));
    const double before = volume(a, b, c, from), behind = volume(a, b, c, to),
                 flat = kTouching * twice_area.norm() * (point(to) - point(from)).norm();
    if (!(before * behind < 0 && std::min(std::abs(before), std::abs(behind)) > flat)) return false;
    const double ab = volume(from, to, a, b), bc = volume(from, to, b, c), ca = volume(from, to, c, a),
                 rim = kTouching * std::abs(ab + bc + ca);
    return (ab > rim && bc > rim && ca > rim) || (ab < -rim && bc < -rim && ca < -rim);
  }

  const Positions& points_;
  const Cells<3>& triangles_;
  const std::function<bool(int, int)>& counts_;
  BoxTree tree_;
};

std::string wrong_numbers(const Positions& points, const Cells<3>& triangles) {
  if (triangles.empty()) return "it has no triangles";
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (const int corner : triangles[t]) {
      if (corner < 0 || corner >= points.cols())
        return "triangle " + std::to_string(t) + " has point " + std::to_string(corner) + "; allowed: 0 to " +
               std::to_string(points.cols() - 1);
      if (!points.col(corner).allFinite()) return "point " + std::to_string(corner) + " has no finite coordinates";
    }
  return "";
}

}  // namespace

Crossings find_crossings(const Positions& points, const Cells<3>& triangles,
                         const std::function<bool(int, int)>& counts) {
  return triangles.empty() ? Crossings() : CrossingSearch(points, triangles, counts).found;
}

std::string check_surface(const Positions& points, const Cells<3>& triangles) {
  if (const std::string wrong = wrong_numbers(points, triangles); !wrong.empty()) return wrong;
  std::string problems;
  const auto add = [&](const std::string& problem) { problems += (problems.empty() ? "" : "; ") + problem; };
  const auto middle_of = [&](int t) {
    const auto& [a, b, c] = triangles[t];
    return text((points.col(a) + points.col(b) + points.col(c)) / 3);
  };
  const auto middle_of_side = [&](const Edge& side) {
    return text((points.col(side.ends[0]) + points.col(side.ends[1])) / 2);
  };

  Body surface;
  surface.triangles = triangles;
  const std::vector<int> flat = flat_triangles(surface, points);
  if (!flat.empty())
    add(count_text(flat.size(), "triangle has no area", "triangles have no area") + ", the first is triangle " +
        std::to_string(flat[0]) + " near " + middle_of(flat[0]));
  const OddSides odd(triangles);
  if (odd.alone.size() == 3 * triangles.size())
    add("no two triangles share a side: points that lie on each other must be one point");
  else if (!odd.alone.empty())
    add("it has holes: " + count_text(odd.alone.size(), "side belongs", "sides belong") +
        " to one triangle alone, the first near " + middle_of_side(odd.alone[0]));
  if (!odd.crowded.empty())
    add(count_text(odd.crowded.size(), "side belongs", "sides belong") +
        " to more than two triangles, the first near " + middle_of_side(odd.crowded[0]));
  if (!odd.turned.empty())
    add("triangles are turned against their neighbours at " + count_text(odd.turned.size(), "side", "sides") +
        ", the first near " + middle_of_side(odd.turned[0]));
  const Crossings crossings = find_crossings(points, triangles);
  if (crossings.count > 0)
    add("it crosses itself: " + count_text(crossings.count, "pair", "pairs") +
        " of triangles cut each other, the first are triangles " + std::to_string(crossings.first[0]) + " and " +
        std::to_string(crossings.first[1]) + " near " + middle_of(crossings.first[0]));
  if (!problems.empty()) return problems;
  double volume = 0;
  for (const auto& triangle : triangles)
    volume += area_vector(points, triangle).dot(points.col(triangle[0]) - points.col(triangles[0][0])) / 3;
  if (volume < 0) return "it is inside out: its normals look inwards";
  return "";
}

}  // namespace elastin::contact
