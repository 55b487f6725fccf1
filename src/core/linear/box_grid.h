#pragma once
#include <array>
#include <span>
#include <vector>

#include "core/base/disjoint_sets.h"
#include "elastin/core/base/types.h"

namespace elastin {

/// A regular grid of cubes over a body's places, as far as they contain anything: a coarse grid of any body, however
/// its molecules are connected. Functions are trilinear in a box, given by values at its corners, the grid's points.
///
/// A cube stands in the grid once for each connected piece of what it contains, and pieces of neighbouring cubes share
/// the points between them only where something joins them: pores, cracks and folds that are narrower than a cube keep
/// their sides apart on every grid.                      [Molino, Bao & Fedkiw 2004; Nesme, Kry, Jeřábková & Faure
/// 2009]
class BoxGrid {
 public:
  static constexpr int kCorners = 8;

  /// One number for each corner of a box.
  using Corners = Eigen::Array<float, kCorners, 1>;
  /// By an axis, the linear functions of a box's corners at a position in it, 1 − x and x.
  static Corners values_along(int axis, const Eigen::Vector3f& at) { return 0.5F + signs(axis) * (at[axis] - 0.5F); }
  /// The side of the box on which each corner is, −1 or 1.
  static Eigen::Map<const Corners> signs(int axis) {
    static constexpr float table[3][kCorners] = {
        {-1, 1, -1, 1, -1, 1, -1, 1}, {-1, -1, 1, 1, -1, -1, 1, 1}, {-1, -1, -1, -1, 1, 1, 1, 1}};
    return Eigen::Map<const Corners>(table[axis]);
  }
  /// The functions of a box's corners at a position in it.
  static Corners values_at(const Eigen::Vector3f& at) {
    return values_along(0, at) * values_along(1, at) * values_along(2, at);
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
  int outline_boxes() const { return counts_[0] * counts_[1] * counts_[2]; }
  /// Until the boxes are numbered: whether each box of the outline is kept, 0 or 1.
  std::vector<char>& used() { return used_; }
  /// Numbers one box for each that is kept, and their points, whatever joins them.
  void number();
  /// Numbers as many boxes for each of the outline as it has pieces, one after the other.
  void number_boxes(const std::vector<int>& pieces);
  /// Then their points, from the pairs of boxes that something joins, each once.
  void number_points(std::vector<std::array<int, 2>> joined);

  /// The grid of boxes twice as large over the same positions, and of each box of this one the larger one around it.
  struct Coarser;
  Coarser coarser() const;

  int boxes() const { return static_cast<int>(corners_.size()); }
  int points() const { return static_cast<int>(at_.size()); }
  double size() const { return size_; }

  /// The first of the outline's box.
  int number_of(int outline_box) const { return first_[outline_box]; }
  /// Where a position lies as a box sees it: 0 … 1 along the grid's own axes inside.
  Eigen::Vector3f at_in(int box, const Vector3& position) const {
    const auto& [x, y, z] = cells_[box];
    return (along(position - origin_) - Vector3(x, y, z)).cast<float>();
  }
  /// A vector of the body's space along the grid's axes, in units of a box's size.
  Vector3 along(const Vector3& vector) const {
    return Vector3(vector[axes_[0]], vector[axes_[1]], vector[axes_[2]]) * per_size_;
  }
  /// The points of a box, corner x + 2 y + 4 z.
  const std::array<int, kCorners>& corners(int box) const { return corners_[box]; }
  /// The boxes around a point, ascending: box · 8 + the corner that it is.
  std::span<const int> around(int point) const {
    return {around_.data() + around_start_[point],
            static_cast<std::size_t>(around_start_[point + 1] - around_start_[point])};
  }
  /// Where a box, or a point, is on the grid.
  const std::array<int, 3>& cell(int box) const { return cells_[box]; }
  const std::array<int, 3>& at(int point) const { return at_[point]; }
  /// The point there, −1 where there is no point; of a grid of whole boxes, number().
  int point_at(const std::array<int, 3>& at) const;

 private:
  BoxGrid() = default;

  std::array<int, 3> cell_of(int outline_box) const;
  int corner_at(int box, const std::array<int, 3>& at) const;
  void number_corners(DisjointSets& same);
  void set_around();

  double size_ = 0, per_size_ = 0;
  Vector3 origin_ = Vector3::Zero();
  std::array<int, 3> axes_{0, 1, 2};  ///< the body's direction that is the grid's x, y, z: shortest first
  std::array<int, 3> counts_{};       ///< boxes of the outline
  std::vector<char> used_;            ///< of each box of the outline
  std::vector<int> first_;            ///< box of each of the outline; one more
  std::vector<int> number_of_point_;  ///< of whole boxes
  std::vector<std::array<int, 2>> joined_;
  std::vector<std::array<int, 3>> cells_, at_;
  std::vector<std::array<int, kCorners>> corners_;
  std::vector<int> around_start_, around_;
};

struct BoxGrid::Coarser {
  BoxGrid grid;
  std::vector<int> parents;
};

}  // namespace elastin
