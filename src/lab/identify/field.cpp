#include "lab/identify/field.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <random>
#include <set>
#include <utility>

#include "core/base/stopwatch.h"
#include "core/linear/sparse_factor.h"
#include "core/linear/sparse_stiffness.h"
#include "core/model/solid_cells.h"
#include "core/solve/responses.h"
#include "core/solve/stiffness_slopes.h"
#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"

namespace elastin::lab {
namespace {

using Sparse = Eigen::SparseMatrix<double>;

constexpr int kMostFactorised = 60000;            ///< molecules of all loads together whose stiffness is factorised
constexpr double kIterated = 1e-8;                ///< residual of the linear solves of others
constexpr double kSmaller = 0.31622776601683794;  ///< each smoothness over the one before
constexpr int kMostSmoothness = 16, kMostSteps = 12, kMostProducts = 300;
constexpr double kEnough = 1e-3;     ///< relative change of the whole at which its search ends
constexpr double kSameNoise = 0.02;  ///< of the squares, how near the discrepancy principle is followed
constexpr int kDraws = 24;

/// The cells with what makes their factors a body.
class CellFactors {
 public:
  CellFactors(const Body& body, const FieldChoice& a_choice)
      : cells(solid_cells_of(body)),
        choice(a_choice),
        shares(shares_of_cells(cells, body.connections.ends, body.size())) {
    for (std::size_t cell = 0; cell < cells.size(); ++cell)
      of_nodes_[sorted(cells[cell].nodes)] = static_cast<int>(cell);
    for (int c = 0; c < body.connections.size(); ++c)
      of_ends_[std::minmax(body.connections.ends[c][0], body.connections.ends[c][1])] = c;
  }

  /// Logarithms of what a body has already.
  VectorX start(const Body& body) const {
    VectorX factors = VectorX::Ones(static_cast<Eigen::Index>(cells.size()));
    int next = 0;
    for (const CellBlock& block : body.blocks) {
      if (block.kind->dimensions != 3) continue;
      if (block.stiffness.size()) factors.segment(next, block.size()) = block.stiffness;
      next += block.size();
    }
    if (next == 0 && body.cell_stiffness.size() == factors.size()) factors = body.cell_stiffness;
    return factors.array().log();
  }
  void put(const VectorX& factors, Body& body) const {
    body.connection_stiffness = shares * factors;
    for (Eigen::Index c = 0; c < body.connection_stiffness.size(); ++c)
      if (!(body.connection_stiffness[c] > 0)) body.connection_stiffness[c] = 1;
    int next = 0;
    for (CellBlock& block : body.blocks)
      if (block.kind->dimensions == 3)
        block.stiffness = factors.segment(std::exchange(next, next + block.size()), block.size());
    if (next == 0 && !body.tetrahedra.empty()) body.cell_stiffness = factors;
  }

  /// How the logarithm of the stiffness of a law's elements changes with that of the cells.
  Sparse of_elements(const LocalElasticity& law, const VectorX& factors) const {
    std::vector<Eigen::Triplet<double>> entries;
    for (int element = 0; element < law.elements(); ++element) {
      const auto nodes = law.molecules_of(element);
      if (nodes.size() == 2) {
        const auto found = of_ends_.find(std::minmax(nodes[0], nodes[1]));
        if (found == of_ends_.end()) return {};
        double whole = 0;
        for (RowShares::InnerIterator it(shares, found->second); it; ++it) whole += it.value() * factors[it.col()];
        for (RowShares::InnerIterator it(shares, found->second); it; ++it)
          entries.emplace_back(element, static_cast<int>(it.col()), it.value() * factors[it.col()] / whole);
        continue;
      }
      const auto found = of_nodes_.find(sorted({nodes.begin(), nodes.end()}));
      if (found == of_nodes_.end()) return {};
      entries.emplace_back(element, found->second, 1);
    }
    Sparse matrix(law.elements(), static_cast<Eigen::Index>(cells.size()));
    matrix.setFromTriplets(entries.begin(), entries.end());
    return matrix;
  }

  std::vector<SolidCell> cells;
  const FieldChoice& choice;
  Eigen::SparseMatrix<double, Eigen::RowMajor> shares;  ///< connections × cells

