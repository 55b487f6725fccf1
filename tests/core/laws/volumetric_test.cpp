#include "elastin/core/laws/volumetric.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/laws/solids/neo_hookean.h"

using namespace elastin;

static_assert(SplitLaw<NeoHookean>);
static_assert(PointLaw<SplitPoint<NeoHookean::Solid>, 3>);

TEST_CASE("a volumetric energy is the form that its name says, with its slopes", "[volumetric]") {
  const double K = 3, J = GENERATE(0.3, 0.9, 1.1, 2.5);
  const double L = std::log(J);
  const Volumetric quadratic{Volumetric::Form::quadratic, K}, logarithmic{Volumetric::Form::logarithmic, K},
      mixed{Volumetric::Form::mixed, K};
  CHECK(quadratic.energy(J - 1) == Approx(K / 2 * (J - 1) * (J - 1)).epsilon(1e-13));
  CHECK(logarithmic.energy(J - 1) == Approx(K / 2 * L * L).epsilon(1e-13));
  CHECK(mixed.energy(J - 1) == Approx(K / 4 * (J * J - 1 - 2 * L)).epsilon(1e-13));
  CHECK(quadratic.slope(J - 1) == Approx(K * (J - 1)).epsilon(1e-13));
  CHECK(logarithmic.slope(J - 1) == Approx(K * L / J).epsilon(1e-13));
  CHECK(mixed.slope(J - 1) == Approx(K / 2 * (J - 1 / J)).epsilon(1e-13));
  CHECK(quadratic.curvature(J - 1) == K);
  CHECK(logarithmic.curvature(J - 1) == Approx(K * (1 - L) / (J * J)).epsilon(1e-13));
  CHECK(mixed.curvature(J - 1) == Approx(K / 2 * (1 + 1 / (J * J))).epsilon(1e-13));
}

TEST_CASE("a volumetric energy keeps its digits near rest", "[volumetric]") {
  // All forms are K/2 x² (1 + O(x)); O(x) is below 1e-8 here.
  for (const auto form : {Volumetric::Form::quadratic, Volumetric::Form::logarithmic, Volumetric::Form::mixed})
    for (const double x : {1e-9, -1e-9, 1e-12}) {
      CHECK(Volumetric{form, 2}.energy(x) == Approx(x * x).epsilon(1e-8));
      CHECK(Volumetric{form, 2}.slope(x) == Approx(2 * x).epsilon(1e-8));
    }
}

TEST_CASE("a split law is the law", "[volumetric]") {
  Material material;
  material.youngs_modulus = 5000;
  material.poissons_ratio = 0.4;
  const auto whole = NeoHookean{}.solid(material);
  const auto split = NeoHookean{}.split(material);
  Matrix3 A;
  A << 0.3, 0.1, -0.05, 0.1, -0.2, 0.15, -0.05, 0.15, 0.4;
  // Rounding of some ten products.
  CHECK((split.stress(A) - whole.stress(A)).norm() < 1e-13 * whole.stress(A).norm());
  CHECK((split.tangent(A) - whole.tangent(A)).norm() < 1e-13 * whole.tangent(A).norm());
  CHECK(split.energy(A) == Approx(whole.energy(A)).epsilon(1e-13));
}
