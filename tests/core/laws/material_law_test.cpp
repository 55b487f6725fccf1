// Laws with constants of their own: stress and tangent by differences, closed forms, moduli at rest, what is refused.

#include "elastin/core/laws/material_law.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>

#include "core/laws/solids/arruda_boyce.h"
#include "core/laws/solids/mooney_rivlin.h"
#include "core/laws/solids/ogden.h"
#include "core/laws/solids/veronda_westmann.h"
#include "core/laws/solids/yeoh.h"
#include "elastin/core/base/error.h"
#include "elastin/core/simulation/catalog.h"
#include "support/cells.h"
#include "support/law_constants.h"

using namespace elastin;
using namespace elastin::testing;

namespace {

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
    int smooth = 0;
    for (int trial = 0; trial < 200; ++trial) {
      INFO("trial " << trial);
      const Matrix3 A = random_strain(random, trial), any = random.matrix<3, 3>(),
                    direction = (any + any.transpose()) / 2;
      const double h = 3e-4;  // of fourth order: truncation of some h⁴ = 1e-14, rounding of 1e-16/h
      // Where fibres begin to bear the tangent jumps, and no difference across shows it.
      const TangentModuli<3> bend =
          law.tangent(A + 2 * h * direction) - 2 * law.tangent(A) + law.tangent(A - 2 * h * direction);
      if (bend.norm() > 1e-4 * law.tangent(A).norm()) continue;
      ++smooth;
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
    CHECK(smooth >= 100);
  }
}

