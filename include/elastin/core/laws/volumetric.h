#pragma once
#include <algorithm>
#include <cmath>
#include <limits>

#include "elastin/core/base/types.h"

namespace elastin {

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

/// C⁻¹ and J of the right Cauchy–Green tensor C = I + A, so that near rest nothing cancels.
struct Dilatation {
  static constexpr double kFlat = 1e-14;  ///< det C where rounding begins to decide its sign

  Matrix3 inverse;  ///< C⁻¹
  double excess;    ///< det C − 1, no less than kFlat − 1: then all is finite, as if J were 1e-7
  bool flat;        ///< whether det C is that small

  explicit Dilatation(const Matrix3& A) {
    const Matrix3 C = Matrix3::Identity() + A;
    excess = determinant_change(A);
    flat = !(1 + excess > kFlat);
    if (flat) excess = kFlat - 1;
    inverse.col(0) = C.col(1).cross(C.col(2));
    inverse.col(1) = C.col(2).cross(C.col(0));
    inverse.col(2) = C.col(0).cross(C.col(1));
    inverse /= 1 + excess;
  }

  double J() const { return std::sqrt(1 + excess); }
  double swelling() const { return excess / (1 + J()); }

  /// det(I + A) − 1.
  static double determinant_change(const Matrix3& A) {
    const double trace = A.trace(), minors = (trace * trace - A.cwiseProduct(A.transpose()).sum()) / 2;
    return trace + minors + A.determinant();
  }
};

/// A law at work whose energy has two terms, W = W_shape(C) + U(J): the second may be taken on a mean volume of the
/// cell, against locking near ν = ½. Together they are a PointLaw<3>.
template <class Point>
struct SplitPoint {
  Point shape;
  Volumetric volume;

  /// S = S_shape + J U′ C⁻¹.
  Matrix3 stress(const Matrix3& A) const {
    const Dilatation now(A);
    return shape.stress(A) + now.J() * volume.slope(now.swelling()) * now.inverse;
  }

  /// ∂S/∂C with p = J U′ and J p′ = J (U′ + J U″): ½ J p′ G_ij G_kl − ½ p (G_ik G_jl + G_il G_jk) is added.
  Eigen::Matrix<double, 6, 6> tangent(const Matrix3& A) const {
    static constexpr int components[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};
    const Dilatation now(A);
    const Matrix3& G = now.inverse;
    const double J = now.J(), p = J * volume.slope(now.swelling());
    const double bulk = p + J * J * volume.curvature(now.swelling());
    Eigen::Matrix<double, 6, 6> result = shape.tangent(A);
    for (int row = 0; row < 6; ++row)
      for (int column = 0; column < 6; ++column) {
        const auto [i, j] = components[row];
        const auto [k, l] = components[column];
        result(row, column) += (bulk * G(i, j) * G(k, l) - p * (G(i, k) * G(j, l) + G(i, l) * G(j, k))) / 2;
      }
    return result;
  }

  double energy(const Matrix3& A) const {
    const Dilatation now(A);
    if (now.flat) return std::numeric_limits<double>::infinity();
    return shape.energy(A) + volume.energy(now.swelling());
  }
};

}  // namespace elastin
