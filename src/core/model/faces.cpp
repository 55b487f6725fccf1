#include "core/model/faces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "core/geometry/boundary.h"
#include "core/model/block_geometry.h"
#include "core/model/ends.h"
#include "core/model/solid_cells.h"
#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"
#include "elastin/core/model/share.h"

namespace elastin {
namespace {

/// A third of the area, seen along `direction`, of each boundary triangle whose three corners are in the face.
VectorX triangle_thirds(const Body& body, const std::vector<int>& molecules, const Vector3& direction) {
  std::vector<char> among(body.size(), 0);
  for (const int molecule : molecules) among[molecule] = 1;
  VectorX areas = VectorX::Zero(body.size());
  const auto is_among = [&](int molecule) { return among[molecule] != 0; };
  Cells<4> cells;  // with a side in the face
  for (const auto& cell : body.tetrahedra)
    if (std::count_if(cell.begin(), cell.end(), is_among) >= 3) cells.push_back(cell);
  for (auto triangle : boundary_of(cells)) {
    if (!std::all_of(triangle.begin(), triangle.end(), is_among)) continue;
    std::sort(triangle.begin(), triangle.end());
    const auto& [a, b, c] = triangle;
    const Vector3 ab = body.rest.col(b) - body.rest.col(a), ac = body.rest.col(c) - body.rest.col(a);
    for (const int corner : triangle) areas[corner] += std::abs(ab.cross(ac).dot(direction)) / 6;
  }
  return areas(molecules);
}

/// Half of the way to the next place on each side along a line, for each point; points at one place share it alike.
std::vector<double> tributary_lengths(const Points2& points) {
  std::vector<double> lengths(points.cols(), 0);
  const Eigen::Vector2d low = points.rowwise().minCoeff(), high = points.rowwise().maxCoeff();
  // Along a line it is the longer side of the box around it that tells the places apart.
  const int axis = high[1] - low[1] > high[0] - low[0] ? 1 : 0;
  const double whole = high[axis] - low[axis];
  std::vector<int> order(lengths.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int a, int b) { return points(axis, a) < points(axis, b); });
  std::vector<std::pair<double, std::size_t>> places;  // and the first point after it
  for (std::size_t i = 0; i < order.size(); ++i) {
    const double at = points(axis, order[i]);
    if (places.empty() || at > places.back().first + 1e-9 * whole) places.emplace_back(at, 0);
    places.back().second = i + 1;
  }
  for (std::size_t place = 0, point = 0; place < places.size(); ++place) {
    const double before = place > 0 ? places[place].first - places[place - 1].first : 0,
                 after = place + 1 < places.size() ? places[place + 1].first - places[place].first : 0;
    const std::size_t first = point;
    for (; point < places[place].second; ++point)
      lengths[order[point]] = (before + after) / 2 / static_cast<double>(places[place].second - first);
  }
  return lengths;
}

/// Molecules at or above a height. Of a refined body those at the end of the body that it came from, and what lies
/// between them: a depth contains the same matter on cells of any size, even where the end is not plane.
std::vector<int> molecules_above(const Body& body, const VectorX& height, double low) {
  std::vector<char> above(body.size());
  const int first = body.size() - static_cast<int>(body.between.size());
  std::vector<int> molecules;
  std::vector<int> ascending(above.size());  // in the whole, so that what one lies between comes before it
  std::iota(ascending.begin(), ascending.end(), 0);
  if (body.share)
    std::sort(ascending.begin(), ascending.end(),
              [&](int a, int b) { return number_in_whole(body, a) < number_in_whole(body, b); });
  for (const int molecule : ascending) {
    const auto at = static_cast<std::size_t>(molecule);
    const MoleculeBetween* between = molecule < first ? nullptr : &body.between[molecule - first];
    if (!between || between->empty())
      above[at] = height[molecule] >= low;
    else
      above[at] =
          std::all_of(between->begin(), between->end(), [&](const auto& other) { return above[other.first] != 0; });
    if (above[at]) molecules.push_back(molecule);
  }
  std::sort(molecules.begin(), molecules.end());
  return molecules;
}

/// How many of these molecules, ascending, its process owns: they come first.
std::size_t owned_in(const Body& body, const std::vector<int>& molecules) {
  return static_cast<std::size_t>(std::lower_bound(molecules.begin(), molecules.end(), owned_molecules(body)) -
                                  molecules.begin());
}

/// The owned of these molecules and those of other processes as seen along a direction, and which is the first of them.
std::pair<Points2, std::size_t> seen_together(const Body& body, const std::vector<int>& molecules, std::size_t owned,
                                              const Vector3& direction) {
  const auto plane = across(direction);
  Points2 own(2, static_cast<Eigen::Index>(owned));
  for (std::size_t i = 0; i < owned; ++i)
    own.col(static_cast<Eigen::Index>(i)) = plane.transpose() * body.rest.col(molecules[i]);
  if (!body.share) return {std::move(own), 0};
  const auto mine = static_cast<double>(owned);
  const std::vector<double> counts = gathered_over(body, std::span(&mine, 1));
  const std::vector<double> all = gathered_over(body, std::span(own.data(), own.size()));
  const auto rank = static_cast<std::ptrdiff_t>(body.share->processes->rank());
  return {Eigen::Map<const Points2>(all.data(), 2, static_cast<Eigen::Index>(all.size()) / 2),
          static_cast<std::size_t>(std::accumulate(counts.begin(), counts.begin() + rank, 0.))};
}

}  // namespace

