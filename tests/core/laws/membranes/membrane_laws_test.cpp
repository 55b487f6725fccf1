// The isotropic membranes against closed forms, and against each other where they must agree.

#include <catch2/catch.hpp>
#include <cmath>

#include "core/laws/membranes/hencky_energy_membrane.h"
#include "core/laws/membranes/hencky_membrane.h"
#include "core/laws/membranes/two_parameter.h"
#include "core/laws/solids/curve.h"
#include "core/laws/solids/neo_hookean.h"
#include "core/laws/solids/st_venant_kirchhoff.h"
#include "elastin/core/base/error.h"
#include "support/cells.h"

using namespace elastin;
using namespace elastin::testing;

using StVenantKirchhoffMembrane = OnTriangle<StVenantKirchhoff>;
using HenckyTriangle = OnTriangle<Hencky>;
using HenckyEnergyTriangle = OnTriangle<HenckyEnergy>;
using NeoHookeanMembrane = OnTriangle<NeoHookean>;
using CurveMembrane = OnTriangle<Curve>;

static_assert(LengthKernel<HenckyEnergyTriangle> && HasEnergy<HenckyEnergyTriangle>);
static_assert(LengthKernel<HenckyTriangle> && !HasEnergy<HenckyTriangle>);
static_assert(LengthKernel<NeoHookeanMembrane> && HasEnergy<NeoHookeanMembrane>);
static_assert(LengthKernel<CurveMembrane> && HasEnergy<CurveMembrane>);

namespace {

/// Force per width at rest along x and y [N/m] of a triangle in the plane z = 0 stretched along both, from the forces
/// alone: the virial of the corners over the area at rest, over the stretch.
template <class Law>
Eigen::Vector2d tensions(const Material& material, double along_x, double along_y) {
  Random random(31);
  CornerPositions<3> rest = random_cell<3>(random);
  rest.row(2).setZero();
  const CornerPositions<3> positions = Vector3(along_x, along_y, 1).asDiagonal() * rest;
  const auto k = Law{}.constants(rest, material);
  const CornerPositions<3> f = forces<3>(positions, Law{}.force_densities(k, squared_lengths<3>(positions)));
  const Matrix3 virial = -f * positions.transpose() / RestCell<Triangle3>(rest).measure();
  CHECK(std::abs(virial(0, 1)) <= 1e-9 * (std::abs(virial(0, 0)) + std::abs(virial(1, 1))));
  return {virial(0, 0) / along_x, virial(1, 1) / along_y};
}

/// The stretch across that leaves no tension there.
template <class Law>
double natural_width(const Material& material, double along, double low = 0.2, double high = 2) {
  for (int halving = 0; halving < 60; ++halving) {
    const double middle = (low + high) / 2;
    (tensions<Law>(material, along, middle)[1] < 0 ? low : high) = middle;
  }
  return low;
}

constexpr double kStretches[] = {0.7, 0.95, 1.0001, 1.1, 1.5, 2.5};

}  // namespace

TEST_CASE("hencky_membrane and hencky_energy_membrane: equal biaxial stress is linear in logarithmic strain, and thins",
          "[membrane]") {
  for (const double nu : {-0.3, 0., 0.3, 0.45, 0.5})
    for (const double stretch : kStretches) {
      // True stress E/(1−ν) ln λ on the thickness t λ^(−2ν/(1−ν)), per width at rest: times λ.
      const double expected = 5000 / (1 - nu) * std::log(stretch) * 0.001 * std::pow(stretch, 1 - 2 * nu / (1 - nu));
      INFO(nu << " " << stretch);
      const Material material = material_of(5000, nu);
      for (const Eigen::Vector2d& found : {tensions<HenckyTriangle>(material, stretch, stretch),
                                           tensions<HenckyEnergyTriangle>(material, stretch, stretch)}) {
        CHECK(found[0] == Approx(expected).epsilon(1e-10));
        CHECK(found[1] == Approx(expected).epsilon(1e-10));
      }
    }
}

