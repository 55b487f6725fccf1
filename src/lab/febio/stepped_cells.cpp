#include "lab/febio/stepped_cells.h"

#include <Eigen/LU>
#include <utility>

#include "core/model/block_geometry.h"

namespace elastin::lab::febio {
namespace {

/// Strains of a step [1] below which its work is not looked at: rounding of the energies is all there is.
constexpr double kLeastStrain = 1e-9;

class SteppedCells final : public Elasticity {
 public:
  SteppedCells(const Body& body, const CellBlock& block, std::unique_ptr<Elasticity> cells,
               std::shared_ptr<const PointLaws<3>> laws, std::shared_ptr<const Clock> clock)
      : body_(body),
        block_(block),
        cells_(std::move(cells)),
        laws_(std::move(laws)),
        clock_(std::move(clock)),
        begin_(body.rest) {}

  std::unique_ptr<Elasticity> clone() const override {
    auto copy = std::make_unique<SteppedCells>(body_, block_, cells_->clone(), laws_, clock_);
    copy->begin_ = begin_;
    return copy;
  }

  bool has_energy() const override { return cells_->has_energy() && !keeps_energy(); }
  bool has_full_tangent() const override { return cells_->has_full_tangent() && !keeps_energy(); }
  bool at_nodes() const override { return true; }
  bool dissipates() const override { return cells_->dissipates(); }
  bool admissible(const Positions& positions) const override {
    return cells_->admissible(positions) && (share() == 1 || cells_->admissible(within(positions)));
  }
  /// Its slope is α_f times that within, over α_f; without a step it is the cells' own.
  double energy(const Positions& positions) const override {
    if (share() == 1 || keeps_energy()) return cells_->energy(positions);
    const double begin = cells_->energy(begin_);
    return begin + (cells_->energy(within(positions)) - begin) / share();
  }
  double internal_force(const Positions& positions) const override { return cells_->internal_force(positions); }
  void add_force_densities(const Positions&, VectorX&, Workspace&) const override {}
  void add_forces(const Positions& positions, const Graph& graph, Positions& forces,
                  Workspace& workspace) const override {
    if (share() == 1) return cells_->add_forces(positions, graph, forces, workspace);
    cells_->add_forces(within(positions), graph, forces, workspace);
    if (!keeps_energy()) return;
    for (int cell = 0; cell < block_.size(); ++cell) add_missing_work(positions, cell, forces);
  }
  void show(const Positions& positions, VectorX& force_densities, const StateVisitor& visit) const override {
    cells_->show(positions, force_densities, visit);
  }

  void linearise(const Positions& positions) override {
    cells_->linearise(share() == 1 ? positions : within(positions));
  }
  void add_own_slopes(VectorX&) const override {}
  void add_stiffness(const Positions& motion, Positions& result, Workspace& workspace) const override {
    cells_->add_stiffness(share() == 1 ? motion : share() * motion, result, workspace);
  }
  void visit_blocks(const BlockVisitor& visit) const override {
    cells_->visit_blocks([&](int a, int b, const Matrix3& block) { visit(a, b, share() * block); });
  }
  void visit_diagonal(const DiagonalVisitor& visit, Workspace& workspace) const override {
    cells_->visit_diagonal([&](int a, const Matrix3& block) { visit(a, share() * block); }, workspace);
  }
  bool visit_gradients(const GradientVisitor& visit) const override {
    return cells_->visit_gradients(
        [&](std::span<const std::pair<int, Vector3>> gradient, double factor) { visit(gradient, share() * factor); });
  }
  /// A step's points are as stiff as the cells', but for α_f: near enough for who asks, a preconditioner.
  void visit_points(const PointsVisitor& visit) const override { cells_->visit_points(visit); }

