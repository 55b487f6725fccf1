#include "core/laws/homogeneous.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "core/base/dense.h"
#include "core/laws/solids/components.h"

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
      : shape_(law.shape(material)), incompressible_(is_incompressible(law, material)), axes_(axes) {
    if (incompressible_) return;
    volume_ = law.solid(material).volume;
    bulk_modulus_ = law.whole ? material.youngs_modulus / (3 * (1 - 2 * material.poissons_ratio)) : volume_.modulus;
  }

  bool incompressible() const { return incompressible_; }
  double bulk_modulus() const { return bulk_modulus_; }
  Matrix3 stress(const Matrix3& A, double pressure) const {
    const Matrix3 world = axes_ * A * axes_.transpose();
    const Matrix3 S = axes_.transpose() * (incompressible_ ? shape_.stress(world) : whole().stress(world)) * axes_;
    return pressure == 0 ? S : Matrix3(S + pressure * Dilatation(A).inverse);
  }

  /// What small changes make of S at one state, at the same pressure.
  class Tangent {
   public:
    Tangent(const TestedLaw& law, const Matrix3& A, double pressure)
        : axes_(law.axes_), inverse_(Dilatation(A).inverse), pressure_(pressure) {
      const Matrix3 world = axes_ * A * axes_.transpose();
      moduli_ = law.incompressible_ ? law.shape_.tangent(world) : TangentModuli<3>(law.whole().tangent(world));
    }
    Matrix3 change(const Matrix3& of_A) const {
      Components strain = components(axes_ * of_A * axes_.transpose());
      strain.tail<3>() *= 2;
      const Matrix3 by_volume = inverse_ * of_A * inverse_;
      return axes_.transpose() * tensor(moduli_ * strain) * axes_ - pressure_ * by_volume;
    }
    const Matrix3& inverse() const { return inverse_; }  ///< C⁻¹

   private:
    Matrix3 axes_, inverse_;
    double pressure_;
    TangentModuli<3> moduli_;
  };

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
  double bulk_modulus_ = 0;
  bool incompressible_;
  Matrix3 axes_;
};

/// What must vanish: the stresses where a test leaves the strain free, and, of an incompressible law, det C − 1. Its
/// unknowns are these strains and the pressure over the stiffness.
class Balance {
 public:
  Balance(const TestedLaw& law, const std::vector<int>& free, double stiffness)
      : law_(law), free_(free), stiffness_(stiffness) {}

  Eigen::Index strains() const { return static_cast<Eigen::Index>(free_.size()); }
  Eigen::Index unknowns() const { return strains() + (law_.incompressible() && !free_.empty() ? 1 : 0); }
  bool has_pressure() const { return unknowns() > strains(); }
  double rounding() const { return 1e-14 * (1 + law_.bulk_modulus() / stiffness_); }  // of stresses over the stiffness

  VectorX residual(const Matrix3& A, double pressure) const { return residual_of(A, law_.stress(A, pressure)); }
  /// Of a stress that is known.
  VectorX residual_of(const Matrix3& A, const Matrix3& stress) const {
    const Components S = components(stress);
    VectorX r(unknowns());
    for (Eigen::Index i = 0; i < strains(); ++i) r[i] = S[component(i)] * weight(A, i);
    if (has_pressure()) r[strains()] = Dilatation::determinant_change(A);
    return r;
  }

  TestedLaw::Tangent tangent(const Matrix3& A, double pressure) const { return {law_, A, pressure}; }
  MatrixX jacobian(const Matrix3& A, const TestedLaw::Tangent& tangent) const {
    MatrixX result = MatrixX::Zero(unknowns(), unknowns());
    const Matrix3& G = tangent.inverse();
    const double det_C = 1 + Dilatation::determinant_change(A);
    for (Eigen::Index j = 0; j < strains(); ++j) {
      const Components S = components(tangent.change(direction(j)));
      for (Eigen::Index i = 0; i < strains(); ++i) result(i, j) = S[component(i)] * weight(A, i);
      if (!has_pressure()) continue;
      result(strains(), j) = det_C * G.cwiseProduct(direction(j)).sum();
      result(j, strains()) = components(G)[component(j)] * weight(A, j) * stiffness_;
    }
    return result;
  }

