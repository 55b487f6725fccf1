#include "mesh/surface_repair.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <numbers>

#include "core/geometry/triangle_tree.h"
#include "elastin/core/base/text.h"

namespace elastin::mesh {
namespace {

constexpr double kSmallHole = 0.02, kTriangleHole = 0.1;  ///< of the surface's area; the latter with three sides
constexpr double kFlat = 1e-12;  ///< of a triangle's longest side squared, as in flat_triangles

using Triangle = std::array<int, 3>;
using Edge = std::array<int, 2>;

/// The triangles at each side; sides are ascending.
std::map<Edge, std::vector<int>> triangles_at_sides(const Cells<3>& triangles) {
  std::map<Edge, std::vector<int>> sides;
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [a, b] = std::minmax(triangles[t][k], triangles[t][(k + 1) % 3]);
      sides[{a, b}].push_back(static_cast<int>(t));
    }
  return sides;
}

bool goes_along(const Triangle& triangle, int from, int to) {
  for (std::size_t k = 0; k < 3; ++k)
    if (triangle[k] == from && triangle[(k + 1) % 3] == to) return true;
  return false;
}

double area(const Vector3& a, const Vector3& b, const Vector3& c) { return (b - a).cross(c - a).norm() / 2; }

template <class Unwanted>
std::size_t drop(Cells<3>& triangles, const Unwanted& unwanted) {
  Cells<3> left;
  for (std::size_t t = 0; t < triangles.size(); ++t)
    if (!unwanted(static_cast<int>(t))) left.push_back(triangles[t]);
  const std::size_t dropped = triangles.size() - left.size();
  triangles = std::move(left);
  return dropped;
}

class Repair {
 public:
  Repair(const Positions& points, const Cells<3>& triangles) {
    surface_.points = points, surface_.triangles = triangles;
    for (const auto& [a, b, c] : triangles) area_ += area(point(a), point(b), point(c));
    drop_copies();
    drop_spare();
    turn_like_neighbours();
    close_holes();
    turn_shells();
    leave_out_unused();
  }
  RepairedSurface surface_;

 private:
  Cells<3>& triangles() { return surface_.triangles; }
  Vector3 point(int number) const { return surface_.points.col(number); }
  void say(std::size_t count, const std::string& one, const std::string& many, const std::string& done) {
    if (count > 0) surface_.repairs.push_back(counted(static_cast<std::ptrdiff_t>(count), one, many) + " " + done);
  }

  /// Two of the same three corners are one where they look the same way, and nothing where they stand back to back.
  void drop_copies() {
    std::map<Triangle, std::vector<int>> same;
    for (std::size_t t = 0; t < triangles().size(); ++t) {
      Triangle corners = triangles()[t];
      std::sort(corners.begin(), corners.end());
      same[corners].push_back(static_cast<int>(t));
    }
    std::vector<char> unwanted(triangles().size(), 0);
    std::size_t twice = 0, back_to_back = 0;
    for (const auto& [corners, all] : same) {
      std::array<std::vector<int>, 2> ways;
      for (const int t : all) ways[goes_along(triangles()[t], corners[0], corners[1])].push_back(t);
      for (std::vector<int>& way : ways)
        for (; way.size() > 1; way.pop_back(), ++twice) unwanted[way.back()] = 1;
      if (ways[0].empty() || ways[1].empty()) continue;
      unwanted[ways[0][0]] = unwanted[ways[1][0]] = 1;
      ++back_to_back;
    }
    drop(triangles(), [&](int t) { return unwanted[t] != 0; });
    say(twice, "triangle", "triangles", "that stood twice dropped");
    say(back_to_back, "pair of triangles", "pairs of triangles", "back to back dropped");
  }

  void drop_spare() {
    std::size_t spare = 0;
    for (std::size_t dropped = 1; dropped > 0 && !triangles().empty(); spare += dropped) {
      std::vector<std::array<int, 2>> count(triangles().size());  // sides without another triangle, sides of many
      for (const auto& [side, at] : triangles_at_sides(triangles()))
        for (const int t : at) count[t][0] += at.size() == 1, count[t][1] += at.size() > 2;
      dropped = drop(triangles(), [&](int t) { return count[t][0] == 3 || (count[t][0] > 0 && count[t][1] > 0); });
    }
    say(spare, "spare triangle", "spare triangles", "dropped");
  }

