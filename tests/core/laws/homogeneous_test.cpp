// Homogeneous tests of laws against closed forms, and where laws are stable.

#include "core/laws/homogeneous.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <map>

#include "elastin/core/simulation/catalog.h"
#include "support/cells.h"
#include "support/law_constants.h"

using namespace elastin;
using namespace elastin::testing;

namespace {

std::optional<HomogeneousState> state_of(const LawConstants& constants, HomogeneousTest test, double amount,
                                         const Matrix3& axes = Matrix3::Identity()) {
  return homogeneous_state(*kCatalog.material_laws.find(constants.law), material_with(constants), test, amount, axes);
}

}  // namespace

TEST_CASE("an incompressible law in homogeneous tests is the closed form", "[law]") {
  const double c1 = 1500, c2 = 400;
  const LawConstants constants{.law = "mooney_rivlin", .numbers = {{"c1", c1}, {"c2", c2}}};
  Random random(81);
  for (const double amount : {-0.5, -0.05, 1e-6, 0.3, 2.}) {
    const double l = 1 + amount;
    const Matrix3 axes = random.rotation();
    INFO("amount " << amount);
    const auto stress = [&](HomogeneousTest test) { return state_of(constants, test, amount, axes).value().stress; };
    // Nominal stresses of Mooney-Rivlin, 2 (λ − λ_free²/λ …)(c₁ + c₂ …) [Treloar 1975, ch. 5].
    CHECK(stress(HomogeneousTest::uniaxial) == Approx(2 * (l - 1 / (l * l)) * (c1 + c2 / l)).epsilon(1e-9));
    CHECK(stress(HomogeneousTest::planar) == Approx(2 * (l - 1 / (l * l * l)) * (c1 + c2)).epsilon(1e-9));
    CHECK(stress(HomogeneousTest::equibiaxial) ==
          Approx(2 * (l - 1 / std::pow(l, 5)) * (c1 + c2 * l * l)).epsilon(1e-9));
    CHECK(stress(HomogeneousTest::shear) == Approx(2 * (c1 + c2) * amount).epsilon(1e-9));
  }
}

TEST_CASE("a nearly incompressible law tends to the incompressible one", "[law]") {
  // The difference is of order μ/κ: extrapolated from κ and 2κ it is of its square.
  const auto constants = law_constants();
  for (const auto& row : kCatalog.material_laws) {
    if (row->from_moduli) continue;
    for (const HomogeneousTest test : kHomogeneousTests) {
      LawConstants exact = constants.at(row->name);
      exact.numbers.erase("bulk_modulus");
      const auto with = [&](double bulk) {
        LawConstants own = exact;
        own.numbers["bulk_modulus"] = bulk;
        return state_of(own, test, 0.2).value().stress;
      };
      const double expected = state_of(exact, test, 0.2).value().stress;
      INFO(row->name << ", " << name_of(test));
      CHECK(2 * with(2e9) - with(1e9) == Approx(expected).epsilon(1e-8));
      CHECK(with(1e6) == Approx(expected).epsilon(0.1));
    }
  }
}

TEST_CASE("a compressible law in uniaxial stress has the moduli at rest", "[law]") {
  const auto constants = law_constants();
  for (const auto& row : kCatalog.material_laws) {
    const LawConstants& own = constants.at(row->name);
    if (!own.directions.empty()) continue;
    const Material material = material_with(own);
    const auto state = state_of(own, HomogeneousTest::uniaxial, 1e-6).value();
    INFO(row->name);
    CHECK(state.stress == Approx(1e-6 * material.youngs_modulus).epsilon(1e-4));
    CHECK(-state.strain(1, 1) / state.strain(0, 0) == Approx(material.poissons_ratio).epsilon(1e-4));
    CHECK(state.stable);
  }
}

TEST_CASE("uniaxial stress askew to fibres leaves no other stress", "[law]") {
  // The solid shears; its state must have the one stress along the axis.
  for (const char* name : {"transversely_isotropic", "holzapfel_gasser_ogden", "fung_orthotropic"}) {
    const LawConstants constants = law_constants().at(name);
    const auto state = state_of(constants, HomogeneousTest::uniaxial, 0.15).value();
    const Matrix3 S = kCatalog.material_laws.find(name)->solid(material_with(constants)).stress(state.strain);
    INFO(name);
    CHECK(S(0, 0) * 1.15 == Approx(state.stress).epsilon(1e-12));
    CHECK(state.stress > 0);
    Matrix3 rest = S;
    rest(0, 0) = 0;
    CHECK(rest.norm() <= 1e-9 * S(0, 0));
    CHECK(std::abs(state.strain(0, 1)) > 1e-3);
  }
}

