#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "elastin/core/base/types.h"

namespace elastin {

/// 2 artanh f = ln((1 + f)/(1 − f)) to two roundings, |f| ≤ 0.172: 2 (f + f³/3 + f⁵/5 …), in short chains.
inline double double_artanh(double f) {
  const double s = f * f, s2 = s * s, s4 = s2 * s2;
  const double low = (1. / 3 + s * (1. / 5)) + s2 * (1. / 7 + s * (1. / 9));
  const double high = (1. / 11 + s * (1. / 13)) + s2 * (1. / 15 + s * (1. / 17));
  const double sum = low + s4 * (high + s4 * ((1. / 19 + s * (1. / 21)) + s2 * (1. / 23)));
  return 2 * f + 2 * f * (s * sum);
}

/// ln x of a normal x > 0 to two roundings: bitwise identical wherever numbers are IEEE's, which the library's
/// logarithm has not. x = 2ⁿ m, √½ ≤ m < √2, and ln m = 2 artanh((m − 1)/(m + 1)).
inline double series_log(double x) {
  constexpr double ln2_high = 0x1.62e42fee00000p-1, ln2_low = 0x1.a39ef35793c76p-33;  // their sum is ln 2
  constexpr std::uint64_t root_of_half = 0x3fe6a09e667f3bcd;
  const auto bits = Eigen::numext::bit_cast<std::uint64_t>(x);
  const auto power = static_cast<std::int64_t>(bits - root_of_half) >> 52;
  const auto m = Eigen::numext::bit_cast<double>(bits - (static_cast<std::uint64_t>(power) << 52));
  const double n = static_cast<double>(power);
  return n * ln2_high + (n * ln2_low + double_artanh((m - 1) / (m + 1)));
}

/// ln(1 + x), x > −1, to some roundings at any size: far from 0 by the logarithm of 1 + x, whose rounding it mends.
inline double short_log1p(double x) {
  if (x > -0.29 && x < 0.41) return double_artanh(x / (2 + x));
  const double rounded = 1 + x;
  return series_log(rounded) + (x - (rounded - 1)) / rounded;
}

/// x^(−⅓) of a normal x > 0 to two roundings, without a division: a third of the exponent's bits is within 3.5 % of it,
/// and each step y (1 − e)^(−⅓), e = 1 − x y³, raises the error to its fourth power.
inline double inverse_cube_root(double x) {
  auto y = Eigen::numext::bit_cast<double>(0x553ef0ff289dd796 - Eigen::numext::bit_cast<std::uint64_t>(x) / 3);
  for (int step = 0; step < 2; ++step) {
    const double e = 1 - x * y * (y * y);
    y += y * e * (1. / 3 + e * (2. / 9 + e * (14. / 81)));
  }
  return y;
}

/// U(J) of a solid law, the energy density [J/m³] of a change of volume alone, with its derivatives. All of them have
/// U(1) = U′(1) = 0 and U″(1) = κ. What they see is the swelling J − 1, > −1, so that near rest nothing cancels.
struct Volumetric {
  enum class Form {
    quadratic,    ///< κ/2 (J − 1)²
    logarithmic,  ///< κ/2 (ln J)²; its pressure falls again beyond J = e
    mixed,        ///< κ/4 (J² − 1 − 2 ln J)                                   [Simo & Taylor 1982]
  };
  Form form = Form::quadratic;
  double modulus = 0;  ///< κ [Pa], ≥ 0

  /// U [J/m³], ≥ 0.
  double energy(double swelling) const {
    switch (form) {
      case Form::quadratic:
        return modulus / 2 * swelling * swelling;
      case Form::logarithmic: {
        const double log_J = std::log1p(swelling);
        return modulus / 2 * log_J * log_J;
      }
      case Form::mixed:
        return modulus / 4 * (swelling * swelling + 2 * above_log(swelling));
    }
    return 0;
  }

  /// U′ = ∂U/∂J [Pa], the mean Cauchy stress that it makes.
  double slope(double swelling) const {
    const double J = 1 + swelling;
    switch (form) {
      case Form::quadratic:
        return modulus * swelling;
      case Form::logarithmic:
        return modulus * std::log1p(swelling) / J;
      case Form::mixed:
        return modulus / 2 * swelling * (1 + J) / J;
    }
    return 0;
  }

