#include "core/model/neighbours.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/boundary.h"

namespace elastin {
namespace {

/// Sides that two cells have, in order of their lowest molecule, then of their molecules; `sides` those of all cells,
/// `of_each` of one.
template <std::size_t corners>
std::vector<SharedSide> shared(std::vector<std::array<int, corners>> sides, int of_each, int molecules) {
  std::vector<int> lowest(sides.size());
  for (std::size_t side = 0; side < sides.size(); ++side) {
    std::sort(sides[side].begin(), sides[side].end());
    lowest[side] = sides[side][0];
  }
  const Rows rows = rows_by_target(molecules, lowest);
  std::vector<SharedSide> found;
  found.reserve(sides.size() / 2);
  std::vector<int> row;
  for (int molecule = 0; molecule < molecules; ++molecule) {
    row.assign(rows[molecule].begin(), rows[molecule].end());
    const auto of = [&](int side) -> const auto& { return sides[side]; };
    std::stable_sort(row.begin(), row.end(), [&](int a, int b) { return of(a) < of(b); });
    for (std::size_t at = 1; at < row.size(); ++at) {
      if (of(row[at]) != of(row[at - 1])) continue;
      SharedSide& side = found.emplace_back();
      side.cells = {row[at - 1] / of_each, row[at] / of_each};
      std::copy(of(row[at]).begin(), of(row[at]).end(), side.molecules.begin());
    }
  }
  return found;
}

template <std::size_t corners>
std::vector<int> flat(const std::vector<std::array<int, corners>>& cells) {
  std::vector<int> nodes;
  nodes.reserve(cells.size() * corners);
  for (const auto& cell : cells) nodes.insert(nodes.end(), cell.begin(), cell.end());
  return nodes;
}

std::vector<std::array<int, 2>> edges_of(const Cells<3>& triangles) {
  std::vector<std::array<int, 2>> edges;
  edges.reserve(3 * triangles.size());
  for (const auto& [a, b, c] : triangles)
    for (const std::array<int, 2> edge : {std::array{a, b}, {b, c}, {c, a}}) edges.push_back(edge);
  return edges;
}

}  // namespace

Neighbours::Neighbours(const Body& body) {
  if (!body.tetrahedra.empty()) {
    of_each = 4, nodes = flat(body.tetrahedra), sides = shared(faces_of(body.tetrahedra), 4, body.size());
  } else if (!body.cubes.empty()) {
    of_each = 8, nodes = flat(body.cubes), sides = shared(faces_of(body.cubes), 6, body.size());
  } else if (!body.triangles.empty()) {
    of_each = 3, nodes = flat(body.triangles), sides = shared(edges_of(body.triangles), 3, body.size());
  }
  cells_of = rows_by_target(body.size(), nodes);
  for (int& slot : cells_of.entries) slot /= of_each;
  volume.resize(size());
  for (int number = 0; number < size(); ++number) {
    const auto span = edges(number, body.rest);
    const double parallel =
        of_each == 3 ? Vector3(span.col(0)).cross(Vector3(span.col(1))).norm() : std::abs(Matrix3(span).determinant());
    volume[number] = parallel / (of_each == 8 ? 1 : of_each == 4 ? 6 : 2);
  }
}

Vector3 Neighbours::middle(int number, const Positions& positions) const {
  Vector3 sum = Vector3::Zero();
  for (const int molecule : cell(number)) sum += positions.col(molecule);
  return sum / of_each;
}

Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 3> Neighbours::edges(int number, const Positions& positions) const {
  const auto own = cell(number);
  Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 3> span(3, of_each == 3 ? 2 : 3);
  for (int axis = 0; axis < span.cols(); ++axis) {
    if (of_each != 8) {
      span.col(axis) = positions.col(own[axis + 1]) - positions.col(own[0]);
      continue;
    }
    span.col(axis).setZero();  // corners of a cube are numbered by the bits of x, y, z
    for (int corner = 0; corner < 8; ++corner)
      span.col(axis) += (corner >> axis & 1 ? 0.25 : -0.25) * positions.col(own[corner]);
  }
  return span;
}

Matrix3 Neighbours::deformation(int number, const Positions& rest, const Positions& positions) const {
  const auto before = edges(number, rest), after = edges(number, positions);
  if (before.cols() == 3) return Matrix3(after) * Matrix3(before).inverse();
  const Eigen::Matrix<double, 3, 2> plane = before, now = after;
  return now * (plane.transpose() * plane).inverse() * plane.transpose();
}

}  // namespace elastin
