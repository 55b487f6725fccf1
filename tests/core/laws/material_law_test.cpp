// Laws with constants of their own: stress and tangent by differences, closed forms, moduli at rest, what is refused.

#include "elastin/core/laws/material_law.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>

#include "core/laws/solids/mooney_rivlin.h"
#include "core/laws/solids/ogden.h"
#include "core/laws/solids/yeoh.h"
#include "elastin/core/base/error.h"
#include "elastin/core/simulation/catalog.h"
#include "support/cells.h"
#include "support/law_constants.h"

using namespace elastin;
using namespace elastin::testing;

namespace {

const Catalog kCatalog = built_in_catalog();

Material material_with(const LawConstants& constants) {
  return with_law(*kCatalog.material_laws.find(constants.law), constants, material_of(5e3, 0.3));
}

/// C − I of random states: any; nearly rest; two or three equal stretches, exactly or up to 1e-9 … 1e-3, in any axes.
Matrix3 random_strain(Random& random, int trial) {
  const Matrix3 turn = random.rotation();
  Vector3 stretch = (1 + 0.35 * random.matrix<3, 1>().array()).matrix();
  const double apart[] = {0, 1e-12, 1e-9, 1e-6, 1e-3};
  const double little = apart[trial % 5];
  if (trial % 4 == 1) stretch = (1 + little * random.matrix<3, 1>().array()).matrix();
  if (trial % 4 == 2) stretch[1] = stretch[0] * (1 + little);
  if (trial % 4 == 3) stretch[1] = stretch[0] * (1 + little), stretch[2] = stretch[0] * (1 - little / 2);
  const Matrix3 A = turn.transpose() * (stretch.cwiseAbs2() - Vector3::Ones()).asDiagonal() * turn;
  return (A + A.transpose()) / 2;
}

/// Nominal stresses [Pa] of an incompressible solid along 1 where 3 is free, and the shear stress, off the law's shape.
struct Homogeneous {
  AnyPoint<3> shape;

  Matrix3 kirchhoff(const Matrix3& F) const {
    return F * shape.stress(F.transpose() * F - Matrix3::Identity()) * F.transpose();
  }
  double tension(const Vector3& stretch) const {
    const Matrix3 tau = kirchhoff(stretch.asDiagonal());
    return (tau(0, 0) - tau(2, 2)) / stretch[0];
  }
  double uniaxial(double l) const { return tension({l, 1 / std::sqrt(l), 1 / std::sqrt(l)}); }
  double planar(double l) const { return tension({l, 1, 1 / l}); }
  double equibiaxial(double l) const { return tension({l, l, 1 / (l * l)}); }
  double shear(double amount) const {
    Matrix3 F = Matrix3::Identity();
    F(0, 1) = amount;
    return kirchhoff(F)(0, 1);
  }
};

/// The same of a law ψ(I₁, I₂) from its slopes, textbook.
struct ByInvariants {
  std::function<std::pair<double, double>(double I1, double I2)> slopes;

  double tension(double a, double b, double c) const {  // stretches along, across, free
    const double I1 = a * a + b * b + c * c, I2 = 1 / (a * a) + 1 / (b * b) + 1 / (c * c);
    const auto [w1, w2] = slopes(I1, I2);
    return 2 * ((a * a - c * c) * w1 + (1 / (c * c) - 1 / (a * a)) * w2) / a;
  }
  double shear(double amount) const {
    const auto [w1, w2] = slopes(3 + amount * amount, 3 + amount * amount);
    return 2 * (w1 + w2) * amount;
  }
};

void check_closed_forms(const LawConstants& constants, const ByInvariants& expected) {
  const Homogeneous law{kCatalog.material_laws.find(constants.law)->shape(material_with(constants))};
  for (const double l : {0.5, 0.9, 1.001, 1.3, 2., 3.}) {
    INFO(constants.law << " at stretch " << l);
    CHECK(law.uniaxial(l) == Approx(expected.tension(l, 1 / std::sqrt(l), 1 / std::sqrt(l))).epsilon(1e-11));
    CHECK(law.planar(l) == Approx(expected.tension(l, 1, 1 / l)).epsilon(1e-11));
    CHECK(law.equibiaxial(l) == Approx(expected.tension(l, l, 1 / (l * l))).epsilon(1e-11));
    CHECK(law.shear(l) == Approx(expected.shear(l)).epsilon(1e-11));
  }
}

}  // namespace

