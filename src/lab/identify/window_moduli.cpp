#include "lab/identify/window_moduli.h"

#include <fmt/format.h>

#include <cmath>

#include "lab/report/table.h"

namespace elastin::lab {
namespace {

constexpr double kAround = 0.1;   // of the range of strains, to both sides of a tangent's or secant's point
constexpr double kBeyond = 0.02;  // of the range, by which a window may end beyond the curve

std::string text_of(const WindowBound& bound) {
  return bound.is_stress ? readable(bound.value, dimension::pressure, 4) : fmt::format("{:.4g} %", 100 * bound.value);
}

/// Of the polynomial over the rows of a window with the lowest degree whose value, or slope, two degrees more do not
/// change by more than their interval. The half width is that interval's and the change, so that it covers the shape of
/// the curve, too.
std::optional<LocalFit> fit_window(const VectorX& x, const VectorX& y, double at, double low, double high, bool chord) {
  constexpr Eigen::Index highest = 6, fewest = 6;  // rows beyond the degree
  const auto lowest = fit_locally(x, y, at, low, high, 2, chord);
  if (!lowest) return lowest;
  const LocalFit first = *lowest;
  LocalFit best = first;
  const auto choose = [&](double LocalFit::*number, double LocalFit::*half) {
    LocalFit fit = first;
    for (Eigen::Index degree = 2;; degree += 2) {
      const LocalFit next = *fit_locally(x, y, at, low, high, degree + 2, chord);
      const double change = next.*number - fit.*number;
      const bool enough = first.rows >= degree + fewest;
      const bool shaped = enough && std::abs(change) > next.*half;
      best.*number = shaped ? next.*number : fit.*number;
      best.*half = (enough ? next.*half : fit.*half) + std::abs(change);
      if (!shaped || degree == highest) return;
      fit = next;
    }
  };
  choose(&LocalFit::value, &LocalFit::value_half);
  choose(&LocalFit::slope, &LocalFit::slope_half);
  return best;
}

}  // namespace

std::vector<WindowModulus> window_moduli(const DataTest& test, const MeasuredData& data) {
  std::vector<WindowModulus> moduli;
  const VectorX strain = data.x.sum() < 0 ? VectorX(-data.x) : data.x,
                stress = data.y.sum() < 0 ? VectorX(-data.y) : data.y;
  const double range = strain.maxCoeff() - strain.minCoeff(), stresses = stress.maxCoeff() - stress.minCoeff();
  const auto fitted = [&](const std::string& window, const VectorX& x, const VectorX& y, double at, double low,
                          double high, bool chord = false) {
    const auto fit = fit_window(x, y, at, low, high, chord);
    if (!fit) test.fail("moduli: " + window + ": " + data.file + " has fewer than two points there");
    return *fit;
  };
  const auto check_within = [&](const std::string& window, const VectorX& curve, double at) {
    const double beyond = kBeyond * (curve.maxCoeff() - curve.minCoeff());
    if (at < curve.minCoeff() - beyond || at > curve.maxCoeff() + beyond)
      test.fail("moduli: " + window + ": the curve of " + data.file + " does not reach that");
  };
  struct Strain {
    double value, half = 0;
  };
  /// Where a stress is reached: by the polynomial of strains over stresses near it.
  const auto strain_at = [&](const std::string& window, const WindowBound& bound) {
    check_within(window, bound.is_stress ? stress : strain, bound.value);
    if (!bound.is_stress) return Strain{bound.value};
    const double near = kAround * stresses;
    const LocalFit fit = fitted(window, stress, strain, bound.value, bound.value - near, bound.value + near);
    return Strain{fit.value, std::isfinite(fit.value_half) ? fit.value_half : 0};
  };
  for (const ModulusWindow& stated : test.moduli) {
    struct Modulus {
      double value, half;
      Eigen::Index rows;
    };
    const auto add = [&](const std::string& window, const std::vector<Strain>& ends, const auto& modulus_between) {
      const auto modulus = [&](std::size_t moved) {
        std::vector<double> at;
        for (std::size_t i = 0; i < ends.size(); ++i) at.push_back(ends[i].value + (i == moved ? ends[i].half : 0));
        return modulus_between(at);
      };
      Modulus found = modulus(ends.size());
      const double value = found.value;
      for (std::size_t i = 0; i < ends.size(); ++i)
        if (ends[i].half > 0) found.half = std::hypot(found.half, modulus(i).value - value);
      moduli.push_back({window, value, value - found.half, value + found.half, found.rows});
    };
    if (stated.kind == ModulusWindow::Kind::chord) {
      const std::string window = "chord from " + text_of(stated.from) + " to " + text_of(stated.to);
      add(window, {strain_at(window, stated.from), strain_at(window, stated.to)}, [&](const std::vector<double>& at) {
        if (!(at[0] < at[1])) test.fail("moduli: " + window + ": `from` must lie below `to`");
        const LocalFit fit = fitted(window, strain, stress, (at[0] + at[1]) / 2, at[0], at[1], true);
        return Modulus{fit.slope, fit.slope_half, fit.rows};
      });
      continue;
    }
    const bool secant = stated.kind == ModulusWindow::Kind::secant;
    const std::string window = (secant ? "secant to " : "tangent at ") + text_of(stated.at);
    add(window, {strain_at(window, stated.at)}, [&](const std::vector<double>& at) {
      const LocalFit fit = fitted(window, strain, stress, at[0], at[0] - kAround * range, at[0] + kAround * range);
      if (secant && !(at[0] > 0)) test.fail("moduli: " + window + ": there is no strain");
      return secant ? Modulus{fit.value / at[0], fit.value_half / at[0], fit.rows}
                    : Modulus{fit.slope, fit.slope_half, fit.rows};
    });
  }
  return moduli;
}

}  // namespace elastin::lab
