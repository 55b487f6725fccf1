#include <utility>

#include "elastin/forces/elasticity.h"

namespace elastin {
namespace {

class Sum final : public Elasticity {
 public:
  Sum(std::unique_ptr<Elasticity> first, std::unique_ptr<Elasticity> second)
      : first_(std::move(first)), second_(std::move(second)) {}

  std::unique_ptr<Elasticity> clone() const override { return make_sum(first_->clone(), second_->clone()); }
  bool admissible(const Positions& positions) const override {
    return first_->admissible(positions) && second_->admissible(positions);
  }
  bool has_energy() const override { return first_->has_energy() && second_->has_energy(); }
  bool has_full_tangent() const override { return first_->has_full_tangent() && second_->has_full_tangent(); }
  double energy(const Positions& positions) const override {
    return first_->energy(positions) + second_->energy(positions);
  }
  void add_force_densities(const Positions& positions, VectorX& densities, Scratch& scratch) const override {
    first_->add_force_densities(positions, densities, scratch);
    second_->add_force_densities(positions, densities, scratch);
  }
  void add_forces(const Positions& positions, const Graph& graph, Positions& forces, Scratch& scratch) const override {
    first_->add_forces(positions, graph, forces, scratch);
    second_->add_forces(positions, graph, forces, scratch);
  }
  void linearise(const Positions& positions) override {
    first_->linearise(positions);
    second_->linearise(positions);
  }
  void add_own_slopes(VectorX& slopes) const override {
    first_->add_own_slopes(slopes);
    second_->add_own_slopes(slopes);
  }
  bool coupled() const override { return first_->coupled() || second_->coupled(); }
  void add_change(const VectorX& squares, VectorX& densities) const override {
    first_->add_change(squares, densities);
    second_->add_change(squares, densities);
  }
  void visit_cells(const CellVisitor& visit) const override {
    first_->visit_cells(visit);
    second_->visit_cells(visit);
  }
  void visit_blocks(const BlockVisitor& visit) const override {
    first_->visit_blocks(visit);
    second_->visit_blocks(visit);
  }
  bool visit_gradients(const GradientVisitor& visit) const override {
    const bool first = first_->visit_gradients(visit), second = second_->visit_gradients(visit);
    return first && second;
  }
  void add_diagonal(std::vector<Matrix3>& blocks) const override {
    first_->add_diagonal(blocks);
    second_->add_diagonal(blocks);
  }

 private:
  std::unique_ptr<Elasticity> first_, second_;
};

}  // namespace

std::unique_ptr<Elasticity> make_sum(std::unique_ptr<Elasticity> first, std::unique_ptr<Elasticity> second) {
  return std::make_unique<Sum>(std::move(first), std::move(second));
}

}  // namespace elastin