  /// Numbers of the shells that hang together over sides of two triangles, one a triangle; `visit` sees each pair once.
  template <class Visit>
  std::vector<int> shells(const Visit& visit) {
    std::vector<std::vector<std::pair<int, Edge>>> neighbours(triangles().size());
    for (const auto& [side, at] : triangles_at_sides(triangles()))
      if (at.size() == 2) neighbours[at[0]].push_back({at[1], side}), neighbours[at[1]].push_back({at[0], side});
    std::vector<int> shell(triangles().size(), -1), next;
    shells_ = 0;
    for (std::size_t first = 0; first < shell.size(); ++first) {
      if (shell[first] >= 0) continue;
      shell[first] = shells_;
      for (next = {static_cast<int>(first)}; !next.empty();) {
        const int t = next.back();
        next.pop_back();
        for (const auto& [other, side] : neighbours[t])
          if (shell[other] < 0) {
            visit(t, other, side);
            shell[other] = shells_;
            next.push_back(other);
          }
      }
      ++shells_;
    }
    return shell;
  }
  void turn(int t) { std::swap(triangles()[t][1], triangles()[t][2]); }

  void turn_like_neighbours() {
    std::vector<char> turned(triangles().size(), 0);
    const std::vector<int> shell = shells([&](int t, int other, const Edge& side) {
      if (goes_along(triangles()[t], side[0], side[1]) != goes_along(triangles()[other], side[0], side[1])) return;
      turn(other);
      turned[other] = 1;
    });
    std::vector<std::array<std::size_t, 2>> count(static_cast<std::size_t>(shells_));
    for (std::size_t t = 0; t < turned.size(); ++t) ++count[shell[t]][turned[t]];
    std::size_t all = 0;
    for (const auto& [as_they_were, against] : count) all += std::min(as_they_were, against);
    for (std::size_t t = 0; t < turned.size(); ++t)  // as most of them were
      if (count[shell[t]][1] > count[shell[t]][0]) turn(static_cast<int>(t));
    say(all, "triangle", "triangles", "turned like the neighbours");
  }

  /// Loops of sides of one triangle alone: small ones get triangles about their middle.
  void close_holes() {
    std::map<int, int> next, uses;
    for (const auto& [side, at] : triangles_at_sides(triangles())) {
      if (at.size() != 1) continue;
      const bool along = goes_along(triangles()[at[0]], side[0], side[1]);
      next[side[along]] = side[!along];  // a triangle in the hole goes the other way
      ++uses[side[along]];
    }
    std::size_t closed = 0;
    double widest = 0;
    while (!next.empty()) {
      std::vector<int> loop;
      bool simple = true;
      for (int at = next.begin()->first; next.contains(at);) {
        loop.push_back(at);
        simple = simple && uses[at] == 1;
        const int to = next[at];
        next.erase(at);
        simple = simple && (next.contains(to) || to == loop[0]);
        at = to;
      }
      Vector3 middle = Vector3::Zero();
      for (const int p : loop) middle += point(p) / static_cast<double>(loop.size());
      double width = 0, own_area = 0;
      for (std::size_t k = 0; k < loop.size(); ++k) {
        for (const int other : loop) width = std::max(width, (point(loop[k]) - point(other)).norm());
        own_area += area(point(loop[k]), point(loop[(k + 1) % loop.size()]), middle);
      }
      if (!simple || loop.size() < 3 || own_area > (loop.size() == 3 ? kTriangleHole : kSmallHole) * area_) {
        surface_.widest_hole = std::max(surface_.widest_hole, width);
        continue;
      }
      ++closed;
      widest = std::max(widest, width);
      if (loop.size() == 3) {
        triangles().push_back({loop[0], loop[1], loop[2]});
        continue;
      }
      const auto centre = static_cast<int>(surface_.points.cols());
      surface_.points.conservativeResize(3, centre + 1);
      surface_.points.col(centre) = middle;
      for (std::size_t k = 0; k < loop.size(); ++k)
        triangles().push_back({loop[k], loop[(k + 1) % loop.size()], centre});
    }
    say(closed, "hole", "holes", "closed, the widest " + number(1e3 * widest, 3) + " mm across");
  }

