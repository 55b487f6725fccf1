#include <algorithm>
#include <cmath>

#include "config/scene_text.h"
#include "core/base/dense.h"
#include "elastin/core/base/text.h"
#include "lab/scene/parts.h"
#include "lab/scene/scene.h"

namespace elastin::lab {
namespace {

constexpr double kNormal = 1.959964;  ///< deviations from the middle of a 95 % interval to its end
constexpr const char* kCorrelation = "correlation";

double read_deviation(const Reader& value, const config::StatedNumber& number) {
  if (!value.is_text()) {
    const auto ends = value.items(2);
    const double low = ends[0].quantity(number.unit), high = ends[1].quantity(number.unit);
    if (!(low < high)) value.fail("an interval goes from its lower to its upper end, and holds 95 %");
    if (number.value < low || number.value > high)
      value.fail("the interval does not hold the number itself, which the scene states as " +
                 elastin::number(number.value) + (number.unit == dimension::none ? "" : " " + si_unit(number.unit)) +
                 ": write an interval around it, or one standard deviation, as 5 % or a quantity");
    return (high - low) / (2 * kNormal);
  }
  if (!value.text().ends_with('%')) return value.quantity(number.unit, kPositive);
  if (number.value == 0) value.fail("the number is 0, of which no share is a deviation: write it with its unit");
  return value.quantity(dimension::none, kPositive) * std::abs(number.value);
}

}  // namespace

void read_uncertainty(Reader reader, const std::vector<std::string>& overrides, Scene& scene) {
  std::vector<std::string> keys;
  for (const auto& [key, value] : reader.entries()) {
    if (key == kCorrelation) continue;
    const config::StatedNumber number =
        value.located([&, key = key] { return config::stated_number(scene.source, overrides, key); });
    scene.uncertain.push_back({key, read_deviation(value, number)});
    keys.push_back(key);
  }
  const auto count = static_cast<Eigen::Index>(keys.size());
  scene.correlation = MatrixX::Identity(count, count);
  const auto correlation = reader.find(kCorrelation);
  if (!correlation) return;
  for (const Reader& item : correlation->items()) {
    const auto row = item.items(3);
    Eigen::Index of[2];
    for (const int end : {0, 1}) {
      const auto found = std::find(keys.begin(), keys.end(), row[end].text());
      if (found == keys.end())
        row[end].fail("'" + row[end].text() + "' has no deviation here" + suggestion(row[end].text(), keys));
      of[end] = found - keys.begin();
    }
    if (of[0] == of[1]) item.fail("a number correlates with another one");
    scene.correlation(of[0], of[1]) = scene.correlation(of[1], of[0]) = row[2].quantity(dimension::none, {-1, 1});
  }
  if (symmetric_eigenvalues(scene.correlation).minCoeff() < -1e-12)
    correlation->fail("no numbers correlate so: the matrix has a negative eigenvalue");
}

}  // namespace elastin::lab