TEST_CASE("Drucker stability: the second derivatives of W by logarithmic strains without a trace", "[law]") {
  // Yeoh with c₂ < 0 in planar tension, stretches l, 1, 1/l: with g = ∂I₁/∂ln λ = 2 λ², h = ∂g/∂ln λ = 4 λ² the matrix
  // is ψ′ diag(h) + ψ″ g gᵀ, on (1, 0, −1)/√2 and (1, −2, 1)/√6.
  const double c1 = 1000, c2 = -150;
  const LawConstants yeoh{.law = "yeoh", .terms = {{c1}, {c2}}};
  const auto determinant = [&](double l) {
    const double a = l * l, b = 1 / a, slope = c1 + 2 * c2 * (a + b - 2), bend = 2 * c2;
    const double gu = 2 * (a - b) / std::sqrt(2), gv = 2 * (a - 2 + b) / std::sqrt(6);
    const double uu = slope * 2 * (a + b) + bend * gu * gu, vv = slope * 4 * (a + 4 + b) / 6 + bend * gv * gv,
                 uv = slope * 4 * (a - b) / std::sqrt(12) + bend * gu * gv;
    return uu * vv - uv * uv;
  };
  double low = 1, high = 2;  // at rest it is positive
  for (int halving = 0; halving < 60; ++halving) {
    const double middle = (low + high) / 2;
    (determinant(middle) > 0 ? low : high) = middle;
  }
  CHECK(low > 1.2);
  CHECK(low < 1.9);
  CHECK(state_of(yeoh, HomogeneousTest::planar, low - 1.0001).value().stable);
  CHECK_FALSE(state_of(yeoh, HomogeneousTest::planar, low - 0.9999).value().stable);
  // And one with positive constants is stable everywhere.
  const LawConstants mooney{.law = "mooney_rivlin", .numbers = {{"c1", 1500}, {"c2", 400}}};
  for (const HomogeneousTest test : kHomogeneousTests)
    for (const double amount : {-0.6, -0.2, 0.5, 3.}) CHECK(state_of(mooney, test, amount).value().stable);
}

namespace {

struct Datum {
  HomogeneousTest test;
  double stretch, stress;  ///< nominal [Pa]
};

std::vector<Datum> treloar() {
  std::ifstream file(std::string(ELASTIN_SOURCE_DIR) + "/scenes/identify/treloar_1944.csv");
  std::vector<Datum> data;
  for (std::string line; std::getline(file, line);)
    for (const HomogeneousTest test : kHomogeneousTests) {
      const std::string name = std::string(name_of(test)) + ",";
      if (!line.starts_with(name)) continue;
      const std::size_t comma = line.find(',', name.size());
      data.push_back({test, std::stod(line.substr(name.size())), 1e6 * std::stod(line.substr(comma + 1))});
    }
  return data;
}

}  // namespace

TEST_CASE("laws fitted to Treloar's rubber miss its three tests by as much as is known", "[law]") {
  // Root mean squares of relative errors [%] of fits to all tests together, incompressible: computed by others from the
  // closed forms.
  const std::vector<Datum> data = treloar();
  REQUIRE(data.size() == 24 + 13 + 16);
  const auto check = [&](const LawConstants& constants, double uniaxial, double planar, double equibiaxial) {
    const Material material = material_with(constants);
    const auto row = kCatalog.material_laws.find(constants.law);
    std::map<HomogeneousTest, std::pair<double, int>> sums;
    for (const Datum& datum : data) {
      const auto state = homogeneous_state(*row, material, datum.test, datum.stretch - 1);
      REQUIRE(state);
      auto& [sum, count] = sums[datum.test];
      sum += std::pow(state->stress / datum.stress - 1, 2), ++count;
    }
    const auto percent = [&](HomogeneousTest test) {
      return 100 * std::sqrt(sums.at(test).first / sums.at(test).second);
    };
    INFO(constants.law);
    CHECK(percent(HomogeneousTest::uniaxial) == Approx(uniaxial).margin(0.5));
    CHECK(percent(HomogeneousTest::planar) == Approx(planar).margin(0.5));
    CHECK(percent(HomogeneousTest::equibiaxial) == Approx(equibiaxial).margin(0.5));
  };
  check({.law = "yeoh", .terms = {{0.19e6}}}, 31, 13, 14);
  check({.law = "mooney_rivlin", .numbers = {{"c1", 0.1828e6}, {"c2", 0.00353e6}}}, 31, 11, 7.4);
  check({.law = "yeoh", .terms = {{0.1852e6}, {-0.00145e6}, {3.97e-5 * 1e6}}}, 16, 6.3, 13.8);
  check({.law = "ogden",
         .words = {{"convention", "febio"}},
         .terms = {{0.512e6 * 1.453, 1.453}, {473 * 5.49, 5.49}, {0.0165e6 * 1.87, -1.87}}},
        13.5, 7.6, 3.0);
}