  /// How S changes with each unknown, its component 11.
  VectorX stress_changes(const TestedLaw::Tangent& tangent) const {
    VectorX changes(unknowns());
    for (Eigen::Index j = 0; j < strains(); ++j) changes[j] = tangent.change(direction(j))(0, 0);
    if (has_pressure()) changes[strains()] = tangent.inverse()(0, 0) * stiffness_;
    return changes;
  }

  void move(const VectorX& step, Matrix3& A, double& pressure) const {
    for (Eigen::Index j = 0; j < strains(); ++j) A += step[j] * direction(j);
    if (has_pressure()) pressure += step[strains()] * stiffness_;
  }

 private:
  int component(Eigen::Index unknown) const { return free_[unknown]; }
  Matrix3 direction(Eigen::Index unknown) const {
    const auto [row, column] = kComponents[component(unknown)];
    Matrix3 result = Matrix3::Zero();
    result(row, column) = result(column, row) = 1;
    return result;
  }
  /// Stresses are judged as Kirchhoff's: S_ij √(C_ii C_jj), for S of a thin direction is large.
  double weight(const Matrix3& A, Eigen::Index unknown) const {
    const auto [row, column] = kComponents[component(unknown)];
    return std::sqrt((1 + A(row, row)) * (1 + A(column, column))) / stiffness_;
  }

  const TestedLaw& law_;
  const std::vector<int>& free_;
  double stiffness_;
};

/// Newton's method.
bool solve(const Balance& balance, Matrix3& A, double& pressure) {
  const double rounding = balance.rounding();
  VectorX r = balance.residual(A, pressure);
  for (int iteration = 0; iteration < 60 && r.size() > 0; ++iteration) {
    const double size = r.norm();
    const VectorX step = least_squares(balance.jacobian(A, balance.tangent(A, pressure)), -r);
    double fraction = 1;
    for (; fraction > 1e-4; fraction /= 2) {
      Matrix3 next = A;
      double next_pressure = pressure;
      balance.move(fraction * step, next, next_pressure);
      if (Dilatation(next).flat || next.diagonal().minCoeff() <= -1) continue;
      const VectorX at = balance.residual(next, next_pressure);
      // Volume first, shape then: in between the residual may grow.
      if (!(at.norm() < (iteration < 20 ? 1e3 : 1) * size) && !(size < 10 * rounding)) continue;
      A = next, pressure = next_pressure, r = at;
      break;
    }
    if (!(fraction > 1e-4)) break;
    if (fraction == 1 && step.norm() < 1e-13 * (1 + A.norm())) break;
  }
  return r.size() == 0 || r.norm() < 1e-10 + 100 * rounding;
}

/// The states of one material in one test, one after the other from rest.
class Path {
 public:
  Path(const MaterialLaw& law, const Material& material, HomogeneousTest test, const Matrix3& axes)
      : law_(law, material, axes), test_(test), stiffness_(material.youngs_modulus), axes_(axes) {}

  /// Goes on to an amount that is farther from rest than the last one, on the same side of it: along ln λ, or the
  /// amount of shear, in steps of at most 0.05, halved where Newton's method does not converge. False where there is no
  /// equilibrium on the way.
  bool advance(double amount) {
    if (!sheared() && !(amount > -1)) return false;
    amount_ = amount;
    if (isotropic_state()) return true;
    const double end = sheared() ? amount : std::log1p(amount);
    double step = std::copysign(0.05, end);
    while (reached_ != end) {
      const bool last = std::abs(end - reached_) <= std::abs(step);
      const double next = last ? end : reached_ + step;
      const Prescribed given = prescribed(test_, last ? amount : sheared() ? next : std::expm1(next));
      Matrix3 at = given.strain;
      for (const int free : given.free) {
        const auto [row, column] = kComponents[free];
        at(row, column) = at(column, row) = A_(row, column);
      }
      double pressure = pressure_;
      if (solve(Balance(law_, given.free, stiffness_), at, pressure)) {
        A_ = at, pressure_ = pressure, reached_ = next;
      } else {
        step /= 2;
        if (std::abs(step) < 1e-4) return false;
      }
    }
    return true;
  }

  double stress() const { return nominal(law_.stress(A_, pressure_)); }
  bool stable() const { return law_.stable(A_); }
  Matrix3 strain() const { return axes_ * A_ * axes_.transpose(); }