std::vector<double> thicknesses(const Body& body, double whole) {
  std::vector<double> all(body.triangles.size(), whole);
  for (const Part& part : body.parts)
    if (part.thickness > 0) std::fill_n(all.begin() + part.triangles.first, part.triangles.count, part.thickness);
  return all;
}

VectorX side_areas(const Body& body, const std::vector<int>& molecules, const Vector3& direction, double thickness) {
  std::vector<char> among(body.size(), 0);
  for (const int molecule : molecules) among[molecule] = 1;
  struct Side {
    int cells = 0, middle = -1;  // a node, −1 without one
    double thickness = 0;
  };
  std::map<std::array<int, 2>, Side> sides;
  const auto note_sides = [&](std::span<const int> nodes, std::size_t corners, double of_cell) {
    for (std::size_t i = 0; i < corners; ++i) {
      const int a = nodes[i], b = nodes[(i + 1) % corners];
      if (!among[a] || !among[b]) continue;
      Side& side = sides[{std::min(a, b), std::max(a, b)}];
      ++side.cells, side.middle = nodes.size() > corners ? nodes[corners + i] : -1, side.thickness = of_cell;
    }
  };
  const std::vector<double> own = thicknesses(body, thickness);  // of triangles, and of those in blocks
  std::size_t triangle = 0;
  if (!has_blocks(body, 2))
    for (; triangle < body.triangles.size(); ++triangle) note_sides(body.triangles[triangle], 3, own[triangle]);
  for (const CellBlock& block : body.blocks)
    for (int cell = 0; block.kind->dimensions == 2 && cell < block.size(); ++cell) {
      note_sides(block.cell(cell), block.kind->corners, own[triangle]);
      triangle += simplices_of(*block.kind, block.cell(cell)).size();
    }
  VectorX lengths = VectorX::Zero(body.size());
  for (const auto& [ends, side] : sides) {
    const int middle = side.middle;
    if (side.cells != 1 || (middle >= 0 && !among[middle])) continue;
    const double length = side.thickness * direction.cross(body.rest.col(ends[1]) - body.rest.col(ends[0])).norm();
    for (const int end : ends) lengths[end] += length / (middle < 0 ? 2 : 6);
    if (middle >= 0) lengths[middle] += length * 4 / 6;
  }
  return lengths(molecules);
}

Eigen::Matrix<double, 3, 2> across(const Vector3& axis) {
  int least = 0;
  axis.cwiseAbs().minCoeff(&least);
  const Vector3 first = axis.cross(Vector3::Unit(least)).normalized();
  Eigen::Matrix<double, 3, 2> plane;
  plane << first, axis.cross(first);
  return plane;
}

Points2 hull_over(const Body& body, const Points2& own) {
  if (!body.share) return convex_hull(own);
  const Points2 hull = own.cols() == 0 ? own : convex_hull(own);
  const std::vector<double> all = gathered_over(body, std::span(hull.data(), hull.size()));
  return convex_hull(Eigen::Map<const Points2>(all.data(), 2, static_cast<Eigen::Index>(all.size()) / 2));
}

