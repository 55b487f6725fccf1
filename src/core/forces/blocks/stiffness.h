#pragma once
#include <algorithm>
#include <utility>

#include "core/base/dense.h"
#include "core/forces/blocks/moduli.h"
#include "core/forces/blocks/sums.h"
#include "core/forces/cell_pressures.h"

namespace elastin::blocks {

/// What the stiffness of a block's cells does to motions and to their pressures, and what solvers see of it. What it is
/// made of must outlive it.
template <int d>
class BlockStiffness final : public NodalStiffness, public StiffPoints, public CellPressures {
 public:
  BlockStiffness(const PointHistory<d>& points, const CellSums& sums)
      : rest_(points.rest()), volumes_(points.volumes()), sums_(sums), moduli_(points) {}

  void linearise_at(const Positions& positions) override { moduli_.linearise_at(positions); }
  bool predicts() const override { return true; }
  void linearise_onward(const Positions& from, const Positions& to) override { moduli_.linearise_onward(from, to); }
  void add_onward_forces(const Positions& from, const Positions& to, Positions& forces,
                         Workspace& workspace) const override {
    sums_.add(forces, workspace, [&](int cell, NodeVectors& own) {
      Strains<d> there, predicted;
      predict_strains<d>(rest_, from, to, cell, there, predicted);
      PointGradients<d> P;
      for (int g = 0; g < rest_.points(); ++g) {
        const PointStiffness<d>& now = moduli_.at(cell, g);
        const Tensor<d> more = there.A[g] - predicted.A[g];
        P[g] = -now.F * (now.S + tensor_of<d>(now.D * doubled_components<d>(more)));
      }
      if (volumes_) {
        const Pressures swelling =
            volumes_.integral(rest_, cell, [&](int g) { return there.swelling[g] - predicted.swelling[g]; });
        volumes_.add_stresses(rest_, cell, -(moduli_.of_pressures(cell) * swelling), moduli_.gradients(cell), P);
      }
      rest_.spread(cell, P, own);
    });
  }

  void add_stiffness(const Positions& motion, Positions& result, Workspace& workspace) const override {
    if (moduli_.shares())
      return sums_.add(result, workspace, [&](int cell, NodeVectors& own) {
        const int* nodes = rest_.block().cell(cell).data();
        Eigen::Matrix<double, 3, kCorners> change;
        for (int a = 0; a < kCorners; ++a) change.col(a) = motion.col(nodes[a]) - motion.col(nodes[0]);
        const auto [matrix, factor] = moduli_.shared(cell);
        multiply24(matrix, change.data(), factor, own.data());
      });
    sums_.add(result, workspace, [&](int cell, NodeVectors& own) {
      PointGradients<d> change, P;
      rest_.set_gradients(cell, rest_.gathered(motion, cell), change);
      for (int g = 0; g < rest_.points(); ++g) {
        const PointStiffness<d>& now = moduli_.at(cell, g);
        P[g].noalias() = change[g] * now.S;
        P[g].noalias() += now.F * change_of_stress(now, change[g]);
      }
      if (volumes_) {
        const auto F = moduli_.gradients(cell);
        const Pressures p = moduli_.of_pressures(cell) * volumes_.swelling_by(rest_, cell, F, change);
        volumes_.add_stresses(rest_, cell, p, F, P);
      }
      rest_.spread(cell, P, own);
    });
  }

  void visit_blocks(const BlockVisitor& visit) const override {
    const int n = rest_.nodes();
    std::vector<Matrix3> K(n * n);
    for (int cell = 0; cell < rest_.size(); ++cell) {
      moduli_.set_blocks(cell, K);
      const auto nodes = rest_.block().cell(cell);
      for (int a = 0; a < n; ++a)
        for (int b = 0; b < n; ++b) visit(nodes[a], nodes[b], moduli_.factor(cell) * K[a * n + b]);
    }
  }

  void visit_diagonal(const DiagonalVisitor& visit, Workspace& workspace) const override {
    constexpr int most_cells = 512;  // at once
    const int n = rest_.nodes();
    auto blocks =
        workspace.buffer(Workspace::diagonals, 6 * n * std::min(most_cells, rest_.size())).reshaped(6, Eigen::AutoSize);
    for (int first = 0; first < rest_.size(); first += most_cells) {
      const int count = std::min(most_cells, rest_.size() - first);
      parallel_for(
          count, [&](int i) { moduli_.set_diagonal(first + i, blocks.middleCols(i * n, n)); }, 1);
      for (int i = 0; i < count * n; ++i) {
        const Eigen::Matrix<double, 6, 1> own = blocks.col(i);
        Matrix3 block;
        block << own[0], own[1], own[2], own[1], own[3], own[4], own[2], own[4], own[5];
        visit(rest_.block().nodes[first * n + i], block);
      }
    }
  }

