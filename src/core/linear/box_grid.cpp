#include "core/linear/box_grid.h"

#include <algorithm>
#include <cmath>

namespace elastin {

BoxGrid::BoxGrid(const Frame& frame) : size_(frame.size), origin_(frame.low) {
  const Vector3 extent = frame.high - frame.low;
  std::sort(axes_.begin(), axes_.end(), [&](int a, int b) { return extent[a] < extent[b]; });
  // Boxes of which less than half would be filled are left out: what sticks out belongs to those before, extrapolated.
  // A bent sheet fills little of its outline, which has to stay small enough for a table.
  const double most = 1e5 + 32 * static_cast<double>(frame.molecules);
  const auto wanted = [&](int axis) { return std::max(1., std::ceil(extent[axes_[axis]] / size_ - 0.49)); };
  while (wanted(0) * wanted(1) * wanted(2) > most) size_ *= 1.25;
  for (int axis = 0; axis < 3; ++axis) counts_[axis] = static_cast<int>(wanted(axis));
  per_size_ = 1 / size_;
  used_.assign(static_cast<std::size_t>(outline_boxes()), 0);
}

int BoxGrid::outline_box(const Vector3& position) const {
  // What lies on a face, as much of a lattice does, belongs to the box beyond, wherever rounding puts it.
  constexpr double rounding = 1e-4;
  const Vector3 at = along(position - origin_) + Vector3::Constant(rounding);
  int box = 0;
  for (int axis = 2; axis >= 0; --axis)
    box = box * counts_[axis] + std::clamp(static_cast<int>(at[axis]), 0, counts_[axis] - 1);
  return box;
}

std::array<int, 3> BoxGrid::cell_of(int outline_box) const {
  return {outline_box % counts_[0], outline_box / counts_[0] % counts_[1], outline_box / counts_[0] / counts_[1]};
}

int BoxGrid::point_at(const std::array<int, 3>& at) const {
  int point = 0;
  for (int axis = 2; axis >= 0; --axis) {
    if (at[axis] < 0 || at[axis] > counts_[axis]) return -1;
    point = point * (counts_[axis] + 1) + at[axis];
  }
  return number_of_point_[point];
}

/// The corner of a box that is at a point of the grid; −1 where none is.
int BoxGrid::corner_at(int box, const std::array<int, 3>& at) const {
  int corner = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const int step = at[axis] - cells_[box][axis];
    if (step < 0 || step > 1) return -1;
    corner |= step << axis;
  }
  return corner;
}

namespace {

std::array<int, 3> corner_of(const std::array<int, 3>& cell, int corner) {
  return {cell[0] + corner % 2, cell[1] + corner / 2 % 2, cell[2] + corner / 4};
}

}  // namespace

void BoxGrid::number_boxes(const std::vector<int>& pieces) {
  first_.assign(pieces.size() + 1, 0);
  for (std::size_t box = 0; box < pieces.size(); ++box) {
    first_[box + 1] = first_[box] + pieces[box];
    cells_.insert(cells_.end(), static_cast<std::size_t>(pieces[box]), cell_of(static_cast<int>(box)));
  }
  corners_.resize(cells_.size());
}

void BoxGrid::number() {
  number_boxes({used_.begin(), used_.end()});
  number_of_point_.assign(static_cast<std::size_t>(counts_[0] + 1) * (counts_[1] + 1) * (counts_[2] + 1), -1);
  for (int box = 0; box < boxes(); ++box)
    for (int c = 0; c < kCorners; ++c) {
      const auto at = corner_of(cells_[box], c);
      int& number = number_of_point_[at[0] + (counts_[0] + 1) * (at[1] + (counts_[1] + 1) * at[2])];
      if (number < 0) number = points(), at_.push_back(at);
      corners_[box][c] = number;
    }
  set_around();
}

void BoxGrid::number_points(std::vector<std::array<int, 2>> joined) {
  joined_ = std::move(joined);
  DisjointSets same(static_cast<std::size_t>(kCorners) * cells_.size());
  for (const auto& [one, other] : joined_)
    for (int c = 0; c < kCorners; ++c)
      if (const int theirs = corner_at(other, corner_of(cells_[one], c)); theirs >= 0)
        same.join(kCorners * one + c, kCorners * other + theirs);
  number_corners(same);
}