  /// U″ [Pa].
  double curvature(double swelling) const {
    const double J = 1 + swelling;
    switch (form) {
      case Form::quadratic:
        return modulus;
      case Form::logarithmic:
        return modulus * (1 - std::log1p(swelling)) / (J * J);
      case Form::mixed:
        return modulus / 2 * (1 + 1 / (J * J));
    }
    return 0;
  }

  /// J U′ [Pa], the mean Kirchhoff stress, and J ∂(J U′)/∂J, of J² − 1.
  double kirchhoff(double excess) const {
    switch (form) {
      case Form::quadratic:
        return modulus * excess / (1 + 1 / std::sqrt(1 + excess));
      case Form::logarithmic:
        return modulus / 2 * short_log1p(excess);
      case Form::mixed:
        return modulus / 2 * excess;
    }
    return 0;
  }
  double kirchhoff_slope(double excess) const {
    switch (form) {
      case Form::quadratic:
        return modulus * (2 * (1 + excess) - std::sqrt(1 + excess));
      case Form::logarithmic:
        return modulus;
      case Form::mixed:
        return modulus * (1 + excess);
    }
    return 0;
  }

 private:
  /// x − ln(1 + x), which cancels near 0: there with r = x/(2 + x), ln(1 + x) = 2 artanh r.
  static double above_log(double x) {
    if (std::abs(x) > 0.2) return x - std::log1p(x);
    const double r = x / (2 + x), square = r * r;
    double series = 0;
    for (int power = 19; power > 1; power -= 2) series = 1. / power + square * series;
    return r * (x - 2 * square * series);
  }
};

/// Adds number(row, column), of column ≤ row, to a symmetric tangent ∂S/∂C.
template <class Number>
void add_symmetric(Eigen::Matrix<double, 6, 6>& tangent, const Number& number) {
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column < row; ++column) {
      const double value = number(row, column);
      tangent(row, column) += value;
      tangent(column, row) += value;
    }
    tangent(row, row) += number(row, row);
  }
}

/// Adds `along` G ⊗ G + `across` G ⊙ G of a symmetric G to a tangent ∂S/∂C, its components in the order 11 22 33 12 13
/// 23; (G ⊙ G)_ijkl = ½ (G_ik G_jl + G_il G_jk), which is −∂C⁻¹/∂C of G = C⁻¹. The entries stand here one by one,
/// because all laws need them and a loop over their indices takes several times as long.
inline void add_symmetric_squares(const Matrix3& G, double along, double across, Eigen::Matrix<double, 6, 6>& tangent) {
  const double xx = G(0, 0), yy = G(1, 1), zz = G(2, 2), xy = G(1, 0), xz = G(2, 0), yz = G(2, 1);
  const double own[6] = {xx, yy, zz, xy, xz, yz}, half = across / 2;
  const double squares[21] = {
      across * xx * xx,                                                                                     //
      across * xy * xy,           across * yy * yy,                                                         //
      across * xz * xz,           across * yz * yz,          across * zz * zz,                              //
      across * xx * xy,           across * xy * yy,          across * xz * yz, half * (xx * yy + xy * xy),  //
      across * xx * xz,           across * xy * yz,          across * xz * zz, half * (xx * yz + xz * xy),  //
      half * (xx * zz + xz * xz),                                                                           //
      across * xy * xz,           across * yy * yz,          across * yz * zz, half * (xy * yz + xz * yy),  //
      half * (xy * zz + xz * yz), half * (yy * zz + yz * yz)};
  add_symmetric(tangent, [&](int row, int column) {
    return along * own[row] * own[column] + squares[row * (row + 1) / 2 + column];
  });
}

/// C⁻¹ and J of the right Cauchy–Green tensor C = I + A, so that near rest nothing cancels.
struct Dilatation {
  static constexpr double kFlat = 1e-14;  ///< det C where rounding begins to decide its sign