TEST_CASE("hencky_membrane: true stress is linear in logarithmic strain, uniaxial and in any other", "[membrane]") {
  for (const double nu : {-0.3, 0., 0.3, 0.45, 0.5})
    for (const double stretch : kStretches) {
      CAPTURE(nu, stretch);
      const Material material = material_of(5000, nu);
      // F = E ln λ on the section λ^(−2ν) of that at rest; the stretch across is λ^(−ν).
      const double width = natural_width<HenckyTriangle>(material, stretch);
      CHECK(width == Approx(std::pow(stretch, -nu)).epsilon(1e-9));
      CHECK(tensions<HenckyTriangle>(material, stretch, width)[0] ==
            Approx(5 * std::log(stretch) * std::pow(stretch, -2 * nu)).epsilon(1e-8));
      for (const double other : {0.8, 1.2, 2.}) {
        const double x = std::log(stretch), y = std::log(other), thin = std::exp(-nu / (1 - nu) * (x + y));
        const Eigen::Vector2d found = tensions<HenckyTriangle>(material, stretch, other);
        CHECK(found[0] == Approx(5 / (1 - nu * nu) * (x + nu * y) * other * thin).epsilon(1e-9).margin(1e-12));
        CHECK(found[1] == Approx(5 / (1 - nu * nu) * (y + nu * x) * stretch * thin).epsilon(1e-9).margin(1e-12));
      }
    }
}

TEST_CASE("hencky_energy_membrane: at nu = 1/2 uniaxial true stress is E ln(stretch)", "[membrane]") {
  for (const double stretch : kStretches) {
    const Material material = material_of(5000, 0.5);
    const double width = natural_width<HenckyEnergyTriangle>(material, stretch);
    CHECK(width == Approx(1 / std::sqrt(stretch)).epsilon(1e-9));
    CHECK(tensions<HenckyEnergyTriangle>(material, stretch, width)[0] ==
          Approx(5000 * std::log(stretch) / stretch * 0.001).epsilon(1e-9));
  }
}

TEST_CASE("neo_hookean_membrane: incompressible rubber at nu = 1/2", "[membrane]") {
  const double mu = 5000 / 3.;
  for (const double stretch : kStretches) {
    const Material material = material_of(5000, 0.5);
    CHECK(tensions<NeoHookeanMembrane>(material, stretch, stretch)[0] ==
          Approx(0.001 * mu * (stretch - std::pow(stretch, -5))).epsilon(1e-9));
    const double width = natural_width<NeoHookeanMembrane>(material, stretch);
    CHECK(width == Approx(1 / std::sqrt(stretch)).epsilon(1e-9));
    CHECK(tensions<NeoHookeanMembrane>(material, stretch, width)[0] ==
          Approx(0.001 * mu * (stretch - 1 / (stretch * stretch))).epsilon(1e-9));
  }
}

TEST_CASE("neo_hookean_membrane: uniaxial stress is the solid's", "[membrane][L03]") {
  // [L03]: E = 1, nominal stress and lateral stretch to the printed digits; at t = 1 mm.
  const auto [nu, stretch, nominal, lateral] =
      GENERATE(from_range(std::begin(kNeoHookeanUniaxial), std::end(kNeoHookeanUniaxial)));
  const Material material = material_of(1, nu);
  const double width = natural_width<NeoHookeanMembrane>(material, stretch);
  CHECK(std::abs(width - lateral) < 6e-7);
  CHECK(std::abs(tensions<NeoHookeanMembrane>(material, stretch, width)[0] / 0.001 - nominal) < 6e-7);
}

TEST_CASE("curve_membrane: the given curve in uniaxial stress, engineering strain in any", "[membrane]") {
  Material material = material_of(5000, 0.4);
  for (const double stretch : kStretches)
    for (const double other : {0.9, 1.3}) {
      const double x = stretch - 1, y = other - 1, plane = 5000 * 0.001 / (1 - 0.16);
      const Eigen::Vector2d found = tensions<CurveMembrane>(material, stretch, other);
      CHECK(std::abs(found[0] - plane * (x + 0.4 * y)) <= 1e-9 * plane);
      CHECK(std::abs(found[1] - plane * (y + 0.4 * x)) <= 1e-9 * plane);
    }
  material.curve = StressStrain::through({{-0.5, -9000}, {-0.1, -600}, {0, 0}, {0.2, 900}, {1, 2000}, {3, 9000}});
  material.youngs_modulus = material.curve->modulus(0);
  for (const double stretch : kStretches) {
    const double width =
        natural_width<CurveMembrane>(material, stretch, 0.95 * (1.4 - 0.4 * stretch), 1.05 * (1.4 - 0.4 * stretch));
    CHECK(width == Approx(1 - 0.4 * (stretch - 1)).epsilon(1e-9));
    CHECK(tensions<CurveMembrane>(material, stretch, width)[0] ==
          Approx(0.001 * material.curve->stress(stretch - 1)).epsilon(1e-9));
  }
}

