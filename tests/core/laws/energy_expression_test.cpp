#include "elastin/core/laws/energy_expression.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "core/laws/solids/components.h"
#include "core/laws/solids/mooney_rivlin.h"
#include "core/laws/solids/neo_hookean.h"
#include "elastin/core/base/error.h"
#include "elastin/core/simulation/energy_law.h"

using namespace elastin;
using Catch::Matchers::Contains;

namespace {

EnergyOperation of(const char* kind, std::vector<int> values = {}) { return {kind, std::move(values), 0, ""}; }
EnergyOperation fixed(double value) { return {"number", {}, value, ""}; }
EnergyOperation parameter(const char* name) { return {"parameter", {}, 0, name}; }

/// μ/2 (I₁ − 3) − μ ln J + λ/2 (J − 1)².
EnergyExpression neo_hookean() {
  return EnergyExpression({parameter("mu"), parameter("lam"), fixed(0.5), of("first"), of("swelling"),
                           of("multiply", {0, 2}), of("multiply", {5, 3}), of("log1p", {4}), of("multiply", {0, 7}),
                           of("subtract", {6, 8}), of("square", {4}), of("multiply", {1, 10}), of("multiply", {2, 11}),
                           of("add", {9, 12})});
}

Matrix3 strain(double amount, unsigned seed) {
  std::mt19937 numbers(seed);
  std::uniform_real_distribution<double> uniform(-amount, amount);
  Matrix3 F = Matrix3::Identity();
  for (double& entry : F.reshaped()) entry += uniform(numbers);
  return F.transpose() * F - Matrix3::Identity();
}

}  // namespace

static_assert(PointLaw<EnergyExpression::Point, 3> && HasEnergyDensity<EnergyExpression::Point, 3>);

TEST_CASE("An energy of invariants is the law that has it", "[laws]") {
  const double mu = 3e4, lambda = 7e4;
  const auto own = neo_hookean().at({mu, lambda});
  const NeoHookean::Solid law{lambda, mu};
  for (const double amount : {1e-8, 1e-3, 0.1, 0.5}) {
    const Matrix3 A = strain(amount, 3);
    CAPTURE(amount);
    // Both are differences of terms of the size of μ: there rounding shows.
    CHECK((own.stress(A) - law.stress(A)).norm() <= 1e-11 * law.stress(A).norm() + 1e-15 * mu);
    CHECK((own.tangent(A) - law.tangent(A)).norm() <= 1e-12 * law.tangent(A).norm());
    // Near rest tr A and ln J nearly cancel, in both alike.
    CHECK(own.energy(A) == Approx(law.energy(A)).epsilon(1e-12).margin(1e-15 * mu * amount));
  }
  Matrix3 flat = -Matrix3::Identity();
  CHECK(own.energy(flat) == std::numeric_limits<double>::infinity());
  CHECK(own.stress(flat).allFinite());
}

TEST_CASE("Every operation has the slopes of its values", "[laws]") {
  // W = μ/2 (I₁ − 3) − μ ln J + μ (J − 1)², and f(x) of x = (J − 1)² + I₂ − 3 − 4 ln J, which has no slope at rest.
  const std::vector<EnergyOperation> first{parameter("mu"),
                                           of("first"),
                                           of("second"),
                                           of("swelling"),
                                           of("square", {3}),
                                           of("log1p", {3}),
                                           fixed(4),
                                           of("multiply", {6, 5}),
                                           of("subtract", {2, 7}),
                                           of("add", {4, 8}),
                                           of("multiply", {0, 4}),
                                           fixed(0.5),
                                           of("multiply", {1, 11}),
                                           of("subtract", {12, 5}),
                                           of("multiply", {13, 0}),
                                           of("add", {14, 10})};
  for (const auto& [name, takes] : energy_operations()) {
    if (name == "less") continue;  // has no slope; `select` is made with it
    std::vector<EnergyOperation> list = first;
    const auto add = [&](EnergyOperation operation) {
      list.push_back(std::move(operation));
      return static_cast<int>(list.size()) - 1;
    };
    const int shifted = add(of("add", {9, 11})), half = add(of("multiply", {9, 11}));
    int last = 0;
    if (name == "select")
      last = add(of("select", {add(of("less", {half, 9})), shifted, half}));
    else if (takes == 2)
      last = add(of(name.c_str(), {shifted, add(of("add", {half, 11}))}));
    else
      last = add(of(name.c_str(), {shifted}));
    const int scaled = add(of("multiply", {last, add(fixed(300))}));
    add(of("add", {15, scaled}));
    CAPTURE(name);
    std::optional<EnergyExpression::Point> law;
    try {
      law = EnergyExpression(list).at({1e4});
    } catch (const InputError& error) {
      CHECK_THAT(error.what(), Contains("unstable at rest"));  // −x², or as falling: nothing to test
      continue;
    }
    const Matrix3 A = strain(0.2, 5);
    const auto tangent = law->tangent(A);
    for (int column = 0; column < 6; ++column) {
      const auto [i, j] = kComponents[column];
      Matrix3 step = Matrix3::Zero();
      const double h = 1e-5;
      step(i, j) += h / 2, step(j, i) += h / 2;
      const double slope = (law->energy(A + step) - law->energy(A - step)) / (2 * h);
      CHECK(law->stress(A)(i, j) / 2 == Approx(slope).epsilon(1e-6).margin(1e-6 * law->stress(A).norm()));
      const Components change = components((law->stress(A + step) - law->stress(A - step)) / (2 * h));
      CHECK((tangent.col(column) - change).norm() <= 1e-6 * tangent.norm());
    }
  }
}

