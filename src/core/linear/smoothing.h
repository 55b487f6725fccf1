#pragma once
#include <algorithm>
#include <cmath>

#include "core/parallel/parallel.h"

namespace elastin {

/// Smoothing by Chebyshev polynomials of the fourth kind in D⁻¹ A, with nothing known but its largest eigenvalue λ.
/// Step i: d ← before · d + now / λ · D⁻¹ (b − A x), x ← x + d.                      [Lottes 2023, algorithm 3]
struct SmoothingStep {
  double before, now;
};
constexpr SmoothingStep smoothing_step(int i) {
  return {i == 1 ? 0 : (2. * i - 3) / (2 * i + 1), (8. * i - 4) / (2 * i + 1)};
}

/// The largest eigenvalue up to which one step pays most. Beyond, a stiff part of the spectrum leaves it little.
constexpr double kOneStep = 3;

/// Somewhat more than λ ≥ 1, by as many powers, from scattered vectors; `apply(x, y)` sets the first `count` columns of
/// y to D⁻¹ A x. What x and y are does not matter.
template <class Vectors, class Apply>
double largest_eigenvalue(int powers, int count, Vectors& x, Vectors& y, Apply&& apply) {
  using Number = typename Vectors::Scalar;
  constexpr double margin = 1.1;
  for (int i = 0; i < count; ++i)
    for (int k = 0; k < 3; ++k)
      x(k, i) = std::sin(Number(1) + Number(12.9898) * static_cast<Number>(i % 4099) + Number(78.233) * Number(k));
  const auto size_of = [&](const Vectors& vectors) {
    return std::sqrt(ordered_sum(count, [&](int i) { return static_cast<double>(vectors.col(i).squaredNorm()); }));
  };
  double largest = 1;
  for (int power = 0; power < powers; ++power) {
    apply(x, y);
    const double before = size_of(x), size = size_of(y);
    if (!(before > 0) || !(size > 0) || !std::isfinite(size)) break;
    largest = std::max(1., size / before);
    x = y / static_cast<Number>(size);
  }
  return margin * largest;
}

}  // namespace elastin