TEMPLATE_TEST_CASE("a membrane law is plane stress at small strain, on any triangle", "[membrane]", HenckyTriangle,
                   HenckyEnergyTriangle, NeoHookeanMembrane, CurveMembrane, TwoParameter) {
  Random random(32);
  for (int trial = 0; trial < 300; ++trial) {
    const CornerPositions<3> rest = random_cell<3>(random);
    const Material material = material_of(5000, 0.25 + 0.25 * random.number());
    const CellVector<3> s0 = squared_lengths<3>(rest);
    const CellMatrix<3> slope = TestType{}.slope(TestType{}.constants(rest, material), s0);
    const CellMatrix<3> expected = StVenantKirchhoffMembrane{}.constants(rest, material).stiffness;
    CHECK((slope - expected).norm() <= 1e-12 * expected.norm());
  }
}

TEMPLATE_TEST_CASE("q is twice the slope of the energy, and its own slope right, at any strain", "[membrane]",
                   HenckyEnergyTriangle, NeoHookeanMembrane, CurveMembrane) {
  const double nu = GENERATE(0., 0.3, 0.45, 0.5);
  const bool curved = GENERATE(false, true);
  Random random(33);
  Material material = material_of(5000, nu);
  if (curved) material.curve = StressStrain::through({{-0.4, -3000}, {0, 0}, {0.3, 1200}, {1, 9000}});
  if (curved) material.youngs_modulus = material.curve->modulus(0);
  for (int trial = 0; trial < 60; ++trial) {
    const CornerPositions<3> rest = random_cell<3>(random);
    const auto k = TestType{}.constants(rest, material);
    const double turned = trial % 3 == 0 ? 1e-7 : 1;  // near equal stretches too
    const Matrix3 F =
        trial % 3 == 2
            ? random_deformation(random)
            : Matrix3((1 + 0.5 * random.number()) * (Matrix3::Identity() + 0.1 * turned * random.matrix<3, 3>()));
    const CellVector<3> s = squared_lengths<3>(F * rest);
    const CellVector<3> q = TestType{}.force_densities(k, s);
    const CellMatrix<3> slope = TestType{}.slope(k, s);
    CHECK((slope - slope.transpose()).norm() <= 1e-13 * slope.norm());
    const CellVector<3> step = 1e-5 * s.minCoeff() * random.matrix<3, 1>();
    const double rise = (TestType{}.energy(k, s + step) - TestType{}.energy(k, s - step));
    // Truncation is step² ~ 1e-10, rounding 1e-16 over the step ~ 1e-11, both times the triangle's thinness.
    CHECK(std::abs(rise - q.dot(step)) <= 1e-6 * q.norm() * step.norm());
    const CellVector<3> change = TestType{}.force_densities(k, s + step) - TestType{}.force_densities(k, s - step);
    CHECK((change - 2 * slope * step).norm() <= 1e-6 * slope.norm() * step.norm());
  }
}

TEMPLATE_TEST_CASE("a membrane's energy keeps its digits near rest", "[membrane]", HenckyEnergyTriangle,
                   NeoHookeanMembrane, CurveMembrane) {
  Random random(34);
  for (const double size : {1e-3, 1e-5, 1e-7})
    for (int trial = 0; trial < 30; ++trial) {
      const CornerPositions<3> rest = random_cell<3>(random);
      const Material material = material_of(5000, 0.3);
      const CellVector<3> s0 = squared_lengths<3>(rest);
      const CellVector<3> change = size * s0.cwiseProduct(random.matrix<3, 1>());
      const CellMatrix<3> K = StVenantKirchhoffMembrane{}.constants(rest, material).stiffness;
      const double expected = change.dot(K * change) / 4;
      const double found = TestType{}.energy(TestType{}.constants(rest, material), s0 + change);
      CHECK(std::abs(found - expected) <= (100 * size + 1e-7) * expected);  // thin triangles strain up to 20 sizes
    }
}

