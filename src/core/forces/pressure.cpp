#include "core/forces/pressure.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>

#include "core/base/cross_matrix.h"
#include "core/base/disjoint_sets.h"
#include "core/model/incidence.h"
#include "core/parallel/parallel.h"
#include "core/shapes/surfaces.h"
#include "elastin/core/base/error.h"

namespace elastin {
namespace {

/// The volume, and how it changes under a motion.
Eigen::Vector2d volume_and_change(const Cells<3>& triangles, const Positions& positions, const Vector3& apex,
                                  const Positions& motion) {
  return ordered_sum<Eigen::Vector2d>(
      static_cast<int>(triangles.size()),
      [&](int cell) -> Eigen::Vector2d {
        const auto& [a, b, c] = triangles[cell];
        const Vector3 x = positions.col(a) - apex, y = positions.col(b) - apex, z = positions.col(c) - apex;
        const Vector3 yz = y.cross(z), zx = z.cross(x), xy = x.cross(y);
        return {x.dot(yz) / 6, (yz.dot(motion.col(a)) + zx.dot(motion.col(b)) + xy.dot(motion.col(c))) / 6};
      },
      Eigen::Vector2d(0, 0));
}

}  // namespace

PressureLaw constant_pressure(double pressure) {
  return [=](double volume, double rest) { return PressureState{pressure, 0, pressure * (volume - rest)}; };
}

PressureLaw enclosed_gas(double amount, double exponent, double ambient) {
  return [=](double volume, double rest) {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    if (!(volume > 0)) return PressureState{infinity, -infinity, -infinity};
    const double absolute = amount / rest * std::pow(rest / volume, exponent);
    const double work =
        exponent == 1 ? amount * std::log(volume / rest) : (amount - absolute * volume) / (exponent - 1);
    return PressureState{absolute - ambient, -exponent * absolute / volume, work - ambient * (volume - rest)};
  };
}

PressureLaw controlled_volume(double volume, double stiffness, double pressure) {
  return [=](double now, double rest) {
    const double missing = volume - now, before = volume - rest;
    return PressureState{pressure + stiffness * missing, -stiffness,
                         pressure * (now - rest) + stiffness / 2 * (before - missing) * (before + missing)};
  };
}

double enclosed_volume(const Cells<3>& triangles, const Positions& positions, const Vector3& apex) {
  return ordered_sum(static_cast<int>(triangles.size()), [&](int cell) {
    const auto& [a, b, c] = triangles[cell];
    const Vector3 x = positions.col(a) - apex, y = positions.col(b) - apex, z = positions.col(c) - apex;
    return x.dot(y.cross(z)) / 6;
  });
}

SurfaceFindings inspect_surface(const Cells<3>& triangles) {
  struct Side {
    int triangle;
    bool ascending;
  };
  std::map<std::array<int, 2>, std::vector<Side>> sides;
  for (std::size_t cell = 0; cell < triangles.size(); ++cell)
    for (std::size_t i = 0; i < 3; ++i) {
      const int a = triangles[cell][i], b = triangles[cell][(i + 1) % 3];
      sides[{std::min(a, b), std::max(a, b)}].push_back({static_cast<int>(cell), a < b});
    }
  SurfaceFindings findings;
  for (const auto& [_, of] : sides) {
    findings.rim_sides += of.size() == 1;
    if (of.size() == 2 && of[0].ascending == of[1].ascending) findings.turned.push_back(of[1].triangle);
    if (of.size() > 2)
      for (const Side& side : of) findings.branchings.push_back(side.triangle);
  }
  for (std::vector<int>* list : {&findings.turned, &findings.branchings}) {
    std::sort(list->begin(), list->end());
    list->erase(std::unique(list->begin(), list->end()), list->end());
  }
  return findings;
}

std::vector<Cells<3>> pieces_of(const Cells<3>& triangles, Eigen::Index molecules) {
  DisjointSets sets(static_cast<std::size_t>(molecules));
  for (const auto& [a, b, c] : triangles) sets.join(a, b), sets.join(b, c);
  std::map<int, Cells<3>> by_set;
  for (const auto& triangle : triangles) by_set[sets.set_of(triangle[0])].push_back(triangle);
  std::vector<Cells<3>> pieces;
  for (auto& [_, piece] : by_set) pieces.push_back(std::move(piece));
  return pieces;
}

namespace {

/// Of a closed surface.
struct Closed {
  Cells<3> triangles;
  bool picked;
  double volume = 0;  ///< below 0 where it looks inwards [m³]
  Eigen::AlignedBox3d box = {};
  int around = -1;  ///< the smallest that it lies within
};

/// How often a closed surface goes round a position; ½ on it.                    [Van Oosterom & Strackee 1983]
double winding_number(const Cells<3>& triangles, const Positions& rest, const Vector3& position) {
  double angle = 0;
  for (const auto& [a, b, c] : triangles) {
    const Vector3 x = rest.col(a) - position, y = rest.col(b) - position, z = rest.col(c) - position;
    const double u = x.norm(), v = y.norm(), w = z.norm();
    angle += 2 * std::atan2(x.dot(y.cross(z)), u * v * w + x.dot(y) * w + y.dot(z) * u + z.dot(x) * v);
  }
  return std::abs(angle) / (4 * M_PI);
}

/// By the molecules at the sides of its box, of which one may touch.
bool lies_within(const Closed& piece, const Closed& other, const Positions& rest) {
  Eigen::AlignedBox3d box = other.box;
  box.extend((box.min().array() - 1e-9 * box.sizes().norm()).matrix());
  box.extend((box.max().array() + 1e-9 * box.sizes().norm()).matrix());
  if (!box.contains(piece.box)) return false;
  double sum = 0;
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {-1., 1.}) {
      int farthest = piece.triangles[0][0];
      for (const auto& triangle : piece.triangles)
        for (const int molecule : triangle)
          if (sign * rest(axis, molecule) > sign * rest(axis, farthest)) farthest = molecule;
      sum += winding_number(other.triangles, rest, rest.col(farthest));
    }
  return sum > 3;
}

void set_nesting(std::vector<Closed>& all, const Positions& rest) {
  for (Closed& piece : all) {
    piece.volume = enclosed_volume(piece.triangles, rest, rest.col(piece.triangles[0][0]));
    for (const auto& triangle : piece.triangles)
      for (const int molecule : triangle) piece.box.extend(rest.col(molecule));
  }
  for (Closed& piece : all)
    for (std::size_t i = 0; i < all.size(); ++i) {
      const bool smaller = piece.around < 0 || std::abs(all[i].volume) < std::abs(all[piece.around].volume);
      if (&piece != &all[i] && smaller && lies_within(piece, all[i], rest)) piece.around = static_cast<int>(i);
    }
}

/// Those that have no molecule of the ones picked.
Cells<3> other_triangles(const Cells<3>& picked, const Body& body) {
  std::vector<char> known(static_cast<std::size_t>(body.size()), 0);
  for (const auto& triangle : picked)
    for (const int molecule : triangle) known[molecule] = 1;
  Cells<3> others;
  for (const auto& triangle : body.triangles)
    if (std::none_of(triangle.begin(), triangle.end(), [&](int molecule) { return known[molecule]; }))
      others.push_back(triangle);
  return others;
}

}  // namespace

