// Membranes without compression.

#include "core/laws/membranes/tension_field.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/base/dense.h"
#include "core/laws/membranes/hencky_energy_membrane.h"
#include "core/laws/solids/curve.h"
#include "core/laws/solids/neo_hookean.h"
#include "core/laws/solids/st_venant_kirchhoff.h"
#include "elastin/core/base/error.h"
#include "elastin/core/simulation/catalog.h"
#include "lab/run/specimen.h"
#include "support/cells.h"

using namespace elastin;
using namespace elastin::lab;
using namespace elastin::testing;

namespace {

/// Ascending.
Eigen::Vector2d principal(const Eigen::Matrix2d& tension) { return symmetric_eigenvalues(tension); }

}  // namespace

TEMPLATE_TEST_CASE("without compression: taut as the law, wrinkled in uniaxial stress, slack without any",
                   "[wrinkling]", StVenantKirchhoff, HenckyEnergy, NeoHookean, Curve) {
  using Plain = OnTriangle<TestType>;
  using Relaxed = OnTriangle<WithoutCompression<TestType>>;
  Random random(51);
  const Material material = material_of(5000, 0.3);
  const double plane = 5000 * 0.001;
  int taut = 0, wrinkled = 0, slack = 0;
  for (int trial = 0; trial < 300; ++trial) {
    CornerPositions<3> rest = random_cell<3>(random);
    rest.row(2).setZero();
    const Eigen::Matrix2d turn = Eigen::Rotation2Dd(random.number() * 3).toRotationMatrix();
    Eigen::Vector2d stretch(1 + 0.3 * random.number(), 1 + 0.3 * random.number());
    Matrix3 F = Matrix3::Identity();
    F.topLeftCorner<2, 2>() = turn * stretch.asDiagonal() * turn.transpose();
    const CornerPositions<3> positions = F * rest;
    const CellVector<3> s = squared_lengths<3>(positions);
    const auto full = Plain{}.constants(rest, material);
    const auto k = Relaxed{}.constants(rest, material);
    const CellVector<3> q = Relaxed{}.force_densities(k, s), own = Plain{}.force_densities(full, s);
    const auto tension_of = [&](const CellVector<3>& force_densities) -> Eigen::Matrix2d {
      return -(forces<3>(positions, force_densities) * positions.transpose()).topLeftCorner<2, 2>() /
             RestCell<Triangle3>(rest).measure();
    };
    const Eigen::Vector2d before = principal(tension_of(own)), after = principal(tension_of(q));
    CHECK(after[0] >= -1e-9 * plane);
    CHECK(Relaxed{}.energy(k, s) <= Plain{}.energy(full, s) * (1 + 1e-9));
    CHECK(Relaxed{}.energy(k, s) >= 0);
    if (before[0] >= 0) {
      ++taut;
      CHECK((q - own).norm() <= 1e-12 * own.norm());
    } else if (stretch.maxCoeff() <= 1) {
      ++slack;
      CHECK(q.norm() == 0);
      CHECK(Relaxed{}.energy(k, s) == 0);
    } else {
      ++wrinkled;
      CHECK(std::abs(after[0]) <= 1e-9 * plane);
      CHECK(after[1] > 0);
      // What uniaxial stress at the natural width is, from the law itself.
      const double longest = stretch.maxCoeff();
      double low = 0.5, high = longest;
      const auto sides_at = [&](double width) {
        return squared_lengths<3>(CornerPositions<3>(Vector3(longest, width, 1).asDiagonal() * rest));
      };
      const auto tensions_at = [&](double width) -> Eigen::Vector2d {
        const CornerPositions<3> at = Vector3(longest, width, 1).asDiagonal() * rest;
        const CornerPositions<3> f = forces<3>(at, Plain{}.force_densities(full, sides_at(width)));
        const Matrix3 virial = -f * at.transpose() / RestCell<Triangle3>(rest).measure();
        return {virial(0, 0), virial(1, 1)};
      };
      for (int halving = 0; halving < 60; ++halving) {
        const double middle = (low + high) / 2;
        (tensions_at(middle)[1] < 0 ? low : high) = middle;
      }
      CHECK(after[1] == Approx(tensions_at(low)[0]).epsilon(1e-7));
    }
    const CellVector<3> step = 1e-6 * s.minCoeff() * random.matrix<3, 1>();
    const double rise = Relaxed{}.energy(k, s + step) - Relaxed{}.energy(k, s - step);
    const CellMatrix<3> slope = Relaxed{}.slope(k, s), law_slope = Plain{}.slope(full, s);
    const double jump = law_slope.norm() * step.squaredNorm();  // where the triangle begins to wrinkle within the step
    CHECK(std::abs(rise - q.dot(step)) <= 1e-5 * plane * step.norm() + jump);
    CHECK((slope - slope.transpose()).norm() <= 1e-12 * law_slope.norm());
    const CellVector<3> change = Relaxed{}.force_densities(k, s + step) - Relaxed{}.force_densities(k, s - step);
    CHECK((change - 2 * slope * step).norm() <= 1e-4 * law_slope.norm() * step.norm());
  }
  CHECK(taut > 20);
  CHECK(wrinkled > 20);
  CHECK(slack > 20);
}

TEMPLATE_TEST_CASE("without compression: flat triangles and points stay finite", "[wrinkling]", StVenantKirchhoff,
                   HenckyEnergy, NeoHookean, Curve) {
  using Relaxed = OnTriangle<WithoutCompression<TestType>>;
  const double nu = GENERATE(0., 0.3, 0.5);
  CornerPositions<3> rest;
  rest << 0, 0.01, 0.004, 0, 0, 0.006, 0, 0, 0;
  const auto k = Relaxed{}.constants(rest, material_of(5000, nu));
  for (const double x : {0., 0.5, 1., 1.5})
    for (const double y : {0., 1e-9, 0.5, 1., 1.5}) {
      const CellVector<3> s = squared_lengths<3>(CornerPositions<3>(Vector3(x, y, 1).asDiagonal() * rest));
      CHECK(Relaxed{}.force_densities(k, s).allFinite());
      CHECK(Relaxed{}.slope(k, s).allFinite());
      CHECK(std::isfinite(Relaxed{}.energy(k, s)));
    }
}

TEST_CASE("compression is dropped by name, from laws that can", "[wrinkling]") {
  const Catalog catalog = built_in_catalog();
  CHECK(choose_strategy(catalog, "hencky_energy_membrane+wrinkling").label == "hencky_energy_membrane+wrinkling");
  CHECK_THROWS_WITH(choose_strategy(catalog, "two_parameter+wrinkling"), Catch::Contains("hencky_energy_membrane"));
  CHECK_THROWS_WITH(choose_strategy(catalog, "neo_hookean_membrane+wrinklng"),
                    Catch::Contains("did you mean '+wrinkling'"));
  CHECK_THROWS_WITH(choose_strategy(catalog, "curve_membrane+wrinkling+wrinkling"), Catch::Contains("repeated"));
}
