#include "elastin/core/forces/prony.h"

#include <cmath>
#include <utility>

#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"

namespace elastin {
namespace {

/// Of a term over a step: e^(−Δ/τ) and h; over none 1, over all time 0.
struct Decay {
  double left, mean;

  Decay(double step, double time) {
    const double x = step / time;
    left = std::exp(-x);
    mean = x > 0 ? (std::isinf(x) ? 0 : -std::expm1(-x) / x) : 1;
  }
};

class Prony final : public Elasticity {
 public:
  Prony(const Body& body, std::unique_ptr<Elasticity> elastic, const Relaxation& relaxation)
      : body_(body),
        elastic_(std::move(elastic)),
        relaxation_(relaxation),
        fixed_(VectorX::Zero(body.connections.size())) {
    factor_ = relaxation.long_term();
    for (const Relaxation::Term& term : relaxation.terms) factor_ += term.share;
  }

  std::unique_ptr<Elasticity> clone() const override {
    auto copy = std::make_unique<Prony>(body_, elastic_->clone(), relaxation_);
    copy->factor_ = factor_, copy->fixed_ = fixed_;
    return copy;
  }

  bool has_energy() const override { return elastic_->has_energy(); }
  bool has_full_tangent() const override { return elastic_->has_full_tangent(); }
  bool admissible(const Positions& positions) const override { return elastic_->admissible(positions); }
  bool dissipates() const override { return true; }

  /// factor W + ½ Σ r (s − s at rest): what a step minimises.
  double energy(const Positions& positions) const override {
    double sum = factor_ * elastic_->energy(positions);
    for (int c = 0; c < body_.connections.size(); ++c) {
      const auto& [a, b] = body_.connections.ends[c];
      const double rest = body_.connections.rest_length[c];
      sum += fixed_[c] / 2 * ((positions.col(b) - positions.col(a)).squaredNorm() - rest * rest);
    }
    return sum;
  }
  void add_force_densities(const Positions& positions, VectorX& force_densities, Workspace& workspace) const override {
    VectorX& own = workspace.relaxing;
    own.setZero(fixed_.size());
    elastic_->add_force_densities(positions, own, workspace);
    force_densities += factor_ * own + fixed_;
  }

  void linearise(const Positions& positions) override {
    elastic_->linearise(positions);
    slopes_.setZero(fixed_.size());
    elastic_->add_own_slopes(slopes_);
    slopes_ *= factor_;
  }
  void add_own_slopes(VectorX& slopes) const override { slopes += slopes_; }
  bool coupled() const override { return elastic_->coupled(); }
  void add_change(const VectorX& squared_lengths, VectorX& force_densities, Workspace& workspace) const override {
    VectorX& own = workspace.relaxing;
    own = factor_ * squared_lengths;
    elastic_->add_change(own, force_densities, workspace);
  }
  void visit_cells(const CellVisitor& visit) const override {
    elastic_->visit_cells([&](const CellSlopes& cells) {
      CellSlopes scaled = cells;
      scaled.factor *= factor_;
      visit(scaled);
    });
  }
  void visit_blocks(const BlockVisitor& visit) const override {
    elastic_->visit_blocks([&](int a, int b, const Matrix3& block) { visit(a, b, factor_ * block); });
  }
  bool visit_gradients(const GradientVisitor& visit) const override {
    return elastic_->visit_gradients(
        [&](std::span<const std::pair<int, Vector3>> gradient, double factor) { visit(gradient, factor_ * factor); });
  }
  void visit_diagonal(const DiagonalVisitor& visit) const override {
    elastic_->visit_diagonal([&](int a, const Matrix3& block) { visit(a, factor_ * block); });
  }

  /// The time, qᵉ then, and each Qᵢ.
  std::vector<HistoryBlock> history(const std::string& name) const override {
    return {{name, std::vector<double>(1 + (1 + relaxation_.terms.size()) * size(), 0)}};
  }

  void begin_step(const std::string& name, const State& from, double time) override {
    factor_ = relaxation_.long_term();
    fixed_.setZero();
    const HistoryBlock* block = from.find_history(name);
    const double step = time - (block ? block->values[0] : from.time);
    for (std::size_t i = 0; i < relaxation_.terms.size(); ++i) {
      const auto& [share, constant] = relaxation_.terms[i];
      const Decay decay(step, constant);
      factor_ += share * decay.mean;
      if (block && !std::isinf(step))
        fixed_ += share * (decay.left * relaxing(*block, i) - decay.mean * elastic(*block));
    }
  }

  void commit_step(const std::string& name, State& state) override {
    HistoryBlock* block = state.find_history(name);
    if (!block) return;
    const double step = state.time - block->values[0];
    now_.setZero(fixed_.size());
    elastic_->add_force_densities(state.positions, now_, workspace_);
    for (std::size_t i = 0; i < relaxation_.terms.size(); ++i) {
      const Decay decay(step, relaxation_.terms[i].time);
      auto own = relaxing(*block, i);
      if (step > 0)
        own = decay.left * own + decay.mean * (now_ - elastic(*block));
      else
        own.setZero();
    }
    elastic(*block) = now_;
    block->values[0] = state.time;
    begin_step(name, state, state.time);
  }

 private:
  std::size_t size() const { return static_cast<std::size_t>(fixed_.size()); }
  Eigen::Map<VectorX> elastic(HistoryBlock& block) const { return {block.values.data() + 1, fixed_.size()}; }
  Eigen::Map<const VectorX> elastic(const HistoryBlock& block) const {
    return {block.values.data() + 1, fixed_.size()};
  }
  Eigen::Map<VectorX> relaxing(HistoryBlock& block, std::size_t term) const {
    return {block.values.data() + 1 + (1 + term) * size(), fixed_.size()};
  }
  Eigen::Map<const VectorX> relaxing(const HistoryBlock& block, std::size_t term) const {
    return {block.values.data() + 1 + (1 + term) * size(), fixed_.size()};
  }

  const Body& body_;
  std::unique_ptr<Elasticity> elastic_;
  Relaxation relaxation_;
  double factor_;  ///< g₀ + Σ gᵢ hᵢ
  VectorX fixed_;  ///< r [N/m]
  // Kept from one step to the next, so that steps ask for no memory.
  VectorX now_, slopes_;
  Workspace workspace_;
};

}  // namespace

void check_relaxation(const Relaxation& relaxation) {
  if (relaxation.terms.empty()) throw InputError("relaxation needs at least one term");
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
  if (elastic->at_nodes())
    throw InputError(
        "relaxation takes springs and cells of first order with straight sides: others have no force density");
  return std::make_unique<Prony>(body, std::move(elastic), relaxation);
}

}  // namespace elastin
