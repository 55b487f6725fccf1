#pragma once
#include <cmath>

#include "core/laws/exponential.h"

namespace elastin {

/// A function of two variables at one point: its value, its slopes and its second slopes, carried along by the rules of
/// differentiation. [Griewank & Walther 2008, ch. 13]
struct Jet {
  double value = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;

  Jet() = default;
  Jet(double constant) : value(constant) {}  // NOLINT: numbers stand for constants
  static Jet first(double at) { return {at, 1, 0}; }
  static Jet second(double at) { return {at, 0, 1}; }

  friend Jet operator+(const Jet& a, const Jet& b) {
    return {a.value + b.value, a.x + b.x, a.y + b.y, a.xx + b.xx, a.xy + b.xy, a.yy + b.yy};
  }
  friend Jet operator-(const Jet& a) { return {-a.value, -a.x, -a.y, -a.xx, -a.xy, -a.yy}; }
  friend Jet operator-(const Jet& a, const Jet& b) { return a + -b; }
  friend Jet operator*(const Jet& a, const Jet& b) {
    return {a.value * b.value,
            a.x * b.value + a.value * b.x,
            a.y * b.value + a.value * b.y,
            a.xx * b.value + 2 * a.x * b.x + a.value * b.xx,
            a.xy * b.value + a.x * b.y + a.y * b.x + a.value * b.xy,
            a.yy * b.value + 2 * a.y * b.y + a.value * b.yy};
  }
  friend Jet operator/(const Jet& a, const Jet& b) {
    const double r = 1 / b.value;
    return a * b.through(r, -r * r, 2 * r * r * r);
  }

  /// f of this, from f, f′ and f″ at its value.
  Jet through(double f, double f1, double f2) const {
    return {f, f1 * x, f1 * y, f1 * xx + f2 * x * x, f1 * xy + f2 * x * y, f1 * yy + f2 * y * y};
  }

 private:
  Jet(double v, double by_x, double by_y, double by_xx = 0, double by_xy = 0, double by_yy = 0)
      : value(v), x(by_x), y(by_y), xx(by_xx), xy(by_xy), yy(by_yy) {}
};

inline Jet sqrt(const Jet& a) {
  const double root = std::sqrt(a.value);
  return a.through(root, 0.5 / root, -0.25 / (root * a.value));
}
/// As limited_expm1.
inline Jet expm1(const Jet& a) {
  const double value = limited_expm1(a.value);
  return a.through(value, 1 + value, 1 + value);
}
inline Jet log1p(const Jet& a) {
  const double r = 1 / (1 + a.value);
  return a.through(std::log1p(a.value), r, -r * r);
}

}  // namespace elastin
