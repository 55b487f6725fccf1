#include "elastin/core/forces/prony.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "core/forces/relaxing.h"
#include "core/forces/unstressed_lengths.h"
#include "core/model/incidence.h"
#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"

namespace elastin {
namespace {

class PronySlopes;

/// The terms' force densities together, relaxing.
class Prony final : public EdgeDensities, public LawHistory, public TransposedHistory {
 public:
  /// @param elastic EdgeDensities all
  Prony(const Body& body, std::vector<std::unique_ptr<Elasticity>> elastic, Relaxing relaxing)
      : body_(body), rest_lengths_(body), owned_(std::move(elastic)), relaxing_(std::move(relaxing)) {
    for (const auto& term : owned_) elastic_.push_back(&dynamic_cast<const EdgeDensities&>(*term));
  }

  std::unique_ptr<Elasticity> clone() const override {
    std::vector<std::unique_ptr<Elasticity>> own;
    for (const auto& term : owned_) own.push_back(term->clone());
    return std::make_unique<Prony>(body_, std::move(own), relaxing_);
  }

  void set_rest(double part) override {
    rest_lengths_.set(part);
    for (const auto& term : owned_) term->set_rest(part);
  }

  bool has_energy() const override {
    return all([](const EdgeDensities& term) { return term.has_energy(); });
  }
  bool has_full_tangent() const override {
    return all([](const EdgeDensities& term) { return term.has_full_tangent(); });
  }
  bool admissible(const Positions& positions) const override {
    return all([&](const EdgeDensities& term) { return term.admissible(positions); });
  }
  bool dissipates() const override { return true; }

  /// factor W + ½ Σ r (s − s at rest): what a step minimises.
  double energy(const Positions& positions) const override {
    double sum = 0;
    for (const auto& term : elastic_) sum += term->energy(positions);
    sum *= relaxing_.factor();
    for (int c = 0; c < body_.connections.size(); ++c) {
      const auto& [a, b] = body_.connections.ends[c];
      const double rest = rest_lengths_[c];
      sum += relaxing_.fixed()[c] / 2 * ((positions.col(b) - positions.col(a)).squaredNorm() - rest * rest);
    }
    return sum;
  }
  double stored_energy(const Positions& positions) const override {
    double elastic = 0;
    for (const auto& term : elastic_) elastic += term->energy(positions);
    return relaxing_.stored_energy(elastic);
  }
  void add_force_densities(const Positions& positions, VectorX& force_densities, Workspace& workspace) const override {
    VectorX& own = workspace.relaxing;
    own.setZero(relaxing_.fixed().size());
    for (const auto& term : elastic_) term->add_force_densities(positions, own, workspace);
    force_densities += relaxing_.factor() * own + relaxing_.fixed();
  }
  void set_part_sizes(const Positions& positions, VectorX& sizes, Workspace& workspace) const override {
    sizes.setZero();
    for (const auto& term : elastic_) term->add_force_densities(positions, sizes, workspace);
    sizes = relaxing_.factor() * sizes.cwiseAbs() + relaxing_.fixed().cwiseAbs();
  }
  /// What the past has left is shared as by show().
  void add_triangle_force_densities(const Positions& positions, Eigen::Ref<Eigen::Matrix3Xd> of_triangles,
                                    VectorX& of_connections, Workspace& workspace) const override {
    const VectorX& fixed = relaxing_.fixed();
    Eigen::Matrix3Xd own = Eigen::Matrix3Xd::Zero(3, of_triangles.cols());
    VectorX elastic = VectorX::Zero(fixed.size()), of_others = elastic, gammas = elastic, cells = elastic;
    for (const auto* term : elastic_) {
      term->add_force_densities(positions, elastic, workspace);
      term->add_triangle_force_densities(positions, own, of_others, workspace);
    }
    own *= relaxing_.factor();
    if (own.cols() == static_cast<Eigen::Index>(body_.triangles.size())) {  // not of a part of the body
      const auto sides = connections_of_each_cell<3>(body_.connections, body_.triangles);
      for (std::size_t cell = 0; cell < sides.size(); ++cell) {
        const double gamma = part_left(elastic(sides[cell]), fixed(sides[cell]));
        gammas(sides[cell]).array() += gamma, cells(sides[cell]).array() += 1;
        own.col(static_cast<Eigen::Index>(cell)) *= 1 + gamma / relaxing_.factor();
      }
    }
    of_triangles += own;
    const VectorX gamma = gammas.array() / cells.array().max(1);
    of_connections += relaxing_.factor() * of_others + fixed - gamma.cwiseProduct(elastic - of_others);
  }
  /// What the past has left is of connections. A cell has as much of it, γ of its own stress, as fits it best on the
  /// cell's sides; the others' γ is the mean of the cells around them.
  void show(const Positions& positions, VectorX& others, const StateVisitor& visit) const override {
    const VectorX& fixed = relaxing_.fixed();
    VectorX elastic = VectorX::Zero(fixed.size()), of_others = elastic, gammas = elastic, cells = elastic;
    Workspace workspace;
    for (const auto* term : elastic_) term->add_force_densities(positions, elastic, workspace);
    for (const auto* term : elastic_) {
      std::vector<int> molecules;
      std::vector<CellState> states;
      term->show(positions, of_others, [&](std::span<const int> own, const CellState& state) {
        molecules.insert(molecules.end(), own.begin(), own.end());
        states.push_back(state);
      });
      if (states.empty()) continue;
      const std::size_t of_each = molecules.size() / states.size();
      const std::vector<int> sides = connections_of_pairs(body_.connections, molecules, static_cast<int>(of_each));
      const std::size_t of_cell = sides.size() / states.size();
      for (std::size_t cell = 0; cell < states.size(); ++cell) {
        const std::vector<int> own(&sides[cell * of_cell], &sides[cell * of_cell] + of_cell);
        const double gamma = part_left(elastic(own), fixed(own));
        gammas(own).array() += gamma, cells(own).array() += 1;
        states[cell].stress *= relaxing_.factor() + gamma;
        visit({&molecules[cell * of_each], of_each}, states[cell]);
      }
    }
    const VectorX gamma = gammas.array() / cells.array().max(1);
    others += relaxing_.factor() * of_others + fixed - gamma.cwiseProduct(elastic - of_others);
  }
  bool coupled() const override {
    return !all([](const EdgeDensities& term) { return !term.coupled(); });
  }
  std::unique_ptr<EdgeSlopes> slopes() const override;