TEST_CASE("every material law keeps its digits near rest", "[law]") {
  // S of a strain of 1e-9 is the tangent times it, up to 1e-9 of itself: on either side where fibres begin to bear.
  const auto constants = law_constants();
  Random random(72);
  for (const auto& row : kCatalog.material_laws) {
    const auto law = row->solid(material_with(constants.at(row->name)));
    const Matrix3 any = random.matrix<3, 3>(), A = 1e-9 * (any + any.transpose());
    const TangentModuli<3> tangent = law.tangent(A);
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

TEST_CASE("every material law turns with its directions", "[law]") {
  const auto constants = law_constants();
  Random random(77);
  for (const auto& row : kCatalog.material_laws) {
    INFO(row->name);
    const Material material = material_with(constants.at(row->name));
    int anisotropic = 0;
    for (int trial = 0; trial < 20; ++trial) {
      const Matrix3 A = random_strain(random, 4), R = random.rotation();
      Material turned = material;
      rotate(turned, R);
      const Matrix3 S = row->solid(material).stress(A), of_turned = row->solid(turned).stress(R * A * R.transpose());
      CHECK((of_turned - R * S * R.transpose()).norm() <= 1e-12 * S.norm());
      const double without = (row->solid(material).stress(R * A * R.transpose()) - R * S * R.transpose()).norm();
      anisotropic += without > 1e-3 * S.norm();
    }
    // Fibres that are pressed do not show.
    CHECK((material.law->directions.empty() ? anisotropic == 0 : anisotropic > 5));
  }
}

TEST_CASE("laws of the invariants: tension, planar tension, equibiaxial tension and shear", "[law]") {
  check_closed_forms({.law = "mooney_rivlin", .numbers = {{"c1", 1500}, {"c2", 400}}},
                     {[](double, double) { return std::pair(1500., 400.); }});
  check_closed_forms({.law = "yeoh", .terms = {{1700}, {-90}, {40}}}, {[](double I1, double) {
                       const double x = I1 - 3;
                       return std::pair(1700 - 2 * 90 * x + 3 * 40 * x * x, 0.);
                     }});
  check_closed_forms({.law = "veronda_westmann", .numbers = {{"c1", 1400}, {"c2", 0.8}}}, {[](double I1, double) {
                       return std::pair(1400 * 0.8 * std::exp(0.8 * (I1 - 3)), -1400 * 0.8 / 2);
                     }});
  check_closed_forms(
      {.law = "arruda_boyce", .numbers = {{"mu", 3000}, {"N", 7}}}, {[](double I1, double) {
        const double x = I1 / 7;
        return std::pair(
            3000 * (1. / 2 + x / 10 + 11 * x * x / 350 + 19 * x * x * x / 1750 + 519 * x * x * x * x / 134750), 0.);
      }});
}

TEST_CASE("fibres with a toe region: tension along them and across", "[law]") {
  const double c1 = 1200, c2 = 300, c3 = 900, c4 = 12, c5 = 4e4, straight = 1.12;
  const LawConstants constants{
      .law = "transversely_isotropic",
      .numbers = {{"c1", c1}, {"c2", c2}, {"c3", c3}, {"c4", c4}, {"c5", c5}, {"lambda_max", straight}},
      .directions = {{"direction", Vector3::UnitX()}}};
  const auto& row = *kCatalog.material_laws.find("transversely_isotropic");
  const Homogeneous law{row.shape(material_with(constants))};
  for (const double l : {0.7, 0.99, 1.03, 1.1199, 1.1201, 1.6}) {
    INFO("stretch " << l);
    const double matrix = 2 * (l - 1 / (l * l)) * (c1 + c2 / l);
    const double toe = c3 * (std::exp(c4 * (std::min(l, straight) - 1)) - 1);
    const double fibre = l <= 1 ? 0 : l <= straight ? toe : toe + c5 * (l - straight);
    CHECK(law.uniaxial(l) == Approx(matrix + fibre / l).epsilon(1e-11));
    // Pulled along 2, free along 1: the fibres shorten, and do not bear.
    const Matrix3 tau = law.kirchhoff(Vector3(1 / std::sqrt(l), l, 1 / std::sqrt(l)).asDiagonal());
    if (l > 1) CHECK((tau(1, 1) - tau(2, 2)) / l == Approx(matrix).epsilon(1e-11));
  }
  LawConstants smooth = constants;  // without c3 the slope has no jump at the end of the toe
  smooth.numbers.erase("c3");
  const Homogeneous without{row.shape(material_with(smooth))};
  const auto slope = [&](double l) {
    const auto fibre = [&](double at) { return without.uniaxial(at) * at - 2 * (at * at - 1 / at) * (c1 + c2 / at); };
    return (fibre(l + 1e-6) - fibre(l - 1e-6)) / 2e-6;
  };
  CHECK(slope(straight - 2e-6) == Approx(c5).epsilon(1e-4));
  CHECK(slope(straight + 2e-6) == Approx(c5).epsilon(1e-7));
}

TEST_CASE("a cube of fibres stretched by 15 % contracts as in the literature's verification problem", "[law]") {
  // FEBio's test ma63: K = 10, c1 = 2.5e-7, c3 = .00234, c4 = 43, c5 = 3, λ_m = 1.07; the 2-norm of the eight sideways
  // displacements is 0.178805553109.
  const LawConstants constants{
      .law = "transversely_isotropic",
      .numbers = {{"c1", 2.5e-7}, {"c3", .00234}, {"c4", 43}, {"c5", 3}, {"lambda_max", 1.07}, {"bulk_modulus", 10}},
      .directions = {{"direction", Vector3::UnitZ()}}};
  const auto law = kCatalog.material_laws.find("transversely_isotropic")->solid(material_with(constants));
  double low = 0.5, high = 1.2;  // the stretch across at which there is no stress across
  for (int halving = 0; halving < 60; ++halving) {
    const double w = (low + high) / 2;
    (law.stress(Vector3(w * w - 1, w * w - 1, 1.15 * 1.15 - 1).asDiagonal())(0, 0) < 0 ? low : high) = w;
  }
  CHECK(std::sqrt(8.) * (1 - low) == Approx(0.178805553109).epsilon(1e-9));
}

TEST_CASE("two families of fibres: tension between them and across", "[law]") {
  const double c = 3000, k1 = 5000, k2 = 0.8, kappa = 0.1, angle = 0.7;
  const LawConstants constants{
      .law = "holzapfel_gasser_ogden",
      .numbers = {{"c", c}, {"k1", k1}, {"k2", k2}, {"kappa", kappa}, {"angle", angle}},
      .directions = {{"direction", Vector3::UnitX()}, {"across", Vector3(1, 1, 0).normalized()}}};
  const Homogeneous law{kCatalog.material_laws.find("holzapfel_gasser_ogden")->shape(material_with(constants))};
  int without = 0, shortened = 0;
  const auto check = [&](double along, double across, double free) {
    const double cosine = std::pow(std::cos(angle), 2), I1 = along * along + across * across + free * free;
    const double I4 = along * along * cosine + across * across * (1 - cosine);
    const double E = kappa * (I1 - 3) + (1 - 3 * kappa) * (I4 - 1);
    without += E<0, shortened += E> 0 && I4 < 1;
    const double g = E > 0 ? 4 * k1 * E * std::exp(k2 * E * E) : 0;  // two families, S = 2 dW/dC
    const double expected =
        (c + g * kappa) * (along * along - free * free) + g * (1 - 3 * kappa) * along * along * cosine;
    CHECK(law.tension({along, across, free}) == Approx(expected / along).epsilon(1e-11));
  };
  for (const double l : {0.8, 0.95, 1.05, 1.3, 1.7}) {
    check(l, 1 / std::sqrt(l), 1 / std::sqrt(l));
    check(l, 1, 1 / l);
    check(l, l, 1 / (l * l));
  }
  check(0.3, 1.1, 1 / 0.33);  // fibres between the two directions are short, dispersed ones across are stretched far
  CHECK(without > 0);
  CHECK(shortened > 0);
}

TEST_CASE("Fung's orthotropic law: tension along its axes and shear between them", "[law]") {
  const double c = 4000;
  LawConstants constants = law_constants().at("fung_orthotropic");
  constants.directions = {{"axis_1", Vector3::UnitX()}, {"axis_2", Vector3::UnitY()}};
  const Homogeneous law{kCatalog.material_laws.find("fung_orthotropic")->shape(material_with(constants))};
  Matrix3 compliance;  // of the nine constants
  compliance << 1 / 9e3, -0.3 / 9e3, -0.4 / 1.2e4, -0.3 / 9e3, 1 / 6e3, -0.2 / 6e3, -0.4 / 1.2e4, -0.2 / 6e3, 1 / 1.2e4;
  const Matrix3 direct = compliance.inverse();
  for (const double l : {0.7, 0.99, 1.2, 1.4}) {
    const Vector3 stretch(l, 1.1, 1 / (1.1 * l)), strain = (stretch.cwiseAbs2() - Vector3::Ones()) / 2;
    const Vector3 linear = direct * strain;
    const double growth = std::exp(strain.dot(linear) / c);
    CHECK(law.tension(stretch) ==
          Approx(growth * (l * l * linear[0] - stretch[2] * stretch[2] * linear[2]) / l).epsilon(1e-11));
  }
  for (const double amount : {0.1, 0.6}) {
    const double E12 = amount / 2, E22 = amount * amount / 2;
    const double growth = std::exp((direct(1, 1) * E22 * E22 + 4 * 2.5e3 * E12 * E12) / c);
    CHECK(law.shear(amount) == Approx(growth * (2 * 2.5e3 * E12 + amount * direct(1, 1) * E22)).epsilon(1e-11));
  }
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
  check(std::type_identity<ArrudaBoyce>{});
  check(std::type_identity<VerondaWestmann>{});
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
  check({.law = "veronda_westmann", .numbers = {{"c1", 1400}, {"c2", 2.5}, {"bulk_modulus", 4e4}}}, 3500);
  check({.law = "arruda_boyce", .numbers = {{"mu", 3000}, {"N", 4}, {"bulk_modulus", 4e4}}},
        3000 * (1 + 3 / 20. + 99 / (175 * 16.) + 513 / (875 * 64.) + 42039 / (67375 * 256.)));
  check(law_constants().at("transversely_isotropic"), 3000);  // at rest the fibres do not bear yet
  check(law_constants().at("holzapfel_gasser_ogden"), 3000);
  LawConstants isotropic = law_constants().at("fung_orthotropic");
  for (const char* modulus : {"E1", "E2", "E3"}) isotropic.numbers[modulus] = 2.6 * 1100;
  for (const char* modulus : {"G12", "G23", "G31"}) isotropic.numbers[modulus] = 1100;
  for (const char* ratio : {"nu12", "nu23", "nu31"}) isotropic.numbers[ratio] = 0.3;
  check(isotropic, 1100);
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
  LawConstants fung = law_constants().at("fung_orthotropic");
  fung.numbers["nu12"] = 1.3;
  refused(fung, "takes no energy");
  fung = law_constants().at("fung_orthotropic");
  fung.directions["axis_2"] = Vector3(2, 2, 1) / 3;
  refused(fung, "not at right angles");
  LawConstants artery = law_constants().at("holzapfel_gasser_ogden");
  artery.directions["across"] = artery.directions["direction"];
  refused(artery, "is along `direction`");
  artery.directions.erase("across");
  refused(artery, "needs 'across'");
  artery.numbers["kappa"] = 0.4;
  refused(artery, "out of range");
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
