#pragma once
#include <algorithm>
#include <cmath>

#include "core/laws/membranes/membrane.h"

namespace elastin {

/// A membrane that bears no compression: it wrinkles, on a scale too fine for any mesh. The relaxed energy of an
/// isotropic law [Pipkin 1986], so it is conservative like the law itself. With C₁ ≥ C₂ the principal values of C:
///   * taut, where the law's own stress across is not negative: w;
///   * wrinkled, where it is but C₁ > 1: w(C₁, C₂*), C₂* the natural width, at which the law has no stress across;
///   * slack, where also C₁ ≤ 1: 0, and no stiffness.
/// With w₁ = ∂w/∂C₁ … at the natural width the slope of the second is w₁, its second slope w₁₁ − w₁₂²/w₂₂.
template <class Density>
struct TensionField {
  static constexpr bool resists_flattening = false;

  Density law;

  explicit TensionField(const Material& material) : law(material) {}

  Jet operator()(const PlaneStrain& strain) const {
    const Jet own = law(strain);
    const double root = std::sqrt(strain.split);
    const double first = (strain.trace + root) / 2, second = (strain.trace - root) / 2;  // C − 1
    if (Principal(own, root).second >= 0) return own;
    if (first <= 0) return 0;
    const Principal now = at_natural_width(first, second);
    const double bend = now.both_first - now.mixed * now.mixed / now.both_second;
    // C₁ − 1 = (τ + √ρ)/2.
    Jet along = 0.5 * (Jet::first(strain.trace) + sqrt(Jet::second(strain.split)));
    along.value = first;
    return along.through(now.energy, now.first, bend);
  }

 private:
  /// w and its derivatives by the principal values, from those by τ and ρ = r², r = C₁ − C₂.
  struct Principal {
    double energy, first, second, both_first, mixed, both_second;

    Principal(const Jet& w, double r)
        : energy(w.value),
          first(w.x + 2 * r * w.y),
          second(w.x - 2 * r * w.y),
          both_first(w.xx + 4 * r * w.xy + 4 * r * r * w.yy + 2 * w.y),
          mixed(w.xx - 4 * r * r * w.yy - 2 * w.y),
          both_second(w.xx - 4 * r * w.xy + 4 * r * r * w.yy + 2 * w.y) {}
  };

  /// Newton's method for ∂w/∂C₂ = 0, kept between the present width, where it is negative, and even stretch, where it
  /// is not.
  [[gnu::noinline]] Principal at_natural_width(double first, double second) const {
    double low = std::max(second, 1e-9 - 1), high = first;
    double width = std::clamp(1 / std::sqrt(1 + first) - 1, low, high);
    Principal now = at(first, width);
    for (int iteration = 0; iteration < 60; ++iteration) {
      (now.second < 0 ? low : high) = width;
      double next = width - now.second / now.both_second;
      if (!(next > low && next < high)) next = (low + high) / 2;
      const double step = std::abs(next - width);
      width = next;
      now = at(first, width);
      if (step <= 1e-15 * (1 + std::abs(width))) break;
    }
    return now;
  }
  Principal at(double first, double second) const {
    const double r = first - second;
    return {law({first + second, r * r}), r};
  }
};

}  // namespace elastin
