#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "core/laws/membranes/two_parameter.h"
#include "core/laws/solids/neo_hookean.h"
#include "core/laws/solids/st_venant_kirchhoff.h"
#include "elastin/core/base/error.h"
#include "elastin/core/simulation/catalog.h"
#include "support/cells.h"

using namespace elastin;
using namespace elastin::testing;

using StVenantKirchhoffSolid = OnTetrahedron<StVenantKirchhoff>;
using StVenantKirchhoffMembrane = OnTriangle<StVenantKirchhoff>;
using NeoHookeanSolid = OnTetrahedron<NeoHookean>;

static_assert(LengthKernel<StVenantKirchhoffSolid> && HasEnergy<StVenantKirchhoffSolid>);
static_assert(LengthKernel<StVenantKirchhoffMembrane> && HasEnergy<StVenantKirchhoffMembrane>);
static_assert(LengthKernel<NeoHookeanSolid> && HasEnergy<NeoHookeanSolid>);
static_assert(LengthLaw<TwoParameter> && !HasEnergy<TwoParameter>);

namespace {

Matrix3 edges(const CornerPositions<4>& positions) { return positions.rightCols<3>().colwise() - positions.col(0); }

/// Second Piola–Kirchhoff stress [Pa] from the deformation gradient.
Matrix3 textbook_stress(StVenantKirchhoffSolid, const Matrix3& F, double lambda, double mu) {
  const Matrix3 strain = (F.transpose() * F - Matrix3::Identity()) / 2;
  return lambda * strain.trace() * Matrix3::Identity() + 2 * mu * strain;
}
Matrix3 textbook_stress(NeoHookeanSolid, const Matrix3& F, double lambda, double mu) {
  const Matrix3 inverse = (F.transpose() * F).inverse();
  const double J = F.determinant();
  return lambda * J * (J - 1) * inverse + mu * (Matrix3::Identity() - inverse);
}

/// Linear plane-stress forces of a triangle [N] by its strain-displacement matrix: f = −t T Bᵀ D B u, in its own plane.
CornerPositions<3> plane_stress_forces(const CornerPositions<3>& rest, const CornerPositions<3>& displacement,
                                       const Material& material) {
  const Vector3 normal = (rest.col(1) - rest.col(0)).cross(rest.col(2) - rest.col(0));
  const Vector3 x = (rest.col(1) - rest.col(0)).normalized(), y = normal.normalized().cross(x);
  Eigen::Matrix<double, 3, 2> frame;
  frame << x, y;
  const Eigen::Matrix<double, 2, 3> position = frame.transpose() * rest, moved = frame.transpose() * displacement;
  const double T = normal.norm() / 2;
  Eigen::Matrix<double, 3, 6> B = Eigen::Matrix<double, 3, 6>::Zero();
  for (int a = 0; a < 3; ++a) {
    const Eigen::Vector2d across = position.col((a + 2) % 3) - position.col((a + 1) % 3);
    B(0, 2 * a) = B(2, 2 * a + 1) = -across.y() / (2 * T);
    B(1, 2 * a + 1) = B(2, 2 * a) = across.x() / (2 * T);
  }
  const double nu = material.poissons_ratio;
  Matrix3 D;
  D << 1, nu, 0, nu, 1, 0, 0, 0, (1 - nu) / 2;
  D *= material.youngs_modulus / (1 - nu * nu);
  const Eigen::Matrix<double, 6, 1> f =
      -material.thickness * T * B.transpose() * D * B * Eigen::Map<const Eigen::Matrix<double, 6, 1>>(moved.data());
  return frame * Eigen::Map<const Eigen::Matrix<double, 2, 3>>(f.data());
}

}  // namespace

TEMPLATE_TEST_CASE("a cell law's q is twice the slope of its energy", "[cell_law]", StVenantKirchhoffSolid,
                   StVenantKirchhoffMembrane, NeoHookeanSolid) {
  constexpr int corners = TestType::Shape::nodes;
  const double nu = GENERATE(-0.3, 0., 0.3, 0.45);
  Random random(1);
  for (int trial = 0; trial < 50; ++trial) {
    const CornerPositions<corners> rest = random_cell<corners>(random);
    const auto k = TestType{}.constants(rest, material_of(5000, nu));
    const CellVector<corners> s = squared_lengths<corners>(random_deformation(random) * rest);
    const CellVector<corners> q = TestType{}.force_densities(k, s);
    for (int c = 0; c < s.size(); ++c) {
      CellVector<corners> step = CellVector<corners>::Zero();
      step[c] = 1e-5 * s.minCoeff();
      const double difference = (TestType{}.energy(k, s + step) - TestType{}.energy(k, s - step)) / (2 * step[c]);
      // Central differences: step² ~ 1e-10 of truncation, 1e-16/step ~ 1e-11 of rounding, times the cell's thinness.
      CHECK(std::abs(2 * difference - q[c]) < 1e-6 * q.norm());
    }
  }
}

