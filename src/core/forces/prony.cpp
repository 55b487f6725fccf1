#include "elastin/core/forces/prony.h"

#include <cmath>
#include <utility>

#include "core/forces/relaxing.h"
#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"

namespace elastin {
namespace {

class Prony final : public Elasticity {
 public:
  Prony(const Body& body, std::unique_ptr<Elasticity> elastic, Relaxing relaxing)
      : body_(body), elastic_(std::move(elastic)), relaxing_(std::move(relaxing)) {}

  std::unique_ptr<Elasticity> clone() const override {
    return std::make_unique<Prony>(body_, elastic_->clone(), relaxing_);
  }

  bool has_energy() const override { return elastic_->has_energy(); }
  bool has_full_tangent() const override { return elastic_->has_full_tangent(); }
  bool admissible(const Positions& positions) const override { return elastic_->admissible(positions); }
  bool dissipates() const override { return true; }

  /// factor W + ½ Σ r (s − s at rest): what a step minimises.
  double energy(const Positions& positions) const override {
    double sum = relaxing_.factor() * elastic_->energy(positions);
    for (int c = 0; c < body_.connections.size(); ++c) {
      const auto& [a, b] = body_.connections.ends[c];
      const double rest = body_.connections.rest_length[c];
      sum += relaxing_.fixed()[c] / 2 * ((positions.col(b) - positions.col(a)).squaredNorm() - rest * rest);
    }
    return sum;
  }
  void add_force_densities(const Positions& positions, VectorX& force_densities, Workspace& workspace) const override {
    VectorX& own = workspace.relaxing;
    own.setZero(relaxing_.fixed().size());
    elastic_->add_force_densities(positions, own, workspace);
    force_densities += relaxing_.factor() * own + relaxing_.fixed();
  }

  void linearise(const Positions& positions) override {
    elastic_->linearise(positions);
    slopes_.setZero(relaxing_.fixed().size());
    elastic_->add_own_slopes(slopes_);
    slopes_ *= relaxing_.factor();
  }
  void add_own_slopes(VectorX& slopes) const override { slopes += slopes_; }
  bool coupled() const override { return elastic_->coupled(); }
  void add_change(const VectorX& squared_lengths, VectorX& force_densities, Workspace& workspace) const override {
    VectorX& own = workspace.relaxing;
    own = relaxing_.factor() * squared_lengths;
    elastic_->add_change(own, force_densities, workspace);
  }
  void visit_cells(const CellVisitor& visit) const override {
    elastic_->visit_cells([&](const CellSlopes& cells) {
      CellSlopes scaled = cells;
      scaled.factor *= relaxing_.factor();
      visit(scaled);
    });
  }
  void visit_blocks(const BlockVisitor& visit) const override {
    elastic_->visit_blocks([&](int a, int b, const Matrix3& block) { visit(a, b, relaxing_.factor() * block); });
  }
  bool visit_gradients(const GradientVisitor& visit) const override {
    return elastic_->visit_gradients([&](std::span<const std::pair<int, Vector3>> gradient, double factor) {
      visit(gradient, relaxing_.factor() * factor);
    });
  }
  void visit_diagonal(const DiagonalVisitor& visit, Workspace& workspace) const override {
    elastic_->visit_diagonal([&](int a, const Matrix3& block) { visit(a, relaxing_.factor() * block); }, workspace);
  }

  std::vector<HistoryBlock> history(const std::string& name) const override {
    std::vector<HistoryBlock> all = relaxing_.history(name);
    for (HistoryBlock& block : elastic_->history(inner(name))) all.push_back(std::move(block));
    return all;
  }
  void begin_step(const std::string& name, const State& from, double time) override {
    elastic_->begin_step(inner(name), from, time);
    relaxing_.begin_step(name, from, time);
  }
  void commit_step(const std::string& name, State& state) override {
    relaxing_.now().setZero();
    elastic_->add_force_densities(state.positions, relaxing_.now(), workspace_);
    relaxing_.commit_step(name, state);
    elastic_->commit_step(inner(name), state);
  }

 private:
  static std::string inner(const std::string& name) { return name + ".in"; }

  const Body& body_;
  std::unique_ptr<Elasticity> elastic_;
  Relaxing relaxing_;
  // Kept from one step to the next, so that steps ask for no memory.
  VectorX slopes_;
  Workspace workspace_;
};

}  // namespace

void check_relaxation(const Relaxation& relaxation) {
  if (!(relaxation.retardation >= 0) || !std::isfinite(relaxation.retardation))
    throw InputError("relaxation: a retardation of " + number(relaxation.retardation) + " s is below 0");
  if (relaxation.terms.empty() && relaxation.retardation == 0) throw InputError("relaxation needs at least one term");
  for (const Relaxation::Term& term : relaxation.terms)
    if (!(term.share > 0 && term.time > 0) || !std::isfinite(term.share) || !std::isfinite(term.time))
      throw InputError("relaxation: the share " + number(term.share) + " over " + number(term.time) +
                       " s: both must be above 0");
  if (!(relaxation.long_term() > 0))
    throw InputError("relaxation: the shares of the instantaneous stiffness sum to " +
                     number(1 - relaxation.long_term()) + "; less than 1 must relax");
}

std::unique_ptr<Elasticity> make_prony(const Body& body, std::unique_ptr<Elasticity> elastic,
                                       const Relaxation& relaxation) {
  check_relaxation(relaxation);
  if (!elastic->at_nodes())
    return std::make_unique<Prony>(body, std::move(elastic), Relaxing(relaxation, body.connections.size()));
  if (!elastic->relax(relaxation))
    throw InputError("relaxation takes springs or cells, and this strategy is of both: relax one of them");
  return elastic;
}

}  // namespace elastin