 private:
  using RowShares = Eigen::SparseMatrix<double, Eigen::RowMajor>;
  static std::vector<int> sorted(std::vector<int> nodes) {
    std::sort(nodes.begin(), nodes.end());
    return nodes;
  }
  std::map<std::vector<int>, int> of_nodes_;
  std::map<std::pair<int, int>, int> of_ends_;
};

/// What joins cells that share a face: eᵀ L e = Σ weight (e_a − e_b)².
struct Smoothness {
  Smoothness(const std::vector<SolidCell>& cells, const Positions& rest, const Positions& middles) {
    double volume = 0;
    for (const SolidCell& cell : cells) volume += volume_of(cell, rest);
    std::vector<Eigen::Triplet<double>> entries;
    for (const auto& [a, b, area] : borders_of(cells, rest)) {
      const double weight = area / ((middles.col(a) - middles.col(b)).norm() * std::cbrt(volume));
      entries.emplace_back(static_cast<int>(roots.size()), a, 1),
          entries.emplace_back(static_cast<int>(roots.size()), b, -1);
      roots.push_back(std::sqrt(weight));
    }
    differences.resize(static_cast<Eigen::Index>(roots.size()), static_cast<Eigen::Index>(cells.size()));
    differences.setFromTriplets(entries.begin(), entries.end());
    differences =
        Eigen::Map<const VectorX>(roots.data(), static_cast<Eigen::Index>(roots.size())).asDiagonal() * differences;
    matrix = differences.transpose() * differences;
  }
  std::vector<double> roots;
  Sparse differences, matrix;  ///< L = Dᵀ D
};

/// One load of one test, to first order.
class Linearised {
 public:
  Linearised(const SpecimenStep& step, const VectorX& weights, const CellFactors& cells, const VectorX& factors,
             const StaticOptions& options, bool factorise)
      : model_(step.model), state_(step.state), weights_(weights(step.rows)), responses_(model_, state_, options) {
    if (!model_.symmetric()) cells.choice.fail("a field needs forces with an energy; loads here follow the surface");
    const Tangent& tangent = responses_.tangent();
    for (const auto& law : model_.elasticity()) {
      Law own;
      if (law->local()) own.of_cells = cells.of_elements(*law->local(), factors);
      if (own.of_cells.size() == 0)
        cells.choice.fail("a field needs a strategy whose elements are connections or cells, each with a stiffness");
      own.slopes = std::make_unique<StiffnessSlopes>(*law->local(), step.state.positions);
      laws_.push_back(std::move(own));
    }
    const ReadingSlopes slopes = step.slopes();
    if (slopes.of_positions.size() > 0) of_positions_ = weights_.asDiagonal() * slopes.of_positions;
    if (slopes.of_reactions.size() > 0) of_reactions_ = weights_.asDiagonal() * slopes.of_reactions;
    if (slopes.of_frame.size() > 0) {
      const Eigen::ColPivHouseholderQR<MatrixX> columns(weights_.asDiagonal() * slopes.of_frame);
      frame_ = columns.householderQ() * MatrixX::Identity(weights_.size(), columns.rank());
    }
    if (!factorise || !tangent.wide_terms().empty()) return;
    const double scale = stiffness_scale(tangent);
    factor_.emplace(sparse_stiffness(tangent, model_.supports, 1e-10 * scale, scale));
    if (!factor_->usable()) factor_.reset();
  }

  Eigen::Index readings() const { return weights_.size(); }
  Eigen::Index of_frame() const { return frame_.cols(); }

  /// Change of the weighted readings with changes of the cells' logarithms.
  VectorX forward(const VectorX& changes) {
    Positions forces = Positions::Zero(3, model_.body().size());
    for (const Law& law : laws_) law.slopes->add_forces(law.of_cells * changes, forces);
    const Positions motion = solved(forces);
    VectorX read = VectorX::Zero(readings());
    if (of_positions_.size() > 0) read += of_positions_ * Eigen::Map<const VectorX>(motion.data(), motion.size());
    if (of_reactions_.size() > 0) {
      Positions reactions(3, motion.cols());
      responses_.tangent().apply(motion, reactions);
      reactions -= forces;
      const Positions fixed = fixed_components(model_.supports, reactions);
      read += of_reactions_ * Eigen::Map<const VectorX>(fixed.data(), fixed.size());
    }
    return without_frame(std::move(read));
  }