TEMPLATE_TEST_CASE("a cell law's slope is the slope of its q", "[cell_law]", StVenantKirchhoffSolid,
                   StVenantKirchhoffMembrane, NeoHookeanSolid, TwoParameter) {
  constexpr int corners = TestType::Shape::nodes;
  const double nu = GENERATE(-0.3, 0., 0.3, 0.45);
  Random random(2);
  for (int trial = 0; trial < 50; ++trial) {
    const CornerPositions<corners> rest = random_cell<corners>(random);
    const auto k = TestType{}.constants(rest, material_of(5000, nu));
    const CellVector<corners> s = squared_lengths<corners>(random_deformation(random) * rest);
    const CellMatrix<corners> slope = TestType{}.slope(k, s);
    for (int c = 0; c < s.size(); ++c) {
      CellVector<corners> step = CellVector<corners>::Zero();
      step[c] = 1e-5 * s.minCoeff();
      const CellVector<corners> difference =
          (TestType{}.force_densities(k, s + step) - TestType{}.force_densities(k, s - step)) / (2 * step[c]);
      CHECK((difference - slope.col(c)).norm() < 1e-6 * slope.norm());
    }
  }
}

TEMPLATE_TEST_CASE("a law of tetrahedra is the finite element", "[cell_law]", StVenantKirchhoffSolid, NeoHookeanSolid) {
  constexpr double E = 5000;
  const double nu = GENERATE(-0.3, 0., 0.3, 0.45);
  const double lambda = E * nu / ((1 + nu) * (1 - 2 * nu)), mu = E / (2 * (1 + nu));
  Random random(3);
  for (int trial = 0; trial < 200; ++trial) {
    const CornerPositions<4> rest = random_cell<4>(random);
    const CornerPositions<4> positions = (random_deformation(random) * rest).colwise() + random.matrix<3, 1>();
    const Matrix3 D_m = edges(rest), F = edges(positions) * D_m.inverse();
    const double volume = std::abs(D_m.determinant()) / 6;
    const Matrix3 P = F * textbook_stress(TestType{}, F, lambda, mu);
    const Matrix3 H = -volume * P * D_m.inverse().transpose();

    const auto k = TestType{}.constants(rest, material_of(E, nu));
    const CornerPositions<4> f = forces<4>(positions, TestType{}.force_densities(k, squared_lengths<4>(positions)));
    // Rounding of a stress on a face; places are up to 1 m from the origin, 200 times a cell, hence not smaller.
    CHECK((f.rightCols<3>() - H).norm() < 1e-12 * 200 * std::max(H.norm(), E * std::pow(volume, 2. / 3)));
    CHECK((f.col(0) + H.rowwise().sum()).norm() < 1e-12 * 200 * std::max(H.norm(), E * std::pow(volume, 2. / 3)));
  }
}

TEMPLATE_TEST_CASE("a rigid motion leaves a cell without force", "[cell_law]", StVenantKirchhoffSolid,
                   StVenantKirchhoffMembrane, NeoHookeanSolid, TwoParameter) {
  constexpr int corners = TestType::Shape::nodes;
  Random random(4);
  for (int trial = 0; trial < 100; ++trial) {
    const CornerPositions<corners> rest = random_cell<corners>(random);
    const auto k = TestType{}.constants(rest, material_of(5000, 0.3));
    const CornerPositions<corners> positions = (random.rotation() * rest).colwise() + 0.01 * random.matrix<3, 1>();
    const CellVector<corners> s = squared_lengths<corners>(positions);
    // Against what lengthening every connection by a tenth gives.
    const double scale = TestType{}.force_densities(k, 1.21 * s).norm();
    CHECK(TestType{}.force_densities(k, s).norm() < 1e-12 * scale);
    if constexpr (HasEnergy<TestType>) CHECK(std::abs(TestType{}.energy(k, s)) < 1e-12 * scale * s.maxCoeff());
  }
}

