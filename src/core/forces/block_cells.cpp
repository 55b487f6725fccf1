#include "elastin/core/forces/block_cells.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "core/forces/blocks/history.h"
#include "core/forces/blocks/stiffness.h"
#include "core/forces/blocks/sums.h"
#include "core/forces/element_forces.h"
#include "core/model/block_geometry.h"
#include "core/model/incidence.h"
#include "elastin/core/laws/local.h"
#include "elastin/core/model/share.h"

namespace elastin {
namespace blocks {
namespace {

/// The driver of a block's cells: what a law of forces at nodes is to the model. Its parts are in the folder blocks:
/// cells at rest, strains, volumes, the law at the points and its history, sums over cells, and the stiffness.
template <int d>
class BlockCells final : public NodalForces, public LocalElasticity, public ElementForces, public PointHistory<d> {
  using Points = PointHistory<d>;
  using Points::rest, Points::volumes;

 public:
  /// Of a law on this block of the body. Both must outlive it.
  BlockCells(const Body& body, const CellBlock& block, ElasticPoints<d> elastic)
      : Points(std::move(elastic)), body_(body), block_(block), sums_(body.size(), block) {}
  void set_rest(double part) override {
    if (body_.unstressed) Points::set_rest(part);
  }

  std::unique_ptr<Elasticity> clone() const override { return std::make_unique<BlockCells>(*this); }
  std::unique_ptr<Elasticity> on_subdomain(const Subdomain& own) const override {
    if (dissipates() || body_.unstressed || &body_ != own.whole || own.body->blocks.size() != body_.blocks.size())
      return nullptr;
    std::vector<int> cells;
    for (int cell = 0; cell < block_.size(); ++cell)
      if (own.owns(lowest_in_whole(body_, block_.cell(cell)))) cells.push_back(cell);
    const CellBlock& block = own.body->blocks[static_cast<std::size_t>(&block_ - body_.blocks.data())];
    return std::make_unique<BlockCells>(*own.body, block,
                                        ElasticPoints<d>(this->elastic(), *own.body, block, std::move(cells)));
  }
  bool has_energy() const override { return this->elastic().has_energy(); }

  const LocalElasticity* local() const override { return has_energy() && !dissipates() ? this : nullptr; }
  int elements() const override { return block_.size(); }
  std::span<const int> molecules_of(int cell) const override { return block_.cell(cell); }
  double element_energy(const Positions& positions, int cell) const override {
    return this->cell_energy(positions, cell);
  }
  void add_blocks(const Positions& positions, std::span<const LocalSlot> slots, LocalBlock& block) const override {
    for (const auto& [cell, node] : slots) add_block(positions, cell, node, block);
  }
  /// J at a point is linear in the position of one node.
  double relative_change(const Positions& positions, std::span<const LocalSlot> slots,
                         const Vector3& motion) const override {
    double most = 0;
    for (const auto& [cell, node] : slots) {
      Strains<d> now;
      set_strains(rest(), positions, cell, now);
      for (int g = 0; g < rest().points(); ++g) {
        const Direction<d> B = rest().slope(cell, g, node);
        most = std::max(most, motion.norm() * B.norm());
        if constexpr (d == 3) {
          const double before = 1 + now.swelling[g], after = before + motion.dot(cofactors<d>(now.F[g]) * B);
          if (!(before > 0) || !(after > 0)) return std::numeric_limits<double>::infinity();
          most = std::max(most, std::abs(after - before) / std::min(before, after));
        }
      }
    }
    return most;
  }

  bool admissible(const Positions& positions) const override {
    if (d == 2) return true;
    return sums_.sum([&](int cell) {
      Strains<d> now;
      set_strains(rest(), positions, cell, now);
      return now.inverted ? 1. : 0.;
    }) == 0;
  }

  double energy(const Positions& positions) const override {
    if (!has_energy()) return 0;
    return sums_.sum([&](int cell) { return this->cell_energy(positions, cell); });
  }

  double stored_energy(const Positions& positions) const override {
    if (!has_energy() || !this->relaxes()) return energy(positions);
    return Points::stored_energy(sums_.sum([&](int cell) { return this->elastic_cell_energy(positions, cell); }));
  }

  void add_forces(const Positions& positions, const Graph&, Positions& forces, Workspace& workspace) const override {
    sums_.add(forces, workspace, [&](int cell, NodeVectors& own) { add_cell_forces(positions, cell, own); });
  }
  void set_element_forces(const Positions& positions, int cell, Eigen::Ref<Positions> forces) const override {
    NodeVectors own = NodeVectors::Zero(3, rest().nodes());
    add_cell_forces(positions, cell, own);
    forces = own;
  }

  double internal_force(const Positions& positions) const override {
    return sums_.sum([&](int cell) {
      Stresses<d> now;
      this->set_stresses(positions, cell, now);
      double sum = 0;
      for (int g = 0; g < rest().points(); ++g) {
        double stress = (now.F[g] * now.S[g]).norm() + now.F[g].norm() * this->left_size(cell, g);
        if (volumes()) stress += std::abs(now.p[g]);
        sum += rest().weight(cell, g) * stress * rest().inverse(cell, g).norm();
      }
      return sum;
    });
  }