std::vector<Cells<3>> closed_spaces(const Cells<3>& triangles, const Body& body) {
  const std::string needs = "gas needs a closed surface of triangles that look outwards";
  std::vector<Closed> all;
  for (const Cells<3>& piece : pieces_of(triangles, body.size())) all.push_back({piece, true});
  for (const Closed& piece : all)
    if (inspect_surface(piece.triangles).rim_sides > 0)
      throw InputError(needs + (all.size() > 1 ? ", and the one of molecule " + std::to_string(piece.triangles[0][0]) +
                                                     " has a rim: let `on` pick the molecules of closed ones"
                                               : ""));
  for (const Cells<3>& piece : pieces_of(other_triangles(triangles, body), body.size()))
    if (inspect_surface(piece).rim_sides == 0) all.push_back({piece, false});
  set_nesting(all, body.rest);
  std::vector<Cells<3>> spaces;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Closed& outer = all[i];
    if (outer.picked && outer.volume < 0 && outer.around < 0)
      throw InputError(needs + ", and the one of molecule " + std::to_string(outer.triangles[0][0]) +
                       " looks inwards and lies within no other");
    if (!outer.picked || !(outer.volume > 0)) continue;
    Cells<3>& space = spaces.emplace_back(outer.triangles);
    for (const Closed& inner : all) {
      if (inner.around != static_cast<int>(i)) continue;
      for (const auto& [a, b, c] : inner.triangles)
        space.push_back(inner.volume > 0 ? std::array<int, 3>{a, c, b} : std::array<int, 3>{a, b, c});
    }
  }
  if (spaces.empty()) throw InputError(needs);
  return spaces;
}

