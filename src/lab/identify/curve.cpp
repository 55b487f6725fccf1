#include "lab/identify/curve.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/dense.h"
#include "lab/identify/fit.h"
#include "lab/report/records.h"

namespace elastin::lab {
namespace {

constexpr double kTurn = 0.05;       // of the range of x
constexpr double kStill = 0.005;     // of the range of x
constexpr Eigen::Index kHeld = 5;    // rows that make a hold
constexpr double kSlow = 0.1;        // of the motion between rows next to a hold
constexpr double kChanged = 0.01;    // of the largest reading
constexpr double kSudden = 0.2;      // of the reading, lost within three rows
constexpr double kGradual = 0.5;     // of the largest reading
constexpr double kBeginning = 0.3;   // of the largest reading, below which the zero point is sought
constexpr double kNearRest = 0.2;    // of the largest reading, below which it is near zero
constexpr Eigen::Index kDense = 30;  // rows from which neighbours show noise
constexpr double kNormal = 0.67449;  // median of |x| of a standard normal x

double median_of_three(const VectorX& a, Eigen::Index from) {
  return std::max(std::min(a[from], a[from + 1]), std::min(std::max(a[from], a[from + 1]), a[from + 2]));
}

/// The readings as positive numbers: by the sign of the largest.
VectorX oriented(const VectorX& values) {
  Eigen::Index largest = 0;
  values.cwiseAbs().maxCoeff(&largest);
  return values[largest] < 0 ? VectorX(-values) : values;
}

}  // namespace

std::vector<Branch> branches_of(const VectorX& x) {
  std::vector<Branch> branches;
  const double turn = x.size() > 0 ? kTurn * (x.maxCoeff() - x.minCoeff()) : 0;
  Eigen::Index begin = 0, farthest = 0;
  double direction = 0;
  for (Eigen::Index i = 1; i < x.size(); ++i) {
    const double from_begin = x[i] - x[0], beyond = x[i] - x[farthest];
    if (direction == 0) {
      if (std::abs(from_begin) > turn) direction = from_begin > 0 ? 1 : -1, farthest = i;
    } else if (beyond * direction > 0) {
      farthest = i;
    } else if (-beyond * direction > turn) {
      branches.push_back({begin, farthest + 1, branches.size() % 2 == 0});
      begin = farthest + 1, farthest = i, direction = -direction;
    }
  }
  branches.push_back({begin, x.size(), branches.size() % 2 == 0});
  return branches;
}

std::vector<Hold> find_holds(const VectorX& x, const VectorX& y, double rest, double noise) {
  std::vector<Hold> holds;
  const Eigen::Index count = x.size();
  if (count < kHeld) return holds;
  const double range = x.maxCoeff() - x.minCoeff(), largest = y.cwiseAbs().maxCoeff();
  const auto motion = [&](Eigen::Index from, Eigen::Index to) {
    return to > from ? std::abs(x[to] - x[from]) / static_cast<double>(to - from) : 0;
  };
  for (Eigen::Index begin = 0; range > 0 && begin < count;) {
    double low = x[begin], high = x[begin];
    Eigen::Index end = begin;
    for (; end < count; ++end) {
      low = std::min(low, x[end]), high = std::max(high, x[end]);
      if (high - low > kStill * range) break;
    }
    const double around = std::max(motion(std::max<Eigen::Index>(0, begin - kHeld), begin),
                                   motion(end - 1, std::min(count - 1, end - 1 + kHeld)));
    if (end - begin < kHeld || motion(begin, end - 1) > kSlow * around) {
      ++begin;
      continue;
    }
    const double first = y.segment(begin, 3).cwiseAbs().mean(), last = y.segment(end - 3, 3).cwiseAbs().mean();
    const bool at_rest = begin == 0 && std::abs(x[0] - rest) < kTurn * range;
    if (!at_rest && std::abs(last - first) > std::max(kChanged * largest, 6 * noise))
      holds.push_back({begin + (begin > 0), end, (last - first) / largest});
    begin = end;
  }
  return holds;
}

std::optional<Tear> find_tear(const VectorX& x, const VectorX& y, double noise) {
  const Eigen::Index count = y.size();
  if (count < 8) return std::nullopt;
  const VectorX a = oriented(y);
  const double range = x.maxCoeff() - x.minCoeff();
  Eigen::Index peak = 0;
  const double largest = a.maxCoeff(&peak);
  for (Eigen::Index i = 0; count >= kDense && i + 6 <= count; ++i) {
    const double before = median_of_three(a, i), after = median_of_three(a, i + 3), lost = before - after;
    if (before < largest / 10 || lost < kSudden * before || lost < 6 * noise || std::abs(x[i + 5] - x[i]) > range / 4)
      continue;
    Eigen::Index row = i;
    while (a[row] > before - std::max(0.2 * lost, 3 * noise)) ++row;
    return Tear{row, lost / before};
  }
  const double least = peak + 1 < count ? a.tail(count - peak - 1).minCoeff() : largest;
  if (peak > 0 && least < kGradual * largest) return Tear{peak + 1, 1 - least / largest};
  return std::nullopt;
}

double noise_of(const VectorX& x, const VectorX& y) {
  if (y.size() < kDense) return 0;
  const double largest = y.cwiseAbs().maxCoeff();
  VectorX bend = VectorX::Zero(y.size());  // of each reading from the line through its neighbours
  for (Eigen::Index i = 1; i + 1 < y.size(); ++i) {
    const double span = x[i + 1] - x[i - 1], share = span != 0 ? std::clamp((x[i] - x[i - 1]) / span, 0., 1.) : 0.5;
    bend[i] = y[i] - (1 - share) * y[i - 1] - share * y[i + 1];
  }
  std::vector<double> all, near_rest;
  for (Eigen::Index i = 2; i + 2 < y.size(); ++i) {  // less the bend of the curve: a fourth difference
    all.push_back(std::abs(bend[i] - (bend[i - 1] + bend[i + 1]) / 2) / std::sqrt(35. / 8));
    if (std::abs(y[i]) < kNearRest * largest) near_rest.push_back(all.back());
  }
  return median(near_rest.size() < 10 ? all : near_rest) / kNormal;
}

namespace {

/// Rows up to three tenths of the largest reading, where the load begins.
struct Beginning {
  VectorX x, y;
};
std::optional<Beginning> beginning_of(const VectorX& x, const VectorX& y) {
  const VectorX a = oriented(y), e = oriented(x);
  const double largest = a.maxCoeff();
  Eigen::Index count = 0;
  while (count < a.size() && a[count] < kBeginning * largest) ++count;
  count = std::min(a.size(), std::max<Eigen::Index>(count, 10));
  if (count < 10) return std::nullopt;
  return Beginning{e.head(count), a.head(count)};
}

/// Σ r² of k d + m d² behind a zero point, k ≥ 0.
double squares_behind(const Beginning& rows, double zero) {
  MatrixX powers(rows.x.size(), 2);
  powers.col(0) = (rows.x.array() - zero).max(0).matrix();
  powers.col(1) = powers.col(0).cwiseAbs2();
  VectorX parts = least_squares(powers, rows.y);
  if (parts[0] < 0) parts << 0, powers.col(1).dot(rows.y) / powers.col(1).squaredNorm();
  return (powers * parts - rows.y).squaredNorm();
}

}  // namespace

std::optional<ZeroPoint> find_zero(const VectorX& x, const VectorX& y) {
  const auto rows = beginning_of(x, y);
  if (!rows) return std::nullopt;
  const double first = rows->x.minCoeff(), last = rows->x.maxCoeff(), range = last - first;
  if (!(range > 0)) return std::nullopt;
  const ProfileSquares squares = [&](double zero) { return squares_behind(*rows, zero); };
  constexpr int steps = 240;
  const double low = first - range, high = last - 0.2 * range, step = (high - low) / steps;
  double best = low, least = std::numeric_limits<double>::infinity();
  for (const double width : {step, step / 50}) {
    const double centre = width < step ? best : (low + high) / 2;
    for (int i = -steps / 2; i <= steps / 2; ++i)
      if (const double at = std::clamp(centre + i * width, low, high), found = *squares(at); found < least)
        least = found, best = at;
  }
  const double freedom = static_cast<double>(rows->x.size() - 3), t = student_quantile(0.95, freedom);
  const double most = least * (1 + t * t / freedom) + 1e-300;
  const double sign = x.dot(oriented(x)) < 0 ? -1 : 1;
  const double ends[] = {profile_end(best, -step, low, least, most, squares),
                         profile_end(best, step, high, least, most, squares)};
  return ZeroPoint{sign * best, sign * ends[sign < 0], sign * ends[sign > 0]};
}

bool begins_late(const VectorX& x, const VectorX& y, double noise) {
  constexpr double much = 20;  // times a residual's share of Σ r²: more than four standard deviations
  const auto rows = beginning_of(x, y);
  const auto zero = find_zero(x, y);
  if (!rows || !zero) return false;
  const double range = rows->x.maxCoeff(), freedom = static_cast<double>(rows->x.size() - 3);
  double smooth = squares_behind(*rows, 0);
  for (int i = 0; i < 60; ++i) {
    const double power = 1 + i / 6., rate = i / 3.;
    for (const VectorX& shape :
         {VectorX((rows->x.array() / range).max(0).pow(power).matrix()),
          VectorX(rows->x.unaryExpr([&](double at) { return rate > 0 ? std::expm1(rate * at / range) : at; }))})
      smooth = std::min(smooth, (shape.dot(rows->y) / shape.squaredNorm() * shape - rows->y).squaredNorm());
  }
  const double least = squares_behind(*rows, std::abs(zero->value));
  return least < 9 * noise * noise * freedom && smooth > least * (1 + much / freedom);
}

std::optional<LocalFit> fit_locally(const VectorX& x, const VectorX& y, double at, double low, double high,
                                    Eigen::Index degree, bool chord) {
  std::vector<Eigen::Index> rows;
  for (Eigen::Index i = 0; i < x.size(); ++i)
    if (x[i] >= low && x[i] <= high) rows.push_back(i);
  const auto count = static_cast<Eigen::Index>(rows.size());
  if (count < 2) return std::nullopt;
  MatrixX powers(count, std::min(degree + 1, std::max<Eigen::Index>(2, count - 1)));
  VectorX values(count);
  const double width = std::max(high - low, 1e-300);  // so that powers are of numbers of about 1
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::Index row = rows[i];
    values[i] = y[row];
    const double place = (x[row] - at) / width;
    for (Eigen::Index j = 0; j < powers.cols(); ++j) {
      powers(i, j) = std::pow(place, static_cast<double>(j));
      if (chord && j % 2 == 1 && j > 1)  // without rise over the window, all of which is then the line's
        powers(i, j) -= place * std::pow(0.5, static_cast<double>(j - 1));
    }
  }
  const VectorX parts = least_squares(powers, values);
  const VectorX half = uncertainty(powers * parts - values, powers, parts).high - parts;
  return LocalFit{parts[0], parts[1] / width, half[0], half[1] / width, count};
}

std::optional<ZeroPoint> find_toe(const VectorX& x, const VectorX& y) {
  const double low = x.minCoeff(), range = x.maxCoeff() - low;
  std::optional<ZeroPoint> zero;
  double steepest = 0;
  for (int i = 0; i <= 32; ++i) {
    const double from = low + range * i / 40, to = from + range / 5, centre = (from + to) / 2;
    const auto fit = fit_locally(x, y, centre, from, to, 1);
    if (!fit || fit->rows < 5 || !(std::abs(fit->slope) > steepest)) continue;
    steepest = std::abs(fit->slope);
    const double back = fit->value / fit->slope;
    const double half = std::hypot(fit->value_half, back * fit->slope_half) / steepest;
    zero = ZeroPoint{centre - back, centre - back - half, centre - back + half};
  }
  return zero;
}

}  // namespace elastin::lab
