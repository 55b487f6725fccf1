#pragma once
#include <array>

namespace elastin {

/// As Jet, of three variables: value, slopes, and second slopes in the order 11 22 33 12 13 23. Not initialised, for
/// there are many of them in a row.
struct Jet3 {
  double value;
  std::array<double, 3> slope;
  std::array<double, 6> curvature;

  static constexpr int pairs[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};

  static Jet3 constant(double value) { return {value, {}, {}}; }
  static Jet3 variable(double value, std::size_t number) {
    Jet3 result{value, {}, {}};
    result.slope[number] = 1;
    return result;
  }

  /// f of a and b, from its slopes and second slopes at their values.
  static Jet3 through(const Jet3& a, const Jet3& b, double f, double fa, double fb, double faa, double fab,
                      double fbb) {
    Jet3 result;
    result.value = f;
    for (std::size_t i = 0; i < 3; ++i) result.slope[i] = fa * a.slope[i] + fb * b.slope[i];
    for (std::size_t p = 0; p < 6; ++p) {
      const auto i = static_cast<std::size_t>(pairs[p][0]), j = static_cast<std::size_t>(pairs[p][1]);
      result.curvature[p] = fa * a.curvature[p] + fb * b.curvature[p] + faa * a.slope[i] * a.slope[j] +
                            fab * (a.slope[i] * b.slope[j] + a.slope[j] * b.slope[i]) + fbb * b.slope[i] * b.slope[j];
    }
    return result;
  }
  /// f of this, from f, f′ and f″ at its value.
  Jet3 through(double f, double f1, double f2) const {
    Jet3 result;
    result.value = f;
    for (std::size_t i = 0; i < 3; ++i) result.slope[i] = f1 * slope[i];
    for (std::size_t p = 0; p < 6; ++p)
      result.curvature[p] = f1 * curvature[p] + f2 * slope[pairs[p][0]] * slope[pairs[p][1]];
    return result;
  }
};

}  // namespace elastin
