#include <algorithm>
#include <utility>

#include "elastin/core/forces/elasticity.h"

namespace elastin {
namespace {

class Sum final : public Elasticity {
 public:
  Sum(std::vector<std::unique_ptr<Elasticity>> terms, std::shared_ptr<const void> owner,
      std::vector<CellRange> triangles)
      : owner_(std::move(owner)), terms_(std::move(terms)), triangles_(std::move(triangles)) {}

  std::unique_ptr<Elasticity> clone() const override {
    std::vector<std::unique_ptr<Elasticity>> terms;
    for (const auto& term : terms_) terms.push_back(term->clone());
    return std::make_unique<Sum>(std::move(terms), owner_, triangles_);
  }
  std::unique_ptr<Elasticity> on_subdomain(const Subdomain& own) const override {
    std::vector<std::unique_ptr<Elasticity>> terms;
    for (const auto& term : terms_) {
      terms.push_back(term->on_subdomain(own));
      if (!terms.back()) return nullptr;
    }
    return std::make_unique<Sum>(std::move(terms), owner_, std::vector<CellRange>{});
  }
  bool admissible(const Positions& positions) const override {
    return all([&](const Elasticity& term) { return term.admissible(positions); });
  }
  bool has_energy() const override {
    return all([](const Elasticity& term) { return term.has_energy(); });
  }
  bool has_full_tangent() const override {
    return all([](const Elasticity& term) { return term.has_full_tangent(); });
  }
  double energy(const Positions& positions) const override {
    double sum = 0;
    for (const auto& term : terms_) sum += term->energy(positions);
    return sum;
  }
  void add_force_densities(const Positions& positions, VectorX& force_densities, Workspace& workspace) const override {
    for (const auto& term : terms_) term->add_force_densities(positions, force_densities, workspace);
  }
  void add_triangle_force_densities(const Positions& positions, Eigen::Ref<Eigen::Matrix3Xd> of_triangles,
                                    VectorX& of_connections, Workspace& workspace) const override {
    for (std::size_t term = 0; term < terms_.size(); ++term) {
      const CellRange own = triangles_.empty() ? CellRange{0, static_cast<int>(of_triangles.cols())} : triangles_[term];
      terms_[term]->add_triangle_force_densities(positions, of_triangles.middleCols(own.first, own.count),
                                                 of_connections, workspace);
    }
  }
  void add_forces(const Positions& positions, const Graph& graph, Positions& forces,
                  Workspace& workspace) const override {
    for (const auto& term : terms_) term->add_forces(positions, graph, forces, workspace);
  }
  bool at_nodes() const override {
    return !all([](const Elasticity& term) { return !term.at_nodes(); });
  }
  void add_stiffness(const Positions& motion, Positions& result, Workspace& workspace) const override {
    for (const auto& term : terms_) term->add_stiffness(motion, result, workspace);
  }
  double internal_force(const Positions& positions) const override {
    double sum = 0;
    for (const auto& term : terms_) sum += term->internal_force(positions);
    return sum;
  }
  void show(const Positions& positions, VectorX& force_densities, const StateVisitor& visit) const override {
    for (const auto& term : terms_) term->show(positions, force_densities, visit);
  }
  void visit_points(const PointsVisitor& visit) const override {
    for (const auto& term : terms_) term->visit_points(visit);
  }
  std::vector<HistoryBlock> history(const std::string& name) const override {
    std::vector<HistoryBlock> all;
    for (std::size_t term = 0; term < terms_.size(); ++term)
      for (HistoryBlock& block : terms_[term]->history(name_of(name, term))) all.push_back(std::move(block));
    return all;
  }
  void begin_step(const std::string& name, const State& from, double time) override {
    for (std::size_t term = 0; term < terms_.size(); ++term) terms_[term]->begin_step(name_of(name, term), from, time);
  }
  void commit_step(const std::string& name, State& state) override {
    for (std::size_t term = 0; term < terms_.size(); ++term) terms_[term]->commit_step(name_of(name, term), state);
  }
  bool add_local_terms(std::vector<const LocalElasticity*>& terms) const override {
    const std::size_t before = terms.size();
    const bool whole = all([&](const Elasticity& term) { return term.add_local_terms(terms); });
    if (!whole) terms.resize(before);
    return whole;
  }
  bool soften(const Softening& softening) override {
    bool any = false;
    for (const auto& term : terms_) any |= term->soften(softening);
    return any;
  }
  bool relax(const Relaxation& relaxation) override {
    return all([&](const auto& term) { return term.at_nodes(); }) &&
           all([&](auto& term) { return term.relax(relaxation); });
  }
  bool dissipates() const override {
    return !all([](const Elasticity& term) { return !term.dissipates(); });
  }
  void linearise(const Positions& positions) override {
    for (const auto& term : terms_) term->linearise(positions);
  }
  void add_own_slopes(VectorX& slopes) const override {
    for (const auto& term : terms_) term->add_own_slopes(slopes);
  }
  bool coupled() const override {
    return !all([](const Elasticity& term) { return !term.coupled(); });
  }
  void add_change(const VectorX& squared_lengths, VectorX& force_densities, Workspace& workspace) const override {
    for (const auto& term : terms_) term->add_change(squared_lengths, force_densities, workspace);
  }
  void visit_cells(const CellVisitor& visit) const override {
    for (const auto& term : terms_) term->visit_cells(visit);
  }
  void visit_blocks(const BlockVisitor& visit) const override {
    for (const auto& term : terms_) term->visit_blocks(visit);
  }
  bool visit_gradients(const GradientVisitor& visit) const override {
    bool whole = true;
    for (const auto& term : terms_) whole &= term->visit_gradients(visit);
    return whole;
  }
  void visit_diagonal(const DiagonalVisitor& visit, Workspace& workspace) const override {
    for (const auto& term : terms_) term->visit_diagonal(visit, workspace);
  }

 private:
  static std::string name_of(const std::string& name, std::size_t term) { return name + "." + std::to_string(term); }

  template <class Check>
  bool all(Check check) const {
    return std::all_of(terms_.begin(), terms_.end(), [&](const auto& term) { return check(*term); });
  }

  std::shared_ptr<const void> owner_;  // outlives the terms
  std::vector<std::unique_ptr<Elasticity>> terms_;
  std::vector<CellRange> triangles_;  // of each term, or empty
};

}  // namespace

std::unique_ptr<Elasticity> make_sum(std::vector<std::unique_ptr<Elasticity>> terms, std::shared_ptr<const void> owner,
                                     std::vector<CellRange> triangles) {
  return std::make_unique<Sum>(std::move(terms), std::move(owner), std::move(triangles));
}

std::unique_ptr<Elasticity> make_sum(std::unique_ptr<Elasticity> first, std::unique_ptr<Elasticity> second) {
  std::vector<std::unique_ptr<Elasticity>> terms;
  terms.push_back(std::move(first)), terms.push_back(std::move(second));
  return make_sum(std::move(terms), nullptr);
}

}  // namespace elastin
