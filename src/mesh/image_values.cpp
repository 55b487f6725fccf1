#include "mesh/image_values.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace elastin::mesh {
namespace {

template <class Visit>
void for_values(const Image& image, const Visit& visit) {
  for (int z = 0; z < image.size[2]; ++z)
    for (int y = 0; y < image.size[1]; ++y)
      for (int x = 0; x < image.size[0]; ++x) visit(image.at(x, y, z), std::array{x, y, z});
}

/// The threshold that parts a histogram into two classes whose means differ most: w₀ w₁ (μ₁ − μ₀)² is greatest. Between
/// classes with a gap it is the middle of the gap.
double otsu_threshold(const Image& image, double low, double high) {
  constexpr int bins = 1024;
  if (!(high > low)) return low;
  std::vector<double> histogram(bins, 0);
  double all = 0, sum = 0;
  for_values(image, [&](double value, const std::array<int, 3>&) {
    if (!std::isfinite(value)) return;
    const int bin = std::min(bins - 1, static_cast<int>(bins * ((value - low) / (high - low))));
    ++histogram[bin], ++all, sum += bin;
  });
  double below = 0, sum_below = 0, best = -1;
  int first = 1, last = 1;
  for (int bin = 0; bin + 1 < bins; ++bin) {
    below += histogram[bin], sum_below += bin * histogram[bin];
    if (below == 0 || below == all) continue;
    const double difference = (sum - sum_below) / (all - below) - sum_below / below;
    const double variance = below * (all - below) * difference * difference;
    if (variance > best) best = variance, first = bin + 1;
    if (variance == best) last = bin + 1;
  }
  return low + (first + last) / 2. * (high - low) / bins;
}

}  // namespace

ImageValues values_of(const Image& image) {
  constexpr std::size_t few = 20, most = 2000;
  ImageValues result;
  bool whole = true;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  std::size_t equal = 0, pairs = 0;
  for_values(image, [&](double value, const std::array<int, 3>& at) {
    if (std::isfinite(value)) low = std::min(low, value), high = std::max(high, value);
    if (std::isnan(value) || value == 0) return;
    const auto& [x, y, z] = at;
    for (int axis = 0; axis < 3; ++axis)
      if (at[axis] > 0) ++pairs, equal += value == image.at(x - (axis == 0), y - (axis == 1), z - (axis == 2));
    whole &= value > 0 && value == std::floor(value);
    if (result.counts.size() <= most) ++result.counts[value];
  });
  result.labels = result.counts.size() <= few || (whole && result.counts.size() <= most && 2 * equal >= pairs);
  if (result.labels) return result;
  result.counts.clear();
  result.threshold = otsu_threshold(image, low, high);
  return result;
}

}  // namespace elastin::mesh