  /// Its transpose: Σ weights · readings by the cells' logarithms.
  VectorX adjoint(const VectorX& of_readings) {
    const VectorX weights = without_frame(of_readings);
    Positions right = Positions::Zero(3, model_.body().size()), fixed = right;
    if (of_positions_.size() > 0)
      Eigen::Map<VectorX>(right.data(), right.size()) += of_positions_.transpose() * weights;
    if (of_reactions_.size() > 0) {
      const VectorX by = of_reactions_.transpose() * weights;
      for (std::size_t i = 0; i < model_.supports.size(); ++i) {
        const Support& support = model_.supports[i];
        const Vector3 own = by.segment<3>(3 * static_cast<Eigen::Index>(i));
        fixed.col(support.molecule) += own - support.free * own;
      }
      Positions held(3, right.cols());
      responses_.tangent().apply(fixed, held);
      right += held;
    }
    const Positions work = solved(std::move(right)) - fixed;
    VectorX result;
    for (const Law& law : laws_) {
      const VectorX own = law.of_cells.transpose() * law.slopes->work(work);
      result.size() > 0 ? void(result += own) : void(result = own);
    }
    return result;
  }

 private:
  struct Law {
    std::unique_ptr<StiffnessSlopes> slopes;
    Sparse of_cells;
  };

  VectorX without_frame(VectorX read) const {
    if (frame_.size() > 0) read -= frame_ * (frame_.transpose() * read);
    return read;
  }
  /// K⁻¹ of the free part.
  Positions solved(Positions right) {
    keep_free(model_.supports, right);
    if (!factor_) return responses_.to(right, Positions::Zero(3, right.cols()), kIterated).motion;
    const VectorX solution = factor_->solve(Eigen::Map<const VectorX>(right.data(), right.size()));
    right = Eigen::Map<const Positions>(solution.data(), 3, right.cols());
    keep_free(model_.supports, right);
    return right;
  }

  Model& model_;
  State state_;
  VectorX weights_;
  Responses responses_;
  std::optional<SparseFactor> factor_;
  std::vector<Law> laws_;
  Sparse of_positions_;
  MatrixX of_reactions_, frame_;
};

/// All tests as one function of the cells' logarithms.
class Readings {
 public:
  Readings(std::vector<WeightedTest>& tests, const CellFactors& cells) : cells_(cells) {
    for (WeightedTest& test : tests) {
      const VectorX& deviations = test.test->data().deviations;
      VectorX weights =
          deviations.size() > 0 ? VectorX(std::sqrt(test.stated->weight) * deviations.cwiseInverse()) : test.factor();
      tests_.push_back({&test, std::move(weights)});
    }
  }

  /// Weighted differences of all readings that count; empty where there is no equilibrium.
  VectorX differences(const VectorX& e) {
    const VectorX factors = e.array().exp();
    steps_.clear(), kept_.clear();
    std::vector<VectorX> parts;
    for (Test& test : tests_) {
      const auto& data = test.of->test->data();
      const bool counts = test.of->stated->weight > 0;
      test.readings = VectorX::Zero(data.y.size());
      const auto loads = static_cast<double>(std::set<double>(data.x.begin(), data.x.end()).size());
      auto kept = test.of->test->visit_equilibria(
          [&](Body& body) { cells_.put(factors, body); },
          [&](const SpecimenStep& step) {
            ++equilibria;
            test.readings(step.rows) = step.readings;
            if (!counts) return;
            const bool factorise = step.model.body().size() * loads <= kMostFactorised;
            steps_.push_back(std::make_unique<Linearised>(step, test.weights, cells_, factors, options_, factorise));
            parts.push_back((step.readings - data.y(step.rows)).cwiseProduct(test.weights(step.rows)));
          });
      if (!kept) return why = test.of->test->why(), VectorX();
      kept_.push_back(std::move(kept));
    }
    Eigen::Index count = 0;
    for (const VectorX& part : parts) count += part.size();
    VectorX all(count);
    count = 0;
    for (const VectorX& part : parts) all.segment(std::exchange(count, count + part.size()), part.size()) = part;
    return all;
  }

