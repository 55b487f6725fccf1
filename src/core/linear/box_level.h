#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/linear/box_grid.h"
#include "core/parallel/parallel.h"

namespace elastin {

/// The stiffness of the boxes of a grid: blocks between corners in single precision, S of corners where something
/// outside the body resists. Boxes whose blocks are alike to rounding, as nearly all of a lattice, share those of the
/// first of them.
struct BoxElements {
  static constexpr int kPairs = BoxGrid::kCorners * (BoxGrid::kCorners - 1) / 2;
  using Pairs = Eigen::Array<float, kPairs, 1>;
  /// Of each pair of corners i < j, 01 02 … 67, the entries of the block A_ij by columns.
  using Element = std::array<Pairs, 9>;
  using Sums = std::array<Matrix3, BoxGrid::kCorners>;

  explicit BoxElements(int boxes);
  const Element& of(int box) const { return elements[kind_of[box]]; }
  /// Sets a box's blocks, or shares those of one of the latest `kinds`, to which the box is added otherwise.
  void set(int box, const Element& element, std::vector<int>& kinds);
  /// Has all boxes share, each of which has a box before it, or itself, as its kind.
  void share();
  /// Has S of these boxes, zero.
  void set_sums_in(const std::vector<char>& boxes);
  std::unique_ptr<Element[]> elements;  ///< of the boxes that are their own kind
  std::vector<int> kind_of;             ///< of each box, the box whose blocks it has
  bool shared = false;                  ///< whether most boxes share them
  std::vector<int> sums_of;             ///< of each box, −1 where S is zero
  std::vector<Sums> sums;
};

/// Items in the boxes of a grid, molecules or the points of a finer one, which move as its trilinear functions say.
class BoxMembers {
 public:
  using Vectors = Eigen::Matrix3Xf;
  struct Member {
    int item;
    Eigen::Vector3f at;  ///< in its box
  };
  /// `box_of` each item; `at` gives where item number i lies in it.
  template <class At>
  BoxMembers(const BoxGrid& grid, const std::vector<int>& box_of, At&& at) : start_(grid.boxes() + 1, 0) {
    for (const int box : box_of) ++start_[box + 1];
    for (int box = 0; box < grid.boxes(); ++box) start_[box + 1] += start_[box];
    members_.resize(box_of.size());
    std::vector<int> next(start_.begin(), start_.end() - 1);
    for (std::size_t i = 0; i < box_of.size(); ++i) {
      const int item = static_cast<int>(i);
      members_[next[box_of[i]]++] = {item, at(item)};
    }
  }
  BoxMembers() = default;
  std::span<const Member> in(int box) const {
    return {members_.data() + start_[box], static_cast<std::size_t>(start_[box + 1] - start_[box])};
  }
  /// result = Pᵀ value(item); `of_boxes` is memory for intermediate results.
  template <class Value>
  void restrict_to(const BoxGrid& grid, Value&& value, Vectors& of_boxes, Vectors& result) const {
    of_boxes.resize(3, BoxGrid::kCorners * grid.boxes());
    parallel_for(
        grid.boxes(),
        [&](int box) {
          std::array<BoxGrid::Corners, 3> sums;
          sums.fill(BoxGrid::Corners::Zero());
          for (const Member& member : in(box)) {
            const BoxGrid::Corners values = BoxGrid::values_at(member.at);
            const Eigen::Vector3f of_item = value(member.item);
            for (int k = 0; k < 3; ++k) sums[k] += of_item[k] * values;
          }
          for (int c = 0; c < BoxGrid::kCorners; ++c)
            for (int k = 0; k < 3; ++k) of_boxes(k, BoxGrid::kCorners * box + c) = sums[k][c];
        },
        kFewBoxes);
    parallel_for(
        grid.points(),
        [&](int point) {
          Eigen::Vector3f sum = Eigen::Vector3f::Zero();
          for (const int corner : grid.around(point)) sum += of_boxes.col(corner);
          result.col(point) = sum;
        },
        kFewBoxes);
  }
  /// Calls add(item, P values) for each item.
  template <class Add>
  void prolong_from(const BoxGrid& grid, const Vectors& values, Add&& add) const {
    parallel_for(
        grid.boxes(),
        [&](int box) {
          std::array<BoxGrid::Corners, 3> corners;
          for (int c = 0; c < BoxGrid::kCorners; ++c)
            for (int k = 0; k < 3; ++k) corners[k][c] = values(k, grid.corners(box)[c]);
          for (const Member& member : in(box)) {
            const BoxGrid::Corners at = BoxGrid::values_at(member.at);
            add(member.item,
                Eigen::Vector3f((corners[0] * at).sum(), (corners[1] * at).sum(), (corners[2] * at).sum()));
          }
        },
        kFewBoxes);
  }

