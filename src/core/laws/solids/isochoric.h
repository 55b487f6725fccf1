#pragma once
#include <algorithm>
#include <cmath>

#include "core/laws/jet.h"
#include "core/laws/solids/components.h"

namespace elastin {

/// The change of shape alone, C̃ = J^(−2/3) C, its invariants with their first and second slopes by C:
///   Ĩ₁ = tr C̃,  Ĩ₂ = tr C̃⁻¹,  Ĩ₄ = a · C̃ a of a unit vector a.                       [Holzapfel 2000, ch. 6]
/// Each in a form that does not cancel near rest. Finite for any A, as Dilatation is.
class Isochoric {
 public:
  explicit Isochoric(const Matrix3& A) : strain_(A), volume_(A) {
    trace_ = A.trace();
    deviator_ = A - Matrix3::Identity() * (trace_ / 3);
    // C = (1 + m)(I + d), tr d = 0: det(I + d) = 1 − ½ d:d + det d.
    const double even = std::max(1 + trace_ / 3, kLeastEven);
    const Matrix3 d = deviator_ / even;
    half_square_ = d.squaredNorm() / 2;
    const double change =
        volume_.flat ? (1 + volume_.excess) / (even * even * even) - 1 : d.determinant() - half_square_;
    change_ = std::clamp(change, kLeast - 1, 0.);
    shape_root_ = std::cbrt(1 + change_);
    const bool as_it_is = even > kLeastEven && change == change_ && !volume_.flat;
    root_ = 1 / (as_it_is ? even * shape_root_ : std::cbrt(1 + volume_.excess));
  }

  const Dilatation& volume() const { return volume_; }

  double first() const { return 3 * lost() / shape_root_; }  ///< Ĩ₁ − 3 = 3 (1 − r)/r, r = det(I + d)^⅓; ≥ 0
  double second() const {                                    ///< Ĩ₂ − 3 = (3 (1 − r²) − ½ d:d)/r², ≥ 0
    return (3 * lost() * (1 + shape_root_) - half_square_) / (shape_root_ * shape_root_);
  }
  double along(const Vector3& a) const {  ///< Ĩ₄ − 1
    const double change = a.dot(strain_ * a);
    const double k = 1 / root_;  // D^⅓; 1/k − 1 = −(D − 1)/(k (1 + k + k²))
    return change - volume_.excess / (k * (1 + k + k * k)) * (1 + change);
  }

  /// ∂Ĩ₁/∂C = D^(−1/3) C⁻¹ dev C, D = det C.
  Components first_slope() const { return components(root_ * symmetric(volume_.inverse * deviator_)); }
  /// ∂Ĩ₂/∂C = D^(−2/3) C⁻¹ dev(I₁ C − C²).
  Components second_slope() const {
    const Matrix3 square = strain_ * strain_;
    const Matrix3 inner = (1 + trace_) * deviator_ - square + Matrix3::Identity() * (square.trace() / 3);
    return components(root_ * root_ * symmetric(volume_.inverse * inner));
  }
  /// ∂Ĩ₄/∂C = D^(−1/3) (a aᵀ − I₄/3 C⁻¹).
  Components along_slope(const Vector3& a) const {
    return root_ * (symmetric_product(a, a) - (1 + a.dot(strain_ * a)) / 3 * components(volume_.inverse));
  }

  /// Each adds `factor` times the second slope by C.
  void add_first_curvature(double factor, TangentModuli<3>& result) const {
    add_curvature(factor, components(Matrix3::Identity()), 3 + trace_, result);
  }
  void add_along_curvature(double factor, const Vector3& a, TangentModuli<3>& result) const {
    add_curvature(factor, symmetric_product(a, a), 1 + a.dot(strain_ * a), result);
  }
  /// D^(−2/3) (I ⊗ I − I ⊙ I − ⅔ (M ⊗ G + G ⊗ M) + 4/9 I₂ G ⊗ G + ⅔ I₂ G ⊙ G),  M = I₁ I − C,  G = C⁻¹.
  void add_second_curvature(double factor, TangentModuli<3>& result) const {
    const double scale = factor * root_ * root_;
    const Components G = components(volume_.inverse),
                     M = (2 + trace_) * components(Matrix3::Identity()) - components(strain_);
    const double I2 = 3 + 2 * trace_ + (trace_ * trace_ - strain_.squaredNorm()) / 2;
    add_symmetric(result, [&]<int row, int column>() {
      constexpr double own = (row < 3 && column < 3 ? 1 : 0) - (row == column ? row < 3 ? 1 : 0.5 : 0);
      return scale * (own - 2. / 3 * (M[row] * G[column] + M[column] * G[row]) + 4. / 9 * I2 * G[row] * G[column] +
                      2. / 3 * I2 * symmetric_square_entry<row, column>(volume_.inverse));
    });
  }

 private:
  static constexpr double kLeast = 1e-30, kLeastEven = 1e-5;

  double lost() const { return -change_ / (1 + shape_root_ + shape_root_ * shape_root_); }  // 1 − r
  static Matrix3 symmetric(const Matrix3& product) { return (product + product.transpose()) / 2; }
  /// Of D^(−1/3) M:C: D^(−1/3) (M:C (G ⊗ G/9 + G ⊙ G/3) − ⅓ (M ⊗ G + G ⊗ M)).
  void add_curvature(double factor, const Components& M, double invariant, TangentModuli<3>& result) const {
    const Components G = components(volume_.inverse);
    const double scale = factor * root_ / 3;
    add_symmetric(result, [&]<int row, int column>() {
      return scale * (invariant * (G[row] * G[column] / 3 + symmetric_square_entry<row, column>(volume_.inverse)) -
                      (M[row] * G[column] + M[column] * G[row]));
    });
  }

  Matrix3 strain_, deviator_;
  Dilatation volume_;
  double trace_, root_, half_square_;  ///< of A; D^(−1/3); ½ d:d
  double change_, shape_root_;         ///< det(I + d) − 1, ≤ 0; r
};

/// ψ(Ĩ₁ − 3, Ĩ₂ − 3) [J/m³] with its derivatives: an isotropic law's energy of a change of shape.
template <class Density>
concept InvariantDensity = requires(const Density& density, const Jet& first, const Jet& second) {
  { density(first, second) } -> std::convertible_to<Jet>;
};

/// Such a law at work, without its U(J).
template <InvariantDensity Density>
struct IsotropicShape {
  Density density;

  Matrix3 stress(const Matrix3& A) const {
    const Isochoric now(A);
    const Jet w = at(now);
    Components S = w.x * now.first_slope();
    if (w.y != 0) S += w.y * now.second_slope();
    return 2 * tensor(S);
  }

  TangentModuli<3> tangent(const Matrix3& A) const {
    const Isochoric now(A);
    const Jet w = at(now);
    const Components first = now.first_slope();
    TangentModuli<3> result = 2 * w.xx * first * first.transpose();
    now.add_first_curvature(2 * w.x, result);
    if (w.y == 0 && w.xy == 0 && w.yy == 0) return result;
    const Components second = now.second_slope();
    result += 2 * w.xy * both_ways(first, second) + 2 * w.yy * second * second.transpose();
    now.add_second_curvature(2 * w.y, result);
    return result;
  }

  double energy(const Matrix3& A) const { return at(Isochoric(A)).value; }

 private:
  Jet at(const Isochoric& now) const { return density(Jet::first(now.first()), Jet::second(now.second())); }
};

}  // namespace elastin