  /// The pressures' part; the rest is in visit_points.
  bool visit_gradients(const GradientVisitor& visit) const override {
    std::vector<std::pair<int, Vector3>> gradient;
    for (int cell = 0; cell < (volumes_ ? rest_.size() : 0); ++cell) {
      const int m = of_each_cell();
      const std::vector<PressureGradient> G = moduli_.pressure_gradients(cell);
      const SymmetricEigen eigen = symmetric_eigen(moduli_.of_pressures(cell).topLeftCorner(m, m));
      for (int k = 0; k < m; ++k) {
        if (!(eigen.values[k] > 0)) continue;
        Pressures along = Pressures::Zero();
        for (int j = 0; j < m; ++j) along[j] = eigen.vectors(j, k);
        gradient.clear();
        const auto nodes = rest_.block().cell(cell);
        for (int a = 0; a < rest_.nodes(); ++a) gradient.emplace_back(nodes[a], G[a] * along);
        visit(gradient, moduli_.factor(cell) * eigen.values[k]);
      }
    }
    return true;
  }

  void visit_points(const PointsVisitor& visit) const override { visit(*this); }
  int stiff_points() const override { return rest_.size() * places(); }
  std::span<const int> nodes_of(int point) const override { return rest_.block().cell(point / places()); }
  Vector3 place_of(int point) const override {
    const NodeVectors nodes = rest_.gathered(rest_.body().rest, point / places());
    return places() == 1 ? Vector3(nodes.rowwise().mean()) : rest_.place_of(nodes, point % places());
  }
  Stiffness stiffness_at(int point) const override {
    const int cell = point / places(), g = point % places();
    return {rest_.frame(cell, g), moduli_.of_gradient(cell, g, places() == 1 ? rest_.points() : g + 1)};
  }

  Eigen::Index pressures() const override {
    return volumes_ ? static_cast<Eigen::Index>(rest_.size()) * of_each_cell() : 0;
  }
  int of_each_cell() const override { return rest_.block().kind->pressures; }
  double stiffness_ratio() const override {
    double most = 0;
    for (int cell = 0; cell < (volumes_ ? rest_.size() : 0); ++cell) {
      constexpr int shear = component<d>(0, 1);
      const double modulus = 2 * moduli_.factor(cell) * moduli_.at(cell, 0).D(shear, shear) / rest_.weight(cell, 0);
      if (modulus > 0) most = std::max(most, volumes_.law(cell).curvature(0) / modulus);
    }
    return most;
  }
  void swell(const Positions& motion, Eigen::Ref<VectorX> swelling) const override {
    const int m = of_each_cell();
    parallel_for(
        rest_.size(),
        [&](int cell) {
          PointGradients<d> change;
          rest_.set_gradients(cell, rest_.gathered(motion, cell), change);
          swelling.segment(static_cast<Eigen::Index>(cell) * m, m) =
              volumes_.swelling_by(rest_, cell, moduli_.gradients(cell), change).head(m);
        },
        kCellThreshold);
  }
  void add_forces_of(const Eigen::Ref<const VectorX>& pressures, Positions& forces,
                     Workspace& workspace) const override {
    const int m = of_each_cell();
    sums_.add(forces, workspace, [&](int cell, NodeVectors& own) {
      Pressures all = Pressures::Zero();
      all.head(m) = pressures.segment(static_cast<Eigen::Index>(cell) * m, m);
      PointGradients<d> P;
      P.fill(Gradient<d>::Zero());
      volumes_.add_stresses(rest_, cell, all, moduli_.gradients(cell), P);
      rest_.spread(cell, P, own);
    });
  }
  void resist(const Eigen::Ref<const VectorX>& swelling, Eigen::Ref<VectorX> pressures) const override {
    const int m = of_each_cell();
    parallel_for(
        rest_.size(),
        [&](int cell) {
          const auto at = static_cast<Eigen::Index>(cell) * m;
          pressures.segment(at, m).noalias() =
              moduli_.factor(cell) * moduli_.of_pressures(cell).topLeftCorner(m, m) * swelling.segment(at, m);
        },
        kCellThreshold);
  }
  void take_part(double part) override { moduli_.take_part(part); }

 private:
  static constexpr int kCorners = AlikeCells<d>::kCorners;

  /// Where a cell's stiffness stands for boxes that are larger than it is: of a solid one of first order in its middle.
  int places() const { return d == 3 && rest_.block().kind->order == 1 ? 1 : rest_.points(); }
  /// δS of a point by δF.
  static Tensor<d> change_of_stress(const PointStiffness<d>& now, const Gradient<d>& change) {
    Components<d> of_C;
    const Tensor<d> half = now.F.transpose() * change;
    constexpr auto order = order_of_components<d>();
    for (int k = 0; k < of_C.size(); ++k) {
      const auto [i, j] = order[k];
      of_C[k] = (half(i, j) + half(j, i)) * (i == j ? 1 : 2);
    }
    return tensor_of<d>(now.D * of_C);
  }

  const CellsAtRest<d>& rest_;
  const CellVolumes<d>& volumes_;
  const CellSums& sums_;
  CellModuli<d> moduli_;
};

}  // namespace elastin::blocks