  Matrix3 inverse;   ///< C⁻¹
  Matrix3 adjugate;  ///< of A
  double excess;     ///< det C − 1, no less than kFlat − 1: then all is finite, as if J were 1e-7
  bool flat;         ///< whether det C is that small

  /// With the cofactors of A: adj(I + A) = (1 + tr A) I − A + adj A.
  explicit Dilatation(const Matrix3& A) {
    const double xx = A(1, 1) * A(2, 2) - A(2, 1) * A(2, 1), yy = A(0, 0) * A(2, 2) - A(2, 0) * A(2, 0),
                 zz = A(0, 0) * A(1, 1) - A(1, 0) * A(1, 0), xy = A(2, 0) * A(2, 1) - A(1, 0) * A(2, 2),
                 xz = A(1, 0) * A(2, 1) - A(2, 0) * A(1, 1), yz = A(1, 0) * A(2, 0) - A(0, 0) * A(2, 1);
    excess = A.trace() + (xx + yy + zz) + (A(0, 0) * xx + A(1, 0) * xy + A(2, 0) * xz);
    flat = !(1 + excess > kFlat);
    if (flat) excess = kFlat - 1;
    adjugate << xx, xy, xz, xy, yy, yz, xz, yz, zz;
    const double scale = 1 / (1 + excess);
    inverse(0, 0) = scale * (1 + (A(1, 1) + A(2, 2)) + xx);
    inverse(1, 1) = scale * (1 + (A(0, 0) + A(2, 2)) + yy);
    inverse(2, 2) = scale * (1 + (A(0, 0) + A(1, 1)) + zz);
    inverse(0, 1) = inverse(1, 0) = scale * (xy - A(1, 0));
    inverse(0, 2) = inverse(2, 0) = scale * (xz - A(2, 0));
    inverse(1, 2) = inverse(2, 1) = scale * (yz - A(2, 1));
  }

  double J() const { return std::sqrt(1 + excess); }
  double swelling() const { return excess / (1 + J()); }

  /// det(I + A) − 1.
  static double determinant_change(const Matrix3& A) {
    const double trace = A.trace(), minors = (trace * trace - A.cwiseProduct(A.transpose()).sum()) / 2;
    return trace + minors + A.determinant();
  }
};

/// A = C − I with what most laws take of it, made once for all that look at it; a law that needs A alone takes that.
struct Strained {
  const Matrix3& A;  ///< no longer than what it was made of
  Dilatation volume;
  double root;  ///< (det C)^(−⅓)

  Strained(const Matrix3& strain) : A(strain), volume(strain) {  // NOLINT: what laws are given
    root = inverse_cube_root(1 + volume.excess);
  }
  operator const Matrix3&() const { return A; }
};

/// A law at work whose energy has two terms, W = W_shape(C) + U(J): the second may be taken on a mean volume of the
/// cell, against locking near ν = ½. Together they are a PointLaw<3>.
template <class Point>
struct SplitPoint {
  Point shape;
  Volumetric volume;

  /// S = S_shape + J U′ C⁻¹.
  Matrix3 stress(const Matrix3& A) const {
    const Strained now(A);
    const double p = volume.kirchhoff(now.volume.excess);
    Matrix3 S = shape.stress(now);
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 3; ++i) S(i, j) += p * now.volume.inverse(i, j);
    return S;
  }

  /// ∂S/∂C with p = J U′ and J p′ = J (U′ + J U″): ½ J p′ G_ij G_kl − ½ p (G_ik G_jl + G_il G_jk) is added.
  Eigen::Matrix<double, 6, 6> tangent(const Matrix3& A) const {
    const Strained now(A);
    const double p = volume.kirchhoff(now.volume.excess);
    Eigen::Matrix<double, 6, 6> result = shape.tangent(now);
    add_symmetric_squares(now.volume.inverse, volume.kirchhoff_slope(now.volume.excess) / 2, -p, result);
    return result;
  }

  double energy(const Matrix3& A) const {
    const Dilatation now(A);
    if (now.flat) return std::numeric_limits<double>::infinity();
    return shape.energy(A) + volume.energy(now.swelling());
  }
};

}  // namespace elastin