Points2 hull_of_whole(const Body& body, const Eigen::Matrix<double, 3, 2>& plane) {
  return hull_over(body, plane.transpose() * body.rest.leftCols(owned_molecules(body)));
}

Face end_face(const Body& body, const Vector3& direction, double depth) {
  const VectorX height = body.rest.transpose() * direction;
  const double low = least_over(body, height.minCoeff()), high = largest_over(body, height.maxCoeff());
  const double reach = depth + 1e-6 * (high - low);  // layers of a lattice lie just at a round depth
  if (!(high - low > 2 * reach)) throw InputError("the body has no length along the axis beyond its grips");
  const double end = depth > 0 && body.outline.cols() > 0 ? (body.outline.transpose() * direction).maxCoeff() : high;
  std::vector<int> molecules = molecules_above(body, height, std::min(end, high) - reach);
  const bool cells = any_over(body, !body.tetrahedra.empty() || !body.triangles.empty());
  if (depth > 0 || !cells || is_plane_end(body, molecules, direction))
    return face_of(body, std::move(molecules), direction);
  EndSides sides = end_sides(body, direction);
  if (sides.normal.isZero(0)) return face_of(body, std::move(molecules), direction);
  Face face = face_of(body, std::move(sides.molecules), direction);
  face.tilted = sides.normal;
  return face;
}

Face face_of(const Body& body, std::vector<int> molecules, const Vector3& direction) {
  Face face;
  face.molecules = std::move(molecules);
  const std::size_t owned = owned_in(body, face.molecules);
  const auto [layer, first] = seen_together(body, face.molecules, owned, direction);
  const Points2 outline = convex_hull(layer);
  face.area = polygon_area(outline);
  const double size = layer.cols() > 0 ? (layer.rowwise().maxCoeff() - layer.rowwise().minCoeff()).norm() : 0;
  const bool line = !(face.area > 1e-9 * size * size);
  if (line) face.area = 0;
  face.share = VectorX::Zero(static_cast<Eigen::Index>(face.molecules.size()));
  auto share = face.share.head(static_cast<Eigen::Index>(owned));
  share.setConstant(1. / static_cast<double>(layer.cols()));
  const auto share_as = [&](const VectorX& parts) {
    const double sum = sum_over(body, parts.head(share.size()).sum());
    if (sum > 0) share = parts.head(share.size()) / sum;
    return sum;
  };
  if (any_over(body, !body.tetrahedra.empty())) {
    const double area = share_as(has_blocks(body, 3) ? face_shares(body, face.molecules, direction)
                                                     : triangle_thirds(body, face.molecules, direction));
    if (area > 0) {
      face.area = area;
      return face;
    }
  }
  if (any_over(body, !body.triangles.empty()) && share_as(side_areas(body, face.molecules, direction, 1)) > 0)
    return face;
  const std::vector<double> parts = line ? tributary_lengths(layer) : tributary_areas(layer, outline);
  // Molecules behind each other, of a grip with a depth, have the same part of the face, each the whole of it.
  const double sum = std::accumulate(parts.begin(), parts.end(), 0.),
               whole = line || sum > (1 + 1e-9) * face.area ? sum : face.area;
  if (!(whole > 0)) return face;
  for (Eigen::Index i = 0; i < share.size(); ++i) share[i] = parts[first + i] / whole;
  return face;
}

Vector3 middle_of(const Body& body, const Face& face, const Positions& positions) {
  Vector3 middle = Vector3::Zero();
  for (std::size_t i = 0; i < face.molecules.size(); ++i)
    middle += face.share[static_cast<Eigen::Index>(i)] * positions.col(face.molecules[i]);
  sum_over(body, {middle.data(), 3});
  return middle;
}

/// Cosine of the angle, 1°, by which a side of a box may be tilted.
constexpr double kStraight = 0.99985;