 private:
  static constexpr int kFewBoxes = 1000;  ///< one thread does fewer sooner than others wake
  std::vector<int> start_;
  std::vector<Member> members_;
};

/// A symmetric stiffness between the points of a grid of boxes that share one, in single precision, for a
/// preconditioner. It is kept as differences, A x = S_i x_i + Σ_j A_ij (x_j − x_i): what moves as a whole then feels no
/// rounding, nor do the soft bending modes of slender bodies.
class BoxLevel {
 public:
  using Vectors = Eigen::Matrix3Xf;

  /// A level that is a part of one, as a process has it, is for coarser(), neighbours() and block_to() only.
  BoxLevel(BoxGrid grid, BoxElements elements, bool is_part = false);

  const BoxGrid& grid() const { return grid_; }
  int points() const { return grid_.points(); }

  /// Pᵀ A P for the trilinear functions of the larger boxes. Gives up what this level is made of.
  std::unique_ptr<BoxLevel> coarser(BoxGrid::Coarser coarser, bool is_part = false);
  /// coarse = Pᵀ fine; `of_boxes` is memory for intermediate results
  void restrict_to(const BoxLevel& coarse, const Vectors& fine, Vectors& of_boxes, Vectors& result) const;
  /// fine += P coarse
  void prolong_from(const BoxLevel& coarse, const Vectors& values, Vectors& fine) const;

  /// Zeros, of each point and one more: a vector is read as four numbers.
  Vectors vectors() const { return Vectors::Zero(3, points() + 1); }

  /// residual = b − A x
  void set_residual(const Vectors& b, const Vectors& x, Vectors& residual) const;
  /// x = d = what the first step of smoothing makes of b from zero
  void start(const Vectors& b, Vectors& x, Vectors& d) const;
  /// How many steps smooth.
  int steps() const { return steps_; }
  void limit_steps(int most) { steps_ = std::min(steps_, most); }
  /// Step number i of smoothing x; see smoothing_step.
  void smooth(int i, const Vectors& b, const Vectors& x, Vectors& better, Vectors& d) const;

  /// The points that share a box with this one, itself first; then perhaps itself again, with blocks of zeros.
  std::span<const int> neighbours(int point) const {
    return {neighbours_.data() + start_[point], static_cast<std::size_t>(start_[point + 1] - start_[point])};
  }
  /// How many points have blocks of their own, which the others share.
  int kept_rows() const { return kept_rows_; }
  /// The block between it and one of those, in double precision.
  Matrix3 block_to(int point, int neighbour) const;

 private:
  static constexpr int kWidth = 4;  ///< of the vector registers: the number of neighbours is a multiple of it
  Eigen::Vector3f difference(const Vectors& x, int point) const;
  std::uint64_t row_key(int point, const std::vector<int>& slots) const;
  void set_rows();
  void set_damping();

  BoxGrid grid_;
  BoxElements elements_;
  BoxMembers members_;  ///< of the next coarser level: points
  std::vector<int> start_, neighbours_;
  /// The blocks of as many neighbours by columns: entry by entry, of each; S_i in the place of a point's own.
  using Blocks = std::array<Eigen::Array<float, kWidth, 1>, 9>;
  std::unique_ptr<Blocks[]> rows_;
  int kept_rows_ = 0;
  std::vector<int> row_at_;  ///< of each point, where its blocks begin: points of one kind share them
  std::vector<Matrix3> sums_;
  std::vector<Eigen::Matrix3f> inverse_;  ///< D⁻¹ over its largest eigenvalue with A
  int steps_ = 1;
};

}  // namespace elastin
