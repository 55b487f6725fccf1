#include "core/linear/linear_choice.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/linear/mixed.h"
#include "core/linear/multigrid.h"
#include "core/linear/sparse_factor.h"
#include "elastin/core/base/text.h"
#include "elastin/core/model/share.h"

namespace elastin {
namespace {

/// Below this many molecules a factorisation beats iterations, but for time steps, whose inertia makes them few.
constexpr int kTinyBody = 60;

/// How many connections long the body is from end to end.
double connections_across(const Body& body) {
  const auto [sum, count] = lengths_of_whole(body);
  const auto [low, high] = outline_of_whole(body);
  return sum > 0 ? (high - low).maxCoeff() * count / sum : 0;
}

double digits_of(double tolerance) { return std::max(1., -std::log10(tolerance)); }

/// What an iteration with a grid hierarchy takes of a molecule, in products of a factorisation: 100 to 1000 on springs
/// and hexahedra of one size, for the products of a factor with little fill take least.
constexpr double kProductsOfIteration = 300;
/// The same of an iteration without a grid hierarchy, of springs and of cells: with these two numbers, a bundle of
/// fibres takes about as long as by its factor, for which cells have first to be summed up.
constexpr double kProductsOfPlain = 16, kProductsOfPlainOfCells = 6;
/// How many iterations are tried for each connection from end to end: fibres that are all alike are to conjugate
/// gradients a single one, which takes as many as it has connections. Until then the residual hardly falls, so that no
/// pace can be measured; near a Poisson's ratio of 1/2 cells take four and a half.
constexpr double kTriedAcross = 2, kTriedAcrossOfCells = 5;
/// Numbers of the largest factor that is tried: 1.2 GB.
constexpr double kMostNumbers = 1e8;

/// Molecules that are fixed join nothing: what stands between plates may fall to pieces.
FactorCost factor_cost_of(const Body& body, const std::vector<Support>& supports) {
  std::vector<char> fixed(body.size(), 0);
  for (const Support& support : supports) fixed[support.molecule] = support.free.isZero(0);
  std::vector<std::array<int, 2>> pairs;
  const auto add = [&](int a, int b) {
    if (!fixed[a] && !fixed[b]) pairs.push_back({a, b});
  };
  for (const auto& [a, b] : body.connections.ends) add(a, b);
  for (const CellBlock& block : body.blocks)
    for (int cell = 0; cell < block.size(); ++cell)
      for (const int a : block.cell(cell))
        for (const int b : block.cell(cell))
          if (a < b) add(a, b);
  return factor_cost(body.size(), pairs);
}

class MultigridOrDirect final : public LinearSolver, public KeepsWay {
 public:
  const char* name() const override { return (plain_ ? plain_ : direct_ ? direct_ : multigrid_)->name(); }
  void forget() override {
    dynamic_cast<KeepsWay&>(*multigrid_).forget();
    plain_.reset(), direct_.reset(), cost_.reset(), indefinite_ = false;
  }

  LinearResult solve(const Tangent& tangent, const std::vector<Support>& supports, const Positions& rhs,
                     double tolerance, Positions& x) override {
    int before = 0;
    if (!direct_) {
      body_ = &tangent.model().body(), supports_ = &supports;
      const LinearResult result = multigrid_->solve(tangent, supports, rhs, tolerance, x);
      if (!direct_) return result;
      dynamic_cast<KeepsWay&>(*multigrid_).forget();
      before = result.iterations;
      if (before == 0) plain_ = make_pcg(plain_iterations());
    }
    if (plain_) {
      LinearResult result = plain_->solve(tangent, supports, rhs, tolerance, x);
      if (result.status != LinearStatus::limit_reached) return result;
      plain_.reset();
      before = result.iterations;
    }
    LinearResult result = direct_->solve(tangent, supports, rhs, tolerance, x);
    if (result.negative_modes > 0) {  // a factor leads to the saddle, iterations downhill, also in the solves to come
      indefinite_ = true, direct_.reset();
      result = multigrid_->solve(tangent, supports, rhs, tolerance, x);
    }
    result.iterations += before;
    return result;
  }

