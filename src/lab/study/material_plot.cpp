#include "lab/study/material_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "elastin/core/laws/homogeneous.h"
#include "lab/report/figures.h"
#include "lab/run/material_numbers.h"

namespace elastin::lab {
namespace {

constexpr int kPoints = 60;  // to either side of rest

/// One branch of a curve away from rest, up to a stress of this size: ranges that are stable or not, one series each.
/// Returns the largest stress.
double add_branch(const MaterialLaw& law, const Material& material, HomogeneousTest test, int colour, double end,
                  double most, Plot& plot) {
  const Matrix3 axes = axes_of_law(law, material);
  PlotSeries series{"", colour, PlotSeries::Kind::line, {{0, 0, name_of(test)}}};
  double largest = 0;
  for (int i = 1; i <= kPoints; ++i) {
    const double part = static_cast<double>(i) / kPoints;
    const double amount = test == HomogeneousTest::shear ? part * end : std::expm1(part * std::log1p(end));
    const auto state = homogeneous_state(law, material, test, amount, axes);
    if (!state || std::abs(state->stress) > most) break;
    largest = std::max(largest, std::abs(state->stress));
    const auto kind = state->stable ? PlotSeries::Kind::line : PlotSeries::Kind::dashed;
    if (kind != series.kind) {
      const PlotPoint joint = series.points.back();
      plot.series.push_back(std::exchange(series, {"", colour, kind, {joint}}));
    }
    series.points.push_back({amount, state->stress, name_of(test)});
  }
  plot.series.push_back(std::move(series));
  return largest;
}

}  // namespace

Plot material_plot(const std::string& title, const MaterialLaw& law, const Material& material, double stretch) {
  Plot plot;
  plot.title = title;
  plot.x = {"nominal strain, amount of shear", "", false};
  plot.y = {"nominal stress", "Pa", false};
  int colour = 0;
  for (const HomogeneousTest test : kHomogeneousTests) {
    const std::size_t first = plot.series.size();
    const double most = add_branch(law, material, test, colour, stretch - 1, INFINITY, plot);
    if (test != HomogeneousTest::shear) add_branch(law, material, test, colour, 1 / stretch - 1, most, plot);
    plot.series[first].name = name_of(test);
    ++colour;
  }
  bool unstable = false;
  for (const PlotSeries& series : plot.series) unstable |= series.kind == PlotSeries::Kind::dashed;
  if (unstable) plot.title += "; dashed: unstable (Drucker)";
  return plot;
}

}  // namespace elastin::lab
