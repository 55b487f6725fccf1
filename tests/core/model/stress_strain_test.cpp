#include "elastin/core/model/stress_strain.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "elastin/core/base/error.h"

using namespace elastin;
using Points = std::vector<StressStrain::Point>;

namespace {

const Points kTable{{-0.3, -40}, {-0.1, -8}, {-0.02, -2}, {0, 0}, {0.01, 0.5}, {0.05, 10}, {0.06, 14}, {0.3, 15}};

struct Named {
  std::string name;
  StressStrain curve;
};
const std::vector<Named> kCurves{{"linear", StressStrain::linear(70)},
                                 {"toe", StressStrain::toe(0.03, 10, 300)},
                                 {"bilinear", StressStrain::bilinear(100, 400, 1e-3)},
                                 {"table", StressStrain::through(kTable)},
                                 {"table of tension", StressStrain::through({{0, 0}, {0.1, 1}, {0.2, 4}})},
                                 {"table of compression", StressStrain::through({{-0.2, -4}, {-0.1, -1}, {0, 0}})}};

}  // namespace

TEST_CASE("a curve increases, and its modulus and energy are its derivative and integral", "[stress_strain]") {
  for (const auto& [name, curve] : kCurves) {
    INFO(name);
    CHECK(curve.stress(0) == 0);
    CHECK(curve.energy_density(0) == 0);
    constexpr double step = 1e-6;
    double energy = 0;  // Simpson's rule from −0.5 on: exact for the cubics but where a step holds a knot
    for (int i = -500; i < 500; ++i) {
      const double low = i * 1e-3, high = low + 1e-3, middle = (low + high) / 2;
      REQUIRE(curve.stress(high) > curve.stress(low));
      REQUIRE(curve.modulus(middle) > 0);
      const double slope = (curve.stress(middle + step) - curve.stress(middle - step)) / (2 * step);
      REQUIRE(curve.modulus(middle) == Approx(slope).epsilon(1e-5));
      energy += (curve.stress(low) + 4 * curve.stress(middle) + curve.stress(high)) / 6 * 1e-3;
      REQUIRE(curve.energy_density(high) - curve.energy_density(-0.5) == Approx(energy).margin(1e-9));
      REQUIRE(curve.secant(middle) * middle == Approx(curve.stress(middle)).epsilon(1e-13));
    }
    CHECK(curve.secant(0) == curve.modulus(0));
    CHECK(curve.secant(1e-14) == Approx(curve.modulus(0)).epsilon(1e-9));
    // Straight on beyond the ends.
    CHECK(curve.stress(0.9) - curve.stress(0.8) == Approx(0.1 * curve.modulus(0.5)));
    CHECK(curve.stress(-0.8) - curve.stress(-0.9) == Approx(0.1 * curve.modulus(-0.5)));
  }
}

TEST_CASE("a curve's slope has no jump", "[stress_strain]") {
  for (const auto& [name, curve] : kCurves)
    for (int i = -5000; i < 5000; ++i) {
      const double at = 1e-4 * i, ulp = 1e-12;
      INFO(name << " at " << at);
      REQUIRE(curve.modulus(at + ulp) == Approx(curve.modulus(at - ulp)).epsilon(1e-5));
    }
}

TEST_CASE("a table's curve goes through its points", "[stress_strain]") {
  const StressStrain curve = StressStrain::through(kTable);
  for (const auto& [strain, stress] : kTable) CHECK(curve.stress(strain) == Approx(stress).epsilon(1e-14));
  // A straight line is kept, and a smooth curve met to third order: sinh at 17 and at 33 points.
  const StressStrain line = StressStrain::through({{-0.1, -2}, {0, 0}, {0.05, 1}, {0.2, 4}});
  CHECK(line.stress(0.13) == Approx(2.6).epsilon(1e-14));
  const auto worst = [](int points) {
    Points table;
    for (int i = 0; i < points; ++i) {
      const double strain = -0.4 + 0.8 * i / (points - 1);
      table.push_back({i == (points - 1) / 2 ? 0 : strain, i == (points - 1) / 2 ? 0 : std::sinh(5 * strain)});
    }
    const StressStrain met = StressStrain::through(table);
    double error = 0;
    for (double e = -0.3; e < 0.3; e += 1e-3) error = std::max(error, std::abs(met.stress(e) - std::sinh(5 * e)));
    return error;
  };
  CHECK(worst(17) < 5e-3);
  CHECK(worst(33) < worst(17) / 6);
}

TEST_CASE("toe and bilinear curves by hand", "[stress_strain]") {
  const StressStrain toe = StressStrain::toe(0.03, 10, 300);
  CHECK(toe.modulus(0) == Approx(10));
  CHECK(toe.modulus(0.015) == Approx(155));
  CHECK(toe.stress(0.015) == Approx((10 + 155) / 2. * 0.015));
  CHECK(toe.modulus(0.05) == Approx(300));
  CHECK(toe.stress(0.05) == Approx(155 * 0.03 + 300 * 0.02));
  CHECK(toe.stress(-0.1) == Approx(-1));
  const StressStrain two = StressStrain::bilinear(100, 400, 1e-3);
  CHECK(two.modulus(0) == Approx(250));
  CHECK(two.stress(0.1) == Approx(100 * 0.1 + 300 * 1e-3 / 4));
  CHECK(two.stress(-0.1) == Approx(-400 * 0.1 + 300 * 1e-3 / 4));
}

TEST_CASE("fibres without compression are as before in tension", "[stress_strain]") {
  for (const auto& [name, curve] : kCurves) {
    INFO(name);
    const StressStrain rope = curve.without_compression();
    for (const double strain : {0., 0.001, 0.02, 0.055, 0.4}) {
      CHECK(rope.stress(strain) == curve.stress(strain));
      CHECK(rope.modulus(strain) == curve.modulus(strain));
      CHECK(rope.energy_density(strain) == curve.energy_density(strain));
    }
    for (const double strain : {-1e-9, -0.02, -0.7}) {
      CHECK(rope.stress(strain) == 0);
      CHECK(rope.modulus(strain) == 0);
      CHECK(rope.energy_density(strain) == 0);
    }
  }
}

TEST_CASE("a curve that cannot be is refused with the point", "[stress_strain]") {
  const auto refusal = [](const Points& points) -> std::string {
    try {
      StressStrain::through(points);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  using Catch::Matchers::Contains;
  CHECK_THAT(refusal({{0, 0}}), Contains("at least two points"));
  CHECK_THAT(refusal({{0.1, 1}, {0.2, 2}}), Contains("origin"));
  CHECK_THAT(refusal({{0, 1}, {0.2, 2}}), Contains("point 0") && Contains("no stress"));
  CHECK_THAT(refusal({{0, 0}, {0.2, 2}, {0.2, 3}}), Contains("point 2") && Contains("strain must be greater"));
  CHECK_THAT(refusal({{0, 0}, {0.2, 2}, {0.3, 2}}), Contains("point 2") && Contains("stress must be greater"));
  CHECK_THAT(refusal({{-1, -3}, {0, 0}}), Contains("point 0") && Contains("-100 %"));
  CHECK_THAT(refusal({{0, 0}, {0.2, std::nan("")}}), Contains("point 1") && Contains("finite"));
  CHECK_THROWS_AS(StressStrain::linear(0), InputError);
  CHECK_THROWS_AS(StressStrain::toe(0.03, -1, 1), InputError);
  CHECK_THROWS_AS(StressStrain::toe(0, 1, 1), InputError);
  CHECK_THROWS_AS(StressStrain::bilinear(1, 0, 1e-3), InputError);
}