TEST_CASE("Invariants of fibres have the slopes of their values", "[laws]") {
  // W = μ/2 (I₁ − 3) − μ ln J + μ (J − 1)² + μ (e^(x²) − 1) + μ x y, x = I₄ − 1, y = I₅ − 1.
  const EnergyExpression energy({parameter("mu"), of("first"), of("swelling"), of("fibre"), of("fibre_square"),
                                 fixed(0.5), of("multiply", {1, 5}), of("log1p", {2}), of("subtract", {6, 7}),
                                 of("square", {2}), of("add", {8, 9}), of("square", {3}), of("expm1", {11}),
                                 of("add", {10, 12}), of("multiply", {3, 4}), of("add", {13, 14}),
                                 of("multiply", {0, 15})});
  REQUIRE(energy.has_fibre());
  const auto law = energy.at({1e4}, 1, Vector3(2, -1, 2) / 3);
  const Matrix3 A = strain(0.2, 7);
  const auto tangent = law.tangent(A);
  CHECK((tangent - tangent.transpose()).norm() <= 1e-12 * tangent.norm());
  for (int column = 0; column < 6; ++column) {
    const auto [i, j] = kComponents[column];
    Matrix3 step = Matrix3::Zero();
    const double h = 1e-5;
    step(i, j) += h / 2, step(j, i) += h / 2;
    const double slope = (law.energy(A + step) - law.energy(A - step)) / (2 * h);
    CHECK(law.stress(A)(i, j) / 2 == Approx(slope).epsilon(1e-6).margin(1e-6 * law.stress(A).norm()));
    const Components change = components((law.stress(A + step) - law.stress(A - step)) / (2 * h));
    CHECK((tangent.col(column) - change).norm() <= 1e-6 * tangent.norm());
  }
}

TEST_CASE("What is no energy is refused", "[laws]") {
  CHECK_THROWS_WITH(EnergyExpression({of("squre", {0})}), Contains("did you mean 'square'"));
  CHECK_THROWS_WITH(EnergyExpression({of("first"), of("add", {0})}), Contains("takes 2 values, and not 1"));
  CHECK_THROWS_WITH(EnergyExpression({of("first"), of("square", {1})}), Contains("allowed: 0 to 0"));
  CHECK_THROWS_WITH(EnergyExpression({}), Contains("allowed: 1 to 256"));
  CHECK_THROWS_WITH(EnergyExpression({of("first")}).at({}), Contains("a stress of 2 Pa at rest"));
  CHECK_THROWS_WITH(EnergyExpression({of("swelling"), of("square", {0})}).at({}), Contains("unstable at rest"));
  CHECK_THROWS_WITH(make_energy_law("own", neo_hookean(), {{"mu", dimension::none, 0, 1, 0, ""}}),
                    Contains("comes from the material"));
  CHECK_THROWS_WITH(make_energy_law("own", EnergyExpression({parameter("nuu")})), Contains("did you mean 'nu'"));
}