TEMPLATE_TEST_CASE("triangles at rest, sliver, obtuse, pressed, flat or a point: everything finite", "[membrane]",
                   HenckyTriangle, HenckyEnergyTriangle, NeoHookeanMembrane, CurveMembrane, TwoParameter,
                   StVenantKirchhoffMembrane) {
  const double nu = GENERATE(0., 0.3, 0.5);
  const Material material = material_of(5000, nu);
  const auto is_fine = [&](const CornerPositions<3>& rest, const CornerPositions<3>& positions, bool flat) {
    const auto k = TestType{}.constants(rest, material);
    const CellVector<3> s = squared_lengths<3>(positions);
    CHECK(TestType{}.force_densities(k, s).allFinite());
    CHECK(TestType{}.slope(k, s).allFinite());
    if constexpr (HasEnergy<TestType>) {
      const double energy = TestType{}.energy(k, s);
      // Its constant matrix loses the energy of triangles 1e-5 thin in rounding; the others work on strains.
      if (!std::is_same_v<TestType, StVenantKirchhoffMembrane> || RestCell<Triangle3>(rest).measure() > 1e-8)
        CHECK(energy >= 0);
      CHECK((std::isfinite(energy) || flat));
    }
  };
  for (const double thinness : {1., 1e-2, 1e-5})
    for (const double apex : {0.5, 0.1, -0.8, 3.}) {
      CornerPositions<3> rest;
      rest << 0, 0.01, 0.01 * apex, 0, 0, 0.01 * thinness, 0, 0, 0;
      const CellVector<3> none =
          TestType{}.force_densities(TestType{}.constants(rest, material), squared_lengths<3>(rest));
      const CellVector<3> some =
          TestType{}.force_densities(TestType{}.constants(rest, material), 1.02 * squared_lengths<3>(rest));
      CHECK(none.norm() <= 1e-9 * some.norm());
      is_fine(rest, rest, false);
      for (const double x : {0.1, 0.9, 2.})
        for (const double y : {0.1, 0.9, 2.}) is_fine(rest, Vector3(x, y, 1).asDiagonal() * rest, false);
      is_fine(rest, Vector3(1, 0, 1).asDiagonal() * rest, true);
      is_fine(rest, Vector3(0, 1, 1).asDiagonal() * rest, true);
      is_fine(rest, CornerPositions<3>::Zero(), true);
    }
}

TEST_CASE("a flat triangle of rubber has infinite energy and pushes open", "[membrane]") {
  CornerPositions<3> rest, open;
  rest << 0, 0.01, 0.004, 0, 0, 0.006, 0, 0, 0;
  const CornerPositions<3> flat = Vector3(1, 0, 0).asDiagonal() * rest;
  open = Vector3(1, 1e-3, 0).asDiagonal() * rest;
  const CellVector<3> s = squared_lengths<3>(flat), opening = squared_lengths<3>(open) - s;
  const auto rubber = NeoHookeanMembrane{}.constants(rest, material_of(5000, 0.4));
  CHECK(std::isinf(NeoHookeanMembrane{}.energy(rubber, s)));
  CHECK(NeoHookeanMembrane{}.force_densities(rubber, s).dot(opening) < 0);
  const auto hencky = HenckyEnergyTriangle{}.constants(rest, material_of(5000, 0.4));
  CHECK(std::isinf(HenckyEnergyTriangle{}.energy(hencky, s)));
}

TEST_CASE("membrane laws say which Poisson's ratios they take", "[membrane]") {
  Random random(35);
  const CornerPositions<3> rest = random_cell<3>(random);
  CHECK_THROWS_WITH(NeoHookeanMembrane{}.constants(rest, material_of(1, -0.1)), Catch::Contains("takes 0 to 0.5"));
  CHECK_THROWS_WITH(NeoHookeanMembrane{}.constants(rest, material_of(1, 0.51)), Catch::Contains("takes 0 to 0.5"));
  CHECK_THROWS_WITH(HenckyEnergyTriangle{}.constants(rest, material_of(1, 0.51)), Catch::Contains("at most 0.5"));
  CHECK_NOTHROW(CurveMembrane{}.constants(rest, material_of(1, 0.5)));
}
