#include "febio/stepped_cells.h"

#include <Eigen/LU>
#include <algorithm>
#include <string>
#include <utility>

#include "core/model/block_geometry.h"

namespace elastin::febio {
namespace {

/// Strains of a step [1] below which its work is not looked at: rounding of the energies is all there is.
constexpr double kLeastStrain = 1e-9;

class SteppedStiffness;

class SteppedCells final : public NodalForces, public LawHistory {
 public:
  using Terms = std::vector<std::unique_ptr<Elasticity>>;
  /// @param cells NodalForces all
  SteppedCells(const Body& body, const CellBlock& block, Terms cells, std::shared_ptr<const PointLaws<3>> laws,
               std::shared_ptr<const Clock> clock)
      : body_(body),
        block_(block),
        owned_(std::move(cells)),
        laws_(std::move(laws)),
        clock_(std::move(clock)),
        begin_(body.rest) {
    for (const auto& own : owned_) cells_.push_back(&dynamic_cast<const NodalForces&>(*own));
  }

  std::unique_ptr<Elasticity> clone() const override {
    Terms own;
    for (const auto& cells : owned_) own.push_back(cells->clone());
    auto copy = std::make_unique<SteppedCells>(body_, block_, std::move(own), laws_, clock_);
    copy->begin_ = begin_;
    return copy;
  }

  bool has_energy() const override {
    return !keeps_energy() && all([](const Elasticity& cells) { return cells.has_energy(); });
  }
  bool has_full_tangent() const override {
    return !keeps_energy() && all([](const Elasticity& cells) { return cells.has_full_tangent(); });
  }
  bool dissipates() const override {
    return !all([](const Elasticity& cells) { return !cells.dissipates(); });
  }
  bool admissible(const Positions& positions) const override {
    const auto here = [&](const Positions& x) {
      return all([&](const Elasticity& cells) { return cells.admissible(x); });
    };
    return here(positions) && (share() == 1 || here(within(positions)));
  }
  /// Its slope is α_f times that within, over α_f; without a step it is the cells' own.
  double energy(const Positions& positions) const override {
    if (share() == 1 || keeps_energy()) return energy_of_cells(positions);
    const double begin = energy_of_cells(begin_);
    return begin + (energy_of_cells(within(positions)) - begin) / share();
  }
  double internal_force(const Positions& positions) const override {
    double sum = 0;
    for (const auto& cells : cells_) sum += cells->internal_force(positions);
    return sum;
  }
  double stored_energy(const Positions& positions) const override {
    double sum = 0;
    for (const auto& cells : cells_) sum += cells->stored_energy(positions);
    return sum;
  }
  void add_forces(const Positions& positions, const Graph& graph, Positions& forces,
                  Workspace& workspace) const override {
    const auto add = [&](const Positions& x) {
      for (const auto& cells : cells_) cells->add_forces(x, graph, forces, workspace);
    };
    if (share() == 1) return add(positions);
    add(within(positions));
    if (!keeps_energy()) return;
    for (int cell = 0; cell < block_.size(); ++cell) add_missing_work(positions, cell, forces);
  }
  void show(const Positions& positions, VectorX& force_densities, const StateVisitor& visit) const override {
    for (const auto& cells : cells_) cells->show(positions, force_densities, visit);
  }

  void show_points(const Positions& positions, const PointVisitor& visit) const override {
    for (const auto& cells : cells_) cells->show_points(positions, visit);
  }

  std::unique_ptr<NodalStiffness> stiffness() const override;

