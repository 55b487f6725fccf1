#include "lab/identify/identify.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/named.h"
#include "elastin/core/base/text.h"
#include "lab/report/table.h"

namespace elastin::lab {
namespace {

constexpr double kWide = 1;        // of |value|, half of an interval beyond which a number is not determined
constexpr double kProfiled = 0.5;  // the same, beyond which the linear model is not trusted
constexpr double kFarBeyond =
    2;  // the same, of any number, beyond which no profile of expensive equilibria is followed
constexpr double kTogether = 0.95;    // correlation that is named
constexpr double kMeasured = 1e-3;    // rms of relative differences below which no test is fitted badly
constexpr double kMisfit = 4;         // mean square of a test over that of the others, beyond which it is named
constexpr double kBeyondNoise = 1.5;  // rms of differences over stated standard deviations, beyond which it is named
constexpr double kNoFit = 0.3;        // rms of all residuals beyond which nothing is found
constexpr int kStabilityPoints = 40;
constexpr int kLinePoints = 80;

std::vector<FoundNumber> found_numbers(const UnknownMaterial& unknown, std::vector<WeightedTest>& tests, const Fit& fit,
                                       const Uncertainty& known, bool profiles, const std::function<bool()>& stop) {
  const auto stopped = [&] { return stop && stop(); };
  const VectorX half_widths = (known.high - known.low) / 2;
  const bool far = !(half_widths.array() <= kFarBeyond * fit.values.array().abs()).all();
  std::vector<FoundNumber> numbers;
  for (std::size_t i = 0; i < unknown.unknowns.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    FoundNumber number{unknown.unknowns[i].name,
                       unknown.unknowns[i].unit,
                       fit.values[at],
                       known.deviations[at],
                       known.low[at],
                       known.high[at]};
    number.scale = unknown.unknowns[i].size > 0 ? unknown.unknowns[i].size : std::abs(number.value);
    const double half = (number.high - number.low) / 2, size = number.scale;
    const bool wide = !(half <= kProfiled * size);
    if (profiles && wide && !(fit.rough && far) && known.freedom > 0 && unknown.unknowns.size() > 1 &&
        fit.outcome != FitOutcome::flat_valley && !stopped()) {
      const auto ends = profile_interval(unknown, tests, fit, known, i, stop);
      number.profiled = !stopped();
      if (number.profiled) std::tie(number.low, number.high) = ends;
    }
    number.determined = number.high - number.low <= 2 * kWide * size;
    numbers.push_back(std::move(number));
  }
  return numbers;
}

/// How residuals change by half the interval of a test's zero point, by the slope of its own predicted curve.
VectorX zero_column(const WeightedTest& test, const VectorX& predicted) {
  const MeasuredData& data = test.test->data();
  const bool strained = data.along && data.along->name == "nominal_strain";  // over a length that changes too
  VectorX column = VectorX::Zero(predicted.size());
  for (Eigen::Index i = 0, last = predicted.size() - 1; i <= last; ++i) {
    const Eigen::Index a = std::max<Eigen::Index>(i - 1, 0), b = std::min(i + 1, last);
    if (data.x[a] != data.x[b])
      column[i] = (predicted[b] - predicted[a]) / (data.x[b] - data.x[a]) * (strained ? 1 + data.x[i] : 1);
  }
  return -data.zero_half * column.cwiseProduct(test.factor());
}

/// Where the tests were weighed by their noise, that noise is known from few readings of some: Student's quantile is
/// then that of fewer degrees of freedom, for each number those of the tests from which it follows.
///                                                                              [Satterthwaite 1946, Welch 1947]
void widen_for_few_readings(const std::vector<WeightedTest>& tests, const Fit& fit, Uncertainty& known) {
  if (known.freedom <= 0 || std::all_of(tests.begin(), tests.end(), [](auto& test) { return test.noise == 1; })) return;
  const MatrixX squares = fit.jacobian.completeOrthogonalDecomposition().pseudoInverse().cwiseAbs2();
  VectorX sum = VectorX::Zero(fit.values.size());
  Eigen::Index row = 0;
  for (const WeightedTest& test : tests) {
    if (!(test.stated->weight > 0)) continue;
    const Eigen::Index count = test.test->data().y.size();
    const VectorX share = squares.middleCols(row, count).rowwise().sum().cwiseQuotient(squares.rowwise().sum());
    sum += share.cwiseAbs2() / test.freedom(fit.values.size());
    row += count;
  }
  for (Eigen::Index i = 0; i < fit.values.size(); ++i) {
    const double half = student_quantile(0.95, 1 / sum[i]) * known.deviations[i];
    known.low[i] = fit.values[i] - half, known.high[i] = fit.values[i] + half;
  }
}

/// Adds what the zero points' intervals move the numbers by.
void add_zero_points(const std::vector<WeightedTest>& tests, const Fit& fit, Uncertainty& known) {
  VectorX squares = VectorX::Zero(fit.values.size());
  Eigen::Index row = 0;
  for (std::size_t i = 0; i < tests.size(); ++i) {
    if (!(tests[i].stated->weight > 0)) continue;
    const Eigen::Index count = tests[i].test->data().y.size();
    if (tests[i].test->data().zero_half > 0 && fit.predictions[i].values.size() == count) {
      VectorX column = VectorX::Zero(fit.residuals.size());
      column.segment(row, count) = zero_column(tests[i], fit.predictions[i].values);
      squares += least_squares(fit.jacobian, column).cwiseAbs2();
    }
    row += count;
  }
  if (squares.isZero(0)) return;
  const double t = student_quantile(0.95, known.freedom);  // the zero points' intervals are of 95 %, too
  known.deviations = (known.deviations.cwiseAbs2() + squares / (t * t)).cwiseSqrt();
  const VectorX half = (((known.high - known.low) / 2).cwiseAbs2() + squares).cwiseSqrt();
  known.low = fit.values - half, known.high = fit.values + half;
}

double relative_rms(const WeightedTest& test, const VectorX& fitted) {
  if (fitted.size() == 0) return std::numeric_limits<double>::quiet_NaN();
  const VectorX ratio = (fitted - test.test->data().y).cwiseQuotient(test.scale());
  return std::sqrt(ratio.squaredNorm() / static_cast<double>(ratio.size()));
}

std::vector<std::pair<double, double>> curve_of(const UnknownMaterial& unknown, const Fit& fit,
                                                const WeightedTest& test) {
  std::vector<std::pair<double, double>> line;
  const VectorX& x = test.test->data().x;
  const double low = std::min(0., x.minCoeff()), high = std::max(0., x.maxCoeff());
  const VectorX at = VectorX::LinSpaced(kLinePoints, low, high);
  const auto found = test.test->line({unknown.row, fit.trial, {}}, at);
  for (Eigen::Index i = 0; found && i < at.size(); ++i) line.emplace_back(at[i], (*found)[i]);
  return line;
}

std::vector<TestAnswer> test_answers(const UnknownMaterial& unknown, const std::vector<WeightedTest>& tests,
                                     const Fit& fit) {
  std::vector<TestAnswer> answers;
  for (std::size_t i = 0; i < tests.size(); ++i) {
    const DataTest& stated = *tests[i].stated;
    const VectorX& fitted = fit.predictions[i].values;
    MeasuredData data = tests[i].test->data();
    if (tests[i].noise != 1)
      data.notes.push_back(
          fmt::format("its readings count 1 / {:.3g}, for they scatter {:.3g} times as much as the surest",
                      tests[i].noise * tests[i].noise, tests[i].noise));
    answers.push_back({stated.name, stated.kind->name, std::move(data), fitted, stated.weight > 0, stated.residuals,
                       tests[i].scale(), tests[i].constant, tests[i].moduli, relative_rms(tests[i], fitted),
                       tests[i].noise, curve_of(unknown, fit, tests[i])});
  }
  return answers;
}

/// The first amount between rest and `end` at which the law is unstable or has no equilibrium; NaN: none.
double first_unstable(const MaterialLaw& row, const Material& material, HomogeneousTest test, double begin,
                      double end) {
  const Matrix3 axes = axes_of_law(row, material);
  for (int i = 1; i <= kStabilityPoints; ++i) {
    const double amount = begin + (end - begin) * i / kStabilityPoints;
    const auto state = homogeneous_state(row, material, test, amount, axes);
    if (!state || !state->stable) return amount;
  }
  return std::numeric_limits<double>::quiet_NaN();
}

/// Twice the range: of tension and shear twice the strain, of compression twice its logarithm.
double twice(double amount, bool shear) {
  return shear || amount > 0 ? 2 * amount : std::expm1(2 * std::log1p(amount));
}

std::vector<StabilityAnswer> stabilities(const UnknownMaterial& unknown, const std::vector<WeightedTest>& tests,
                                         const Fit& fit) {
  std::vector<StabilityAnswer> answers;
  double all_low = 0, all_high = 0;
  for (const HomogeneousTest kind : kHomogeneousTests) {
    StabilityAnswer answer{name_of(kind)};
    for (const WeightedTest& test : tests) {
      if (test.stated->kind->homogeneous != kind || !(test.stated->weight > 0)) continue;
      answer.measured = true;
      answer.low = std::min(answer.low, test.test->data().x.minCoeff());
      answer.high = std::max(answer.high, test.test->data().x.maxCoeff());
    }
    all_low = std::min(all_low, answer.low), all_high = std::max(all_high, answer.high);
    answers.push_back(answer);
  }
  if (all_low == 0 && all_high == 0) return {};
  for (std::size_t i = 0; i < answers.size(); ++i) {
    StabilityAnswer& answer = answers[i];
    const HomogeneousTest kind = kHomogeneousTests[i];
    const bool shear = kind == HomogeneousTest::shear;
    // In the other tests as far as the lengths went: biaxial stretches are the inverse squares of uniaxial ones.
    if (!answer.measured) answer.low = shear ? 0 : all_low, answer.high = all_high;
    for (const double end : {answer.high, answer.low}) {
      if (end == 0) continue;
      const double within = first_unstable(*unknown.row, fit.trial.material, kind, 0, end);
      if (std::isfinite(within)) {
        answer.unstable_within = within;
      } else if (const double beyond = first_unstable(*unknown.row, fit.trial.material, kind, end, twice(end, shear));
                 std::isfinite(beyond)) {
        answer.unstable_beyond = beyond;
      }
    }
  }
  return answers;
}

std::string percent_text(double ratio) { return fmt::format("{:.3g} %", 100 * ratio); }

void warn_of_numbers(const Answer& answer, std::vector<std::string>& warnings) {
  for (std::size_t i = 0; i < answer.numbers.size(); ++i) {
    const FoundNumber& number = answer.numbers[i];
    if (number.determined) continue;
    std::string together;
    for (std::size_t j = 0; j < answer.numbers.size(); ++j) {
      const double both = answer.correlation(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
      if (i == j || std::abs(both) <= kTogether) continue;
      const FoundNumber& other = answer.numbers[j];
      together += fmt::format("{}{} ({:+.3f})", together.empty() ? "" : ", ", other.name, both);
      // Where both grow alike, what one is of the other may be known.
      const double own = number.deviation / number.value, its = other.deviation / other.value,
                   of_ratio = 2 * std::sqrt(std::max(0., own * own + its * its - 2 * both * own * its));
      if (number.unit == other.unit && of_ratio < kProfiled)
        together += fmt::format(", and {} / {} is {:.3g} ± {:.2g} %", other.name, number.name,
                                other.value / number.value, 100 * of_ratio);
    }
    const std::string interval = std::isfinite(number.high - number.low)
                                     ? ": its 95 % interval is " + readable(number.low, number.unit, 3) + " … " +
                                           readable(number.high, number.unit, 3)
                                     : "";
    warnings.push_back(number.name + " is not determined by these data" + interval +
                       (together.empty() ? "" : "; it is correlated with " + together));
  }
}

/// @param scatter of specimens that differ: by how much is no fault of one of them
void warn_of_tests(const Answer& answer, const TestScatter* scatter, std::vector<std::string>& warnings) {
  for (const TestAnswer& test : answer.tests) {
    const auto number = static_cast<std::size_t>(&test - answer.tests.data());
    const bool differs =
        scatter && std::find(scatter->tests.begin(), scatter->tests.end(), number) != scatter->tests.end();
    if (test.fitted.size() == 0) {
      warnings.push_back(test.name + ": the material found has no equilibrium there");
      continue;
    }
    if (!test.counted) {
      warnings.push_back(fmt::format("{} was not fitted; the material found misses it by {} rms", test.name,
                                     percent_text(test.relative_rms)));
      continue;
    }
    double others = 0, count = 0;
    for (const TestAnswer& other : answer.tests)
      if (&other != &test && other.counted) {
        others += std::pow(other.relative_rms / other.noise, 2) * static_cast<double>(other.data.y.size());
        count += static_cast<double>(other.data.y.size());
      }
    if (count > 0 && !differs && test.relative_rms > kMeasured &&
        std::pow(test.relative_rms / test.noise, 2) > kMisfit * others / count)
      warnings.push_back(fmt::format("{} is fitted badly: {} rms, the other tests {}", test.name,
                                     percent_text(test.relative_rms), percent_text(std::sqrt(others / count))));
    if (const VectorX& stated = test.data.deviations; stated.size() > 0) {
      const double found = std::sqrt((test.fitted - test.data.y).cwiseQuotient(stated).squaredNorm() /
                                     static_cast<double>(stated.size()));
      if (found > kBeyondNoise)
        warnings.push_back(
            fmt::format("{} is missed by {:.3g} of the standard deviations that it states (rms): the "
                        "scene, its grips or the law lacks something",
                        test.name, found));
    }
  }
}

/// Neighbouring points scatter each by itself; where their differences agree the model is off there.
void warn_of_places(const TestAnswer& test, std::vector<std::string>& warnings) {
  constexpr Eigen::Index most = 2000;  // readings that are looked at
  constexpr double agreeing = 0.3;     // correlation that no scatter shows
  const VectorX missed = test.fitted - test.data.y;
  const Eigen::Index count = missed.size(), every = std::max<Eigen::Index>(count / most, 1);
  double together = 0, alone = 0, pairs = 0;
  for (Eigen::Index i = 0; i < count; i += every) {
    Eigen::Index nearest = -1;
    double least = std::numeric_limits<double>::infinity();
    for (Eigen::Index j = 0; j < count; ++j) {
      if (i == j || test.data.axes[i] != test.data.axes[j] || test.data.x[i] != test.data.x[j]) continue;
      const double distance = (test.data.places.col(i) - test.data.places.col(j)).squaredNorm();
      if (distance < least) least = distance, nearest = j;
    }
    if (nearest < 0) continue;
    together += missed[i] * missed[nearest], alone += missed[i] * missed[i], pairs += 1;
  }
  if (together > std::max(agreeing, 4 / std::sqrt(pairs)) * alone)
    warnings.push_back(
        fmt::format("the differences of {} agree between neighbouring points (correlation {:.2f}), as no scatter does: "
                    "the law, the grips or too coarse cells; try finer ones. The intervals take it for scatter",
                    test.name, together / alone));
}

void warn_of_specimens(const Answer& answer, const TestScatter& scatter, std::vector<std::string>& warnings) {
  std::vector<std::string> names;
  for (const std::size_t test : scatter.tests) names.push_back(answer.tests[test].name);
  warnings.push_back(fmt::format(
      "{} differ by {:.2g} % in their scale (standard deviation), far more than their readings scatter: specimens that "
      "are unlike, or whose section is not what it was taken for. The intervals are those of the mean of all such "
      "specimens, of which these are {}",
      fmt::join(names, ", "), 100 * scatter.deviation, names.size()));
}

/// Intervals take residuals for scatter.
/// @param scatter of specimens that differ, which is no shape: then of what a fit of each test alone leaves
void warn_of_shape(const Answer& answer, const TestScatter* scatter, std::vector<std::string>& warnings) {
  for (const TestAnswer& test : answer.tests) {
    if (!test.counted || test.fitted.size() < kFewest || test.relative_rms <= kRounding) continue;
    if (!test.data.axes.empty()) {
      warn_of_places(test, warnings);
      continue;
    }
    const VectorX differences = scatter ? scatter->left[static_cast<std::size_t>(&test - answer.tests.data())]
                                        : VectorX(test.fitted - test.data.y);
    if (const SignChanges changes = sign_changes(differences); changes.too_few())
      warnings.push_back(
          fmt::format("the misfit of {} has a shape: {:.0f} changes of sign where scatter has about "
                      "{:.0f}; the law lacks something, and the intervals take it for scatter",
                      test.name, changes.count, changes.expected));
  }
}

/// What relaxes before the first reading is foreseen alone, by exp(time / tau) of what the readings show.
void warn_of_beginnings(const Answer& answer, const std::vector<WeightedTest>& tests, const Trial& trial,
                        std::vector<std::string>& warnings) {
  constexpr double late = 0.5;  // of the shortest time, where that is 1.6 times as much
  if (!trial.material.relaxation || trial.material.relaxation->terms.empty()) return;
  double shortest = std::numeric_limits<double>::infinity();
  for (const auto& [share, time] : trial.material.relaxation->terms) shortest = std::min(shortest, time);
  for (std::size_t i = 0; i < tests.size(); ++i) {
    const DataTest& stated = *tests[i].stated;
    if (!stated.kind->in_time || stated.kind->oscillates || !answer.tests[i].counted) continue;
    const double first = answer.tests[i].data.x[0], behind = first - stated.ramp;
    if (behind > late * shortest)
      warnings.push_back(fmt::format(
          "{}: the first reading stands at {}{}, and the shortest time of relaxation is {}: its share, and the "
          "stiffness before it relaxed, are extrapolated. Time counts from where the strain begins to grow; if the "
          "file has the "
          "machine's clock, write its time there as `begins`",
          stated.name, readable(first, dimension::time),
          stated.ramp > 0 ? fmt::format(", {} after the ramp", readable(behind, dimension::time)) : "",
          readable(shortest, dimension::time)));
  }
}

void warn_of_stability(const Answer& answer, std::vector<std::string>& warnings) {
  std::vector<std::string> missing, kinds;
  for (const StabilityAnswer& stability : answer.stability) {
    (stability.measured ? kinds : missing).push_back(stability.test);
    const double at = std::isfinite(stability.unstable_within) ? stability.unstable_within : stability.unstable_beyond;
    if (!std::isfinite(at)) continue;
    warnings.push_back(fmt::format(
        "the law is unstable (Drucker) in the {} test from a strain of {:.3g} on, {}", stability.test, at,
        std::isfinite(stability.unstable_within)
            ? stability.measured ? "within the measured range" : "within the strains that were measured elsewhere"
            : "within twice the measured range"));
  }
  if (kinds.size() == 1 && answer.numbers.size() > 1)
    warnings.push_back(
        fmt::format("unsafe elsewhere: the {} test alone was measured; what the law says in {} tests is "
                    "not supported by any measured value",
                    kinds.front(), fmt::join(missing, ", ")));
}

std::string relaxation_yaml(const Relaxation& relaxation, bool plain) {
  if (relaxation.retardation > 0)
    return "{model: kelvin_voigt, time: " + quantity_text(relaxation.retardation, dimension::time, plain) + "}";
  const std::string terms = joined(relaxation.terms, [&](const Relaxation::Term& term) {
    return fmt::format("[{:.9g}, {}]", term.share, quantity_text(term.time, dimension::time, plain));
  });
  return fmt::format("{{terms: [{}], moduli: {}}}", terms, relaxation.instantaneous ? "instantaneous" : "long_term");
}

}  // namespace

std::string material_yaml(const MaterialLaw* row, const Trial& trial, bool plain) {
  const Material& material = trial.material;
  const auto value = [&](double number, const Dimension& unit) { return quantity_text(number, unit, plain); };
  const auto direction = [](const Vector3& d) { return fmt::format("[{:.9g}, {:.9g}, {:.9g}]", d.x(), d.y(), d.z()); };
  std::string out = "material:\n";
  const auto add = [&](const std::string& key, const std::string& text) { out += "  " + key + ": " + text + "\n"; };
  if (row) add("law", row->name);
  if (trial.curve) out += "  " + trial.curve->yaml(plain) + "\n";
  if (!row || row->from_moduli) {
    if (!trial.curve) add("youngs_modulus", value(material.youngs_modulus, dimension::pressure));
    add("poissons_ratio", value(material.poissons_ratio, dimension::none));
  }
  if (row && material.law) {
    if (!material.law->terms.empty()) {
      std::string terms;
      for (const auto& term : material.law->terms) {
        std::string one;
        for (std::size_t column = 0; column < term.size(); ++column)
          one += (column ? ", " : "") + value(term[column], row->columns[column].unit);
        terms += (terms.empty() ? "" : ", ") + (term.size() > 1 ? "[" + one + "]" : one);
      }
      add("terms", "[" + terms + "]");
    }
    for (const ParameterInfo& info : row->parameters) {
      if (const auto found = material.law->numbers.find(info.name); found != material.law->numbers.end())
        add(info.name, value(found->second, info.unit));
      if (const auto found = material.law->directions.find(info.name); found != material.law->directions.end())
        add(info.name, direction(found->second));
    }
    for (const WordInfo& info : row->words)
      if (const auto found = material.law->words.find(info.name); found != material.law->words.end())
        if (found->second != info.words.front()) add(info.name, found->second);
  }
  if (material.density != Material{}.density) add("density", value(material.density, dimension::density));
  if (material.thickness > 0) add("thickness", value(material.thickness, dimension::length));
  if (material.relaxation) add("relaxation", relaxation_yaml(*material.relaxation, plain));
  return out;
}

Answer make_answer(const UnknownMaterial& unknown, std::vector<WeightedTest>& tests, const Fit& fit, bool profiles,
                   const std::function<bool()>& stop) {
  Answer answer;
  answer.law = unknown.row ? unknown.row->name : "";
  answer.outcome = fit.outcome, answer.cause = fit.cause;
  answer.starts = fit.starts, answer.agreeing = fit.agreeing, answer.seconds = fit.seconds;
  if (fit.values.size() == 0 || fit.predictions.empty()) return answer;  // failed, as its cause says
  Uncertainty known = uncertainty(fit.residuals, fit.jacobian, fit.values);
  const auto scatter = widen_for_other_specimens(tests, fit, known);
  if (!scatter) widen_for_few_readings(tests, fit, known);
  add_zero_points(tests, fit, known);
  answer.freedom = known.freedom, answer.condition = known.condition, answer.correlation = known.correlation;
  answer.criterion = small_sample_criterion(fit.squares, fit.residuals.size(), fit.values.size());
  answer.numbers = found_numbers(unknown, tests, fit, known, profiles && !scatter, stop);
  answer.tests = test_answers(unknown, tests, fit);
  if (unknown.row) answer.stability = stabilities(unknown, tests, fit);
  for (const FoundNumber& number : answer.numbers)
    if (!number.determined) answer.material += "# " + number.name + " is not determined by the data.\n";
  answer.material += material_yaml(unknown.row, fit.trial, unknown.plain) + unknown.kept;
  if (const double left = whole_rms(answer); answer.outcome == FitOutcome::converged && left > kNoFit)
    answer.outcome = FitOutcome::misfit,
    answer.cause =
        percent_text(left) + " of the measured values are left: neither the data nor the law can be right as they are";
  if (answer.outcome != FitOutcome::converged)
    answer.warnings.push_back(std::string(name_of(answer.outcome)) + ": " + answer.cause);
  for (const TestAnswer& test : answer.tests)
    for (const std::string& warning : test.data.warnings) answer.warnings.push_back(test.data.file + ": " + warning);
  if (known.freedom <= 0)
    answer.warnings.push_back("as many unknowns as measured points: the fit has no intervals and shows nothing");
  warn_of_numbers(answer, answer.warnings);
  const TestScatter* differ = scatter ? &*scatter : nullptr;
  warn_of_tests(answer, differ, answer.warnings);
  if (scatter) warn_of_specimens(answer, *scatter, answer.warnings);
  warn_of_shape(answer, differ, answer.warnings);
  warn_of_beginnings(answer, tests, fit.trial, answer.warnings);
  warn_of_stability(answer, answer.warnings);
  return answer;
}

namespace {

void warn_of_field(const FoundField& field, const Material& material, std::vector<std::string>& warnings) {
  if (!field.converged) warnings.push_back("the search for the field ran out of steps, or was stopped");
  if (field.only_ratios)
    warnings.push_back(
        "these data do not determine a common factor of the stiffness: only ratios between cells are found, and their "
        "mean is the material's E; add a test of forces");
  if (field.misfit > kBeyondNoise * kBeyondNoise)
    warnings.push_back(
        fmt::format("no field leaves less than {:.3g} times the stated sigma (rms): the scene, its grips "
                    "or the law lacks something, or the cells are too coarse",
                    std::sqrt(field.misfit)));
  const auto open = (field.deviations.array() > 0.5).count();
  if (open > 0)
    warnings.push_back(fmt::format("{} of {} cells are hardly determined: their deviation is more than half of E ({})",
                                   open, field.factors.size(), readable(material.youngs_modulus, dimension::pressure)));
}

}  // namespace

Answer make_answer(const UnknownMaterial& unknown, const std::vector<WeightedTest>& tests, FoundField field) {
  Answer answer;
  answer.law = unknown.row ? unknown.row->name : "";
  answer.outcome = field.converged ? FitOutcome::converged : FitOutcome::not_converged;
  answer.seconds = field.seconds, answer.starts = answer.agreeing = 1;
  Fit fit;
  fit.trial = unknown.trial;
  for (VectorX& readings : field.readings) fit.predictions.push_back({std::move(readings), {}});
  answer.tests = test_answers(unknown, tests, fit);
  answer.material = material_yaml(unknown.row, unknown.trial, unknown.plain) + unknown.kept;
  for (const TestAnswer& test : answer.tests)
    for (const std::string& warning : test.data.warnings) answer.warnings.push_back(test.data.file + ": " + warning);
  warn_of_field(field, unknown.trial.material, answer.warnings);
  warn_of_shape(answer, nullptr, answer.warnings);
  answer.field = std::move(field);
  return answer;
}

double whole_rms(const Answer& answer) {
  double squares = 0, count = 0;
  for (const TestAnswer& test : answer.tests)
    if (test.counted) {
      squares += test.relative_rms * test.relative_rms * static_cast<double>(test.data.y.size());
      count += static_cast<double>(test.data.y.size());
    }
  return std::sqrt(squares / count);
}

LawAnswer law_answer(const Answer& answer) {
  LawAnswer law{answer.law, answer.numbers.size(), answer.outcome, answer.cause, answer.criterion, true, {}};
  for (const StabilityAnswer& stability : answer.stability)
    if (stability.measured && std::isfinite(stability.unstable_within)) law.stable = false;
  for (const TestAnswer& test : answer.tests) law.relative_rms.emplace_back(test.name, test.relative_rms);
  return law;
}

}  // namespace elastin::lab
