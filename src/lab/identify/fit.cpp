#include "lab/identify/fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <map>
#include <numbers>

#include "core/base/named.h"
#include "core/base/random.h"
#include "core/base/stopwatch.h"
#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"
#include "lab/run/least_squares.h"

namespace elastin::lab {
namespace {

constexpr double kDifference = 1e-5;  // of a number, over which the law is compared
constexpr double kSameLeast = 1e-2;   // relative difference of sums of squares that are near the same least
constexpr double kRough = 1e-4;       // relative change of squares at which one of several searches ends
constexpr int kRoughIterations = 60;
constexpr double kLeaning = 1e-2;                   // cosine of residuals and a slope beyond which it is no least
constexpr double kExact = 1e-7;                     // rms below which residuals are rounding, of equilibria too
constexpr double kRoughness = 1e-3;                 // of the rms, unbalanced forces that a search can do with,
constexpr double kRoughest = 1e-5, kFinest = 1e-9;  // within these
constexpr double kInsignificant = 1e-6;  // of the scatter's square, a gain: numbers move by 1/1000 of their deviations
constexpr double kBlind = 1e-6;  // of their scale, what readings change with the whole of a number they do not see
constexpr double kFlat = 1e7;    // condition beyond which rounding of the residuals decides
constexpr double kGauss = 1e8;   // radius of the first step that leaves it nearly that of Gauss and Newton
constexpr int kMostDraws = 60;   // of random numbers until a law admits them

VectorX starts_of(const std::vector<MaterialNumber>& unknowns) {
  VectorX values(static_cast<Eigen::Index>(unknowns.size()));
  for (std::size_t i = 0; i < unknowns.size(); ++i) values[static_cast<Eigen::Index>(i)] = unknowns[i].value;
  return values;
}

/// How the search sees the unknowns: over their sizes, or as logarithms where they keep their signs. Valleys of powers
/// and exponentials, μ e^(α …), are straight in these.
class Scaling {
 public:
  Scaling(const UnknownMaterial& unknown, bool logarithmic) {
    const VectorX start = starts_of(unknown.unknowns);
    size = VectorX::Ones(start.size()), sign_ = VectorX::Zero(start.size());
    low = VectorX::Ones(start.size()), high = low;
    for (Eigen::Index i = 0; i < start.size(); ++i) {
      const MaterialNumber& number = unknown.unknowns[i];
      const double typical = number.unit == dimension::pressure ? 0.1 * unknown.trial.material.youngs_modulus : 1;
      size[i] = number.size > 0 ? number.size : start[i] != 0 ? std::abs(start[i]) : typical;
      if (logarithmic && start[i] != 0 && number.size == 0) sign_[i] = start[i] > 0 ? 1 : -1;
      const double margin = number.above_low ? 1e-9 * size[i] : 0;
      low[i] = scaled(i, number.low + margin), high[i] = scaled(i, number.high);
      if (sign_[i] < 0) std::swap(low[i], high[i]);
    }
  }

  VectorX values(const VectorX& z) const {
    VectorX result(z.size());
    for (Eigen::Index i = 0; i < z.size(); ++i)
      result[i] = size[i] * (sign_[i] == 0 ? z[i] : sign_[i] * std::exp(z[i]));
    return result;
  }
  VectorX scaled(const VectorX& values) const {
    VectorX result(values.size());
    for (Eigen::Index i = 0; i < values.size(); ++i) result[i] = scaled(i, values[i]);
    return result;
  }
  /// ∂value/∂z.
  VectorX slopes(const VectorX& z) const {
    const VectorX at = values(z);
    VectorX result(z.size());
    for (Eigen::Index i = 0; i < z.size(); ++i) result[i] = sign_[i] == 0 ? size[i] : at[i];
    return result;
  }

  VectorX size, low, high;  ///< of the values; bounds of z

 private:
  double scaled(Eigen::Index i, double value) const {
    if (sign_[i] == 0) return value / size[i];
    constexpr double most = 30;  // e to this: further no number moves in its search
    return std::clamp(std::log(std::max(sign_[i] * value / size[i], 0.)), -most, most);
  }
  VectorX sign_;
};

/// The residuals of all tests that count as a function of the unknowns over their sizes.
class Residuals {
 public:
  Residuals(const UnknownMaterial& unknown, std::vector<WeightedTest>& tests, bool logarithmic)
      : scaling(unknown, logarithmic), unknown_(unknown), tests_(tests) {
    for (const WeightedTest& test : tests)
      if (test.stated->weight > 0) count += test.test->data().y.size();
  }

