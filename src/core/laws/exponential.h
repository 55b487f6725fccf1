#pragma once
#include <Eigen/Core>
#include <cstdint>

namespace elastin {

/// The largest power of e in a law: e^350 is far beyond any material, and its square is finite.
inline constexpr double kMostPower = 350;

/// e^y − 1 to two roundings, of |y| ≤ kMostPower; beyond as there. No call and no branch: those of several stretches
/// and terms run side by side. y = n ln 2 + r, |r| ≤ ½ ln 2, e^y − 1 = 2ⁿ (e^r − 1) + (2ⁿ − 1).
inline double limited_expm1(double y) {
  constexpr double per_ln2 = 1.4426950408889634, shifter = 0x1.8p52;
  constexpr double ln2_high = 0x1.62e42fee00000p-1, ln2_low = 0x1.a39ef35793c76p-33;  // their sum is ln 2
  y = y > -kMostPower ? y : -kMostPower;
  y = y < kMostPower ? y : kMostPower;
  const double shifted = y * per_ln2 + shifter, n = shifted - shifter;  // n in the last bits of `shifted`
  const double r = (y - n * ln2_high) - n * ln2_low;
  // e^r − 1 = r + r² (1/2! + r/3! + … + r¹¹/13!), even and odd powers apart; what is left out is 1e-17 of it.
  const double s = r * r;
  const double even =
      1. / 2 + s * (1. / 24 + s * (1. / 720 + s * (1. / 40320 + s * (1. / 3628800 + s * (1. / 479001600)))));
  const double odd =
      1. / 6 + s * (1. / 120 + s * (1. / 5040 + s * (1. / 362880 + s * (1. / 39916800 + s * (1. / 6227020800.)))));
  const double own = r + s * (even + r * odd);
  const double scale = Eigen::numext::bit_cast<double>((Eigen::numext::bit_cast<std::uint64_t>(shifted) + 1023) << 52);
  return scale * own + (scale - 1);
}

}  // namespace elastin