  std::vector<HistoryBlock> history(const std::string& name) const override {
    std::vector<HistoryBlock> all = cells_->history(name + ".cells");
    all.push_back({name, {body_.rest.data(), body_.rest.data() + body_.rest.size()}});
    return all;
  }
  void begin_step(const std::string& name, const State& from, double) override {
    cells_->begin_step(name + ".cells", from, clock_->time);
    if (const HistoryBlock* block = from.find_history(name))
      begin_ = Eigen::Map<const Positions>(block->values.data(), 3, body_.size());
  }
  void commit_step(const std::string& name, State& state) override {
    const double time = std::exchange(state.time, clock_->time);  // that of an analysis at rest goes by its steps
    cells_->commit_step(name + ".cells", state);
    state.time = time;
    begin_ = state.positions;
    if (HistoryBlock* block = state.find_history(name))
      Eigen::Map<Positions>(block->values.data(), 3, body_.size()) = state.positions;
  }

 private:
  double share() const { return clock_->share; }
  bool keeps_energy() const { return share() == 0.5; }
  Positions within(const Positions& positions) const { return begin_ + share() * (positions - begin_); }

  void add_missing_work(const Positions& positions, int cell, Positions& forces) const {
    const auto nodes = block_.cell(cell);
    const Eigen::MatrixXd rest = positions_of(body_.rest, nodes), first = positions_of(begin_, nodes) - rest,
                          change = positions_of(positions, nodes) - positions_of(begin_, nodes);
    const std::size_t points = block_.kind->slopes.size();
    std::vector<Matrix3> F(points), E(points), before(points), after(points), middle(points), S(points),
        inverse(points);
    std::vector<double> weights(points, 0);
    const auto strain = [](const Matrix3& H) -> Matrix3 { return H + H.transpose() + H.transpose() * H; };
    for (std::size_t g = 0; g < points; ++g) {
      const Eigen::MatrixXd slopes = block_.kind->slopes[g].transpose();
      inverse[g] = Matrix3(rest * slopes).inverse();
      const Matrix3 H0 = first * slopes * inverse[g], dH = change * slopes * inverse[g], half = H0 + dH / 2;
      before[g] = strain(H0), after[g] = strain(H0 + dH), middle[g] = strain(half);
      F[g] = Matrix3::Identity() + half;
      const Matrix3 work = F[g].transpose() * dH;
      E[g] = (work + work.transpose()) / 2;
    }
    laws_->stresses(cell, middle, S);
    for (std::size_t g = 0; g < points; ++g) {
      const Matrix3 C = (Matrix3::Identity() + middle[g]).inverse(), G = C * E[g] * C;
      const double square = E[g].cwiseProduct(G).sum();
      if (!(square > kLeastStrain * kLeastStrain)) continue;
      weights[g] = 1;
      const double gained = laws_->energy(cell, after, weights) - laws_->energy(cell, before, weights);
      weights[g] = 0;
      const double missing = gained - S[g].cwiseProduct(E[g]).sum();
      const double weight = block_.kind->weights[static_cast<Eigen::Index>(g)] / std::abs(inverse[g].determinant());
      const Eigen::MatrixXd own =
          -weight * missing / square * F[g] * G * inverse[g].transpose() * block_.kind->slopes[g];
      for (std::size_t a = 0; a < nodes.size(); ++a) forces.col(nodes[a]) += own.col(static_cast<Eigen::Index>(a));
    }
  }

  const Body& body_;
  const CellBlock& block_;
  std::unique_ptr<Elasticity> cells_;
  std::shared_ptr<const PointLaws<3>> laws_;
  std::shared_ptr<const Clock> clock_;
  Positions begin_;  ///< x₀
};

}  // namespace

std::unique_ptr<Elasticity> make_stepped_cells(const Body& body, const CellBlock& block,
                                               std::unique_ptr<Elasticity> cells,
                                               std::shared_ptr<const PointLaws<3>> laws,
                                               std::shared_ptr<const Clock> clock) {
  return std::make_unique<SteppedCells>(body, block, std::move(cells), std::move(laws), std::move(clock));
}

}  // namespace elastin::lab::febio
