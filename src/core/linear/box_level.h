#pragma once
#include <memory>
#include <vector>

#include "core/linear/box_grid.h"

namespace elastin {

/// A symmetric stiffness between the points of a grid of boxes and their 26 neighbours, in single precision, for a
/// preconditioner. It is kept as differences, A x = S_i x_i + Σ_j A_ij (x_j − x_i): what moves as a whole then feels no
/// rounding, nor do the soft bending modes of slender bodies.
class BoxLevel {
 public:
  static constexpr int kSlots = 28;             ///< 27 neighbours and one to fill the vector registers
  using Row = Eigen::Matrix<float, kSlots, 9>;  ///< of a point: its neighbours' blocks by columns; S_i in the middle
  using Vectors = Eigen::Matrix3Xf;

  explicit BoxLevel(BoxGrid grid);

  const BoxGrid& grid() const { return grid_; }
  int points() const { return grid_.points(); }

  /// Adds to the block between two points, `code` above the middle: that below follows from finish().
  auto block(int point, int code) { return rows_[point].row(code); }
  /// Adds to S of a point.
  Matrix3& sum(int point) { return sums_[point]; }
  const Matrix3& sum(int point) const { return sums_[point]; }
  /// Mirrors the blocks and makes ready for the calls below; a level that is a part of one only for coarser(),
  /// neighbour() and block_to().
  void finish(bool is_part = false);

  /// Pᵀ A P for the trilinear functions of the coarser grid.
  std::unique_ptr<BoxLevel> coarser(bool is_part = false) const;
  /// coarse = Pᵀ fine
  void restrict_to(const BoxLevel& coarse, const Vectors& fine, Vectors& result) const;
  /// fine += P coarse
  void prolong_from(const BoxLevel& coarse, const Vectors& values, Vectors& fine) const;

  /// residual = b − A x
  void set_residual(const Vectors& b, const Vectors& x, Vectors& residual) const;
  /// x = ω D⁻¹ b
  void start(const Vectors& b, Vectors& x) const;
  /// better = x + ω D⁻¹ (b − A x)
  void smooth(const Vectors& b, const Vectors& x, Vectors& better) const;

  /// The block A_ij, itself included, in double precision.
  Matrix3 block_to(int point, int code) const;
  int neighbour(int point, int code) const { return around_[point][code]; }

 private:
  Eigen::Vector3f difference(const Vectors& x, int point) const;
  void set_damping();

  BoxGrid grid_;
  std::vector<Row, Eigen::aligned_allocator<Row>> rows_;
  std::vector<std::array<int, BoxGrid::kAround>> around_;  ///< points; the point itself where there is none
  std::vector<Matrix3> sums_;
  std::vector<Eigen::Matrix3f> inverse_;  ///< D⁻¹ with the damping ω
};

}  // namespace elastin
