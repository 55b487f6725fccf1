// What laws compute in short ways, compared with the long ones: eigenvalues and axes, functions of a tensor, e^y − 1,
// C⁻¹, and the strain and force densities of a simplex.

#include "core/laws/solids/principal.h"

#include <Eigen/Eigenvalues>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "core/base/dense.h"
#include "core/laws/exponential.h"
#include "elastin/core/laws/cell_kernel.h"
#include "elastin/core/shapes/simplices.h"

using namespace elastin;

namespace {

/// Random states, two and three equal and nearly equal eigenvalues among them, from a strain of 1e-9 up.
std::vector<Matrix3> states() {
  std::mt19937 generator(5);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<Matrix3> all{Matrix3::Zero(), 0.3 * Matrix3::Identity(), Vector3(0.1, 0.1, -0.4).asDiagonal(),
                           Vector3(-0.2, 0.5, 0.5).asDiagonal()};
  for (const double size : {1e-9, 1e-4, 0.1, 0.9, 8.})
    for (const double apart : {1., 1e-3, 1e-7, 1e-10, 1e-14, 0.})
      for (int repeat = 0; repeat < 20; ++repeat) {
        const Matrix3 any = Matrix3::NullaryExpr([&] { return uniform(generator); });
        const Matrix3 axes = Eigen::HouseholderQR<Matrix3>(any).householderQ();
        const double one = uniform(generator), other = repeat % 2 ? uniform(generator) : one * (1 + apart);
        const Vector3 values(one, one * (1 + apart * uniform(generator)), other);
        const Matrix3 A = axes * (size * values).cwiseMax(-0.95).asDiagonal() * axes.transpose();
        all.push_back((A + A.transpose()) / 2);
      }
  return all;
}

}  // namespace

TEST_CASE("eigenvalues and axes in closed form are those of the iteration", "[laws][dense]") {
  for (const Matrix3& A : states()) {
    INFO(A);
    const double size = A.norm();
    const SymmetricEigen3 found = symmetric_eigen3(A);
    const Vector3 exact = Eigen::SelfAdjointEigenSolver<Matrix3>(A).eigenvalues();
    CHECK((found.values - exact).norm() <= 4e-15 * size);
    CHECK((found.vectors.transpose() * found.vectors - Matrix3::Identity()).norm() <= 1e-14);
    CHECK((found.vectors * found.values.asDiagonal() * found.vectors.transpose() - A).norm() <= 1e-14 * size);
  }
}

TEST_CASE("a function of a tensor without its axes is that with them", "[laws]") {
  const auto f = [](double x) { return std::expm1(1.7 * std::log1p(x)) / (1 + x); };
  for (const Matrix3& A : states()) {
    INFO(A);
    const Eigen::SelfAdjointEigenSolver<Matrix3> exact(A);
    const Matrix3 expected = exact.eigenvectors() *
                             exact.eigenvalues().unaryExpr([&](double x) { return f(x); }).asDiagonal() *
                             exact.eigenvectors().transpose();
    const Vector3 x = principal_values(A);
    const Vector3 values(f(x[0]), f(x[1]), f(x[2]));
    CHECK((principal_function(A, x, values) - expected).norm() <= 1e-12 * std::max(expected.norm(), A.norm()));
  }
}

TEST_CASE("e^y − 1, ln(1 + x) and x^(−1/3) without a call", "[laws]") {
  for (double y = 1e-12; y < kMostPower; y *= 1.07)
    for (const double signed_y : {y, -y})
      CHECK(std::abs(limited_expm1(signed_y) - std::expm1(signed_y)) <= 5e-16 * std::abs(std::expm1(signed_y)));
  CHECK(limited_expm1(0) == 0);
  CHECK(limited_expm1(1e9) == limited_expm1(kMostPower));
  CHECK(std::isfinite(std::pow(1 + limited_expm1(1e9), 2)));
  CHECK(limited_expm1(-1e9) == -1);
  for (double x = 1e-14; x < 1e6; x *= 1.3) {
    CHECK(short_log1p(x) == Approx(std::log1p(x)).epsilon(1e-15));
    if (x < 1) CHECK(short_log1p(-x) == Approx(std::log1p(-x)).epsilon(1e-15));
    CHECK(inverse_cube_root(x) == Approx(1 / std::cbrt(x)).epsilon(1e-15));
    CHECK(inverse_cube_root(1 + x) == Approx(1 / std::cbrt(1 + x)).epsilon(1e-15));
  }
}