BoxSides find_box(const Body& body, const Matrix3& axes, double depth) {
  const Positions along = axes.transpose() * body.rest;
  BoxSides box;
  for (int k = 0; k < 3; ++k)
    box.size[k] = largest_over(body, along.row(k).maxCoeff()) - least_over(body, along.row(k).minCoeff());
  for (int side = 0; side < 6; ++side) {
    const int axis = side / 2;
    const Vector3 outward = (side % 2 ? 1 : -1) * axes.col(axis);
    const std::string end = std::string("the end of ") + (side % 2 ? '+' : '-') + "xyz"[axis];
    box.sides[side] = end_face(body, outward, depth);
    const Vector3& tilted = box.sides[side].tilted;
    if (!tilted.isZero(0) && tilted.dot(outward) < kStraight)
      throw InputError("the body is no box along these axes: its side at " + end + " is tilted by " +
                       number(std::acos(tilted.dot(outward)) * 180 / EIGEN_PI, 2) + "°");
    if (!(box.sides[side].area >= 0.5 * box.size.prod() / box.size[axis]))
      throw InputError("the body is no box: its molecules at " + end +
                       " span less than half of that side (give grip_depth if they lie behind it)");
  }
  return box;
}

namespace {

/// Directions of the lines between neighbours on the outline of the body as seen askew, the longest first: of a box six
/// of its edges.
std::vector<Vector3> outline_directions(const Body& body) {
  constexpr std::size_t most = 12;
  const auto plane = across(Vector3(0.3571, 0.6137, 0.7041).normalized());
  const Points2 seen = plane.transpose() * body.rest, hull = convex_hull(seen);
  std::vector<Vector3> lines, corners;
  for (Eigen::Index corner = 0; corner < hull.cols(); ++corner) {
    Eigen::Index molecule = 0;
    (seen.colwise() - hull.col(corner)).colwise().squaredNorm().minCoeff(&molecule);
    corners.emplace_back(body.rest.col(molecule));
  }
  for (std::size_t corner = 0; corner < corners.size(); ++corner)
    lines.push_back(corners[(corner + 1) % corners.size()] - corners[corner]);
  std::stable_sort(lines.begin(), lines.end(),
                   [](const Vector3& a, const Vector3& b) { return a.squaredNorm() > b.squaredNorm(); });
  if (lines.size() > most) lines.resize(most);
  for (Vector3& line : lines) line.normalize();
  return lines;
}

}  // namespace

std::optional<Matrix3> box_axes(const Body& body) {
  constexpr double square = 1e-3;  // what the cosine of a right angle may be, for rough edges
  std::optional<Matrix3> rough;
  const auto is_plane_box = [&](const Matrix3& axes) {
    try {
      const BoxSides box = find_box(body, axes, 0);
      if (std::all_of(box.sides.begin(), box.sides.end(), [](const Face& side) { return side.tilted.isZero(0); }))
        return true;
      if (!rough) rough = axes;
    } catch (const InputError&) {
    }
    return false;
  };
  if (is_plane_box(Matrix3::Identity())) return Matrix3::Identity();
  if (body.share) return rough;
  const std::vector<Vector3> lines = outline_directions(body);
  for (std::size_t one = 0; one < lines.size(); ++one)
    for (std::size_t other = one + 1; other < lines.size(); ++other) {
      if (std::abs(lines[one].dot(lines[other])) > square) continue;
      Matrix3 axes;
      axes.col(0) = lines[one];
      axes.col(2) = lines[one].cross(lines[other]).normalized();
      axes.col(1) = axes.col(2).cross(axes.col(0));
      if (is_plane_box(axes)) return axes;
    }
  return rough;
}

Surface find_surface(const Body& body, const Matrix3& axes, double depth) {
  Surface surface;
  std::vector<char> outside(body.size(), 0);
  if (any_over(body, !body.tetrahedra.empty())) {
    if (depth > 0) throw InputError("grip_depth: the body's cells say what its surface is");
    for (const auto& triangle : boundary_of(body.tetrahedra))
      for (const int corner : triangle) outside[corner] = 1;
    surface.volume = volume_of_cells(body, body.rest);
    mark_ghosts_as_owners(body, outside);
  } else {
    if (any_over(body, !body.triangles.empty())) throw InputError("a membrane of triangles is no solid");
    const BoxSides box = find_box(body, axes, depth);
    surface.volume = box.size.prod();
    for (const Face& side : box.sides)
      for (const int molecule : side.molecules) outside[molecule] = 1;
  }
  for (int molecule = 0; molecule < body.size(); ++molecule)
    if (outside[molecule]) surface.molecules.push_back(molecule);
  return surface;
}

}  // namespace elastin