TEST_CASE("every material law: S = 2 dW/dC, and its tangent", "[law]") {
  const auto constants = law_constants();
  for (const auto& row : kCatalog.material_laws) {
    INFO(row->name);
    REQUIRE(constants.contains(row->name));
    const Material material = material_with(constants.at(row->name));
    const auto law = row->solid(material);
    const double stiffness = law.tangent(Matrix3::Zero()).norm();
    Random random(71);
    for (int trial = 0; trial < 200; ++trial) {
      INFO("trial " << trial);
      const Matrix3 A = random_strain(random, trial), any = random.matrix<3, 3>(),
                    direction = (any + any.transpose()) / 2;
      const double h = 3e-4;  // of fourth order: truncation of some h⁴ = 1e-14, rounding of 1e-16/h
      const auto energy = [&](double times) { return law.energy(A + times * h * direction); };
      const double rate = (8 * (energy(1) - energy(-1)) - energy(2) + energy(-2)) / (12 * h);
      const Matrix3 S = law.stress(A);
      CHECK(std::abs(rate - S.cwiseProduct(direction).sum() / 2) <= 1e-8 * (S.norm() + stiffness));
      const auto stress = [&](double times) -> Matrix3 { return law.stress(A + times * h * direction); };
      const Matrix3 change = (8 * (stress(1) - stress(-1)) - stress(2) + stress(-2)) / (12 * h);
      Components strain = components(direction);
      strain.tail<3>() *= 2;
      const TangentModuli<3> tangent = law.tangent(A);
      CHECK((tangent * strain - components(change)).norm() <= 1e-8 * (tangent.norm() + stiffness));
      CHECK((tangent - tangent.transpose()).norm() <= 1e-12 * tangent.norm());
      CHECK(law.energy(A) >= -1e-16 * stiffness);
    }
  }
}

TEST_CASE("every material law keeps its digits near rest", "[law]") {
  // S of a strain of 1e-9 is the tangent at rest times it, up to 1e-9 of itself.
  const auto constants = law_constants();
  Random random(72);
  for (const auto& row : kCatalog.material_laws) {
    const auto law = row->solid(material_with(constants.at(row->name)));
    const TangentModuli<3> tangent = law.tangent(Matrix3::Zero());
    const Matrix3 any = random.matrix<3, 3>(), A = 1e-9 * (any + any.transpose());
    Components strain = components(A);
    strain.tail<3>() *= 2;
    const Components expected = tangent * strain;
    INFO(row->name);
    CHECK((components(law.stress(A)) - expected).norm() <= 1e-7 * expected.norm());
    CHECK(law.stress(Matrix3::Zero()).norm() <= 1e-14 * tangent.norm());
  }
}

TEST_CASE("every material law: a point that falls flat pushes apart and has no finite energy", "[law]") {
  const auto constants = law_constants();
  Random random(73);
  for (const auto& row : kCatalog.material_laws) {
    INFO(row->name);
    const auto law = row->solid(material_with(constants.at(row->name)));
    for (int trial = 0; trial < 30; ++trial) {
      const Matrix3 turn = random.rotation();
      const Vector3 n = turn.row(2).transpose();
      Matrix3 flat = turn.transpose() * Vector3(0.2, -0.1, -1).asDiagonal() * turn;
      if (trial % 3 == 1) flat *= 3;  // no deformation at all: C is not positive
      if (trial % 3 == 2) flat = -Matrix3::Identity();
      CHECK(law.energy(flat) == std::numeric_limits<double>::infinity());
      CHECK(law.stress(flat).allFinite());
      CHECK(law.tangent(flat).allFinite());
      if (trial % 3 == 0) CHECK(n.dot(law.stress(flat) * n) < 0);
    }
  }
}

TEST_CASE("a material law's moduli scale with the material's E", "[law]") {
  const auto constants = law_constants(), twice = law_constants(2);
  Random random(74);
  const Matrix3 A = random_strain(random, 0);
  for (const auto& row : kCatalog.material_laws) {
    if (row->from_moduli) continue;
    INFO(row->name);
    Material material = material_with(constants.at(row->name));
    const Matrix3 S = row->solid(material).stress(A);
    material.youngs_modulus *= 2;  // a stiffer region
    CHECK((row->solid(material).stress(A) - 2 * S).norm() <= 1e-14 * S.norm());
    const Material stiffer = material_with(twice.at(row->name));
    CHECK((row->solid(stiffer).stress(A) - 2 * S).norm() <= 1e-14 * S.norm());
    CHECK(stiffer.youngs_modulus == Approx(material.youngs_modulus).epsilon(1e-14));
    CHECK(stiffer.poissons_ratio == Approx(material.poissons_ratio).epsilon(1e-14));
  }
}

