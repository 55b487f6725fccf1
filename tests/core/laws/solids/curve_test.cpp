#include "core/laws/solids/curve.h"

#include <catch2/catch.hpp>
#include <random>

#include "core/base/dense.h"
#include "core/laws/solids/fibre.h"
#include "elastin/core/shapes/simplices.h"

using namespace elastin;

using CurveSolid = CellKernel<Curve, Tetrahedron4>;
using Fibres = CellKernel<FibreLaw, Tetrahedron4>;

static_assert(LengthKernel<CurveSolid> && HasEnergy<CurveSolid>);
static_assert(LengthKernel<Fibres> && HasEnergy<Fibres>);

namespace {

using CornerPositions = Eigen::Matrix<double, 3, 4>;

const CornerPositions kCell =
    (CornerPositions() << 0, 0.011, 0.002, 0.003, 0, 0.001, 0.009, 0.002, 0, -0.001, 0.001, 0.008).finished();

CellVector<4> squared_lengths(const CornerPositions& positions) {
  CellVector<4> s;
  int side = 0;
  for (const auto& [a, b] : node_pairs<4>()) s[side++] = (positions.col(b) - positions.col(a)).squaredNorm();
  return s;
}

/// First Piola–Kirchhoff stress [Pa] of the cell under x = F X, from the forces on its corners alone.
template <class Law>
Matrix3 nominal_stress(const typename Law::Constants& k, const Matrix3& F) {
  const CornerPositions positions = F * kCell;
  const CellVector<4> q = Law{}.force_densities(k, squared_lengths(positions));
  CornerPositions f = CornerPositions::Zero();
  int side = 0;
  for (const auto& [a, b] : node_pairs<4>()) {
    const Vector3 pull = q[side++] * (positions.col(b) - positions.col(a));
    f.col(a) += pull;
    f.col(b) -= pull;
  }
  const Matrix3 edges = kCell.rightCols<3>().colwise() - kCell.col(0);
  return -f.rightCols<3>() * edges.transpose() / (std::abs(edges.determinant()) / 6);
}

Material with_curve(const StressStrain& curve, double nu) {
  Material material;
  material.youngs_modulus = curve.modulus(0);
  material.poissons_ratio = nu;
  material.curve = curve;
  return material;
}

const std::vector<StressStrain> kCurves{
    StressStrain::linear(5e3), StressStrain::toe(0.03, 1e4, 3e5), StressStrain::bilinear(1e4, 4e4, 1e-3),
    StressStrain::through({{-0.4, -900}, {-0.2, -700}, {-0.05, -300}, {0, 0}, {0.1, 100}, {0.2, 400}, {0.5, 3000}})};

Matrix3 random_matrix(std::mt19937_64& generator) {
  return Matrix3::NullaryExpr([&] { return static_cast<double>(generator() >> 11) * 0x1p-52 - 1; });
}

Matrix3 turn() { return Eigen::AngleAxisd(0.8, Vector3(1, -2, 0.5).normalized()).toRotationMatrix(); }

template <class Law>
void check_derivatives(const typename Law::Constants& k, std::mt19937_64& generator) {
  for (int trial = 0; trial < 60; ++trial) {
    const Matrix3 F = Matrix3::Identity() + (trial % 2 ? 0.3 : 0.01) * random_matrix(generator);
    const CellVector<4> s = squared_lengths(F * kCell), q = Law{}.force_densities(k, s);
    const CellMatrix<4> slope = Law{}.slope(k, s);
    for (int c = 0; c < 6; ++c) {
      CellVector<4> step = CellVector<4>::Zero();
      step[c] = 1e-6 * s.minCoeff();
      const auto energy = [&](double times) { return Law{}.energy(k, s + times * step); };
      const double difference = (8 * (energy(1) - energy(-1)) - energy(2) + energy(-2)) / (12 * step[c]);
      // Rounding of the energy over the step: 1e-16/1e-6, times the cell's thinness and the curve's bends.
      CHECK(std::abs(2 * difference - q[c]) < 1e-5 * q.norm() + 1e-9 * slope.norm() * s.norm());
      const CellVector<4> change =
          (Law{}.force_densities(k, s + step) - Law{}.force_densities(k, s - step)) / (2 * step[c]);
      CHECK((change - slope.col(c)).norm() < 1e-5 * slope.norm());
    }
  }
}

}  // namespace

TEST_CASE("curve: uniaxial stress is the given curve, with nu at every strain", "[cell_law][curve]") {
  const double nu = GENERATE(-0.2, 0., 0.25, 0.45, 0.499);
  for (const StressStrain& curve : kCurves) {
    const auto k = CurveSolid{}.constants(kCell, with_curve(curve, nu));
    for (const double strain : {-0.45, -0.2, -0.05, -1e-3, -1e-6, 1e-6, 1e-3, 0.01, 0.03, 0.1, 0.4, 1.}) {
      const double across = 1 - nu * strain;
      const Matrix3 F = Vector3(across, across, 1 + strain).asDiagonal();
      const Matrix3 P = turn().transpose() * nominal_stress<CurveSolid>(k, turn() * F);
      INFO("nu " << nu << ", strain " << strain);
      // What rounding of the squared lengths does to the strain, 1e-15 or so, is seen by the stiffest modulus.
      const double tolerance = 1e-10 * std::abs(curve.stress(strain)) + 1e-13 * 4e5 / (1 - 2 * nu);
      CHECK(std::abs(P(2, 2) - curve.stress(strain)) < tolerance);
      CHECK(std::abs(P(0, 0)) < tolerance);
      CHECK(std::abs(P(1, 1)) < tolerance);
      CHECK(std::abs(P(0, 2)) < tolerance);
    }
  }
}