TEST_CASE("C⁻¹, det C and the squares of C⁻¹ from the cofactors of A", "[laws]") {
  for (const Matrix3& A : states()) {
    INFO(A);
    const Matrix3 C = Matrix3::Identity() + A, exact = C.inverse();
    const Dilatation now(A);
    // det C is a sum of terms as large as 1 and A³, each with its rounding.
    const double terms = 1 + A.norm() * A.squaredNorm();
    CHECK((now.inverse - exact).norm() <= 4e-15 * terms / C.determinant() * exact.norm());
    CHECK(now.excess == Approx(Dilatation::determinant_change(A)).epsilon(1e-12).margin(1e-15 * A.norm()));
    if (std::abs(A.determinant()) > 1e-3)
      CHECK((now.adjugate - A.determinant() * A.inverse()).norm() <= 1e-12 * now.adjugate.norm());
    Eigen::Matrix<double, 6, 6> tangent = Eigen::Matrix<double, 6, 6>::Zero();
    add_symmetric_squares(exact, 0.7, -1.3, tangent);
    for (int row = 0; row < 6; ++row)
      for (int column = 0; column < 6; ++column) {
        const auto [i, j] = kComponents[row];
        const auto [k, l] = kComponents[column];
        const double expected =
            0.7 * exact(i, j) * exact(k, l) - 1.3 / 2 * (exact(i, k) * exact(j, l) + exact(i, l) * exact(j, k));
        CHECK(std::abs(tangent(row, column) - expected) <= 1e-13 * exact.squaredNorm());
      }
  }
}

namespace {

/// S = M A + A M of a fixed symmetric M: any law, with a direction in every axis.
struct AnyLaw {
  static constexpr std::string_view name = "any", summary = "any", source = "";
  struct Point {
    Matrix3 stress(const Matrix3& A) const { return kM * A + A * kM; }
    TangentModuli<3> tangent(const Matrix3&) const { return TangentModuli<3>::Zero(); }
  };
  Point solid(const Material&) const { return {}; }
  static inline const Matrix3 kM = (Matrix3() << 2, 0.3, -0.7, 0.3, 1, 0.4, -0.7, 0.4, 3).finished();
};

}  // namespace

TEST_CASE("a simplex by its edges has the force densities of the sum over all pairs", "[laws]") {
  std::mt19937 generator(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const PointKernel<AnyLaw, Tetrahedron4> kernel;
  constexpr auto pairs = node_pairs<4>();
  for (int repeat = 0; repeat < 50; ++repeat) {
    NodePositions<4> rest;
    rest << 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1;
    rest += 0.2 * NodePositions<4>::NullaryExpr([&] { return uniform(generator); });
    const RestCell<Tetrahedron4> cell(rest);
    const CellVector<4> s =
        cell.squared_lengths.cwiseProduct(CellVector<4>::NullaryExpr([&] { return 1 + 0.3 * uniform(generator); }));
    Matrix3 A = Matrix3::Zero();
    const auto& B = cell.gradients[0];
    for (int c = 0; c < 6; ++c) {
      const Matrix3 product = B.col(pairs[c][0]) * B.col(pairs[c][1]).transpose();
      A -= (s[c] - cell.squared_lengths[c]) / 2 * (product + product.transpose());
    }
    const Matrix3 S = AnyLaw::Point{}.stress(A);
    const CellVector<4> q = kernel.force_densities(kernel.constants(rest, Material{}), s);
    for (int c = 0; c < 6; ++c)
      CHECK(q[c] ==
            Approx(-cell.weights[0] * B.col(pairs[c][0]).dot(S * B.col(pairs[c][1]))).epsilon(1e-12).margin(1e-13));
  }
}
