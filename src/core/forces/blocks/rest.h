#pragma once
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/forces/blocks/tensors.h"
#include "elastin/core/model/body.h"
#include "elastin/core/model/rest.h"

namespace elastin::blocks {

/// The cells of one block where they are unstressed: weights, frames and slopes B_a of the shape functions at the
/// points of their quadrature. Cells of one shape have them once. Knows no law and no motion.
template <int d>
class CellsAtRest {
 public:
  /// Both must outlive it.
  CellsAtRest(const Body& body, const CellBlock& block)
      : body_(body), block_(block), points_(static_cast<int>(block.kind->slopes.size())), slopes_(*block.kind) {
    set(1);
  }
  /// Makes a part of Body::unstressed count, as Elasticity::set_rest.
  void set(double part) {
    shape_.clear(), first_of_shape_.clear(), rest_.clear(), frames_.clear(), offsets_.clear();
    for (int cell = 0; cell < size(); ++cell) set(cell, part);
  }

  const Body& body() const { return body_; }
  const CellBlock& block() const { return block_; }
  int size() const { return block_.size(); }
  int nodes() const { return block_.kind->nodes; }
  int points() const { return points_; }
  int shape(int cell) const { return shape_[cell]; }
  /// Of each shape, the cell that has it first.
  const std::vector<int>& first_of_shape() const { return first_of_shape_; }

  /// w_g [m³], [m²].
  double weight(int cell, int g) const { return point(cell, g).weight; }
  /// Of ∂X/∂ξ, in the frame of the point.
  const Tensor<d>& inverse(int cell, int g) const { return point(cell, g).inverse; }
  /// The frame of a point, orthonormal: space itself in a solid, else first along ∂X/∂ξ₁, second in the cell.
  Gradient<d> frame(int cell, int g) const {
    if constexpr (d == 3)
      return Matrix3::Identity();
    else
      return frames_[at(cell, g)];
  }
  /// Adds F without displacement, beyond the frame, of a body that is stressed then.
  void add_offset(int cell, int g, Gradient<d>& H) const {
    if (!offsets_.empty()) H += offsets_[at(cell, g)];
  }
  /// B_a at a point.
  Direction<d> slope(int cell, int g, int a) const {
    return inverse(cell, g).transpose() * Eigen::Map<const Direction<d>>(block_.kind->slopes[g].data() + d * a);
  }

  /// What the nodes of a cell have of `values`.
  NodeVectors gathered(const Positions& values, int cell) const {
    NodeVectors own(3, nodes());
    const int* molecules = block_.cell(cell).data();
    for (int a = 0; a < nodes(); ++a) own.col(a) = values.col(molecules[a]);
    return own;
  }
  /// Σ v_a ⊗ B_a at each point.
  void set_gradients(int cell, const NodeVectors& values, PointGradients<d>& at_points) const {
    slopes_.gradients(values, at_points);
    for (int g = 0; g < points_; ++g) {
      Gradient<d>& own = at_points[g];
      own = (own * inverse(cell, g)).eval();
    }
  }
  /// own.col(a) += Σ_g P_g B_a; P becomes what its reference slopes multiply.
  void spread(int cell, PointGradients<d>& P, NodeVectors& own) const {
    for (int g = 0; g < points_; ++g) {
      Gradient<d>& at_point = P[g];
      at_point = (at_point * inverse(cell, g).transpose()).eval();
    }
    slopes_.spread(P, own);
  }
  /// Of a point of the cell with these nodes.
  Vector3 place_of(const NodeVectors& own, int g) const {
    Vector3 place = Vector3::Zero();
    for (int a = 0; a < nodes(); ++a) place += block_.kind->values(a, g) * own.col(a);
    return place;
  }

 private:
  struct Point {
    Tensor<d> inverse;
    double weight;
  };

  std::size_t at(int cell, int g) const { return shape_[cell] * points_ + g; }
  const Point& point(int cell, int g) const { return rest_[at(cell, g)]; }
  /// Of a share of a body from the first node, and rounded: whichever cells a process has, a cell is the same there as
  /// on any other, and those of a grid are alike to the last digit.
  NodeVectors nodes_at_rest(int cell) const {
    NodeVectors own = gathered(body_.rest, cell);
    if (!body_.share) return own;
    own.colwise() -= Vector3(own.col(0));
    constexpr int digits = 40;  // binary; less than the rounding of positions leaves
    const double unit = std::ldexp(1, std::ilogb(own.col(1).norm()) - digits);
    return (own / unit).array().round() * unit;
  }
  /// Cells of a grid are like one of the last few new ones.
  bool is_like_another(const NodeVectors& own) {
    constexpr std::size_t last = 8;
    const double rounding = body_.share ? 0 : 1e-11 * (own.col(1) - own.col(0)).norm();
    if (body_.unstressed) return false;
    for (std::size_t shape = first_of_shape_.size(), end = shape - std::min(shape, last); shape-- > end;) {
      const NodeVectors other = nodes_at_rest(first_of_shape_[shape]);
      bool same = true;
      for (int a = 1; a < nodes() && same; ++a)
        same = (own.col(a) - own.col(0) - other.col(a) + other.col(0)).cwiseAbs().maxCoeff() <= rounding;
      if (!same) continue;
      shape_.push_back(static_cast<int>(shape));
      return true;
    }
    return false;
  }
  void set(int cell, double part) {
    const NodeVectors own = nodes_at_rest(cell);
    if (is_like_another(own)) return;
    shape_.push_back(static_cast<int>(first_of_shape_.size()));
    first_of_shape_.push_back(cell);
    PointGradients<d> all;
    slopes_.gradients(own, all);
    for (int g = 0; g < points_; ++g) {
      Gradient<d> edges = all[g];
      if (body_.unstressed) edges = body_.unstressed->at(place_of(own, g), own.rowwise().mean(), part) * edges;
      Tensor<d> in_frame;
      if constexpr (d == 3) {
        in_frame = edges;
      } else {
        const Vector3 first = edges.col(0).normalized(),
                      normal = Vector3(edges.col(0)).cross(Vector3(edges.col(1))).normalized();
        Gradient<d> axes;
        axes << first, normal.cross(first);
        frames_.push_back(axes);
        in_frame = axes.transpose() * edges;
      }
      rest_.push_back({in_frame.inverse(), block_.kind->weights[g] * std::abs(in_frame.determinant())});
      if (body_.unstressed) offsets_.push_back(all[g] * rest_.back().inverse - frame(cell, g));
    }
  }

  const Body& body_;
  const CellBlock& block_;
  int points_;
  ReferenceSlopes<d> slopes_;
  std::vector<int> shape_;           ///< of each cell
  std::vector<int> first_of_shape_;  ///< what follows is of each shape, at each point
  std::vector<Point> rest_;
  std::vector<Gradient<d>> frames_, offsets_;
};

}  // namespace elastin::blocks
