#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

namespace elastin::testing {

/// Forces per width at rest along the meridian and around [N/m], of the two stretches.
using MembraneLaw = std::function<std::array<double, 2>(double along, double around)>;

struct BubbleSolution {
  double height, stretch, tension;  ///< [m], at the pole, nominal at the pole [N/m]
};

/// A disc of radius a held at its rim under the pressure p, as an ordinary differential equation in the radius R at
/// rest, solved by shooting from the pole: with the meridian's slope φ, r′ = λ₁ cos φ, z′ = −λ₁ sin φ, λ₂ = r/R,
///   (R N₁)′ = N₂ cos φ,   R N₁ sin φ = p r²/2,   r(a) = a.
/// Knows nothing of triangles. 4th order in `steps`.
inline BubbleSolution solve_bubble(const MembraneLaw& law, double radius, double pressure, int steps = 2000) {
  const auto meridian_stretch = [&](double tension, double around) {
    double low = 0.2, high = 12;
    for (int halving = 0; halving < 70; ++halving) {
      const double middle = (low + high) / 2;
      (law(middle, around)[0] < tension ? low : high) = middle;
    }
    return low;
  };
  using State = std::array<double, 3>;  // r, R N₁, drop of z
  const auto slope = [&](double R, const State& y) -> State {
    const double around = y[0] / R, along = meridian_stretch(y[1] / R, around);
    const double sine = std::min(1., pressure * y[0] * y[0] / (2 * std::max(y[1], 1e-12))),
                 cosine = std::sqrt(1 - sine * sine);
    return {along * cosine, law(along, around)[1] * cosine, along * sine};
  };
  const auto shoot = [&](double stretch) {
    const double first = radius * 1e-6, h = (radius - first) / steps;
    State y{stretch * first, first * law(stretch, stretch)[0], 0};
    const auto moved = [](const State& from, const State& k, double by) -> State {
      return {from[0] + by * k[0], from[1] + by * k[1], from[2] + by * k[2]};
    };
    for (int step = 0; step < steps; ++step) {
      const double R = first + step * h;
      const State k1 = slope(R, y), k2 = slope(R + h / 2, moved(y, k1, h / 2)),
                  k3 = slope(R + h / 2, moved(y, k2, h / 2)), k4 = slope(R + h, moved(y, k3, h));
      for (std::size_t i = 0; i < 3; ++i) y[i] += h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
    }
    return y;
  };
  double low = 1.01, high = 1.01;  // at the pole; more stretch there leads to a wider rim
  while (shoot(high)[0] < radius && high < 8) low = high, high += 0.05;
  for (int halving = 0; halving < 45; ++halving) {
    const double middle = (low + high) / 2;
    (shoot(middle)[0] < radius ? low : high) = middle;
  }
  return {shoot(low)[2], low, law(low, low)[0]};
}

}  // namespace elastin::testing