  VectorX forward(const VectorX& changes) {
    Eigen::Index count = 0;
    for (const auto& step : steps_) count += step->readings();
    VectorX all(count);
    count = 0;
    for (const auto& step : steps_)
      all.segment(std::exchange(count, count + step->readings()), step->readings()) = step->forward(changes);
    linear_solves += static_cast<int>(steps_.size());
    return all;
  }
  VectorX adjoint(const VectorX& weights) {
    VectorX sum = VectorX::Zero(static_cast<Eigen::Index>(cells_.cells.size()));
    Eigen::Index count = 0;
    for (const auto& step : steps_)
      sum += step->adjoint(weights.segment(std::exchange(count, count + step->readings()), step->readings()));
    linear_solves += static_cast<int>(steps_.size());
    return sum;
  }
  /// What scatter of size 1 of each reading leaves of the squares.
  double scatter() const {
    double sum = 0;
    for (const auto& step : steps_) sum += static_cast<double>(step->readings() - step->of_frame());
    return sum;
  }
  std::vector<VectorX> of_tests() const {
    std::vector<VectorX> readings;
    for (const Test& test : tests_) readings.push_back(test.readings);
    return readings;
  }

  int equilibria = 0, linear_solves = 0;
  std::string why;

 private:
  struct Test {
    WeightedTest* of;
    VectorX weights, readings = {};
  };
  const CellFactors& cells_;
  StaticOptions options_;
  std::vector<Test> tests_;
  std::vector<std::shared_ptr<const void>> kept_;  ///< models
  std::vector<std::unique_ptr<Linearised>> steps_;
};

VectorX signs(std::mt19937_64& generator, Eigen::Index count) {
  return VectorX::NullaryExpr(count, [&] { return generator() >> 63 ? 1. : -1.; });
}

/// The search for one smoothness after the other.
class FieldSearch {
 public:
  FieldSearch(const FieldChoice& choice, Readings& readings, const Smoothness& smoothness, VectorX start,
              const FieldOptions& options)
      : e(std::move(start)), choice_(choice), readings_(readings), smoothness_(smoothness), options_(options) {
    r = readings_.differences(e);
    if (r.size() == 0) throw InputError("no field: " + readings_.why);
    const VectorX whole = readings_.forward(VectorX::Ones(e.size()));
    of_all_ = whole.squaredNorm();
    only_ratios = of_all_ < 1;
  }

  /// Gauss and Newton's steps from where the last search ended.
  void minimise(double alpha, double enough) {
    double whole = value(alpha, e, r);
    for (int step = 0; step < kMostSteps && !stopped(); ++step) {
      const VectorX gradient = readings_.adjoint(r) + alpha * (smoothness_.matrix * e);
      const VectorX change = solve(alpha, -gradient, std::max(enough, 1e-2));
      double part = 1;
      VectorX tried, left;
      for (; part > 1e-3; part /= 4) {
        tried = (e + part * change).cwiseMax(std::log(choice_.low)).cwiseMin(std::log(choice_.high));
        left = readings_.differences(tried);
        if (left.size() > 0 && value(alpha, tried, left) < whole) break;
      }
      if (!(part > 1e-3)) {  // back to where the slopes are those of e
        r = readings_.differences(e);
        return;
      }
      e = tried, r = left;
      const double before = std::exchange(whole, value(alpha, e, r));
      if (before - whole < enough * whole) return;
    }
    converged = false;
  }