TEST_CASE("Mooney-Rivlin and Yeoh: tension, planar tension, equibiaxial tension and shear", "[law]") {
  check_closed_forms({.law = "mooney_rivlin", .numbers = {{"c1", 1500}, {"c2", 400}}},
                     {[](double, double) { return std::pair(1500., 400.); }});
  check_closed_forms({.law = "yeoh", .terms = {{1700}, {-90}, {40}}}, {[](double I1, double) {
                       const double x = I1 - 3;
                       return std::pair(1700 - 2 * 90 * x + 3 * 40 * x * x, 0.);
                     }});
}

TEST_CASE("Ogden: tension, planar tension, equibiaxial tension and shear, in each convention", "[law]") {
  // W = Σ c/m² (λ₁^m + λ₂^m + λ₃^m − 3): nominal stress Σ c/m (λ^(m−1) − free stretch^m/λ).
  const std::vector<std::pair<double, double>> terms{{5200, 1.3}, {40, 5}, {120, -2}};
  const auto closed = [&](double along, double free) {
    double sum = 0;
    for (const auto& [c, m] : terms) sum += c / m * (std::pow(along, m) - std::pow(free, m)) / along;
    return sum;
  };
  for (const auto& [convention, mu] :
       std::map<std::string, std::function<double(double, double)>>{{"ogden", [](double c, double m) { return c / m; }},
                                                                    {"abaqus", [](double c, double) { return c / 2; }},
                                                                    {"febio", [](double c, double) { return c; }}}) {
    LawConstants constants{.law = "ogden", .words = {{"convention", convention}}};
    for (const auto& [c, m] : terms) constants.terms.push_back({mu(c, m), m});
    const Material material = material_with(constants);
    CHECK(material.youngs_modulus == Approx(3 * (5200 + 40 + 120) / 2.).epsilon(1e-13));
    const Homogeneous law{kCatalog.material_laws.find("ogden")->shape(material)};
    for (const double l : {0.5, 0.9, 1.001, 1.3, 2., 3.}) {
      INFO(convention << " at stretch " << l);
      CHECK(law.uniaxial(l) == Approx(closed(l, 1 / std::sqrt(l))).epsilon(1e-11));
      CHECK(law.planar(l) == Approx(closed(l, 1 / l)).epsilon(1e-11));
      CHECK(law.equibiaxial(l) == Approx(closed(l, 1 / (l * l))).epsilon(1e-11));
      // Simple shear: principal stretches s and 1/s, and the shear stress (τ₁ − τ₂)/(s + 1/s).
      const double s = l / 2 + std::sqrt(1 + l * l / 4);
      CHECK(law.shear(l) == Approx(closed(s, 1 / s) * s / (s + 1 / s)).epsilon(1e-11));
    }
  }
}

TEST_CASE("Ogden with exponents 2 and -2 is Mooney-Rivlin, with one of 2 and one term of Yeoh neo-Hookean", "[law]") {
  const auto solid = [](const LawConstants& constants) {
    return kCatalog.material_laws.find(constants.law)->solid(material_with(constants));
  };
  const std::map<std::string, double> bulk{{"bulk_modulus", 4e4}};
  const auto ogden = solid({.law = "ogden", .numbers = bulk, .terms = {{3000, 2}, {-800, -2}}});
  const auto mooney = solid({.law = "mooney_rivlin", .numbers = {{"c1", 1500}, {"c2", 400}, {"bulk_modulus", 4e4}}});
  const auto yeoh = solid({.law = "yeoh", .numbers = bulk, .terms = {{1500}}});
  const auto neo = solid({.law = "ogden", .numbers = bulk, .terms = {{3000, 2}}});
  Random random(75);
  for (int trial = 0; trial < 100; ++trial) {
    const Matrix3 A = random_strain(random, trial);
    const auto same = [&](const auto& one, const auto& other) {
      const double scale = other.tangent(A).norm();
      CHECK((one.stress(A) - other.stress(A)).norm() <= 1e-12 * scale);
      CHECK((one.tangent(A) - other.tangent(A)).norm() <= 1e-11 * scale);
      CHECK(std::abs(one.energy(A) - other.energy(A)) <= 1e-13 * scale);
    };
    same(ogden, mooney);
    same(neo, yeoh);
  }
}

