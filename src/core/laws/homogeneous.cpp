#include "elastin/core/laws/homogeneous.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/laws/solids/components.h"
#include "elastin/core/base/dense.h"

namespace elastin {
namespace {

constexpr int k11 = 0, k22 = 1, k33 = 2, k12 = 3, k13 = 4, k23 = 5;  // rows of Components

/// Strain components of a test: those that it prescribes, and those whose stress vanishes.
struct Prescribed {
  Matrix3 strain;
  std::vector<int> free;
};

Prescribed prescribed(HomogeneousTest test, double amount) {
  const double change = amount * (2 + amount);
  Matrix3 A = Matrix3::Zero();
  switch (test) {
    case HomogeneousTest::uniaxial:
      A(0, 0) = change;
      return {A, {k22, k33, k12, k13, k23}};
    case HomogeneousTest::planar:
      A(0, 0) = change;
      return {A, {k33, k13, k23}};
    case HomogeneousTest::equibiaxial:
      A(0, 0) = A(1, 1) = change;
      return {A, {k33, k13, k23}};
    case HomogeneousTest::shear:
      A(0, 1) = A(1, 0) = amount, A(1, 1) = amount * amount;
      return {A, {}};
  }
  return {A, {}};
}

/// The law in the frame of the test, and its pressure where it is incompressible.
class TestedLaw {
 public:
  TestedLaw(const MaterialLaw& law, const Material& material, const Matrix3& axes)
      : shape_(law.shape(material)),
        incompressible_(!law.from_moduli && !material.law->numbers.contains("bulk_modulus")),
        axes_(axes) {
    if (!incompressible_) volume_ = law.solid(material).volume;
  }

  bool incompressible() const { return incompressible_; }
  double bulk_modulus() const { return volume_.modulus; }
  Matrix3 stress(const Matrix3& A, double pressure) const {
    const Matrix3 world = axes_ * A * axes_.transpose();
    const Matrix3 S = incompressible_ ? shape_.stress(world) : whole().stress(world);
    return axes_.transpose() * S * axes_ + pressure * Dilatation(A).inverse;
  }
  /// The change of S with a change of A at the same pressure.
  Matrix3 change(const Matrix3& A, double pressure, const Matrix3& of_A) const {
    const Matrix3 world = axes_ * A * axes_.transpose();
    Components strain = components(axes_ * of_A * axes_.transpose());
    strain.tail<3>() *= 2;
    const Components S = (incompressible_ ? shape_.tangent(world) : TangentModuli<3>(whole().tangent(world))) * strain;
    const Matrix3 G = Dilatation(A).inverse;
    return axes_.transpose() * tensor(S) * axes_ - pressure * G * of_A * G;
  }

  /// ∂τ_i/∂ln λ_j of the shape in the axes of C resists every change without a trace.
  bool stable(const Matrix3& A) const {
    const SymmetricEigen3 solved = symmetric_eigen3(axes_ * A * axes_.transpose());
    const Vector3 C = (1 + solved.values.array()).matrix();
    const Matrix3 S = solved.vectors.transpose() * shape_.stress(axes_ * A * axes_.transpose()) * solved.vectors;
    const TangentModuli<3> tangent = shape_.tangent(axes_ * A * axes_.transpose());
    Matrix3 D;
    for (int j = 0; j < 3; ++j) {
      const Components strain = symmetric_product(solved.vectors.col(j), solved.vectors.col(j));
      Components twice = strain;
      twice.tail<3>() *= 2;
      const Matrix3 change = solved.vectors.transpose() * tensor(tangent * twice) * solved.vectors;
      for (int i = 0; i < 3; ++i) D(i, j) = 2 * C[i] * C[j] * change(i, i) + (i == j ? 2 * S(i, i) * C[i] : 0);
    }
    Eigen::Matrix<double, 3, 2> traceless;
    traceless << std::sqrt(0.5), std::sqrt(1. / 6), -std::sqrt(0.5), std::sqrt(1. / 6), 0, -2 * std::sqrt(1. / 6);
    const Eigen::Matrix2d kept = traceless.transpose() * (D + D.transpose()) / 2 * traceless;
    return kept.trace() > 0 && kept.determinant() > 0;
  }

 private:
  SplitPoint<AnyPoint<3>> whole() const { return {shape_, volume_}; }

