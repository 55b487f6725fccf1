#pragma once
#include <array>
#include <vector>

#include "elastin/core/base/types.h"

namespace elastin {

/// A regular grid of cubes over a body's places, as far as they contain anything: a coarse grid of any body, however
/// its molecules are connected. Functions are trilinear in a box, given by values at its corners, the grid's points.
///
/// Boxes and points are numbered layer by layer, layers across the body's longest direction.
class BoxGrid {
 public:
  static constexpr int kCorners = 8, kAround = 27, kSelf = 13;

  /// Where a position lies in its box: 0 … 1 along the grid's own axes.
  struct Location {
    int box;
    Eigen::Vector3f at;
  };

  /// One number for each corner of a box.
  using Corners = Eigen::Array<float, kCorners, 1>;
  /// The functions of a box's corners at a position in it.
  static Corners values_at(const Eigen::Vector3f& at) {
    Corners values;
    for (int c = 0; c < kCorners; ++c)
      values[c] = (c % 2 ? at.x() : 1 - at.x()) * (c / 2 % 2 ? at.y() : 1 - at.y()) * (c / 4 ? at.z() : 1 - at.z());
    return values;
  }

  /// What a grid is laid over: a body's outline, and boxes of a size [m], taken larger where a body is so thin or bent
  /// that its outline has too many of them.
  struct Frame {
    Vector3 low, high;  ///< [m]
    int molecules;
    double size;
  };
  explicit BoxGrid(const Frame& frame);

  /// The box of the outline that contains a position.
  int outline_box(const Vector3& position) const;
  /// Until the boxes are numbered: keeps one.
  void use(int outline_box) { used_[outline_box] = 1; }
  /// Until then too: whether each box of the outline is kept, 0 or 1.
  std::vector<char>& used() { return used_; }
  /// Numbers the boxes that were kept, and their points.
  void number();

  /// The grid of boxes twice as large over the same positions.
  BoxGrid coarser() const;

  int boxes() const { return static_cast<int>(corners_.size()); }
  int points() const { return static_cast<int>(at_.size()); }
  double size() const { return size_; }
  int layers() const { return counts_[2]; }
  /// The first box of a layer, boxes() for layer = layers().
  int first_box(int layer) const { return layer_start_[layer]; }

  /// Of a box that was kept.
  int number_of(int outline_box) const { return number_of_box_[outline_box]; }
  Location locate(const Vector3& position) const;
  /// A vector of the body's space along the grid's axes, in units of a box's size.
  Vector3 along(const Vector3& vector) const {
    return Vector3(vector[axes_[0]], vector[axes_[1]], vector[axes_[2]]) * per_size_;
  }
  /// The points of a box, corner x + 2 y + 4 z.
  const std::array<int, kCorners>& corners(int box) const { return corners_[box]; }
  /// Where a point is on the grid.
  const std::array<int, 3>& at(int point) const { return at_[point]; }
  /// The point there, −1 where there is none.
  int point_at(const std::array<int, 3>& at) const;

 private:
  BoxGrid() = default;

  int outline_box(const Vector3& position, Eigen::Vector3f& at) const;

  double size_ = 0, per_size_ = 0;
  Vector3 origin_ = Vector3::Zero();  ///< along the grid's axes
  std::array<int, 3> axes_{0, 1, 2};  ///< the body's direction that is the grid's x, y, z: shortest first
  std::array<int, 3> counts_{};       ///< boxes of the outline
  std::vector<char> used_;            ///< of each box of the outline
  std::vector<int> number_of_box_, number_of_point_;
  std::vector<int> layer_start_;
  std::vector<std::array<int, kCorners>> corners_;
  std::vector<std::array<int, 3>> at_;
};

/// Of the 27 points around one, itself included, x first: how far they are along each axis.
constexpr std::array<int, 3> around(int code) { return {code % 3 - 1, code / 3 % 3 - 1, code / 9 - 1}; }

}  // namespace elastin