  /// As the search sees them.
  bool evaluate(const VectorX& z, VectorX& residuals, MatrixX* jacobian) {
    try {
      if (!try_evaluate(scaling.values(z), residuals, jacobian, rough ? accuracy_ : 0)) return false;
      if (jacobian) *jacobian *= scaling.slopes(z).asDiagonal();
      if (rough) judge(z, residuals, jacobian);
      return true;
    } catch (...) {  // not through the solver's library
      thrown = std::current_exception();
      return false;
    }
  }

  /// By the unknowns themselves.
  /// @param accuracy see TestedMaterial
  bool try_evaluate(const VectorX& values, VectorX& residuals, MatrixX* jacobian, double accuracy = 0) {
    auto tested = material_at(values, jacobian != nullptr);
    if (!tested) return false;
    tested->accuracy = accuracy;
    residuals.resize(count);
    if (jacobian) jacobian->resize(count, values.size());
    Eigen::Index row = 0;
    for (WeightedTest& test : tests_) {
      if (!(test.stated->weight > 0)) continue;
      const auto found = test.test->predict(*tested);
      if (!found) {
        why = test.stated->name + ": " + test.test->why();
        return false;
      }
      const VectorX& measured = test.test->data().y;
      const VectorX factor = test.factor();
      residuals.segment(row, measured.size()) = (found->values - measured).cwiseProduct(factor);
      if (jacobian) {
        for (Eigen::Index column = 0; column < values.size(); ++column)
          jacobian->block(row, column, measured.size(), 1) = found->slopes.col(column).cwiseProduct(factor);
      }
      row += measured.size();
    }
    return true;
  }

  std::optional<TestedMaterial> material_at(const VectorX& values, bool slopes) {
    try {
      TestedMaterial tested{unknown_.row, with_numbers(unknown_.row, unknown_.trial, unknown_.unknowns, values), {}};
      for (std::size_t i = 0; i < unknown_.unknowns.size(); ++i)
        tested.numbers.emplace_back(unknown_.unknowns[i].name, values[static_cast<Eigen::Index>(i)]);
      if (slopes)
        tested.changes =
            trial_changes(unknown_.row, unknown_.trial, unknown_.unknowns, values, kDifference * steps(values));
      return tested;
    } catch (const InputError& error) {
      why = error.what();
      return std::nullopt;
    }
  }

  /// What each number is large against.
  VectorX steps(const VectorX& values) const {
    VectorX steps = values.cwiseAbs().cwiseMax(0.1 * scaling.size);
    for (std::size_t i = 0; i < unknown_.unknowns.size(); ++i)
      if (unknown_.unknowns[i].size > 0) steps[static_cast<Eigen::Index>(i)] = unknown_.unknowns[i].size;
    return steps;
  }

  /// Whether the last slopes promise so little that no step is worth its equilibria.
  bool settled() const { return settled_; }

  Eigen::Index count = 0;
  bool rough = false;  ///< whether values may be as rough as the residuals allow, and a search ends where it is settled
  Scaling scaling;
  std::string why;
  std::exception_ptr thrown;

 private:
  void judge(const VectorX& z, const VectorX& residuals, const MatrixX* jacobian) {
    const double squares = residuals.squaredNorm(), rms = std::sqrt(squares / static_cast<double>(count));
    accuracy_ = std::clamp(kRoughness * rms, kFinest, kRoughest);
    if (!jacobian) return;
    MatrixX free(count, jacobian->cols());  // what no bound blocks
    Eigen::Index columns = 0;
    for (Eigen::Index i = 0; i < jacobian->cols(); ++i) {
      const double fall = -jacobian->col(i).dot(residuals), near = 1e-7 * std::max(1., std::abs(z[i]));
      const bool blocked = (z[i] < scaling.low[i] + near && fall < 0) || (z[i] > scaling.high[i] - near && fall > 0);
      if (!blocked) free.col(columns++) = jacobian->col(i);
    }
    free.conservativeResize(Eigen::NoChange, columns);
    const double gain = columns > 0 ? (free * least_squares(free, residuals)).squaredNorm() : 0;
    const double scatter = (squares - gain) / static_cast<double>(std::max<Eigen::Index>(count - columns, 1));
    settled_ = rms < kExact || gain <= kInsignificant * scatter;
  }

