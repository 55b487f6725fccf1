#include "lab/run/curve_fit.h"

#include <algorithm>
#include <cmath>

namespace elastin::lab {
namespace {

/// Through the origin, the loaded side's points, and as many of the given curve on the other side.
std::vector<StressStrain::Point> with_other_side(const StressStrain& given,
                                                 const std::vector<StressStrain::Point>& loaded) {
  std::vector<StressStrain::Point> points{{0, 0}};
  for (const auto& point : loaded) {
    points.push_back(point);
    const double other = -point.strain;
    if (other > -0.9) points.push_back({other, given.stress(other)});
  }
  std::sort(points.begin(), points.end(), [](const auto& a, const auto& b) { return a.strain < b.strain; });
  return points;
}

double largest_error(const StressStrain& given, const std::vector<StressStrain::Point>& shown) {
  double difference = 0, largest = 0;
  for (const auto& [strain, stress] : shown) {
    difference = std::max(difference, std::abs(stress - given.stress(strain)));
    largest = std::max(largest, std::abs(given.stress(strain)));
  }
  return difference / largest;
}

}  // namespace

CurveFit fit_curve(const StressStrain& given, const MeasureCurve& measure) {
  constexpr int most_runs = 25;
  constexpr double tolerance = 1e-4;
  CurveFit best{given, 1};
  StressStrain springs = given;
  std::size_t steps = 0;
  for (int run = 0; run < most_runs && best.error > tolerance; ++run) {
    std::vector<StressStrain::Point> shown = measure(springs);
    if (run == 0) steps = shown.size();
    if (shown.empty() || shown.size() < steps) break;
    const double error = largest_error(given, shown);
    if (!(error < 100)) break;
    if (error < best.error) best = {springs, error};
    for (auto& [strain, stress] : shown) stress = springs.stress(strain) * given.stress(strain) / stress;
    const auto points = with_other_side(given, shown);
    if (StressStrain::fault(points)) break;
    springs = StressStrain::through(points);
  }
  return best;
}

}  // namespace elastin::lab
