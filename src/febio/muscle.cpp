#include "febio/muscle.h"

#include <algorithm>
#include <cmath>

#include "core/laws/solids/components.h"

namespace elastin::febio {
namespace {

Jet3 scaled(const Jet3& a, double factor) { return a.through(factor * a.value, factor, 0); }
Jet3 sum(const Jet3& a, const Jet3& b) { return Jet3::through(a, b, a.value + b.value, 1, 1, 0, 0, 0); }
Jet3 product(const Jet3& a, const Jet3& b) { return Jet3::through(a, b, a.value * b.value, b.value, a.value, 0, 1, 0); }
Jet3 power(const Jet3& a, double exponent) {
  const double value = std::pow(a.value, exponent), slope = exponent * value / a.value;
  return a.through(value, slope, (exponent - 1) * slope / a.value);
}

/// acosh² w, which is smooth at w = 1: 2 Σ (−1)^(n + 1) (2 (w − 1))ⁿ/(n² (2n over n)). No invariants have w < 1.
Jet3 square_of_acosh(const Jet3& w) {
  const double s = w.value - 1;
  if (s < 0.05) {
    double value = 0, slope = 0, curvature = 0, coefficient = -2;  // 2 (−1)^(n + 1) 2ⁿ/(2n over n)
    for (int n = 1; n <= 14; ++n) {
      coefficient *= -2. * n / (2 * (2 * n - 1));
      value += coefficient / (n * n) * std::pow(s, n);
      slope += coefficient / n * std::pow(s, n - 1);
      if (n > 1) curvature += coefficient * (n - 1) / n * std::pow(s, n - 2);
    }
    return w.through(value, slope, curvature);
  }
  const double square = s * (s + 2), ratio = std::acosh(w.value) / std::sqrt(square);
  return w.through(ratio * ratio * square, 2 * ratio, 2 * (1 - w.value * ratio) / square);
}

}  // namespace

Muscle::Force Muscle::passive_force(double x) const {
  if (x <= 1) return {0, 0, 0};
  const double toe = std::min(x, straight) - 1, rest = x - 1 - toe, grown = std::expm1(rate * toe);
  const double value = passive * grown, slope = passive * rate * (grown + 1);
  const double integral = passive * (rate > 0 ? grown / rate - toe : 0);
  return {integral + rest * (value + rest / 2 * slope), value + rest * slope, slope};
}

Muscle::Force Muscle::active_force(double x) {
  if (x <= 0.4) return {0, 0, 0};
  if (x <= 0.6) return {3 * std::pow(x - 0.4, 3), 9 * std::pow(x - 0.4, 2), 18 * (x - 0.4)};
  const double rising = 0.024;
  if (x <= 1.4)
    return {rising + x - 0.6 - 4. / 3 * (std::pow(x - 1, 3) + 0.064), 1 - 4 * std::pow(1 - x, 2), 8 * (1 - x)};
  const double upper = rising + 0.8 - 4. / 3 * 0.128, below = std::min(x - 1.6, 0.);
  return {upper + 3 * (std::pow(below, 3) + 0.008), 9 * below * below, 18 * below};
}

/// ψ with its slopes by C̃, from which those by C follow:                                [Holzapfel 2000, eq. 6.90 f.]
///   S = 2 r (P − ⅓ (P:C) G),  P = ∂ψ/∂C̃,  r = J^(−2/3),  G = C⁻¹.
struct Muscle::Present {
  Matrix3 C;   ///< C̃
  Vector3 Ca;  ///< C̃ a
  Matrix3 G;   ///< C⁻¹
  double r;
  Jet3 psi;                  ///< by Ĩ₁, Ĩ₄, Ĩ₅
  Components fourth, fifth;  ///< ∂Ĩ₄/∂C̃, ∂Ĩ₅/∂C̃
  Components P;

  Present(const Muscle& law, const Strained& point) : G(point.volume.inverse), r(point.root) {
    C = r * (Matrix3::Identity() + point.A);
    Ca = C * law.direction;
    const Jet3 I1 = Jet3::variable(C.trace(), 0), I4 = Jet3::variable(std::max(law.direction.dot(Ca), 1e-12), 1),
               I5 = Jet3::variable(Ca.squaredNorm(), 2);
    const Jet3 root = power(I4, 0.5), inverse_root = power(I4, -0.5);
    const Jet3 w = scaled(product(sum(product(I1, I4), scaled(I5, -1)), inverse_root), 0.5);
    const double x = root.value / law.optimal, log_I4 = std::log(I4.value);
    const Force passive = law.passive_force(x), active = active_force(x);
    psi = sum(scaled(product(I5, power(I4, -2)), law.along), scaled(square_of_acosh(w), law.across));
    psi = sum(psi,
              root.through(law.peak * (passive.integral + law.activation * active.integral),
                           law.peak / law.optimal * (passive.value + law.activation * active.value),
                           law.peak / (law.optimal * law.optimal) * (passive.slope + law.activation * active.slope)));
    const double ratio = 9. / 8 * law.matrix / I4.value;
    psi = sum(psi, I4.through(9. / 16 * law.matrix * log_I4 * log_I4, ratio * log_I4, ratio / I4.value * (1 - log_I4)));
    psi.value -= law.along;
    fourth = symmetric_product(law.direction, law.direction);
    fifth = 2 * symmetric_product(law.direction, Ca);
    P = psi.slope[0] * unit() + psi.slope[1] * fourth + psi.slope[2] * fifth;
  }
  static Components unit() { return components(Matrix3::Identity()); }
};

Matrix3 Muscle::stress(const Strained& point) const {
  const Present now(*this, point);
  // Of C̃ = r C: P:C G = P:C̃ G/r.
  return 2 * now.r * tensor(now.P) - 2. / 3 * double_product(now.P, now.C) * now.G;
}

TangentModuli<3> Muscle::tangent(const Strained& point) const {
  const Present now(*this, point);
  const std::array<Components, 3> slopes{Present::unit(), now.fourth, now.fifth};
  TangentModuli<3> Q = TangentModuli<3>::Zero();  // ∂²ψ/∂C̃²
  for (std::size_t p = 0; p < 6; ++p) {
    const auto i = static_cast<std::size_t>(Jet3::pairs[p][0]), j = static_cast<std::size_t>(Jet3::pairs[p][1]);
    if (i == j)
      Q += now.psi.curvature[p] * slopes[i] * slopes[i].transpose();
    else
      Q += now.psi.curvature[p] * both_ways(slopes[i], slopes[j]);
  }
  // ∂²Ĩ₅/∂C̃² sends dC to a (dC a)ᵀ + (dC a) aᵀ: a column for each component that changes.
  for (int column = 0; column < 6; ++column) {
    Components one = Components::Zero();
    one[column] = column < 3 ? 1 : 0.5;
    Q.col(column) += 2 * now.psi.slope[2] * symmetric_product(direction, tensor(one) * direction);
  }
  Components doubled = components(now.C);
  doubled.tail<3>() *= 2;
  const Components QC = Q * doubled, G = components(now.G);
  const double PC = double_product(now.P, now.C);
  TangentModuli<3> result = 2 * now.r * now.r * Q - 2. / 3 * now.r * both_ways(Components(QC + now.P), G);
  add_symmetric_squares(now.G, 2. / 9 * (doubled.dot(QC) + PC), 2. / 3 * PC, result);
  return result;
}

double Muscle::energy(const Strained& point) const { return Present(*this, point).psi.value; }

}  // namespace elastin::febio
