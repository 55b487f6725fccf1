#pragma once
#include <algorithm>
#include <cmath>

#include "core/parallel/parallel.h"
#include "elastin/core/forces/tangent.h"

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

/// Whether K is a sum of positive parts of two molecules each: of connections that resist every motion of their ends
/// against each other, or none. No eigenvalue of D⁻¹ K is then above kLargestOfLinks: (a − b)ᵀ P (a − b) is at most
/// 2 (aᵀ P a + bᵀ P b), twice what D has of it.
bool is_of_resisting_links(const Tangent& tangent);
constexpr double kLargestOfLinks = 2;

struct LargestEigenvalue {
  double of_most = 1;  ///< λ ≥ 1 as powers show it, which see no stiff place that is rare
  double bound = 1;    ///< somewhat more than λ
};

/// From scattered vectors; `apply(x, y)` sets the first `count` columns of y to D⁻¹ A x. What x, y, z are does not
/// matter. Behind the powers, Chebyshev polynomials let grow what lies above the eigenvalue that these have found.
template <class Vectors, class Apply>
LargestEigenvalue largest_eigenvalue(int count, Vectors& x, Vectors& y, Vectors& z, Apply&& apply) {
  using Number = typename Vectors::Scalar;
  constexpr int powers = 8, polynomial = 6;
  constexpr double margin = 1.1;
  parallel_for(
      count,
      [&](int i) {
        for (int k = 0; k < 3; ++k)
          x(k, i) = std::sin(Number(1) + Number(12.9898) * static_cast<Number>(i % 4099) + Number(78.233) * Number(k));
      },
      kMoleculeThreshold);
  const auto size_of = [&](const Vectors& vectors) {
    return std::sqrt(ordered_sum(count, [&](int i) { return static_cast<double>(vectors.col(i).squaredNorm()); }));
  };
  double largest = 1;
  const auto grow = [&] {  // y = D⁻¹ A x, of x that have a size
    apply(x, y);
    const double before = size_of(x), size = size_of(y);
    const bool grows = before > 0 && size > 0 && std::isfinite(size);
    if (grows) largest = std::max(1., size / before);
    return grows ? size : 0;
  };
  for (int power = 0; power < powers; ++power)
    if (const double size = grow(); size > 0)
      x = y / static_cast<Number>(size);
    else
      break;
  const LargestEigenvalue found{margin * largest, margin * largest};
  const auto twice = static_cast<Number>(4 / largest);
  z = x;
  apply(x, y);
  x = twice / 2 * y - x;
  for (int degree = 2; degree <= polynomial; ++degree) {
    apply(x, y);
    z = twice * y - 2 * x - z;
    std::swap(x, z);
  }
  grow();
  return {found.of_most, std::max(found.bound, margin * largest)};
}

}  // namespace elastin