  std::vector<HistoryBlock> history(const std::string& name) const override {
    std::vector<HistoryBlock> all = relaxing_.history(name);
    for_each_history(name, [&](const LawHistory& term, const std::string& own) {
      for (HistoryBlock& block : term.history(own)) all.push_back(std::move(block));
    });
    return all;
  }
  void begin_step(const std::string& name, const State& from, double time) override {
    for_each_history(name, [&](LawHistory& term, const std::string& own) { term.begin_step(own, from, time); });
    relaxing_.begin_step(name, from, time);
  }
  void commit_step(const std::string& name, State& state) override {
    relaxing_.now().setZero();
    for (const auto& term : elastic_) term->add_force_densities(state.positions, relaxing_.now(), workspace_);
    for (int c = 0; c < body_.connections.size(); ++c) {
      const auto& [a, b] = body_.connections.ends[c];
      const double rest = rest_lengths_[c];
      relaxing_.strain()[c] = (state.positions.col(b) - state.positions.col(a)).squaredNorm() - rest * rest;
    }
    relaxing_.commit_step(name, state);
    for_each_history(name, [&](LawHistory& term, const std::string& own) { term.commit_step(own, state); });
  }

  /// ∂q/∂s of the terms is symmetric.
  void transpose_commit(const HistoryBlock& from, double time, const Positions& positions, std::vector<double>& slopes,
                        Positions& of_positions) const override {
    const VectorX of_now = relaxing_.transpose_commit(time - from.values[0], slopes);
    VectorX own = VectorX::Zero(of_now.size()), change = own;
    Workspace workspace;
    for (const auto* term : elastic_) {
      const auto at = term->slopes();
      at->linearise_at(positions);
      at->add_own_slopes(own);
      at->add_change(of_now, change, workspace);
    }
    change += own.cwiseProduct(of_now);
    for (int c = 0; c < body_.connections.size(); ++c) {
      const auto& [a, b] = body_.connections.ends[c];
      const Vector3 slope = 2 * change[c] * (positions.col(b) - positions.col(a));
      of_positions.col(b) += slope;
      of_positions.col(a) -= slope;
    }
  }
  void transpose_forces(const HistoryBlock& from, double time, const Positions& positions, const Positions& lambda,
                        std::vector<double>& slopes) const override {
    VectorX work(body_.connections.size());
    for (int c = 0; c < body_.connections.size(); ++c) {
      const auto& [a, b] = body_.connections.ends[c];
      work[c] = (positions.col(b) - positions.col(a)).dot(lambda.col(a) - lambda.col(b));
    }
    relaxing_.transpose_fixed(time - from.values[0], work, slopes);
  }

