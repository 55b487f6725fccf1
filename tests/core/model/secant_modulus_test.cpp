#include <catch2/catch.hpp>
#include <cmath>

#include "elastin/core/base/error.h"
#include "elastin/core/model/stress_strain.h"

using namespace elastin;
using Catch::Matchers::Contains;

TEST_CASE("a secant modulus as a polynomial is met, in tension and compression", "[stress_strain]") {
  struct Case {
    std::vector<double> c;
    double up_to, tolerance;
  };
  for (const Case& test : {Case{{5}, 1, 1e-13},
                           {{1.8, -1.62, 1.08}, 0.9, 1e-13},            // a cubic stress: exact
                           {{1.8, -2.4, 2.9, -1.1}, 0.8, 1e-6},         // in pieces
                           {{1, 0.5, -0.2, 0.1, 0.02, 0.3}, 3, 1e-4}})  // beyond 100 % strain too
    for (const double strain : {0.01, 0.13, 0.5, 0.79}) {
      double E = 0;
      for (std::size_t k = 0; k < test.c.size(); ++k) E += test.c[k] * std::pow(strain, static_cast<double>(k));
      const StressStrain curve = StressStrain::secant_polynomial(test.c, test.up_to);
      CHECK(curve.secant(strain) == Approx(E).epsilon(test.tolerance));
      CHECK(curve.secant(-strain) == Approx(E).epsilon(test.tolerance));
      CHECK(curve.stress(strain) == Approx(E * strain).epsilon(test.tolerance));
      CHECK(curve.stress(-strain) == Approx(-E * strain).epsilon(test.tolerance));
    }
  const StressStrain curve = StressStrain::secant_polynomial({2, -1}, 0.5);
  CHECK(curve.modulus(0) == Approx(2));
  CHECK(curve.modulus(0.7) == Approx(curve.modulus(0.5)));  // straight on
}

TEST_CASE("a table of secant moduli is met at its points and between", "[stress_strain]") {
  const StressStrain curve = StressStrain::secant_table({{0, 10}, {0.1, 8}, {0.3, 7}, {0.6, 9}});
  for (const auto& [strain, E] : {std::pair{0.1, 8.}, {0.3, 7.}, {0.6, 9.}})
    CHECK(curve.secant(strain) == Approx(E).epsilon(1e-9));
  CHECK(curve.modulus(0) == Approx(10).epsilon(1e-9));
  CHECK(curve.secant(0.05) > 8);
  CHECK(curve.secant(0.05) < 10);
  const StressStrain late = StressStrain::secant_table({{0.2, 5}, {0.4, 6}});
  CHECK(late.secant(0.1) == Approx(5));
}

TEST_CASE("a secant modulus whose stress falls is refused with the strain", "[stress_strain]") {
  CHECK_THROWS_WITH(StressStrain::secant_polynomial({1, -1}, 0.8),
                    Contains("at a strain of 0.5") && Contains("above 0"));
  CHECK_THROWS_WITH(StressStrain::secant_polynomial({-1}, 0.8), Contains("at a strain of 0"));
  CHECK_THROWS_WITH(StressStrain::secant_polynomial({}, 0.8), Contains("at least one coefficient"));
  CHECK_THROWS_WITH(StressStrain::secant_polynomial({1}, 0), Contains("up_to"));
  CHECK_THROWS_WITH(StressStrain::secant_table({{0, 1}}), Contains("at least two points"));
  CHECK_THROWS_WITH(StressStrain::secant_table({{0, 10}, {0.1, 1}}), Contains("at a strain of"));
  CHECK_THROWS_WITH(StressStrain::secant_table({{0.2, 1}, {0.1, 2}}), Contains("increase"));
}
