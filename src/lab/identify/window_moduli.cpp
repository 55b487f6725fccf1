#include "lab/identify/window_moduli.h"

#include <fmt/format.h>

#include "lab/report/table.h"

namespace elastin::lab {
namespace {

constexpr double kAround = 0.1;   // of the range of strains, to both sides of a tangent's or secant's point
constexpr double kBeyond = 0.02;  // of the range, by which a window may end beyond the curve

std::string text_of(const WindowBound& bound) {
  return bound.is_stress ? readable(bound.value, dimension::pressure, 4) : fmt::format("{:.4g} %", 100 * bound.value);
}

}  // namespace

std::vector<WindowModulus> window_moduli(const DataTest& test, const MeasuredData& data) {
  std::vector<WindowModulus> moduli;
  const VectorX strain = data.x.cwiseAbs(), stress = data.y.cwiseAbs();
  const double range = strain.maxCoeff() - strain.minCoeff(), stresses = stress.maxCoeff() - stress.minCoeff();
  const auto fitted = [&](const std::string& window, const VectorX& x, const VectorX& y, double at, double low,
                          double high) {
    const auto fit = fit_locally(x, y, at, low, high);
    if (!fit) test.fail("moduli: " + window + ": " + data.file + " has fewer than two points there");
    return *fit;
  };
  const auto check_within = [&](const std::string& window, const VectorX& curve, double at) {
    const double beyond = kBeyond * (curve.maxCoeff() - curve.minCoeff());
    if (at < curve.minCoeff() - beyond || at > curve.maxCoeff() + beyond)
      test.fail("moduli: " + window + ": the curve of " + data.file + " does not reach that");
  };
  /// Where a stress is reached: by the parabola of strains over stresses near it.
  const auto strain_at = [&](const std::string& window, const WindowBound& bound) {
    check_within(window, bound.is_stress ? stress : strain, bound.value);
    if (!bound.is_stress) return bound.value;
    const double near = kAround * stresses;
    return fitted(window, stress, strain, bound.value, bound.value - near, bound.value + near).value;
  };
  for (const ModulusWindow& stated : test.moduli) {
    if (stated.kind == ModulusWindow::Kind::chord) {
      const std::string window = "chord from " + text_of(stated.from) + " to " + text_of(stated.to);
      const double low = strain_at(window, stated.from), high = strain_at(window, stated.to);
      if (!(low < high)) test.fail("moduli: " + window + ": `from` must lie below `to`");
      const LocalFit fit = fitted(window, strain, stress, (low + high) / 2, low, high);
      moduli.push_back({window, fit.slope, fit.slope - fit.slope_half, fit.slope + fit.slope_half, fit.rows});
      continue;
    }
    const bool secant = stated.kind == ModulusWindow::Kind::secant;
    const std::string window = (secant ? "secant to " : "tangent at ") + text_of(stated.at);
    const double at = strain_at(window, stated.at);
    const LocalFit fit = fitted(window, strain, stress, at, at - kAround * range, at + kAround * range);
    if (secant && !(at > 0)) test.fail("moduli: " + window + ": there is no strain");
    const double value = secant ? fit.value / at : fit.slope, half = secant ? fit.value_half / at : fit.slope_half;
    moduli.push_back({window, value, value - half, value + half, fit.rows});
  }
  return moduli;
}

}  // namespace elastin::lab