TEST_CASE("neo-Hookean uniaxial tension", "[cell_law]") {
  // [L03]: E = 1, nominal stress and lateral stretch to the printed digits.
  const auto [nu, stretch, nominal, lateral] =
      GENERATE(from_range(std::begin(kNeoHookeanUniaxial), std::end(kNeoHookeanUniaxial)));
  Random random(5);
  const CornerPositions<4> rest = random_cell<4>(random);
  const Matrix3 D_m = edges(rest);
  const auto k = NeoHookeanSolid{}.constants(rest, material_of(1, nu));
  // First Piola–Kirchhoff stress, from the forces alone.
  const auto stress = [&, stretch = stretch](double across) -> Matrix3 {
    const CornerPositions<4> positions = Vector3(across, across, stretch).asDiagonal() * rest;
    const CornerPositions<4> f =
        forces<4>(positions, NeoHookeanSolid{}.force_densities(k, squared_lengths<4>(positions)));
    return -f.rightCols<3>() * D_m.transpose() / (std::abs(D_m.determinant()) / 6);
  };
  double low = 0.3, high = 2;
  for (int halving = 0; halving < 60; ++halving) {
    const double middle = (low + high) / 2;
    (stress(middle)(0, 0) < 0 ? low : high) = middle;
  }
  CHECK(std::abs(low - lateral) < 6e-7);
  CHECK(std::abs(stress(low)(2, 2) - nominal) < 6e-7);
  CHECK(std::abs(stress(low)(1, 1)) < 1e-9);
  CHECK(std::abs(stress(low)(0, 2)) < 1e-9);
}

TEST_CASE("a neo-Hookean cell that falls flat pushes apart and has no finite energy", "[cell_law]") {
  Random random(6);
  for (int trial = 0; trial < 100; ++trial) {
    const CornerPositions<4> rest = random_cell<4>(random);
    const auto k = NeoHookeanSolid{}.constants(rest, material_of(5000, 0.3));
    const Matrix3 turn = random.rotation();
    const CornerPositions<4> flat = turn * Vector3(1, 1, 0).asDiagonal() * turn.transpose() * rest;
    const CellVector<4> s = squared_lengths<4>(flat);
    CHECK(NeoHookeanSolid{}.energy(k, s) == std::numeric_limits<double>::infinity());
    const CellVector<4> q = NeoHookeanSolid{}.force_densities(k, s);
    CHECK(q.allFinite());
    CHECK(NeoHookeanSolid{}.slope(k, s).allFinite());
    // Opening the cell along the direction in which it is flat lowers the energy: power of the forces > 0.
    const CornerPositions<4> open = turn * Vector3(1, 1, 1e-3).asDiagonal() * turn.transpose() * rest;
    CHECK(q.dot(squared_lengths<4>(open) - s) < 0);
  }
}

TEST_CASE("two_parameter and the membrane are plane stress at small strain, on any triangle", "[cell_law]") {
  Random random(7);
  int obtuse = 0;
  for (int trial = 0; trial < 1000; ++trial) {
    const CornerPositions<3> rest = random_cell<3>(random);
    const CellVector<3> s0 = squared_lengths<3>(rest);
    obtuse += 2 * s0.maxCoeff() > s0.sum();
    const Material material = material_of(5000, 0.45 * random.number());
    const auto k = TwoParameter{}.constants(rest, material);
    const CornerPositions<3> displacement = 0.005 * random.matrix<3, 3>();

    // First order: q = slope · δs, δs = 2 (x_b − x_a) · (u_b − u_a).
    const CellVector<3> change =
        (squared_lengths<3>(rest + displacement) - squared_lengths<3>(rest - displacement)) / 2;
    const CornerPositions<3> expected = plane_stress_forces(rest, displacement, material);
    const CornerPositions<3> linear = forces<3>(rest, TwoParameter{}.slope(k, s0) * change);
    CHECK((linear - expected).norm() < 1e-12 * expected.norm());
    const auto membrane = StVenantKirchhoffMembrane{}.constants(rest, material);
    const CornerPositions<3> biquadratic = forces<3>(rest, StVenantKirchhoffMembrane{}.slope(membrane, s0) * change);
    CHECK((biquadratic - expected).norm() < 1e-12 * expected.norm());

    // And the law itself, not its slope: what is left shrinks with the strain (1e-6, over the triangle's thinness).
    const CornerPositions<3> positions = rest + 1e-6 * displacement;
    const CornerPositions<3> f = forces<3>(positions, TwoParameter{}.force_densities(k, squared_lengths<3>(positions)));
    CHECK((f - 1e-6 * expected).norm() < 1e-3 * 1e-6 * expected.norm());
  }
  CHECK(obtuse > 100);
  CHECK(obtuse < 900);
}