  AnyPoint<3> shape_;
  Volumetric volume_;
  bool incompressible_;
  Matrix3 axes_;
};

/// Newton's method for no stress where the test leaves the strain free, and, of an incompressible law, for det C = 1.
bool solve(const TestedLaw& law, const Prescribed& test, double stiffness, Matrix3& A, double& pressure) {
  const double rounding = 1e-14 * (1 + law.bulk_modulus() / stiffness);  // of stresses over the stiffness
  const int count = static_cast<int>(test.free.size()), unknowns = count + (law.incompressible() && count > 0 ? 1 : 0);
  // Stresses are judged as Kirchhoff's: S_ij √(C_ii C_jj), for S of a thin direction is large.
  const auto weight = [&](const Matrix3& at, int i) {
    const auto [row, column] = kComponents[test.free[static_cast<std::size_t>(i)]];
    return std::sqrt((1 + at(row, row)) * (1 + at(column, column))) / stiffness;
  };
  const auto residual = [&](const Matrix3& at, double p) {
    const Components S = components(law.stress(at, p));
    VectorX r(unknowns);
    for (int i = 0; i < count; ++i) r[i] = S[test.free[static_cast<std::size_t>(i)]] * weight(at, i);
    if (unknowns > count) r[count] = Dilatation::determinant_change(at);
    return r;
  };
  VectorX r = residual(A, pressure);
  for (int iteration = 0; iteration < 60 && unknowns > 0; ++iteration) {
    const double size = r.norm();
    MatrixX jacobian = MatrixX::Zero(unknowns, unknowns);
    const Matrix3 G = Dilatation(A).inverse;
    const double det_C = 1 + Dilatation::determinant_change(A);
    std::vector<Matrix3> directions;
    for (int j = 0; j < count; ++j) {
      const auto [row, column] = kComponents[test.free[static_cast<std::size_t>(j)]];
      Matrix3 direction = Matrix3::Zero();
      direction(row, column) = direction(column, row) = 1;
      const Components S = components(law.change(A, pressure, direction));
      for (int i = 0; i < count; ++i) jacobian(i, j) = S[test.free[static_cast<std::size_t>(i)]] * weight(A, i);
      if (unknowns > count) {
        jacobian(count, j) = det_C * G.cwiseProduct(direction).sum();
        jacobian(j, count) = components(G)[test.free[static_cast<std::size_t>(j)]] * weight(A, j) * stiffness;
      }
      directions.push_back(direction);
    }
    const VectorX step = least_squares(jacobian, -r);
    double fraction = 1;
    for (; fraction > 1e-4; fraction /= 2) {
      Matrix3 next = A;
      for (int j = 0; j < count; ++j) next += fraction * step[j] * directions[static_cast<std::size_t>(j)];
      const double next_pressure = pressure + (unknowns > count ? fraction * step[count] * stiffness : 0);
      if (Dilatation(next).flat || next.diagonal().minCoeff() <= -1) continue;
      const VectorX at = residual(next, next_pressure);
      // Volume first, shape then: on the way the residual may grow.
      if (!(at.norm() < (iteration < 20 ? 1e3 : 1) * size) && !(size < 10 * rounding)) continue;
      A = next, pressure = next_pressure, r = at;
      break;
    }
    if (!(fraction > 1e-4)) break;
    if (fraction == 1 && step.norm() < 1e-13 * (1 + A.norm() + std::abs(pressure) / stiffness)) break;
  }
  return r.size() == 0 || r.norm() < 1e-10 + 100 * rounding;
}

}  // namespace

const char* name_of(HomogeneousTest test) {
  switch (test) {
    case HomogeneousTest::uniaxial:
      return "uniaxial";
    case HomogeneousTest::planar:
      return "planar";
    case HomogeneousTest::equibiaxial:
      return "equibiaxial";
    case HomogeneousTest::shear:
      return "shear";
  }
  return "";
}

std::optional<HomogeneousState> homogeneous_state(const MaterialLaw& law, const Material& material,
                                                  HomogeneousTest test, double amount, const Matrix3& axes) {
  const TestedLaw tested(law, material, axes);
  const bool shear = test == HomogeneousTest::shear;
  if (!shear && !(amount > -1)) return std::nullopt;
  // Along ln λ, or the amount of shear: steps of at most 0.05, halved where Newton's method does not converge.
  const double end = shear ? amount : std::log1p(amount);
  Matrix3 A = Matrix3::Zero();
  double pressure = 0, reached = 0, step = std::copysign(0.05, end);
  while (reached != end) {
    const bool last = std::abs(end - reached) <= std::abs(step);
    const double next = last ? end : reached + step;
    const Prescribed given = prescribed(test, last ? amount : shear ? next : std::expm1(next));
    Matrix3 at = given.strain;
    for (const int free : given.free) {
      const auto [row, column] = kComponents[free];
      at(row, column) = at(column, row) = A(row, column);
    }
    double p = pressure;
    if (solve(tested, given, material.youngs_modulus, at, p)) {
      A = at, pressure = p, reached = next;
    } else {
      step /= 2;
      if (std::abs(step) < 1e-4) return std::nullopt;
    }
  }
  const Matrix3 S = tested.stress(A, pressure);
  Matrix3 F = Matrix3::Identity();
  F(0, 1) = amount;
  const double stress = shear ? (F * S * F.transpose())(0, 1) : (1 + amount) * S(0, 0);
  if (!std::isfinite(stress)) return std::nullopt;
  return HomogeneousState{stress, axes * A * axes.transpose(), tested.stable(A)};
}

}  // namespace elastin