 private:
  friend class PronySlopes;

  /// γ of what the past has left of a cell's force densities, γ times its own, where that fits best.
  static double part_left(const VectorX& elastic, const VectorX& fixed) {
    const double size = elastic.squaredNorm();
    return size > 0 ? fixed.dot(elastic) / size : 0;
  }
  template <class Visit>
  void for_each_history(const std::string& name, Visit visit) const {
    for (std::size_t term = 0; term < owned_.size(); ++term)
      if (auto* own = dynamic_cast<LawHistory*>(owned_[term].get()))
        visit(*own, name + ".in" + (term == 0 ? "" : std::to_string(term)));
  }
  template <class Check>
  bool all(Check check) const {
    return std::all_of(elastic_.begin(), elastic_.end(), [&](const auto* term) { return check(*term); });
  }

  const Body& body_;
  UnstressedLengths rest_lengths_;
  std::vector<std::unique_ptr<Elasticity>> owned_;
  std::vector<const EdgeDensities*> elastic_;
  Relaxing relaxing_;
  Workspace workspace_;  // kept from one step to the next, so that steps allocate no memory
};

class PronySlopes final : public EdgeSlopes {
 public:
  explicit PronySlopes(const Prony& law) : law_(law) {
    for (const auto& term : law.elastic_) elastic_.push_back(term->slopes());
  }

  void linearise_at(const Positions& positions) override {
    own_slopes_.setZero(law_.relaxing_.fixed().size());
    for (const auto& term : elastic_) {
      term->linearise_at(positions);
      term->add_own_slopes(own_slopes_);
    }
    own_slopes_ *= factor();
  }
  void add_own_slopes(VectorX& slopes) const override { slopes += own_slopes_; }
  void add_change(const VectorX& squared_lengths, VectorX& force_densities, Workspace& workspace) const override {
    VectorX& own = workspace.relaxing;
    own = factor() * squared_lengths;
    for (const auto& term : elastic_) term->add_change(own, force_densities, workspace);
  }
  void visit_cells(const CellVisitor& visit) const override {
    for (const auto& term : elastic_)
      term->visit_cells([&](const CellSlopes& cells) {
        CellSlopes scaled = cells;
        scaled.factor *= factor();
        visit(scaled);
      });
  }
  void visit_blocks(const BlockVisitor& visit) const override {
    for (const auto& term : elastic_)
      term->visit_blocks([&](int a, int b, const Matrix3& block) { visit(a, b, factor() * block); });
  }
  bool visit_gradients(const GradientVisitor& visit) const override {
    bool whole = true;
    for (const auto& term : elastic_)
      whole &= term->visit_gradients([&](std::span<const std::pair<int, Vector3>> gradient, double of_energy) {
        visit(gradient, factor() * of_energy);
      });
    return whole;
  }
  void visit_diagonal(const DiagonalVisitor& visit, Workspace& workspace) const override {
    for (const auto& term : elastic_)
      term->visit_diagonal([&](int a, const Matrix3& block) { visit(a, factor() * block); }, workspace);
  }

 private:
  double factor() const { return law_.relaxing_.factor(); }

  const Prony& law_;
  std::vector<std::unique_ptr<EdgeSlopes>> elastic_;
  VectorX own_slopes_;
};

std::unique_ptr<EdgeSlopes> Prony::slopes() const { return std::make_unique<PronySlopes>(*this); }

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

ElasticTerms make_prony(const Body& body, ElasticTerms elastic, const Relaxation& relaxation) {
  check_relaxation(relaxation);
  std::vector<NodalForces*> at_nodes;
  for (const auto& term : elastic.terms)
    if (auto* nodal = dynamic_cast<NodalForces*>(term.get())) at_nodes.push_back(nodal);
  if (at_nodes.empty()) {
    ElasticTerms all =
        std::make_unique<Prony>(body, std::move(elastic.terms), Relaxing(relaxation, body.connections.size()));
    all.owners = std::move(elastic.owners);
    return all;
  }
  if (at_nodes.size() < elastic.terms.size() ||
      !std::all_of(at_nodes.begin(), at_nodes.end(), [&](auto* law) { return law->relax(relaxation); }))
    throw InputError("relaxation takes springs or cells, and this strategy is of both: relax one of them");
  return elastic;
}

}  // namespace elastin