  std::vector<HistoryBlock> history(const std::string& name) const override {
    std::vector<HistoryBlock> all;
    for_each_history(name, [&](const LawHistory& cells, const std::string& own) {
      for (HistoryBlock& block : cells.history(own)) all.push_back(std::move(block));
    });
    all.push_back({name, {body_.rest.data(), body_.rest.data() + body_.rest.size()}});
    return all;
  }
  void begin_step(const std::string& name, const State& from, double) override {
    for_each_history(name,
                     [&](LawHistory& cells, const std::string& own) { cells.begin_step(own, from, clock_->time); });
    if (const HistoryBlock* block = from.find_history(name))
      begin_ = Eigen::Map<const Positions>(block->values.data(), 3, body_.size());
  }
  void commit_step(const std::string& name, State& state) override {
    const double time = std::exchange(state.time, clock_->time);  // that of an analysis at rest goes by its steps
    for_each_history(name, [&](LawHistory& cells, const std::string& own) { cells.commit_step(own, state); });
    state.time = time;
    begin_ = state.positions;
    if (HistoryBlock* block = state.find_history(name))
      Eigen::Map<Positions>(block->values.data(), 3, body_.size()) = state.positions;
  }

 private:
  friend class SteppedStiffness;
  double share() const { return clock_->share; }
  bool keeps_energy() const { return share() == 0.5; }
  double energy_of_cells(const Positions& positions) const {
    double sum = 0;
    for (const auto& cells : cells_) sum += cells->energy(positions);
    return sum;
  }
  template <class Check>
  bool all(Check check) const {
    return std::all_of(cells_.begin(), cells_.end(), [&](const auto& cells) { return check(*cells); });
  }
  template <class Visit>
  void for_each_history(const std::string& name, Visit visit) const {
    for (std::size_t term = 0; term < owned_.size(); ++term)
      if (auto* own = dynamic_cast<LawHistory*>(owned_[term].get()))
        visit(*own, name + ".cells" + (term == 0 ? "" : std::to_string(term)));
  }
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
  Terms owned_;
  std::vector<const NodalForces*> cells_;
  std::shared_ptr<const PointLaws<3>> laws_;
  std::shared_ptr<const Clock> clock_;
  Positions begin_;  ///< x₀
};

class SteppedStiffness final : public NodalStiffness {
 public:
  explicit SteppedStiffness(const SteppedCells& law) : law_(law) {
    for (const auto* cells : law.cells_) cells_.push_back(cells->stiffness());
  }

  void linearise_at(const Positions& positions) override {
    for (const auto& cells : cells_) cells->linearise_at(share() == 1 ? positions : law_.within(positions));
  }
  void add_stiffness(const Positions& motion, Positions& result, Workspace& workspace) const override {
    for (const auto& cells : cells_) cells->add_stiffness(share() == 1 ? motion : share() * motion, result, workspace);
  }
  void visit_blocks(const BlockVisitor& visit) const override {
    for (const auto& cells : cells_)
      cells->visit_blocks([&](int a, int b, const Matrix3& block) { visit(a, b, share() * block); });
  }
  void visit_diagonal(const DiagonalVisitor& visit, Workspace& workspace) const override {
    for (const auto& cells : cells_)
      cells->visit_diagonal([&](int a, const Matrix3& block) { visit(a, share() * block); }, workspace);
  }
  bool visit_gradients(const GradientVisitor& visit) const override {
    bool whole = true;
    for (const auto& cells : cells_)
      whole &= cells->visit_gradients(
          [&](std::span<const std::pair<int, Vector3>> gradient, double factor) { visit(gradient, share() * factor); });
    return whole;
  }
  /// A step's points are as stiff as the cells', but for α_f: accurate enough for a preconditioner.
  void visit_points(const PointsVisitor& visit) const override {
    for (const auto& cells : cells_) cells->visit_points(visit);
  }

 private:
  double share() const { return law_.share(); }

  const SteppedCells& law_;
  std::vector<std::unique_ptr<NodalStiffness>> cells_;
};

std::unique_ptr<NodalStiffness> SteppedCells::stiffness() const { return std::make_unique<SteppedStiffness>(*this); }

}  // namespace

ElasticTerms make_stepped_cells(const Body& body, const CellBlock& block, ElasticTerms cells,
                                std::shared_ptr<const PointLaws<3>> laws, std::shared_ptr<const Clock> clock) {
  return std::make_unique<SteppedCells>(body, block, std::move(cells.terms), std::move(laws), std::move(clock));
}

}  // namespace elastin::febio
