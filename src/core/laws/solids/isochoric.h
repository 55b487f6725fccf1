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
  /// @param point must outlive this
  explicit Isochoric(const Strained& point) : strain_(point.A), volume_(point.volume) {
    trace_ = point.A.trace();
    deviator_ = on_diagonal(components(point.A), -trace_ / 3);
    inverse_ = components(volume_.inverse);
    root_ = point.root;
  }

  struct Invariants {
    double first, second;
  };
  /// Ĩ₁ − 3 = 3 (1 − r)/r and Ĩ₂ − 3 = (3 (1 − r²) − ½ d:d)/r², ≥ 0, where C = (1 + m)(I + d), tr d = 0, r = det(I +
  /// d)^⅓, and det(I + d) = 1 − ½ d:d + det d: a form that does not cancel near rest.
  Invariants invariants() const {
    const double scale = 1 / std::max(1 + trace_ / 3, kLeastEven), cube = scale * scale * scale;
    const double half_square = double_product(deviator_, deviator_) / 2 * scale * scale;
    double change = symmetric_determinant(deviator_) * cube - half_square, root = scale / root_;
    if (volume_.flat || !(1 + change > kLeast) || scale == 1 / kLeastEven) {
      change = std::clamp((1 + volume_.excess) * cube - 1, kLeast - 1, 0.);
      root = std::cbrt(1 + change);
    }
    const double lost = -std::min(change, 0.) / (1 + root + root * root), inverse = 1 / root;  // 1 − r; 1/r
    return {3 * lost * inverse, (3 * lost * (1 + root) - half_square) * inverse * inverse};
  }
  double first() const { return invariants().first; }

  /// Ĩ₄ − 1 of a fibre, from its aᵀ A a: D^(−1/3) − 1 = −(1 − 1/D)/(1 + D^(−1/3) + D^(−2/3)).
  double along(double change) const {
    return change - volume_.excess / ((1 + volume_.excess) * (1 + root_ + root_ * root_)) * (1 + change);
  }

  /// ∂Ĩ₁/∂C = D^(−1/3) C⁻¹ dev C, D = det C.
  Components first_slope() const { return slope(1, 0); }
  /// ∂Ĩ₂/∂C = D^(−2/3) C⁻¹ dev(I₁ C − C²).
  Components second_slope() const { return slope(0, 1); }
  /// by_first ∂Ĩ₁/∂C + by_second ∂Ĩ₂/∂C.
  Components slope(double by_first, double by_second) const {
    const double first = by_first * root_, second = by_second * root_ * root_;
    if (second == 0)
      return commuting_product(inverse_, each_component([&](int row) { return first * deviator_[row]; }));
    const Components other = second_deviator();
    return commuting_product(inverse_,
                             each_component([&](int row) { return first * deviator_[row] + second * other[row]; }));
  }
  /// ∂Ĩ₄/∂C = D^(−1/3) (a aᵀ − I₄/3 C⁻¹), from a aᵀ and aᵀ A a.
  Components along_slope(const Components& aa, double change) const {
    const double share = (1 + change) / 3;
    return each_component([&](int row) { return root_ * (aa[row] - share * inverse_[row]); });
  }

  /// Each adds `factor` times the second slope by C.
  void add_first_curvature(double factor, TangentModuli<3>& result) const {
    add_curvature(factor, components(Matrix3::Identity()), 3 + trace_, result);
  }
  void add_along_curvature(double factor, const Components& aa, double change, TangentModuli<3>& result) const {
    add_curvature(factor, aa, 1 + change, result);
  }
  /// D^(−2/3) (I ⊗ I − I ⊙ I − ⅔ (M ⊗ G + G ⊗ M) + 4/9 I₂ G ⊗ G + ⅔ I₂ G ⊙ G),  M = I₁ I − C,  G = C⁻¹.
  void add_second_curvature(double factor, TangentModuli<3>& result) const {
    const double scale = factor * root_ * root_;
    const Components M = on_diagonal(-components(strain_), 2 + trace_);
    const double I2 = 3 + 2 * trace_ + (trace_ * trace_ - strain_.squaredNorm()) / 2;
    add_symmetric_squares(volume_.inverse, 4. / 9 * scale * I2, 2. / 3 * scale * I2, result);
    add_both_ways(-2. / 3 * scale, M, inverse_, result);
    result.topLeftCorner<3, 3>().array() += scale;
    result.diagonal().head<3>().array() -= scale;
    result.diagonal().tail<3>().array() -= scale / 2;
  }

 private:
  static constexpr double kLeast = 1e-30, kLeastEven = 1e-5;

  /// dev(I₁ C − C²) = dev(A − adj A)                                                      [Cayley & Hamilton]
  Components second_deviator() const {
    const Components adjugate = components(volume_.adjugate);
    return on_diagonal(each_component([&](int row) { return deviator_[row] - adjugate[row]; }),
                       volume_.adjugate.trace() / 3);
  }
  /// Of D^(−1/3) M:C: D^(−1/3) (M:C (G ⊗ G/9 + G ⊙ G/3) − ⅓ (M ⊗ G + G ⊗ M)).
  void add_curvature(double factor, const Components& M, double invariant, TangentModuli<3>& result) const {
    const double scale = factor * root_ / 3;
    add_symmetric_squares(volume_.inverse, scale * invariant / 3, scale * invariant, result);
    add_both_ways(-scale, M, inverse_, result);
  }

  const Matrix3& strain_;
  const Dilatation& volume_;
  Components deviator_, inverse_;  ///< dev A = dev C; C⁻¹
  double trace_, root_;            ///< of A; D^(−1/3)
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

  Matrix3 stress(const Strained& point) const {
    const Isochoric now(point);
    const Jet w = at(now);
    return tensor(now.slope(2 * w.x, 2 * w.y));
  }

  TangentModuli<3> tangent(const Strained& point) const {
    const Isochoric now(point);
    const Jet w = at(now);
    TangentModuli<3> result = TangentModuli<3>::Zero();
    now.add_first_curvature(2 * w.x, result);
    const bool by_first_alone = w.y == 0 && w.xy == 0 && w.yy == 0;
    if (!by_first_alone) now.add_second_curvature(2 * w.y, result);
    if (w.xx == 0 && w.xy == 0 && w.yy == 0) return result;
    const Components first = now.first_slope();
    add_square(2 * w.xx, first, result);
    if (by_first_alone) return result;
    const Components second = now.second_slope();
    add_both_ways(2 * w.xy, first, second, result);
    add_square(2 * w.yy, second, result);
    return result;
  }

  double energy(const Strained& point) const { return at(Isochoric(point)).value; }

 private:
  Jet at(const Isochoric& now) const {
    const auto [first, second] = now.invariants();
    return density(Jet::first(first), Jet::second(second));
  }
};

}  // namespace elastin
