#pragma once
#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "core/forces/blocks/alike.h"

namespace elastin::blocks {

/// The stiffness of a block's cells at one state: what a linearisation stores at their points, and the matrices of one
/// cell. Cells that are alike have it once, without their factors. Knows no solver.
template <int d>
class CellModuli {
 public:
  static constexpr int kCorners = AlikeCells<d>::kCorners;
  using UpperTriangle = Eigen::Matrix<double, 6, 1>;
  using UpperTriangles = Eigen::Matrix<double, 6, Eigen::Dynamic>;  ///< xx xy xz yy yz zz, a column each
  using OfGradient = Eigen::Matrix<double, 3 * d, 3 * d>;           ///< StiffPoints::Stiffness

  explicit CellModuli(const PointHistory<d>& points) : points_(points) {}
  void linearise_at(const Positions& positions) {
    if (alike_.find(points_, positions))
      share(positions);
    else
      linearise_each([&](int cell) { set_now(positions, cell, cell); });
  }
  void linearise_onward(const Positions& from, const Positions& to) {
    alike_.clear();
    linearise_each([&](int cell) {
      Strains<d> there;
      Stresses<d> predicted;
      predict_strains<d>(points_.rest(), from, to, cell, there, predicted);
      points_.set_stresses(cell, predicted);
      set_now(predicted, cell, cell);
    });
  }
  /// From the next linearisation on of the pressures, see CellPressures.
  void take_part(double part) { pressure_part_ = part; }

  const PointStiffness<d>& at(int cell, int g) const { return now_[alike_.kind(cell) * points_.rest().points() + g]; }
  /// F at each point of a cell.
  auto gradients(int cell) const {
    return [first = &at(cell, 0)](int g) -> const Gradient<d>& { return first[g].F; };
  }
  const PressureMatrix& of_pressures(int cell) const { return of_pressures_[alike_.kind(cell)]; }
  double factor(int cell) const { return alike_.factor(cell); }

  /// Whether cells are alike; then the stiffness between all nodes of one, by columns, and its factor.
  bool shares() const { return !shared_.empty(); }
  std::pair<const double*, double> shared(int cell) const {
    const auto& [kind, factor] = alike_.of(cell);
    return {shared_[kind].matrix.data(), factor};
  }
  /// Between the nodes of a cell, a · nodes + b, without its factor.
  void set_blocks(int cell, std::vector<Matrix3>& K) const {
    const CellsAtRest<d>& rest = points_.rest();
    const int n = rest.nodes();
    std::fill(K.begin(), K.end(), Matrix3::Zero());
    for (int g = 0; g < rest.points(); ++g) {
      std::array<Acting<d>, kMostNodes> node;
      for (int a = 0; a < n; ++a) node[a] = acting<d>(at(cell, g), rest.slope(cell, g, a));
      for (int a = 0; a < n; ++a)
        for (int b = 0; b < n; ++b) add_pair<d>(node[a], node[b], K[a * n + b]);
    }
    if (points_.volumes()) {
      const std::vector<PressureGradient> G = pressure_gradients(cell);
      for (int a = 0; a < n; ++a)
        for (int b = 0; b < n; ++b) add_pressures(G[a], of_pressures(cell), G[b], K[a * n + b]);
    }
  }
  /// The upper triangles of the diagonal ones, with it. Those of one point are Σ_pq B_p B_q A_pq,
  /// A_pq = 2 Σ_rs F_r D_pr,qs F_sᵀ + S_pq: A_pq + A_qp is found once for all nodes.
  void set_diagonal(int cell, Eigen::Ref<UpperTriangles> blocks) const {
    const CellsAtRest<d>& rest = points_.rest();
    blocks.setZero();
    if (shares()) {
      for (int a = 0; a < kCorners; ++a)
        blocks.col(a) =
            factor(cell) * upper_triangle(shared_[alike_.kind(cell)].matrix.template block<3, 3>(3 * a, 3 * a));
      return;
    }
    constexpr auto order = order_of_components<d>();
    for (int g = 0; g < rest.points(); ++g) {
      const PointStiffness<d>& now = at(cell, g);
      std::array<UpperTriangle, order.size()> A;
      for (std::size_t k = 0; k < order.size(); ++k) {
        const auto [p, q] = order[k];
        Tensor<d> between;
        for (int r = 0; r < d; ++r)
          for (int s = 0; s < d; ++s) {
            between(r, s) = now.D(component<d>(p, r), component<d>(q, s));
            if (p != q) between(r, s) += now.D(component<d>(q, r), component<d>(p, s));
          }
        const double along = p == q ? now.S(p, p) : now.S(p, q) + now.S(q, p);
        const Matrix3 block = 2 * now.F * between * now.F.transpose() + along * Matrix3::Identity();
        A[k] = upper_triangle(block);
      }
      for (int a = 0; a < rest.nodes(); ++a) {
        const Direction<d> B = rest.slope(cell, g, a);
        for (std::size_t k = 0; k < order.size(); ++k) blocks.col(a) += B[order[k][0]] * B[order[k][1]] * A[k];
      }
    }
    if (points_.volumes()) {
      const std::vector<PressureGradient> G = pressure_gradients(cell);
      for (int a = 0; a < rest.nodes(); ++a) {
        Matrix3 block = Matrix3::Zero();
        add_pressures(G[a], of_pressures(cell), G[a], block);
        blocks.col(a) += upper_triangle(block);
      }
    }
  }
  /// The sum over points first … end − 1 of what a gradient in the frame's axes meets, with it.
  OfGradient of_gradient(int cell, int first, int end) const {
    if (shares()) return factor(cell) * shared_[alike_.kind(cell)].of_gradient;
    return sum_at(cell, first, end);
  }
  /// ∂(∫ φ J)/∂x of each node.
  std::vector<PressureGradient> pressure_gradients(int cell) const {
    const CellsAtRest<d>& rest = points_.rest();
    std::vector<PressureGradient> G(rest.nodes(), PressureGradient::Zero());
    for (int g = 0; g < rest.points(); ++g) {
      const Gradient<d> to_node = rest.weight(cell, g) * cofactors<d>(at(cell, g).F);
      for (int a = 0; a < rest.nodes(); ++a) points_.volumes().add_gradient(to_node, rest.slope(cell, g, a), g, G[a]);
    }
    return G;
  }