  /// (JᵀJ + αL) x = right, by conjugate gradients behind αL and a part of what all cells change together; to a part of
  /// the right-hand side, or of another one.
  VectorX solve(double alpha, VectorX right, double enough, const VectorX* part_of = nullptr) {
    centre(right);
    if (!(alpha == factored_)) {
      Sparse matrix = alpha * smoothness_.matrix;
      const double own =
          std::max(of_all_ / static_cast<double>(e.size()), 1e-6 * alpha * smoothness_.matrix.diagonal().mean());
      for (Eigen::Index i = 0; i < matrix.rows(); ++i) matrix.coeffRef(i, i) += own;
      factor_.compute(matrix), factored_ = alpha;
    }
    VectorX x = VectorX::Zero(right.size()), left = right, z = factor_.solve(left);
    centre(z);
    VectorX p = z;
    double product = left.dot(z);
    const double goal = enough * enough * (part_of ? part_of->dot(factor_.solve(*part_of)) : product);
    for (int i = 0; i < kMostProducts && product > goal && !stopped(); ++i) {
      VectorX kp = readings_.adjoint(readings_.forward(p)) + alpha * (smoothness_.matrix * p);
      centre(kp);
      const double step = product / p.dot(kp);
      x += step * p, left -= step * kp;
      z = factor_.solve(left);
      centre(z);
      const double next = left.dot(z);
      p = z + next / product * p;
      product = next;
    }
    return x;
  }

  /// How many readings the field takes up, the trace of J (JᵀJ + αL)⁻¹ Jᵀ, by a few draws. [Hutchinson 1989]
  double taken_up(double alpha) {
    constexpr int draws = 2;
    std::mt19937_64 generator(2);
    double sum = 0;
    for (int draw = 0; draw < draws; ++draw) {
      const VectorX seen = readings_.adjoint(signs(generator, r.size()));
      sum += seen.dot(solve(alpha, seen, 0.05)) / draws;
    }
    return sum;
  }

  double squares() const { return r.squaredNorm(); }
  double unevenness() const { return e.dot(smoothness_.matrix * e); }
  bool stopped() const { return options_.stop && options_.stop(); }

  VectorX e, r;
  bool only_ratios = false, converged = true;

 private:
  double value(double alpha, const VectorX& at, const VectorX& left) const {
    return left.squaredNorm() + alpha * at.dot(smoothness_.matrix * at);
  }
  void centre(VectorX& of_cells) const {
    if (only_ratios) of_cells.array() -= of_cells.mean();
  }

