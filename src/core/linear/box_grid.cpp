#include "core/linear/box_grid.h"

#include <algorithm>
#include <cmath>

namespace elastin {

BoxGrid::BoxGrid(const Frame& frame) : size_(frame.size) {
  const Vector3 &low = frame.low, extent = frame.high - low;
  std::sort(axes_.begin(), axes_.end(), [&](int a, int b) { return extent[a] < extent[b]; });
  origin_ = {low[axes_[0]], low[axes_[1]], low[axes_[2]]};
  // Boxes of which less than half would be filled are left out: what sticks out belongs to those before, extrapolated.
  // A bent sheet fills little of its outline, which has to stay small enough for a table.
  const double most = 1e5 + 32 * static_cast<double>(frame.molecules);
  const auto wanted = [&](int axis) { return std::max(1., std::ceil(extent[axes_[axis]] / size_ - 0.49)); };
  while (wanted(0) * wanted(1) * wanted(2) > most) size_ *= 1.25;
  for (int axis = 0; axis < 3; ++axis) counts_[axis] = static_cast<int>(wanted(axis));
  per_size_ = 1 / size_;
  used_.assign(static_cast<std::size_t>(counts_[0]) * counts_[1] * counts_[2], 0);
}

int BoxGrid::outline_box(const Vector3& position, Eigen::Vector3f& at) const {
  int box = 0;
  for (int axis = 2; axis >= 0; --axis) {
    const double along = (position[axes_[axis]] - origin_[axis]) * per_size_;
    const int number = std::clamp(static_cast<int>(along), 0, counts_[axis] - 1);
    at[axis] = static_cast<float>(along - number);
    box = box * counts_[axis] + number;
  }
  return box;
}

int BoxGrid::outline_box(const Vector3& position) const {
  Eigen::Vector3f ignored;
  return outline_box(position, ignored);
}

BoxGrid::Location BoxGrid::locate(const Vector3& position) const {
  Location result;
  result.box = number_of(outline_box(position, result.at));
  return result;
}

int BoxGrid::point_at(const std::array<int, 3>& at) const {
  int point = 0;
  for (int axis = 2; axis >= 0; --axis) {
    if (at[axis] < 0 || at[axis] > counts_[axis]) return -1;
    point = point * (counts_[axis] + 1) + at[axis];
  }
  return number_of_point_[point];
}

void BoxGrid::number() {
  const std::array<int, 3> lines{counts_[0] + 1, counts_[1] + 1, counts_[2] + 1};
  number_of_box_.assign(used_.size(), -1);
  number_of_point_.assign(static_cast<std::size_t>(lines[0]) * lines[1] * lines[2], -1);
  const auto corner = [&](std::size_t box, int c) {
    const int x = static_cast<int>(box) % counts_[0], y = static_cast<int>(box) / counts_[0] % counts_[1],
              z = static_cast<int>(box) / counts_[0] / counts_[1];
    return static_cast<std::size_t>(x + c % 2 + lines[0] * (y + c / 2 % 2 + lines[1] * (z + c / 4)));
  };
  int boxes = 0;
  const int layer = counts_[0] * counts_[1];
  for (std::size_t box = 0; box < used_.size(); ++box) {
    if (box % static_cast<std::size_t>(layer) == 0) layer_start_.push_back(boxes);
    if (!used_[box]) continue;
    number_of_box_[box] = boxes++;
    for (int c = 0; c < kCorners; ++c) number_of_point_[corner(box, c)] = 0;
  }
  layer_start_.push_back(boxes);
  for (std::size_t point = 0; point < number_of_point_.size(); ++point) {
    if (number_of_point_[point] < 0) continue;
    number_of_point_[point] = points();
    const int p = static_cast<int>(point);
    at_.push_back({p % lines[0], p / lines[0] % lines[1], p / lines[0] / lines[1]});
  }
  corners_.resize(boxes);
  for (std::size_t box = 0; box < used_.size(); ++box)
    for (int c = 0; used_[box] && c < kCorners; ++c)
      corners_[number_of_box_[box]][c] = number_of_point_[corner(box, c)];
}

BoxGrid BoxGrid::coarser() const {
  BoxGrid grid;
  grid.size_ = 2 * size_;
  grid.per_size_ = per_size_ / 2;
  grid.origin_ = origin_;
  grid.axes_ = axes_;
  for (int axis = 0; axis < 3; ++axis) grid.counts_[axis] = (counts_[axis] + 1) / 2;
  grid.used_.assign(static_cast<std::size_t>(grid.counts_[0]) * grid.counts_[1] * grid.counts_[2], 0);
  for (std::size_t box = 0; box < used_.size(); ++box) {
    const int b = static_cast<int>(box);
    const int x = b % counts_[0] / 2, y = b / counts_[0] % counts_[1] / 2, z = b / counts_[0] / counts_[1] / 2;
    if (used_[box]) grid.used_[x + grid.counts_[0] * (y + grid.counts_[1] * z)] = 1;
  }
  grid.number();
  return grid;
}

}  // namespace elastin