 private:
  /// The stiffness of hexahedra that are alike.
  struct Shared {
    Eigen::Matrix<double, 3 * kCorners, 3 * kCorners> matrix;
    OfGradient of_gradient;
  };

  static UpperTriangle upper_triangle(const Matrix3& block) {
    return {block(0, 0), block(0, 1), block(0, 2), block(1, 1), block(1, 2), block(2, 2)};
  }
  void set_count(int count) {
    now_.resize(count * points_.rest().points());
    now_.shrink_to_fit();
    if (points_.volumes()) of_pressures_.resize(count);
  }
  template <class Set>
  void linearise_each(Set set) {
    shared_.clear();
    set_count(points_.rest().size());
    parallel_for(points_.rest().size(), set, kCellThreshold);
  }
  void share(const Positions& positions) {
    set_count(alike_.kinds());
    shared_.clear();
    std::vector<Matrix3> K(kCorners * kCorners);
    for (int kind = 0; kind < alike_.kinds(); ++kind) {
      const int cell = alike_.first_of(kind);
      set_now(positions, cell, kind);
      set_blocks(cell, K);
      Shared own;
      own.of_gradient = sum_at(cell, 0, points_.rest().points());
      for (int a = 0; a < kCorners; ++a)
        for (int b = 0; b < kCorners; ++b) own.matrix.template block<3, 3>(3 * a, 3 * b) = K[a * kCorners + b];
      shared_.push_back(own);
    }
  }
  void set_now(const Positions& positions, int cell, int number) {
    Stresses<d> now;
    points_.set_stresses(positions, cell, now);
    set_now(now, cell, number);
  }
  /// By strains, pressures and, without these, stresses.
  void set_now(Stresses<d>& now, int cell, int number) {
    const CellsAtRest<d>& rest = points_.rest();
    AtPoints<TangentModuli<d>> D;
    points_.set_moduli(cell, now, D);
    for (int g = 0; g < rest.points(); ++g) {
      const double weight = rest.weight(cell, g);
      now_[number * rest.points() + g] = {now.F[g], weight * now.S[g], weight * D[g]};
    }
    if (points_.volumes()) of_pressures_[number] = points_.stiffness_of_pressures(cell, now, pressure_part_);
  }
  OfGradient sum_at(int cell, int first, int end) const {
    OfGradient sum = OfGradient::Zero();
    for (int g = first; g < end; ++g) {
      std::array<Acting<d>, d> axis;
      for (int p = 0; p < d; ++p) axis[p] = acting<d>(at(cell, g), Direction<d>::Unit(p));
      for (int p = 0; p < d; ++p)
        for (int q = 0; q < d; ++q) {
          Matrix3 block = Matrix3::Zero();
          add_pair<d>(axis[p], axis[q], block);
          sum.template block<3, 3>(3 * p, 3 * q) += block;
        }
    }
    return sum;
  }

  const PointHistory<d>& points_;
  double pressure_part_ = 1;
  // At the positions of the last linearisation, of each cell or kind of cells.
  AlikeCells<d> alike_;
  std::vector<Shared, Eigen::aligned_allocator<Shared>> shared_;
  std::vector<PointStiffness<d>> now_;
  std::vector<PressureMatrix> of_pressures_;
};

}  // namespace elastin::blocks