  const UnknownMaterial& unknown_;
  std::vector<WeightedTest>& tests_;
  double accuracy_ = kRoughest;
  bool settled_ = false;
};

LeastSquaresProblem problem_of(Residuals& residuals, const FitOptions& options) {
  LeastSquaresProblem problem;
  problem.residuals = residuals.count;
  problem.low = residuals.scaling.low, problem.high = residuals.scaling.high;
  problem.evaluate = [&residuals](const VectorX& scaled, VectorX& r, MatrixX* J) {
    return residuals.evaluate(scaled, r, J);
  };
  problem.stop = options.stop;
  if (options.rough) {
    residuals.rough = true;
    problem.enough = [&residuals] { return residuals.settled(); };
    problem.first_radius = kGauss;
  }
  return problem;
}

/// Numbers around the material's own: each times up to some four, at times of the other sign.
std::optional<VectorX> random_start(const UnknownMaterial& unknown, Residuals& residuals, std::mt19937_64& generator) {
  for (int draw = 0; draw < kMostDraws; ++draw) {
    VectorX values = starts_of(unknown.unknowns);
    for (Eigen::Index i = 0; i < values.size(); ++i) {
      const MaterialNumber& number = unknown.unknowns[i];
      const double normal =
          std::sqrt(-2 * std::log1p(-unit_random(generator))) * std::cos(2 * std::numbers::pi * unit_random(generator));
      const bool turned = unit_random(generator) < 0.2;
      double value = values[i] == 0 ? 0.1 * residuals.scaling.size[i] * normal : values[i] * std::exp(0.8 * normal);
      if (turned && number.low < 0 && number.high > 0) value = -value;
      const double margin = number.above_low ? 1e-6 * residuals.scaling.size[i] : 0;
      values[i] = std::clamp(value, number.low + margin, number.high);
    }
    VectorX r;
    if (residuals.evaluate(residuals.scaling.scaled(values), r, nullptr)) return values;
  }
  return std::nullopt;
}

void find_bounds(const UnknownMaterial& unknown, const Residuals& residuals, Fit& fit) {
  for (Eigen::Index i = 0; i < fit.values.size(); ++i) {
    const MaterialNumber& number = unknown.unknowns[i];
    const double near = 1e-7 * residuals.scaling.size[i];
    if (fit.values[i] - number.low < near || number.high - fit.values[i] < near)
      fit.at_bound.push_back(static_cast<std::size_t>(i));
  }
}

/// How much of the residuals, at most, the change of one unknown could still take away: the largest cosine of r and a
/// column of J; 0 at a least, and where they are rounding.
double leaning(const Fit& fit) {
  double largest = 0;
  const double size = fit.residuals.norm();
  if (size < kExact * std::sqrt(static_cast<double>(fit.residuals.size()))) return 0;
  for (Eigen::Index i = 0; i < fit.jacobian.cols(); ++i) {
    const double length = fit.jacobian.col(i).norm();
    if (length > 0 && size > 0)
      largest = std::max(largest, std::abs(fit.jacobian.col(i).dot(fit.residuals)) / (length * size));
  }
  return largest;
}

/// What of the unknowns the data say nothing of; "" if there is nothing.
/// @param forces whether a test measured any
std::string flat_cause(const UnknownMaterial& unknown, const Fit& fit, const Uncertainty& known, bool forces) {
  VectorX size = fit.values;  // a position may be 0
  for (Eigen::Index i = 0; i < size.size(); ++i)
    if (const double own = unknown.unknowns[i].size; own > 0) size[i] = own;
  const VectorX change = (fit.jacobian.colwise().norm().transpose().array() * size.array()).abs();
  const bool blind = (change.array() < kBlind * std::sqrt(static_cast<double>(fit.residuals.size()))).any();
  if (!blind && known.condition <= kFlat) return "";
  const VectorX relative = known.flattest.array() / change.array();
  std::string names;
  int count = 0;
  bool moduli = true;  // whether all of them grow alike, as they may under displacements alone
  for (Eigen::Index i = 0; i < change.size(); ++i) {
    const bool named = blind ? change[i] < kBlind * std::sqrt(static_cast<double>(fit.residuals.size()))
                             : std::abs(known.flattest[i]) > 0.1;
    if (!named) continue;
    names += (names.empty() ? "" : ", ") + unknown.unknowns[i].name, ++count;
    moduli &= unknown.unknowns[i].unit == dimension::pressure &&
              (blind || std::abs(relative[i]) > (1 - kSameLeast) * relative.cwiseAbs().maxCoeff());
  }
  const std::string or_force = moduli && !forces ? ", or measure a force" : "";
  if (blind) return "the data do not change with " + names + ": fix " + (count > 1 ? "them" : "it") + or_force;
  if (moduli) return "the data determine the ratios of " + names + " alone: fix one of them" + or_force;
  return "the data do not change with a change of " + names + " together: fix one of them";
}

void judge(const UnknownMaterial& unknown, const std::vector<WeightedTest>& tests, Fit& fit) {
  const bool forces = std::any_of(tests.begin(), tests.end(), [](const WeightedTest& test) {
    return test.test->data().up->unit != dimension::length;
  });
  const Uncertainty known = uncertainty(fit.residuals, fit.jacobian, fit.values);
  if (!fit.converged) {
    fit.outcome = FitOutcome::not_converged, fit.cause = "the search did not end: " + fit.message;
  } else if (const std::string flat = flat_cause(unknown, fit, known, forces); !flat.empty()) {
    fit.outcome = FitOutcome::flat_valley, fit.cause = flat;
  } else if (fit.at_bound.empty() && leaning(fit) > kLeaning) {
    fit.outcome = FitOutcome::bound_reached;
    fit.cause = "the residuals would still fall where the law is not admissible: it becomes unstable at rest";
  } else if (!fit.at_bound.empty()) {
    fit.outcome = FitOutcome::bound_reached;
    fit.cause = joined(fit.at_bound, [&](std::size_t i) { return unknown.unknowns[i].name; });
    fit.cause += fit.at_bound.size() > 1 ? " lie at bounds" : " lies at a bound";
  } else {
    fit.outcome = FitOutcome::converged;
  }
}

/// Of the terms of a relaxation, or of a law whose terms have several numbers each: where the numbers of each unknown
/// term are, the one by which terms are ordered last. None where the terms' bounds differ.
std::vector<std::vector<Eigen::Index>> like_terms(const std::vector<MaterialNumber>& unknowns, bool of_law) {
  using Kind = MaterialNumber::Kind;
  std::map<std::size_t, std::vector<Eigen::Index>> places;
  for (std::size_t i = 0; i < unknowns.size(); ++i)
    if (of_law ? unknowns[i].kind == Kind::law_term
               : unknowns[i].kind == Kind::share || unknowns[i].kind == Kind::relaxation_time)
      places[unknowns[i].term].push_back(static_cast<Eigen::Index>(i));
  std::vector<std::vector<Eigen::Index>> terms;
  for (const auto& [term, own] : places) {
    if (own.size() < 2) continue;
    if (!terms.empty())
      for (std::size_t i = 0; i < own.size(); ++i) {
        const MaterialNumber &number = unknowns[own[i]], &first = unknowns[terms.front()[i]];
        if (own.size() != terms.front().size() || number.low != first.low || number.high != first.high) return {};
      }
    terms.push_back(own);
  }
  return terms;
}

/// Terms whose exchange changes nothing come out in the order in which the material states them, by relaxation time or
/// exponent: which of them a search takes for which is chance.
void order_terms(const std::vector<MaterialNumber>& unknowns, VectorX& values) {
  for (const bool of_law : {false, true}) {
    const std::vector<std::vector<Eigen::Index>> terms = like_terms(unknowns, of_law);
    const auto ordered = [&](const VectorX& by) {
      std::vector<std::vector<Eigen::Index>> list = terms;
      std::stable_sort(list.begin(), list.end(),
                       [&](const auto& a, const auto& b) { return by[a.back()] < by[b.back()]; });
      return list;
    };
    const auto stated = ordered(starts_of(unknowns)), found = ordered(values);
    const VectorX before = values;
    for (std::size_t term = 0; term < terms.size(); ++term)
      for (std::size_t i = 0; i < stated[term].size(); ++i) values[stated[term][i]] = before[found[term][i]];
  }
}

/// The best end of several searches, gone on with to the last digit.
SearchEnd searched(const UnknownMaterial& unknown, Residuals& residuals, const FitOptions& options) {
  const Stopwatch watch;
  LeastSquaresProblem problem = problem_of(residuals, options);
  const bool several = options.starts > 1;
  if (options.rough) problem.iterations = kRoughIterations;
  const int last_iterations = problem.iterations;
  const double last_tolerance = options.rough ? std::max(options.tolerance, kInsignificant) : options.tolerance;
  problem.tolerance = several ? kRough : last_tolerance;
  if (several) problem.iterations = kRoughIterations;
  std::mt19937_64 generator(20);
  SearchEnd end;
  LeastSquaresResult best;
  std::vector<double> ends;
  const auto search = [&](const VectorX& from, const std::string& which) {
    if (options.progress)
      problem.progress = [&, which](int iteration, double squares) {
        options.progress(fmt::format("{}, {}, iteration {}, rms {:.3g} %", unknown.label, which, iteration,
                                     100 * std::sqrt(squares / static_cast<double>(residuals.count))));
      };
    LeastSquaresResult found = minimise_squares(problem, from);
    if (residuals.thrown) std::rethrow_exception(residuals.thrown);
    end.iterations += found.iterations, end.evaluations += found.evaluations;
    return found;
  };
  const bool known = options.known && options.known->values.size() == residuals.scaling.low.size();
  for (int start = 0; start < options.starts && !(start > 0 && options.stop && options.stop()); ++start) {
    const auto from = start > 0 ? random_start(unknown, residuals, generator)
                                : std::optional(known ? options.known->values : starts_of(unknown.unknowns));
    if (residuals.thrown) std::rethrow_exception(residuals.thrown);
    if (!from) continue;
    const LeastSquaresResult found =
        search(residuals.scaling.scaled(*from), fmt::format("search {} of {}", start + 1, options.starts));
    if (!found.usable || !std::isfinite(found.squares)) continue;
    ends.push_back(found.squares);
    if (!best.usable || found.squares < best.squares) best = found;
  }
  if (best.usable && several) {
    problem.tolerance = last_tolerance, problem.iterations = last_iterations;
    const LeastSquaresResult last = search(best.unknowns, "the best search to its end");
    if (last.usable) best = last;
  }
  end.starts = static_cast<int>(ends.size());
  end.seconds = watch.seconds();
  if (!best.usable) return end;
  const double rounding = kExact * kExact * static_cast<double>(residuals.count);
  for (const double squares : ends)
    if (squares <= std::max(best.squares * (1 + kSameLeast), rounding)) ++end.agreeing;
  end.values = residuals.scaling.values(best.unknowns);
  order_terms(unknown.unknowns, end.values);
  end.converged = best.converged, end.message = best.message;
  return end;
}

}  // namespace

VectorX WeightedTest::scale() const {
  const VectorX& measured = test->data().y;
  const double largest = measured.cwiseAbs().maxCoeff();
  if (stated->residuals == ResidualScale::relative) return measured;
  if (stated->residuals == ResidualScale::absolute || std::isinf(constant))
    return VectorX::Constant(measured.size(), largest);
  // One that the scatter shows leaves the scale of the largest value as it is.
  const double least = constant > 0 ? constant : test->data().least_scale(),
               whole = constant > 0 ? std::hypot(1, constant / largest) : 1;
  return measured.unaryExpr([=](double y) { return std::hypot(y, least) / whole; });
}

double WeightedTest::freedom(Eigen::Index unknowns) const {
  const auto readings = static_cast<double>(test->data().y.size());
  return readings - std::min(static_cast<double>(unknowns), readings / 2);
}

VectorX WeightedTest::factor() const {
  VectorX factor = std::sqrt(stated->weight) / noise * scale().cwiseInverse();
  if (const VectorX& deviations = test->data().deviations; deviations.size() > 0)
    factor.array() *= deviations.mean() / deviations.array();
  return factor;
}

const char* name_of(FitOutcome outcome) {
  switch (outcome) {
    case FitOutcome::converged:
      return "converged";
    case FitOutcome::bound_reached:
      return "bound_reached";
    case FitOutcome::flat_valley:
      return "flat_valley";
    case FitOutcome::misfit:
      return "misfit";
    case FitOutcome::not_converged:
      return "not_converged";
    case FitOutcome::failed:
      return "failed";
  }
  return "";
}

Fit fit_material(const UnknownMaterial& unknown, std::vector<WeightedTest>& tests, const FitOptions& options) {
  Residuals residuals(unknown, tests, options.keep_signs);
  Fit fit;
  fit.rough = options.rough;
  static_cast<SearchEnd&>(fit) =
      options.known && options.known->converged ? *options.known : searched(unknown, residuals, options);
  if (fit.values.size() == 0) {
    fit.cause = "no start could be solved" + (residuals.why.empty() ? "" : ": " + residuals.why);
    return fit;
  }
  const auto tested = residuals.material_at(fit.values, true);
  if (!tested || !residuals.try_evaluate(fit.values, fit.residuals, &fit.jacobian)) {
    fit.cause = "the material found could not be evaluated again: " + residuals.why;
    return fit;
  }
  fit.squares = fit.residuals.squaredNorm();
  fit.trial = tested->trial;
  for (WeightedTest& test : tests) fit.predictions.push_back(test.test->predict(*tested).value_or(Prediction{}));
  find_bounds(unknown, residuals, fit);
  judge(unknown, tests, fit);
  return fit;
}

namespace {

/// Σ r² of the others at their least for a value of one unknown, nearly: from where the slopes of the fit foresee them,
/// less what Gauss's step from there promises; after such a step where that is much.
std::optional<double> foreseen_squares(const UnknownMaterial& others, std::vector<WeightedTest>& tests, const Fit& fit,
                                       Eigen::Index at, double value) {
  constexpr double much = 0.1;  // of Σ r²
  const Eigen::Index count = fit.values.size();
  MatrixX slopes(fit.jacobian.rows(), count - 1);
  VectorX values(count - 1);
  for (Eigen::Index i = 0, j = 0; i < count; ++i)
    if (i != at) slopes.col(j) = fit.jacobian.col(i), values[j++] = fit.values[i];
  const VectorX start = values;
  const auto go = [&](const VectorX& step) {
    values += step;
    for (Eigen::Index i = 0; i < values.size(); ++i) {  // no further than to a tenth, and within its bounds
      const MaterialNumber& number = others.unknowns[i];
      if (values[i] * start[i] < 0.01 * start[i] * start[i]) values[i] = 0.1 * start[i];
      values[i] = std::clamp(values[i], number.low, number.high);
    }
  };
  go(-least_squares(slopes, fit.jacobian.col(at) * (value - fit.values[at])));
  Residuals residuals(others, tests, true);
  std::optional<double> found;
  for (int step = 0; step < 2; ++step) {
    VectorX r;
    MatrixX J;
    if (!residuals.try_evaluate(values, r, &J, kRoughest)) return found;
    const VectorX by = least_squares(J, r);
    const double squares = r.squaredNorm(), gain = (J * by).squaredNorm();
    found = std::min(found.value_or(squares), squares - (gain < much * squares ? gain : 0));
    if (gain < much * squares) break;
    go(-by);
  }
  return found;
}

}  // namespace

std::pair<double, double> profile_interval(const UnknownMaterial& unknown, std::vector<WeightedTest>& tests,
                                           const Fit& fit, const Uncertainty& known, std::size_t number,
                                           const std::function<bool()>& stop) {
  const auto at = static_cast<Eigen::Index>(number);
  const double t = student_quantile(0.95, known.freedom);
  const double most = fit.squares * (1 + t * t / known.freedom);
  UnknownMaterial others = unknown;
  for (std::size_t i = 0; i < others.unknowns.size(); ++i)
    others.unknowns[i].value = fit.values[static_cast<Eigen::Index>(i)];
  const MaterialNumber own = others.unknowns[number];
  others.unknowns.erase(others.unknowns.begin() + static_cast<std::ptrdiff_t>(number));
  FitOptions once;
  once.starts = 1, once.tolerance = 1e-7, once.keep_signs = true, once.stop = stop;
  const auto squares = [&](double value) -> std::optional<double> {
    if (stop && stop()) return std::nullopt;
    try {
      VectorX only(1);
      only << value;
      others.trial = with_numbers(unknown.row, fit.trial, {own}, only);
    } catch (const InputError&) {
      return std::nullopt;
    }
    if (fit.rough) return foreseen_squares(others, tests, fit, at, value);
    const Fit found = fit_material(others, tests, once);
    if (found.outcome == FitOutcome::failed) return std::nullopt;
    if (found.squares > most) return found.squares;
    for (std::size_t i = 0; i < others.unknowns.size(); ++i)  // the next value is farther out
      others.unknowns[i].value = found.values[static_cast<Eigen::Index>(i)];
    return found.squares;
  };
  const auto end = [&](double side, double bound) {
    for (std::size_t i = 0; i < others.unknowns.size(); ++i)
      others.unknowns[i].value = fit.values[static_cast<Eigen::Index>(i < number ? i : i + 1)];
    const double step = std::isfinite(known.deviations[at]) ? t * known.deviations[at] : std::abs(fit.values[at]);
    const ProfileEffort effort = fit.rough ? ProfileEffort{2, 0.05} : ProfileEffort{};
    return profile_end(fit.values[at], side * std::min(step, std::abs(fit.values[at]) * (fit.rough ? 2 : 0.5)), bound,
                       fit.squares, most, squares, effort);
  };
  return {end(-1, own.low), end(1, own.high)};
}

}  // namespace elastin::lab