  void show(const Positions& positions, VectorX& force_densities, const StateVisitor& visit) const override {
    const int n = rest().nodes();
    const std::vector<int> connections = connections_of_some_pairs(body_.connections, block_.nodes, n);
    std::size_t first_pair = 0;
    for (int cell = 0; cell < block_.size(); ++cell, first_pair += static_cast<std::size_t>(n * (n - 1) / 2)) {
      Stresses<d> now;
      this->set_stresses(positions, cell, now);
      CellState state;
      double rest_size = 0, size = 0;
      for (int g = 0; g < rest().points(); ++g) {
        const double weight = rest().weight(cell, g);
        const Tensor<d> C = Tensor<d>::Identity() + now.A[g];
        if (volumes()) now.S[g] += now.p[g] * std::max(0., 1 + now.swelling[g]) * C.inverse();
        const Gradient<d> E = rest().frame(cell, g);
        state.strain += weight / 2 * E * now.A[g] * E.transpose();
        state.stress += weight * now.F[g] * now.S[g] * now.F[g].transpose();
        rest_size += weight, size += weight * std::sqrt(std::max(0., C.determinant()));
        std::array<Direction<d>, kMostNodes> B, SB;
        for (int a = 0; a < n; ++a) B[a] = rest().slope(cell, g, a), SB[a] = now.S[g] * B[a];
        std::size_t pair = first_pair;
        for (int a = 0; a < n; ++a)
          for (int b = a + 1; b < n; ++b, ++pair)
            if (connections[pair] >= 0) force_densities[connections[pair]] -= weight * B[a].dot(SB[b]);
      }
      state.strain /= rest_size;
      if (size > 0) state.stress /= size;
      if (!state.stress.allFinite()) state.stress.setZero();
      visit(block_.cell(cell), state);
    }
  }

  void show_points(const Positions& positions, const PointVisitor& visit) const override {
    if constexpr (d == 3)
      for (int cell = 0; cell < block_.size(); ++cell) {
        Stresses<d> now;
        this->set_stresses(positions, cell, now);
        const Positions places = positions_of(positions, block_.cell(cell)) * block_.kind->values;
        for (int g = 0; g < rest().points(); ++g) {
          if (volumes()) add_pressure<d>(now.p[g], now.A[g], now.S[g]);
          const double J = 1 + now.swelling[g];
          if (J > 0)
            visit(block_.cell(cell),
                  {places.col(g), rest().weight(cell, g) * J, now.F[g] * now.S[g] * now.F[g].transpose() / J});
        }
      }
  }

  std::unique_ptr<NodalStiffness> stiffness() const override {
    return std::make_unique<BlockStiffness<d>>(*this, sums_);
  }

  bool relax(const Relaxation& relaxation) override {
    Points::relax(relaxation);
    return true;
  }
  bool dissipates() const override { return this->softened() || this->relaxes(); }

 private:
  void add_cell_forces(const Positions& positions, int cell, NodeVectors& own) const {
    Stresses<d> now;
    this->set_stresses(positions, cell, now);
    PointGradients<d> P;
    for (int g = 0; g < rest().points(); ++g) {
      P[g] = now.F[g] * now.S[g];
      if (volumes()) P[g] += now.p[g] * cofactors<d>(now.F[g]);
      P[g] *= -rest().weight(cell, g);
    }
    rest().spread(cell, P, own);
  }

  /// What one cell makes of the position of one of its nodes: the diagonal block of visit_diagonal, of one node alone.
  void add_block(const Positions& positions, int cell, int node, LocalBlock& block) const {
    Stresses<d> now;
    this->set_stresses(positions, cell, now);
    AtPoints<TangentModuli<d>> D;
    this->set_moduli(cell, now, D);
    PressureGradient G = PressureGradient::Zero();
    for (int g = 0; g < rest().points(); ++g) {
      const double weight = rest().weight(cell, g);
      const Direction<d> B = rest().slope(cell, g, node);
      if (volumes()) volumes().add_gradient(weight * cofactors<d>(now.F[g]), B, g, G);
      const Acting<d> here = acting<d>({now.F[g], weight * now.S[g], weight * D[g]}, B);
      block.gradient += now.F[g] * here.SB;
      add_pair<d>(here, here, block.hessian);
    }
    if (volumes()) add_pressures(G, this->stiffness_of_pressures(cell, now), G, block.hessian);
  }

  const Body& body_;
  const CellBlock& block_;
  CellSums sums_;
};

}  // namespace
}  // namespace blocks

template <int dimensions>
std::unique_ptr<NodalForces> make_block_cells(const Body& body, const CellBlock& block,
                                              std::shared_ptr<const PointLaws<dimensions>> laws,
                                              std::vector<Volumetric> volume) {
  return std::make_unique<blocks::BlockCells<dimensions>>(
      body, block, blocks::ElasticPoints<dimensions>(body, block, std::move(laws), std::move(volume)));
}
template std::unique_ptr<NodalForces> make_block_cells<2>(const Body&, const CellBlock&,
                                                          std::shared_ptr<const PointLaws<2>>, std::vector<Volumetric>);
template std::unique_ptr<NodalForces> make_block_cells<3>(const Body&, const CellBlock&,
                                                          std::shared_ptr<const PointLaws<3>>, std::vector<Volumetric>);

}  // namespace elastin