TEST_CASE("neo_hookean_log in uniaxial stress", "[law]") {
  // σ_i = (μ (λ_i² − 1) + λ ln J)/J: across it vanishes, and along P = μ (l − w²/l) with w the stretch across.
  const Material material = material_with({.law = "neo_hookean_log"});
  const double mu = 5e3 / 2.6, lambda = 5e3 * 0.3 / (1.3 * 0.4);
  const auto law = kCatalog.material_laws.find("neo_hookean_log")->solid(material);
  for (const double l : {0.6, 0.99, 1.2, 2.}) {
    double low = 0.3, high = 2;  // of mu (w² − 1) + lambda ln(l w²), which increases with w
    for (int halving = 0; halving < 60; ++halving) {
      const double w = (low + high) / 2;
      (mu * (w * w - 1) + lambda * std::log(l * w * w) < 0 ? low : high) = w;
    }
    const Matrix3 S = law.stress(Vector3(l * l - 1, low * low - 1, low * low - 1).asDiagonal());
    CHECK(l * S(0, 0) == Approx(mu * (l - low * low / l)).epsilon(1e-12));
    CHECK(std::abs(S(1, 1)) <= 1e-12 * mu);
    CHECK(law.energy(Vector3(l * l - 1, low * low - 1, low * low - 1).asDiagonal()) ==
          Approx(mu / 2 * (l * l + 2 * low * low - 3) - mu * std::log(l * low * low) +
                 lambda / 2 * std::pow(std::log(l * low * low), 2))
              .epsilon(1e-12));
  }
}

TEST_CASE("a material law in plane stress is the incompressible solid whose thickness has no stress", "[law]") {
  const auto constants = law_constants();
  int membranes = 0;
  const auto check = [&]<class Law>(std::type_identity<Law>) {
    ++membranes;
    INFO(Law::name);
    const Material material = material_with(constants.at(std::string(Law::name)));
    const auto membrane = Law{}.membrane(material);
    const auto shape = Law{}.shape(material);
    Random random(76);
    for (int trial = 0; trial < 40; ++trial) {
      const Matrix3 any = random_strain(random, trial);
      const Eigen::Matrix2d A = any.topLeftCorner<2, 2>();
      const double D = (Eigen::Matrix2d::Identity() + A).determinant();
      Matrix3 full = Matrix3::Zero();
      full.topLeftCorner<2, 2>() = A;
      full(2, 2) = 1 / D - 1;
      const Matrix3 S = shape.stress(full), G = (Matrix3::Identity() + full).inverse();
      const Eigen::Matrix2d expected = material.thickness * (S - S(2, 2) / G(2, 2) * G).topLeftCorner<2, 2>();
      const double scale = membrane.tangent(A).norm();
      CHECK((membrane.stress(A) - expected).norm() <= 1e-11 * scale);
      CHECK(std::abs(membrane.energy(A) - material.thickness * shape.energy(full)) <= 1e-12 * scale);
      // And its tangent by differences.
      const Eigen::Matrix2d some = random.matrix<2, 2>(), direction = (some + some.transpose()) / 2;
      const double h = 3e-4;
      const auto stress = [&](double times) -> Eigen::Matrix2d { return membrane.stress(A + times * h * direction); };
      const Eigen::Matrix2d change = (8 * (stress(1) - stress(-1)) - stress(2) + stress(-2)) / (12 * h);
      const Vector3 rates = membrane.tangent(A) * Vector3(direction(0, 0), direction(1, 1), 2 * direction(0, 1));
      CHECK((rates - Vector3(change(0, 0), change(1, 1), change(0, 1))).norm() <= 1e-8 * scale);
    }
  };
  check(std::type_identity<MooneyRivlin>{});
  check(std::type_identity<Yeoh>{});
  check(std::type_identity<Ogden>{});
  int listed = 0;
  for (const Strategy& strategy : kCatalog.strategies())
    listed += !strategy.law.empty() && strategy.name.ends_with("_membrane");
  CHECK(membranes == listed);
}