TEST_CASE("curve: q is twice the slope of the energy, and its slope its own", "[cell_law][curve]") {
  const double nu = GENERATE(-0.2, 0.25, 0.45);
  std::mt19937_64 generator(3);
  for (const StressStrain& curve : kCurves)
    check_derivatives<CurveSolid>(CurveSolid{}.constants(kCell, with_curve(curve, nu)), generator);
}

TEST_CASE("curve: equal stretches are no special case", "[cell_law][curve]") {
  const auto k = CurveSolid{}.constants(kCell, with_curve(kCurves[1], 0.3));
  for (const Vector3& stretch : {Vector3(1, 1, 1), Vector3(1.1, 1.1, 1.1), Vector3(0.9, 0.9, 1.3)}) {
    const Matrix3 F = turn() * stretch.asDiagonal() * turn().transpose();
    const CellVector<4> s = squared_lengths(F * kCell);
    // Another one that differs by less than the slope can show, but whose stretches are not equal.
    const Matrix3 near = F + 1e-11 * (Matrix3() << 1, 2, 0, -1, 0.5, 3, 0, 1, -2).finished();
    const CellMatrix<4> slope = CurveSolid{}.slope(k, s), other = CurveSolid{}.slope(k, squared_lengths(near * kCell));
    CHECK(slope.allFinite());
    CHECK((slope - other).norm() < 1e-6 * slope.norm());
  }
}

TEST_CASE("curve: straight, it is Hooke's law in the frame that turns with the cell", "[cell_law][curve]") {
  constexpr double E = 5e3, nu = 0.3, lambda = E * nu / ((1 + nu) * (1 - 2 * nu)), mu = E / (2 * (1 + nu));
  Material material;
  material.youngs_modulus = E;
  material.poissons_ratio = nu;
  const auto k = CurveSolid{}.constants(kCell, material);
  std::mt19937_64 generator(4);
  for (int trial = 0; trial < 50; ++trial) {
    const Matrix3 F = turn() * (Matrix3::Identity() + 0.3 * random_matrix(generator));
    const SymmetricEigen3 squares = symmetric_eigen3(F.transpose() * F);  // R = F (FᵀF)^-½
    const Matrix3 inverse =
        squares.vectors * squares.values.cwiseSqrt().cwiseInverse().asDiagonal() * squares.vectors.transpose();
    const Matrix3 R = F * inverse, strain = R.transpose() * F - Matrix3::Identity();
    const Matrix3 P = R * (lambda * strain.trace() * Matrix3::Identity() + 2 * mu * strain);
    CHECK((nominal_stress<CurveSolid>(k, F) - P).norm() < 1e-10 * P.norm());
  }
}

TEST_CASE("curve: stays finite on a flat cell", "[cell_law][curve]") {
  for (const StressStrain& curve : kCurves) {
    const auto k = CurveSolid{}.constants(kCell, with_curve(curve, 0.3));
    const Matrix3 flat = turn() * Vector3(1, 1, 0).asDiagonal() * turn().transpose();
    for (const Matrix3& F : {flat, Matrix3(Matrix3::Zero())}) {
      const CellVector<4> s = squared_lengths(F * kCell);
      CHECK(CurveSolid{}.force_densities(k, s).allFinite());
      CHECK(CurveSolid{}.slope(k, s).allFinite());
      CHECK(std::isfinite(CurveSolid{}.energy(k, s)));
    }
  }
}

TEST_CASE("fibres add their nominal stress along their direction", "[cell_law][fibre]") {
  std::mt19937_64 generator(5);
  for (const StressStrain& curve : kCurves) {
    Material material;
    material.fibre = Fibre{Vector3(2, -1, 2) / 3, curve};
    const Vector3 a = material.fibre->direction;
    const auto k = Fibres{}.constants(kCell, material);
    for (int trial = 0; trial < 30; ++trial) {
      const Matrix3 F = turn() * (Matrix3::Identity() + 0.3 * random_matrix(generator));
      const double stretch = (F * a).norm();
      // The fibres pull with ψ′ along the turned direction, per section of the whole across a.
      const Matrix3 P = curve.stress(stretch - 1) * (F * a).normalized() * a.transpose();
      CHECK((nominal_stress<Fibres>(k, F) - P).norm() < 1e-10 * (P.norm() + curve.modulus(0)));
    }
    check_derivatives<Fibres>(k, generator);
  }
}
