#pragma once
#include <array>

namespace elastin {

/// As Jet, of several variables: value, slopes, and second slopes in the order of `pairs`, 11 22 33 12 13 23. Not
/// initialised, for there are many of them in a row.
template <std::size_t variables>
struct JetOf {
  static constexpr std::size_t kPairs = variables * (variables + 1) / 2;

  double value;
  std::array<double, variables> slope;
  std::array<double, kPairs> curvature;

  static constexpr auto pairs = [] {
    std::array<std::array<std::size_t, 2>, kPairs> list{};
    std::size_t next = 0;
    for (std::size_t i = 0; i < variables; ++i) list[next++] = {i, i};
    for (std::size_t i = 0; i < variables; ++i)
      for (std::size_t j = i + 1; j < variables; ++j) list[next++] = {i, j};
    return list;
  }();

  static JetOf constant(double value) { return {value, {}, {}}; }
  static JetOf variable(double value, std::size_t number) {
    JetOf result{value, {}, {}};
    result.slope[number] = 1;
    return result;
  }

  /// f of a and b, from its slopes and second slopes at their values.
  static JetOf through(const JetOf& a, const JetOf& b, double f, double fa, double fb, double faa, double fab,
                       double fbb) {
    JetOf result;
    result.value = f;
    for (std::size_t i = 0; i < variables; ++i) result.slope[i] = fa * a.slope[i] + fb * b.slope[i];
    for (std::size_t p = 0; p < kPairs; ++p) {
      const auto [i, j] = pairs[p];
      result.curvature[p] = fa * a.curvature[p] + fb * b.curvature[p] + faa * a.slope[i] * a.slope[j] +
                            fab * (a.slope[i] * b.slope[j] + a.slope[j] * b.slope[i]) + fbb * b.slope[i] * b.slope[j];
    }
    return result;
  }
  /// f of this, from f, f′ and f″ at its value.
  JetOf through(double f, double f1, double f2) const {
    JetOf result;
    result.value = f;
    for (std::size_t i = 0; i < variables; ++i) result.slope[i] = f1 * slope[i];
    for (std::size_t p = 0; p < kPairs; ++p)
      result.curvature[p] = f1 * curvature[p] + f2 * slope[pairs[p][0]] * slope[pairs[p][1]];
    return result;
  }
};

using Jet3 = JetOf<3>;

}  // namespace elastin