  const FieldChoice& choice_;
  Readings& readings_;
  const Smoothness& smoothness_;
  const FieldOptions& options_;
  SparseFactor factor_;
  double factored_ = 0;
  double of_all_ = 0;  ///< square of what all cells together change
};

}  // namespace

FoundField find_field(const FieldChoice& choice, std::vector<WeightedTest>& tests, const FieldOptions& options) {
  const Stopwatch clock;
  const Body* body = nullptr;
  int counted = 0;
  bool noise = true;
  for (const WeightedTest& test : tests) {
    const Body* own = test.test->body();
    if (!own) choice.fail("the test '" + test.stated->name + "' is of no body; a field takes `specimen` and `points`");
    if (body && (own->rest != body->rest || solid_cells(*own) != solid_cells(*body)))
      choice.fail("the test '" + test.stated->name + "' is of another body than the first");
    body = own;
    counted += test.stated->weight > 0;
    noise &= !(test.stated->weight > 0) || test.test->data().deviations.size() > 0;
  }
  if (counted > 1 && !noise)
    for (const WeightedTest& test : tests)
      if (test.test->data().deviations.size() == 0)
        choice.fail("several tests count by their noise: give '" + test.stated->name +
                    "' its `sigma`, or a column of that name");
  const CellFactors cells(*body, choice);
  if (cells.cells.size() < 2) choice.fail("the body has no solid cells: give it `cells: delaunay`, or a mesh");
  FoundField found;
  found.middles.resize(3, static_cast<Eigen::Index>(cells.cells.size()));
  for (std::size_t i = 0; i < cells.cells.size(); ++i)
    found.middles.col(static_cast<Eigen::Index>(i)) = body->rest(Eigen::all, cells.cells[i].nodes).rowwise().mean();
  auto shape = std::make_shared<Body>();
  shape->rest = body->rest;
  for (const SolidCell& cell : cells.cells) {
    if (shape->blocks.empty() || shape->blocks.back().kind != cell.kind) shape->blocks.push_back({cell.kind, {}, {}});
    auto& nodes = shape->blocks.back().nodes;
    nodes.insert(nodes.end(), cell.nodes.begin(), cell.nodes.end());
  }
  found.shape = shape;
  const Smoothness smoothness(cells.cells, body->rest, found.middles);
  Readings readings(tests, cells);
  FieldSearch search(choice, readings, smoothness, cells.start(*body), options);
  const double scatter = readings.scatter();
  const auto attempt = [&](double alpha, double enough) {
    if (options.progress)
      options.progress(fmt::format("field, smoothness {:.3g}, {} linear solves", alpha, readings.linear_solves));
    search.minimise(alpha, enough);
    found.tried.push_back({alpha, search.squares(), search.unevenness()});
  };
  double alpha = choice.smoothness;
  if (alpha > 0) {
    found.chosen_by = "stated";
  } else if (noise && search.squares() <= scatter) {
    found.chosen_by = "one stiffness leaves no more than sigma";
    alpha = scatter;
  } else {
    double best = std::numeric_limits<double>::infinity(), taken = 0;
    int worse = 0;
    for (double next = 10 * search.squares(); found.tried.size() < kMostSmoothness && worse < 2 && !search.stopped();
         next *= kSmaller) {
      attempt(next, 0.05);
      if (noise && search.squares() <= scatter) break;
      const double left = std::max(scatter - search.taken_up(next), 1.), criterion = search.squares() / (left * left);
      worse = criterion < best ? 0 : worse + 1;
      if (worse == 0) best = criterion, alpha = next, taken = scatter - left;
    }
    if (noise && search.squares() <= scatter) {
      found.chosen_by = "differences are as large as sigma";
      for (int i = 0; i < 4 && found.tried.size() > 1; ++i) {  // between the last two that lie about it
        auto above = found.tried.end(), below = found.tried.end();
        for (auto it = found.tried.begin(); it != found.tried.end(); ++it) {
          auto& nearest = it->squares > scatter ? above : below;
          if (nearest == found.tried.end() || std::abs(it->squares - scatter) < std::abs(nearest->squares - scatter))
            nearest = it;
        }
        if (above == found.tried.end() || below == found.tried.end()) break;
        const double part = std::log(scatter / below->squares) / std::log(above->squares / below->squares);
        alpha = std::exp(std::log(below->smoothness) + part * std::log(above->smoothness / below->smoothness));
        attempt(alpha, 0.01);
        if (std::abs(search.squares() - scatter) < kSameNoise * scatter) break;
      }
    } else {
      found.chosen_by = fmt::format("{}least generalised cross-validation, {:.3g} of {:.3g} readings taken up",
                                    noise ? "no field leaves as little as sigma: " : "", taken, scatter);
    }
  }
  if (alpha != scatter) {
    search.converged = true;
    attempt(alpha, kEnough);
  }
  found.smoothness = alpha, found.converged = search.converged && !search.stopped();
  found.only_ratios = search.only_ratios;
  if (search.only_ratios) search.e.array() -= search.e.mean();
  found.factors = search.e.array().exp();
  found.readings = readings.of_tests();
  if (noise) found.misfit = search.squares() / scatter;
  const double size = std::sqrt(noise ? std::max(1., found.misfit) : search.squares() / scatter);
  found.deviations = VectorX::Zero(search.e.size());
  // Fields about it are as uneven as it is, and no smoother than the choice of the smoothness assumes.
  const double own = std::min(alpha, static_cast<double>(search.e.size()) / std::max(search.unevenness(), 1e-300));
  std::mt19937_64 generator(1);
  for (int draw = 0; draw < kDraws && !search.stopped(); ++draw) {
    if (options.progress) options.progress(fmt::format("field, deviations, draw {} of {}", draw + 1, kDraws));
    const VectorX of_readings = signs(generator, search.r.size()),
                  of_field = signs(generator, smoothness.differences.rows());
    const VectorX uneven = std::sqrt(own) * (smoothness.differences.transpose() * of_field);
    const VectorX change = search.solve(own, readings.adjoint(of_readings) + uneven, 0.05, &uneven);
    found.deviations += size * size / kDraws * change.cwiseAbs2();
  }
  found.deviations = found.deviations.cwiseSqrt();
  found.equilibria = readings.equilibria, found.linear_solves = readings.linear_solves, found.seconds = clock.seconds();
  return found;
}

}  // namespace elastin::lab