 private:
  int plain_iterations() const {
    const bool cells = !body_->blocks.empty();
    return static_cast<int>(
        std::min((cells ? kTriedAcrossOfCells : kTriedAcross) * connections_across(*body_),
                 cost_->products / ((cells ? kProductsOfPlainOfCells : kProductsOfPlain) * body_->size())));
  }

  bool indefinite_ = false;  ///< whether the stiffness has had negative modes
  const Body* body_ = nullptr;
  const std::vector<Support>* supports_ = nullptr;
  std::optional<FactorCost> cost_;        ///< once it was asked
  std::unique_ptr<LinearSolver> direct_;  ///< once it is known to be quicker
  std::unique_ptr<LinearSolver> plain_;   ///< before it, on a bundle of fibres, while that serves
  std::unique_ptr<LinearSolver> multigrid_ = make_multigrid([this](double to_come) {
    if (indefinite_) return false;
    if (!cost_) cost_ = factor_cost_of(*body_, *supports_);
    if (cost_->numbers < kMostNumbers && cost_->products < kProductsOfIteration * to_come * body_->size())
      direct_ = make_direct();
    return direct_ != nullptr;
  });
};

}  // namespace

bool factor_is_quicker(const Body& body, const std::vector<Support>& supports, double products) {
  const FactorCost cost = factor_cost_of(body, supports);
  return cost.numbers < kMostNumbers && cost.products < products * body.size();
}

std::unique_ptr<LinearSolver> make_multigrid_or_direct() { return std::make_unique<MultigridOrDirect>(); }

double expected_iterations(const Body& body, double tolerance) {
  return 1.25 * connections_across(body) * digits_of(tolerance);
}

std::pair<bool, std::string> multigrid_is_worth_it(const Model& model, double tolerance) {
  const Body& body = model.body();
  const double across = connections_across(body);
  const bool cells = !model.nodal_laws().empty() || std::any_of(model.edge_laws().begin(), model.edge_laws().end(),
                                                                [](const auto* law) { return law->coupled(); });
  // In iterations of single molecules' blocks: of springs they cost little compared with a cycle, and least between
  // neighbours on a grid.
  const double cheap = cells ? 1 : body.grid && !has_other_stiffness(body) ? 1.9 : 1.5;
  const bool worth_it = expected_iterations(body, tolerance) > cheap * (20 + 8 * digits_of(tolerance));
  const std::string size = counted(static_cast<int>(molecules_of_whole(body)), "molecule") + ", " +
                           std::to_string(std::lround(across)) + " connections from end to end";
  return {worth_it, size + (worth_it ? ": conjugate gradients alone would take many iterations" : " are not many")};
}

LinearChoice choose_linear_solver(const Tangent& tangent, const LinearMethod& requested, double tolerance) {
  const Model& model = tangent.model();
  const Body& body = model.body();
  if (requested->make) return {requested, ""};
  static const LinearMethod pcg = "pcg", bicgstab = "bicgstab", direct = "direct", multigrid = "multigrid",
                            mixed = "mixed";
  if (!tangent.symmetric()) return {pcg, ""};
  const bool moving = tangent.weights().acceleration != 0;
  if (!model.has_energy() && !moving) return {bicgstab, "the stiffness is not symmetric"};
  if (body.size() <= kTinyBody && !moving) return {direct, counted(body.size(), "molecule") + " are few"};
  if (moving) return {pcg, ""};  // inertia keeps iterations few; a step has no memory for words
  const auto [worth_it, why] = multigrid_is_worth_it(model, tolerance);
  if (worth_it && SoftVolume::pays(tangent))
    return {mixed, why + ", and near a Poisson's ratio of 1/2 pressures of their own save most of them"};
  return {worth_it ? multigrid : pcg, why};
}

}  // namespace elastin