TEST_CASE("two_parameter has a finite tension in a side that alone keeps its length", "[cell_law]") {
  // Equilateral triangle, side 01 along x, stretched by ε along y alone: plane stress is σ_y = E ε/(1−ν²), σ_x = ν σ_y.
  constexpr double E = 5000, nu = 0.3, strain = 1e-6, side = 0.01;
  const double height = side * std::sqrt(3.) / 2;
  CornerPositions<3> rest;
  rest << 0, side, side / 2, 0, 0, height, 0, 0, 0;
  const Material material = material_of(E, nu);
  const auto k = TwoParameter{}.constants(rest, material);
  const CornerPositions<3> positions = Vector3(1, 1 + strain, 1).asDiagonal() * rest;
  const CellVector<3> q = TwoParameter{}.force_densities(k, squared_lengths<3>(positions));
  // Corner 0 is pulled by half of t σ on the opposite side's width: across x h/2, across y L/4. In q:
  // q_01 L + q_02 L/2 = t σ_x h/2, q_02 h = t σ_y L/4.
  const double sigma = E * strain / (1 - nu * nu), t = material.thickness;
  const double q02 = t * sigma * side / 4 / height, q01 = (t * nu * sigma * height / 2 - q02 * side / 2) / side;
  CHECK(q[1] == Approx(q02).epsilon(1e-5));
  CHECK(q[2] == Approx(q02).epsilon(1e-5));
  CHECK(std::abs(q[0] - q01) < 1e-5 * q02);
}

TEST_CASE("two_parameter stays finite on a flat triangle", "[cell_law]") {
  Random random(8);
  for (int trial = 0; trial < 100; ++trial) {
    const CornerPositions<3> rest = random_cell<3>(random);
    const auto k = TwoParameter{}.constants(rest, material_of(5000, 0.3));
    const Vector3 along = random.matrix<3, 1>().normalized();
    CornerPositions<3> flat = along * (along.transpose() * rest);
    for (int collapse = 0; collapse < 3; ++collapse) {  // a line, a line with two corners on one place, a point
      if (collapse > 0) flat.col(collapse) = flat.col(0);
      CHECK(TwoParameter{}.force_densities(k, squared_lengths<3>(flat)).allFinite());
      CHECK(TwoParameter{}.slope(k, squared_lengths<3>(flat)).allFinite());
    }
  }
}

TEST_CASE("cell laws say what they can't do", "[cell_law]") {
  const Catalog catalog = built_in_catalog();
  Body body;
  CHECK(catalog.find("st_venant_kirchhoff").unsuited(body) == "needs tetrahedra");
  CHECK(catalog.find("neo_hookean").unsuited(body) == "needs tetrahedra");
  CHECK(catalog.find("st_venant_kirchhoff_membrane").unsuited(body) == "needs triangles");
  CHECK(catalog.find("two_parameter").unsuited(body) == "needs triangles");
  body.triangles.push_back({0, 1, 2});
  CHECK(catalog.find("two_parameter").unsuited(body).empty());
  body.tetrahedra.push_back({0, 1, 2, 3});
  CHECK(catalog.find("neo_hookean").unsuited(body).empty());

  Random random(9);
  const CornerPositions<4> cell = random_cell<4>(random);
  for (const double nu : {-1., 0.5, 0.6}) {
    CHECK_THROWS_AS(NeoHookeanSolid{}.constants(cell, material_of(1, nu)), InputError);
    CHECK_THROWS_AS(StVenantKirchhoffSolid{}.constants(cell, material_of(1, nu)), InputError);
  }
}

TEST_CASE("the stress of neo_hookean has all its digits near rest", "[law]") {
  const NeoHookean::Solid law{3e5, 1e4};
  Matrix3 A;
  A << 3, 1, -2, 1, -4, 0.5, -2, 0.5, 2;
  const Matrix3 linear = law.lambda / 2 * A.trace() * Matrix3::Identity() + law.mu * A;
  for (const double size : {1e-6, 1e-9, 1e-12}) {
    const Matrix3 stress = law.stress(size * A) / size;
    CHECK((stress - linear).norm() < 30 * size * linear.norm() + 1e-14 * linear.norm());
    CHECK(stress == stress.transpose());
  }
  // Far from rest the two forms are one.
  const Matrix3 C = Matrix3::Identity() + 0.1 * A, inverse = C.inverse();
  const double J = std::sqrt(C.determinant());
  const Matrix3 stress = law.lambda * J * (J - 1) * inverse + law.mu * (Matrix3::Identity() - inverse);
  CHECK((law.stress(0.1 * A) - stress).norm() < 1e-12 * stress.norm());
}