Pressure::Pressure(const Body& body, Cells<3> triangles, PressureLaw law, const Vector3& apex, bool rim_fixed)
    : body_(body), triangles_(std::move(triangles)), apex_(apex) {
  if (triangles_.empty()) throw InputError("a pressure needs a body with triangles");
  const SurfaceFindings findings = inspect_surface(triangles_);
  const auto refuse = [](const std::vector<int>& list, const std::string& why) {
    if (!list.empty())
      throw InputError("triangle " + std::to_string(list.front()) +
                       (list.size() > 1 ? " (and " + std::to_string(list.size() - 1) + " more)" : "") + " " + why);
  };
  refuse(findings.branchings, "shares a side with more than one other: a pressure needs a surface with two faces");
  refuse(findings.turned, "is turned against its neighbour: a pressure needs one side of the surface to be inside");
  conservative_ = rim_fixed || findings.rim_sides == 0;
  rest_volume_ = volume(body.rest);
  set_law(std::move(law));
  std::vector<int> corners;
  for (const auto& triangle : triangles_) corners.insert(corners.end(), triangle.begin(), triangle.end());
  Rows rows = rows_by_target(body.size(), corners);
  start_ = std::move(rows.start);
  slots_ = std::move(rows.entries);
}

double Pressure::volume(const Positions& positions) const { return enclosed_volume(triangles_, positions, apex_); }

/// Adds a vector of each triangle to its three corners. One thread scatters, several gather; both add a molecule's
/// triangles in ascending order, so the results are bitwise identical.
template <class OfTriangle>
void Pressure::add_to_corners(Positions& sums, OfTriangle&& of_triangle) const {
  const int triangles = static_cast<int>(triangles_.size());
  if (triangles < kParallelThreshold || threads() == 1) {
    for (int cell = 0; cell < triangles; ++cell) {
      const auto& corners = triangles_[cell];
      const Vector3 vector = of_triangle(corners);
      for (const int corner : corners) sums.col(corner) += vector;
    }
    return;
  }
  Positions vectors(3, triangles);
  parallel_for(triangles, [&](int cell) { vectors.col(cell) = of_triangle(triangles_[cell]); });
  parallel_for(
      body_.size(),
      [&](int molecule) {
        Vector3 sum = sums.col(molecule);
        const auto at = static_cast<std::size_t>(molecule);
        for (int slot = start_[at]; slot < start_[at + 1]; ++slot) sum += vectors.col(slots_[slot] / 3);
        sums.col(molecule) = sum;
      },
      1);
}

void Pressure::set_law(PressureLaw law) {
  law_ = std::move(law);
  const PressureState at_rest = law_(rest_volume_, rest_volume_);
  constant_ = at_rest.slope == 0 && law_(2 * rest_volume_, rest_volume_).slope == 0;
}

void Pressure::add_forces(const State& state, Positions& forces) const {
  const double share = pressure_state(state.positions).pressure / 3;
  add_to_corners(forces, [&](const std::array<int, 3>& triangle) -> Vector3 {
    return share * area_vector(state.positions, triangle);
  });
}

double Pressure::energy(const State& state) const { return conservative_ ? -pressure_state(state.positions).work : 0; }

void Pressure::add_change(const State& state, const Positions& dx, const Positions&, Positions& forces) const {
  const Positions& x = state.positions;
  Eigen::Vector2d volume(rest_volume_, 0);
  if (!constant_) volume = volume_and_change(triangles_, x, apex_, dx);
  const PressureState now = law_(volume[0], rest_volume_);
  const double share = now.pressure / 6, share_change = now.slope * volume[1] / 6;
  add_to_corners(forces, [&](const std::array<int, 3>& triangle) -> Vector3 {
    const auto& [a, b, c] = triangle;
    const Vector3 first = x.col(b) - x.col(a), second = x.col(c) - x.col(a);
    const Vector3 d_first = dx.col(b) - dx.col(a), d_second = dx.col(c) - dx.col(a);
    Vector3 change = share * (d_first.cross(second) + first.cross(d_second));
    if (share_change != 0) change += share_change * first.cross(second);
    return change;
  });
}

/// The area vector's derivative by corner b is ½ [x_{b+2} − x_{b+1}]×, the same for the force on each corner a.
void Pressure::visit_blocks(const State& state, double, const BlockVisitor& visit) const {
  const double pressure = pressure_state(state.positions).pressure;
  for (const auto& triangle : triangles_)
    for (std::size_t b = 0; b < 3; ++b) {
      const Vector3 across = state.positions.col(triangle[(b + 2) % 3]) - state.positions.col(triangle[(b + 1) % 3]);
      const Matrix3 block = -pressure / 6 * cross_matrix(across);
      for (const int a : triangle) visit(a, triangle[b], block);
    }
}

std::vector<WideTerm> Pressure::wide_terms(const State& state) const {
  const double slope = pressure_state(state.positions).slope;
  if (slope == 0) return {};
  Positions areas = Positions::Zero(3, body_.size());
  add_to_corners(
      areas, [&](const std::array<int, 3>& triangle) -> Vector3 { return area_vector(state.positions, triangle) / 3; });
  return {{-slope, std::move(areas)}};
}

}  // namespace elastin