  struct Shell {
    Cells<3> triangles;
    bool closed = true;
    double volume = 0;
    Box box{Vector3::Constant(std::numeric_limits<double>::infinity()),
            Vector3::Constant(-std::numeric_limits<double>::infinity())};
  };

  /// Whether a shell is in another one: where both cross, neither is.
  bool holds(const Shell& outer, const TriangleTree& tree, const Shell& inner) const {
    constexpr std::size_t samples = 64;
    for (std::size_t t = 0; t < inner.triangles.size(); t += 1 + inner.triangles.size() / samples)
      for (const int corner : inner.triangles[t])
        if (!(tree.signed_distance(point(corner)) * (outer.volume < 0 ? -1 : 1) < 0)) return false;
    return true;
  }

  void turn_shells() {
    const std::vector<int> shell = shells([](int, int, const Edge&) {});
    std::vector<Shell> all(static_cast<std::size_t>(shells_));
    for (std::size_t t = 0; t < shell.size(); ++t) {
      Shell& own = all[shell[t]];
      own.triangles.push_back(triangles()[t]);
      for (const int corner : triangles()[t])
        own.box = {own.box.low.cwiseMin(point(corner)), own.box.high.cwiseMax(point(corner))};
    }
    for (Shell& own : all) {
      for (const auto& [side, at] : triangles_at_sides(own.triangles)) own.closed = own.closed && at.size() == 2;
      for (const auto& [a, b, c] : own.triangles) {
        const Vector3 from = own.box.middle();
        own.volume += (point(a) - from).dot((point(b) - from).cross(point(c) - from)) / 6;
      }
    }
    std::vector<int> depth(all.size(), 0);
    for (const Shell& outer : all) {
      std::unique_ptr<TriangleTree> tree;
      for (std::size_t i = 0; outer.closed && i < all.size(); ++i) {
        const Shell& inner = all[i];
        if (&inner == &outer || !((inner.box.low - outer.box.low).array() >= 0).all() ||
            !((outer.box.high - inner.box.high).array() >= 0).all())
          continue;
        if (!tree) tree = std::make_unique<TriangleTree>(surface_.points, outer.triangles);
        depth[i] += holds(outer, *tree, inner);
      }
    }
    std::array<std::size_t, 2> turned{};
    std::vector<char> wrong(all.size(), 0);
    for (std::size_t i = 0; i < all.size(); ++i) {
      wrong[i] = (all[i].volume < 0) != (depth[i] % 2 == 1);
      turned[static_cast<std::size_t>(depth[i] % 2)] += wrong[i] != 0;
    }
    for (std::size_t t = 0; t < shell.size(); ++t)
      if (wrong[shell[t]]) turn(static_cast<int>(t));
    say(turned[0], "shell that was", "shells that were", "inside out turned");
    say(turned[1], "inner shell", "inner shells", "turned to bound a cavity");
  }

  void leave_out_unused() {
    std::vector<int> number(static_cast<std::size_t>(surface_.points.cols()), -1), used;
    for (const Triangle& triangle : triangles())
      for (const int corner : triangle) number[corner] = 0;
    for (std::size_t p = 0; p < number.size(); ++p)
      if (number[p] == 0) number[p] = static_cast<int>(used.size()), used.push_back(static_cast<int>(p));
    for (Triangle& triangle : triangles())
      for (int& corner : triangle) corner = number[corner];
    surface_.points = surface_.points(Eigen::all, used).eval();
  }

  double area_ = 0;
  int shells_ = 0;
};

}  // namespace

RepairedSurface repair_surface(const Positions& points, const Cells<3>& triangles) {
  return Repair(points, triangles).surface_;
}

