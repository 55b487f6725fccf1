#include "contact/surface_check.h"

#include <algorithm>
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
      crossed = triangles_cross({point(one[0]), point(one[1]), point(one[2])},
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
  /// Whether the side of `one` across from the shared corner goes through the inside of `other`.
  bool far_side_cuts(const Triangle& one, const Triangle& other, int shared) const {
    const int k = one[0] == shared ? 0 : one[1] == shared ? 1 : 2;
    const int from = one[(k + 1) % 3], to = one[(k + 2) % 3];
    const auto& [a, b, c] = other;
    if (!(volume(a, b, c, from) * volume(a, b, c, to) < 0)) return false;
    const double ab = volume(from, to, a, b), bc = volume(from, to, b, c), ca = volume(from, to, c, a);
    return (ab > 0 && bc > 0 && ca > 0) || (ab < 0 && bc < 0 && ca < 0);
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