  /// The change of the stress with a number of the material: at the state that is kept, and by the change of that
  /// state, dz = −(∂r/∂z)⁻¹ ∂r/∂θ. One solve for all numbers: ∂σ/∂z · dz = −λ · ∂r/∂θ, (∂r/∂z)ᵀ λ = ∂σ/∂z.
  VectorX slopes(const std::vector<std::vector<TestedLaw>>& changed, const std::vector<MaterialChange>& changes) const {
    const Prescribed given = prescribed(test_, amount_);
    const Balance own(law_, given.free, stiffness_);
    VectorX result = VectorX::Zero(static_cast<Eigen::Index>(changes.size()));
    if (changes.empty()) return result;
    VectorX by_residual(own.unknowns());
    if (own.unknowns() > 0) {
      const TestedLaw::Tangent tangent = own.tangent(A_, pressure_);
      by_residual = -least_squares(own.jacobian(A_, tangent).transpose(), (1 + amount_) * own.stress_changes(tangent));
    }
    for (std::size_t change = 0; change < changes.size(); ++change) {
      for (std::size_t i = 0; i < changed[change].size(); ++i) {
        const double weight = changes[change].weights[i];
        const Matrix3 S = changed[change][i].stress(A_, pressure_);
        result[static_cast<Eigen::Index>(change)] += weight * (nominal(S) + by_residual.dot(own.residual_of(A_, S)));
      }
    }
    return result;
  }

 private:
  bool sheared() const { return test_ == HomogeneousTest::shear; }

  /// Of an incompressible law that is isotropic the state is known; any other leaves a residual there.
  bool isotropic_state() {
    if (!law_.incompressible()) return false;
    Prescribed given = prescribed(test_, amount_);
    const double C = 1 + given.strain(0, 0);
    if (test_ == HomogeneousTest::uniaxial) given.strain(k22, k22) = given.strain(k33, k33) = 1 / std::sqrt(C) - 1;
    if (test_ == HomogeneousTest::planar) given.strain(k33, k33) = 1 / C - 1;
    if (test_ == HomogeneousTest::equibiaxial) given.strain(k33, k33) = 1 / (C * C) - 1;
    const Matrix3 inverse = Dilatation(given.strain).inverse;
    Matrix3 S = law_.stress(given.strain, 0);
    const double pressure = given.free.empty() ? 0 : -S(2, 2) / inverse(2, 2);
    S += pressure * inverse;
    const double size = C * std::abs(S(0, 0)) / stiffness_;
    const VectorX residual = Balance(law_, given.free, stiffness_).residual_of(given.strain, S);
    if (!(residual.norm() < 1e-13 * (1 + size))) return false;
    A_ = given.strain, pressure_ = pressure, reached_ = sheared() ? amount_ : std::log1p(amount_);
    return true;
  }

  double nominal(const Matrix3& S) const { return sheared() ? S(0, 1) + amount_ * S(1, 1) : (1 + amount_) * S(0, 0); }

  TestedLaw law_;
  HomogeneousTest test_;
  double stiffness_;
  Matrix3 axes_, A_ = Matrix3::Zero();
  double pressure_ = 0, reached_ = 0, amount_ = 0;
};

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
  Path path(law, material, test, axes);
  if (!path.advance(amount) || !std::isfinite(path.stress())) return std::nullopt;
  return HomogeneousState{path.stress(), path.strain(), path.stable()};
}

std::optional<HomogeneousStresses> homogeneous_stresses(const MaterialLaw& law, const Material& material,
                                                        HomogeneousTest test, const VectorX& amounts,
                                                        const std::vector<MaterialChange>& changes,
                                                        const Matrix3& axes) {
  std::vector<std::vector<TestedLaw>> changed(changes.size());
  for (std::size_t change = 0; change < changes.size(); ++change)
    for (const Material& other : changes[change].materials) changed[change].emplace_back(law, other, axes);
  std::vector<Eigen::Index> order(amounts.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](auto a, auto b) { return std::abs(amounts[a]) < std::abs(amounts[b]); });
  HomogeneousStresses result{VectorX(amounts.size()),
                             MatrixX(amounts.size(), static_cast<Eigen::Index>(changes.size()))};
  Path stretched(law, material, test, axes), pressed = stretched;
  for (const Eigen::Index i : order) {
    Path& path = amounts[i] < 0 ? pressed : stretched;
    if (!path.advance(amounts[i])) return std::nullopt;
    result.stresses[i] = path.stress();
    result.slopes.row(i) = path.slopes(changed, changes).transpose();
  }
  if (!result.stresses.allFinite() || !result.slopes.allFinite()) return std::nullopt;
  return result;
}

}  // namespace elastin