std::vector<std::string> drop_flat_triangles(const std::vector<Vector3>& points, Cells<3>& triangles) {
  const auto length = [&](int a, int b) { return (points[a] - points[b]).norm(); };
  std::size_t dropped = 0;
  for (int round = 0; round < 20; ++round) {
    std::vector<char> flat(triangles.size(), 0), touched(triangles.size(), 0);
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      const auto& [a, b, c] = triangles[t];
      const double longest = std::max({length(a, b), length(b, c), length(c, a)});
      flat[t] = !(area(points[a], points[b], points[c]) > kFlat * longest * longest);
    }
    if (std::find(flat.begin(), flat.end(), 1) == flat.end()) break;
    const auto sides = triangles_at_sides(triangles);
    Cells<3> added;
    for (std::size_t t = 0; t < flat.size(); ++t) {
      if (!flat[t] || touched[t]) continue;
      Triangle own = triangles[t];
      for (int turn = 0; turn < 2 && length(own[0], own[1]) < std::max(length(own[1], own[2]), length(own[2], own[0]));
           ++turn)
        std::rotate(own.begin(), own.begin() + 1, own.end());
      touched[t] = 1;
      ++dropped;
      const auto [from, to, middle] = own;
      if (from == to || to == middle || middle == from) continue;
      for (const int other : sides.at({std::min(from, to), std::max(from, to)})) {  // splits the neighbour
        if (touched[other] || flat[other]) continue;
        touched[other] = 1;
        for (const int replaced : {from, to}) {
          Triangle half = triangles[other];
          std::replace(half.begin(), half.end(), replaced, middle);
          added.push_back(half);
        }
        break;
      }
    }
    drop(triangles, [&](int t) { return touched[t] != 0; });
    triangles.insert(triangles.end(), added.begin(), added.end());
  }
  if (dropped == 0) return {};
  return {counted(static_cast<std::ptrdiff_t>(dropped), "triangle") + " without area dropped"};
}

WindingNumber::WindingNumber(const Positions& points, const Cells<3>& triangles) {
  std::vector<Box> boxes;
  for (const auto& [a, b, c] : triangles) {
    const std::array<Vector3, 3> x{points.col(a), points.col(b), points.col(c)};
    corners_.push_back(x);
    boxes.push_back({x[0].cwiseMin(x[1]).cwiseMin(x[2]), x[0].cwiseMax(x[1]).cwiseMax(x[2])});
  }
  tree_ = BoxTree(boxes);
  const std::size_t count = tree_.nodes().size();
  area_.resize(count), middle_.resize(count), reach_.resize(count);
  std::vector<double> weight(count);
  for (std::size_t n = count; n-- > 0;) {
    const BoxTree::Node& node = tree_.nodes()[n];
    if (node.second < 0) {
      const auto& [a, b, c] = corners_[node.item];
      area_[n] = (b - a).cross(c - a) / 2;
      middle_[n] = (a + b + c) / 3;
      weight[n] = area_[n].norm();
    } else {
      const auto second = static_cast<std::size_t>(node.second);
      area_[n] = area_[n + 1] + area_[second];
      weight[n] = weight[n + 1] + weight[second];
      middle_[n] = (weight[n + 1] * middle_[n + 1] + weight[second] * middle_[second]) / weight[n];
    }
    reach_[n] = (node.box.high - middle_[n]).cwiseMax(middle_[n] - node.box.low).norm();
  }
}

double WindingNumber::sum(int node, const Vector3& point) const {
  constexpr double far = 3;
  const Vector3 to = middle_[node] - point;
  const double distance = to.norm();
  if (distance > far * reach_[node]) return area_[node].dot(to) / (4 * std::numbers::pi * std::pow(distance, 3));
  const int second = tree_.nodes()[node].second;
  if (second >= 0) return sum(node + 1, point) + sum(second, point);
  const auto& [x, y, z] = corners_[tree_.nodes()[node].item];
  const Vector3 a = x - point, b = y - point, c = z - point;
  const double la = a.norm(), lb = b.norm(), lc = c.norm();
  return std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb) /
         (2 * std::numbers::pi);
}

}  // namespace elastin::mesh