TEST_CASE("E and nu at rest follow from a law's constants", "[law]") {
  const auto moduli = [](double mu, double K) {
    return std::pair(9 * K * mu / (3 * K + mu), (3 * K - 2 * mu) / (6 * K + 2 * mu));
  };
  const auto check = [&](const LawConstants& constants, double mu) {
    INFO(constants.law);
    const Material material = material_with(constants);
    const auto [E, nu] = moduli(mu, 4e4);
    CHECK(material.youngs_modulus == Approx(E).epsilon(1e-13));
    CHECK(material.poissons_ratio == Approx(nu).epsilon(1e-13));
    CHECK(material.law->youngs_modulus == material.youngs_modulus);
    LawConstants incompressible = constants;
    incompressible.numbers.erase("bulk_modulus");
    CHECK(material_with(incompressible).youngs_modulus == Approx(3 * mu).epsilon(1e-13));
    CHECK(material_with(incompressible).poissons_ratio == 0.5);
  };
  const std::map<std::string, double> bulk{{"bulk_modulus", 4e4}};
  check({.law = "mooney_rivlin", .numbers = {{"c1", 1500}, {"c2", 400}, {"bulk_modulus", 4e4}}}, 3800);
  check({.law = "yeoh", .numbers = bulk, .terms = {{1700}, {-90}, {40}}}, 3400);
  check({.law = "ogden", .numbers = bulk, .terms = {{630e3, 1.3}, {1.2e3, 5}, {-10e3, -2}}},
        (630e3 * 1.3 + 1.2e3 * 5 + 10e3 * 2) / 2);
  const Material given = material_with({.law = "neo_hookean_log"});
  CHECK(given.youngs_modulus == 5e3);
  CHECK(given.poissons_ratio == 0.3);
}

TEST_CASE("constants that a law does not have or cannot take are refused with why", "[law]") {
  const auto refused = [](const LawConstants& constants, const char* why) {
    INFO(constants.law);
    CHECK_THROWS_WITH(material_with(constants), Catch::Contains(why));
  };
  refused({.law = "mooney_rivlin", .numbers = {{"c2", 400}}}, "mooney_rivlin needs 'c1'");
  refused({.law = "mooney_rivlin", .numbers = {{"c1", 100}, {"c2", -400}}}, "unstable at rest");
  refused({.law = "mooney_rivlin", .numbers = {{"c1", 100}, {"c2", -400}}}, "-600 Pa");
  refused({.law = "mooney_rivlin", .numbers = {{"c1", 100}, {"bulk_moduls", 400}}}, "did you mean 'bulk_modulus'");
  refused({.law = "mooney_rivlin", .numbers = {{"c1", 100}, {"bulk_modulus", -1}}}, "above 0 Pa");
  refused({.law = "mooney_rivlin", .numbers = {{"c1", 100}}, .words = {{"volumetric", "quadratc"}}},
          "did you mean 'quadratic'");
  refused({.law = "mooney_rivlin", .numbers = {{"c1", 100}}, .terms = {{1}}}, "has no terms");
  refused({.law = "yeoh", .terms = {{-100}, {50}}}, "unstable at rest");
  refused({.law = "yeoh", .terms = {{1}, {1}, {1}, {1}, {1}, {1}, {1}}}, "takes 1 to 6");
  refused({.law = "ogden"}, "takes 1 to 6");
  refused({.law = "ogden", .terms = {{100}}}, "needs 2 numbers, not 1");
  refused({.law = "ogden", .terms = {{100, 0}}}, "exponent 0");
  refused({.law = "ogden", .terms = {{100, -2}}}, "unstable at rest");
  refused({.law = "ogden", .words = {{"convention", "abacus"}}, .terms = {{100, 2}}}, "did you mean 'abaqus'");
  refused({.law = "neo_hookean_log", .numbers = {{"c1", 1}}}, "takes no parameters");
  CHECK_THROWS_WITH(kCatalog.material_laws.find("odgen"), Catch::Contains("did you mean 'ogden'"));
  CHECK_THROWS_WITH(MooneyRivlin{}.solid(material_of(1, 0.3)), Catch::Contains("no constants of mooney_rivlin"));
}

TEST_CASE("a strategy says which constants it lacks", "[law]") {
  const Material plain = material_of(5e3, 0.3);
  Material ogden = material_with(law_constants().at("ogden")), incompressible = ogden;
  incompressible.law->numbers.erase("bulk_modulus");
  const Strategy solid = kCatalog.find("ogden"), membrane = kCatalog.find("ogden_membrane");
  CHECK_THAT(solid.unsuited_material(plain), Catch::Contains("`law: ogden`"));
  CHECK_THAT(kCatalog.find("yeoh").unsuited_material(ogden), Catch::Contains("`law: yeoh`"));
  CHECK_THAT(solid.unsuited_material(incompressible), Catch::Contains("bulk_modulus"));
  CHECK(solid.unsuited_material(ogden).empty());
  CHECK(membrane.unsuited_material(incompressible).empty());
  CHECK(kCatalog.find("neo_hookean_log").unsuited_material(plain).empty());
  CHECK(kCatalog.find("neo_hookean").unsuited_material(ogden).empty());
}