void BoxGrid::number_corners(DisjointSets& same) {
  for (int box = 0; box < boxes(); ++box)
    for (int c = 0; c < kCorners; ++c) {
      const int set = same.set_of(kCorners * box + c);
      if (set == kCorners * box + c)
        corners_[box][c] = points(), at_.push_back(corner_of(cells_[box], c));
      else
        corners_[box][c] = corners_[set / kCorners][set % kCorners];
    }
  set_around();
}

void BoxGrid::set_around() {
  around_start_.assign(at_.size() + 1, 0);
  for (const auto& corners : corners_)
    for (const int point : corners) ++around_start_[point + 1];
  for (int point = 0; point < points(); ++point) around_start_[point + 1] += around_start_[point];
  around_.resize(static_cast<std::size_t>(kCorners) * corners_.size());
  std::vector<int> next(around_start_.begin(), around_start_.end() - 1);
  for (int box = 0; box < boxes(); ++box)
    for (int c = 0; c < kCorners; ++c) around_[next[corners_[box][c]]++] = kCorners * box + c;
}

BoxGrid::Coarser BoxGrid::coarser() const {
  Coarser result{BoxGrid(), std::vector<int>(cells_.size())};
  BoxGrid& grid = result.grid;
  std::vector<int>& parents = result.parents;
  grid.size_ = 2 * size_;
  grid.per_size_ = per_size_ / 2;
  grid.origin_ = origin_;
  grid.axes_ = axes_;
  for (int axis = 0; axis < 3; ++axis) grid.counts_[axis] = (counts_[axis] + 1) / 2;
  const auto outline_of = [&](int box) {
    const auto& [x, y, z] = cells_[box];
    return x / 2 + grid.counts_[0] * (y / 2 + grid.counts_[1] * (z / 2));
  };
  const auto outline_boxes = static_cast<std::size_t>(grid.outline_boxes());
  if (!number_of_point_.empty()) {
    grid.used_.assign(outline_boxes, 0);
    for (int box = 0; box < boxes(); ++box) grid.used_[outline_of(box)] = 1;
    grid.number();
    for (int box = 0; box < boxes(); ++box) parents[box] = grid.number_of(outline_of(box));
    return result;
  }
  DisjointSets together(cells_.size());
  for (const auto& [one, other] : joined_)
    if (outline_of(one) == outline_of(other)) together.join(one, other);
  std::vector<int> pieces(outline_boxes, 0);
  for (int box = 0; box < boxes(); ++box) {
    const int set = together.set_of(box);
    parents[box] = set == box ? pieces[outline_of(box)]++ : parents[set];
  }
  grid.number_boxes(pieces);
  for (int box = 0; box < boxes(); ++box) parents[box] += grid.number_of(outline_of(box));
  for (const auto& [one, other] : joined_)
    if (parents[one] != parents[other])
      grid.joined_.push_back({std::min(parents[one], parents[other]), std::max(parents[one], parents[other])});
  std::sort(grid.joined_.begin(), grid.joined_.end());
  grid.joined_.erase(std::unique(grid.joined_.begin(), grid.joined_.end()), grid.joined_.end());
  // The larger boxes around a point have the same values there: they share the points that those depend on.
  DisjointSets same(static_cast<std::size_t>(kCorners) * grid.cells_.size());
  for (int point = 0; point < points(); ++point) {
    const int first = parents[around(point).front() / kCorners];
    const auto& [x, y, z] = at_[point];
    for (const int box_corner : around(point)) {
      const int other = parents[box_corner / kCorners];
      if (other == first) continue;
      for (int c = 0; c < kCorners; ++c) {
        if ((c % 2 && x % 2 == 0) || (c / 2 % 2 && y % 2 == 0) || (c / 4 && z % 2 == 0)) continue;
        const std::array<int, 3> at{x / 2 + c % 2, y / 2 + c / 2 % 2, z / 2 + c / 4};
        same.join(kCorners * first + grid.corner_at(first, at), kCorners * other + grid.corner_at(other, at));
      }
    }
  }
  grid.number_corners(same);
  return result;
}

}  // namespace elastin
