#include "lab/identify/fit.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace elastin::lab {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

/// Continued fraction of the incomplete beta function.                              [Numerical Recipes 3rd ed., 6.4]
double beta_fraction(double a, double b, double x) {
  constexpr double tiny = 1e-300;
  double c = 1, d = 1 - (a + b) * x / (a + 1);
  d = 1 / (std::abs(d) < tiny ? tiny : d);
  double result = d;
  for (int m = 1; m < 500; ++m) {
    for (const double term : {m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m)),
                              -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1))}) {
      d = 1 + term * d, c = 1 + term / c;
      d = 1 / (std::abs(d) < tiny ? tiny : d);
      c = std::abs(c) < tiny ? tiny : c;
      result *= d * c;
    }
    if (std::abs(d * c - 1) < 1e-15) break;
  }
  return result;
}

double incomplete_beta(double a, double b, double x) {
  if (x <= 0) return 0;
  if (x >= 1) return 1;
  const double front =
      std::exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) + a * std::log(x) + b * std::log1p(-x));
  return x < (a + 1) / (a + b + 2) ? front * beta_fraction(a, b, x) / a : 1 - front * beta_fraction(b, a, 1 - x) / b;
}

}  // namespace

double student_quantile(double confidence, double freedom) {
  if (!(freedom > 0)) return kInfinite;
  // The share beyond ±t is I_x(ν/2, ½), x = ν/(ν + t²).
  double low = 0, high = 1;
  const auto beyond = [&](double t) { return incomplete_beta(freedom / 2, 0.5, freedom / (freedom + t * t)); };
  while (beyond(high) > 1 - confidence) high *= 2;
  for (int i = 0; i < 200 && high - low > 1e-14 * high; ++i) {
    const double middle = (low + high) / 2;
    (beyond(middle) > 1 - confidence ? low : high) = middle;
  }
  return (low + high) / 2;
}

double f_beyond(double ratio, double above, double below) {
  return incomplete_beta(below / 2, above / 2, below / (below + above * ratio));
}

Uncertainty uncertainty(const VectorX& residuals, const MatrixX& jacobian, const VectorX& values) {
  const Eigen::Index count = values.size();
  Uncertainty result;
  result.freedom = static_cast<int>(residuals.size() - count);
  result.deviations = VectorX::Constant(count, kInfinite);
  result.correlation = MatrixX::Identity(count, count);
  VectorX lengths = jacobian.colwise().norm().transpose();
  MatrixX scaled = jacobian;
  for (Eigen::Index i = 0; i < count; ++i)
    if (lengths[i] > 0) scaled.col(i) /= lengths[i];
  const SymmetricEigen normal = symmetric_eigen(transposed_product(scaled, scaled));
  const double least = std::max(normal.values[0], 0.), largest = normal.values[count - 1];
  result.condition = least > 1e-15 * largest ? std::sqrt(largest / least) : kInfinite;
  result.flattest = normal.vectors.col(0);
  if (result.freedom > 0) {
    const double variance = residuals.squaredNorm() / result.freedom;
    MatrixX covariance = MatrixX::Zero(count, count);
    for (Eigen::Index mode = 0; mode < count; ++mode) {
      const double stiffness = std::max(normal.values[mode], 1e-15 * largest);
      covariance += variance / stiffness * normal.vectors.col(mode) * normal.vectors.col(mode).transpose();
    }
    for (Eigen::Index i = 0; i < count; ++i) {
      if (lengths[i] > 0) result.deviations[i] = std::sqrt(covariance(i, i)) / lengths[i];
      for (Eigen::Index j = 0; j < count; ++j)
        if (i != j && covariance(i, i) > 0 && covariance(j, j) > 0)
          result.correlation(i, j) = covariance(i, j) / std::sqrt(covariance(i, i) * covariance(j, j));
    }
  }
  const VectorX half = student_quantile(0.95, result.freedom) * result.deviations;
  result.low = values - half, result.high = values + half;
  return result;
}

double small_sample_criterion(double squares, Eigen::Index residuals, Eigen::Index unknowns) {
  const double n = static_cast<double>(residuals), k = static_cast<double>(unknowns) + 1;
  if (!(n - k - 1 > 0) || !(squares > 0)) return squares > 0 ? kInfinite : -kInfinite;
  return n * std::log(squares / n) + 2 * k + 2 * k * (k + 1) / (n - k - 1);
}

SignChanges sign_changes(const VectorX& differences) {
  double above = 0, below = 0;
  SignChanges changes;
  for (Eigen::Index i = 0; i < differences.size(); ++i) {
    (differences[i] > 0 ? above : below) += 1;
    if (i > 0 && (differences[i] > 0) != (differences[i - 1] > 0)) changes.count += 1;
  }
  const double n = above + below;
  if (n > 0 && (above == 0 || below == 0)) {
    changes.expected = (n - 1) / 2, changes.deviation = std::sqrt(n - 1) / 2;
    return changes;
  }
  changes.expected = n > 0 ? 2 * above * below / n : 0;
  changes.deviation = n > 1 ? std::sqrt(std::max(0., changes.expected * (changes.expected - 1) / (n - 1))) : 0;
  return changes;
}

double scatter_constant(const VectorX& measured, const VectorX& differences, double least) {
  constexpr double significant = 3.84 / 2;  // of χ² with one degree of freedom, beyond which 5 % lie
  constexpr double finer = 1.8, most = 3;   // of the largest value; beyond it the scatter is alike
  const double n = static_cast<double>(measured.size());
  // −ln L, at the likeliest factor of the scatter.
  const auto loss = [&](double s) {
    if (std::isinf(s)) return n / 2 * std::log(differences.squaredNorm());
    const VectorX scale = measured.unaryExpr([s](double y) { return std::hypot(y, s); });
    return n / 2 * std::log(differences.cwiseQuotient(scale).squaredNorm()) + scale.array().log().sum();
  };
  double best = kInfinite, lowest = loss(kInfinite);
  const double largest = measured.cwiseAbs().maxCoeff();
  for (double s = least * finer; s < most * largest; s *= finer)
    if (const double at = loss(s); at < lowest) best = s, lowest = at;
  return loss(least) - lowest > significant ? best : 0;
}

double profile_end(double value, double step, double bound, double least_squares, double most_squares,
                   const ProfileSquares& squares, const ProfileEffort& effort) {
  // The root of the deviance is nearly linear in the unknown: 0 at the value, 1 at the end.
  const auto root = [&](double at) {
    const auto found = squares(at);
    return found ? std::sqrt(std::max(0., (*found - least_squares) / (most_squares - least_squares))) : kInfinite;
  };
  const auto within = [&](double at) { return step > 0 ? std::min(at, bound) : std::max(at, bound); };
  double inside = value, low = 0, outside = within(value + step), high = root(outside);
  for (int i = 0; high < 1; ++i) {
    if (outside == bound) return bound;
    if (i == effort.steps) return step > 0 ? kInfinite : -kInfinite;
    inside = outside, low = high;
    step *= 1.6;
    outside = within(outside + step), high = root(outside);
  }
  for (int i = 0; i < 12; ++i) {
    const double share = std::isfinite(high) ? std::clamp((1 - low) / (high - low), 0.1, 0.9) : 0.5;
    const double between = inside + share * (outside - inside), at = root(between);
    (at < 1 ? inside : outside) = between;
    (at < 1 ? low : high) = at;
    if (std::abs(at - 1) < effort.tolerance) return between;
  }
  return inside;
}

}  // namespace elastin::lab
