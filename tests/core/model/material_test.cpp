#include "elastin/core/model/material.h"

#include <Eigen/LU>
#include <catch2/catch.hpp>

using namespace elastin;

namespace {

using Voigt = Eigen::Matrix<double, 6, 6>;

/// a a as the six numbers that stand for a strain (shear doubled) or for a stress.
Eigen::Matrix<double, 6, 1> dyad(const Vector3& a, double shear) {
  Eigen::Matrix<double, 6, 1> v;
  v << a.x() * a.x(), a.y() * a.y(), a.z() * a.z(), shear * a.y() * a.z(), shear * a.x() * a.z(), shear * a.x() * a.y();
  return v;
}

}  // namespace

TEST_CASE("a fibre-reinforced material along any direction is the inverse of its stiffness", "[material]") {
  constexpr double E = 2e4;
  const auto [nu, fibres] = GENERATE(table<double, double>({{0.3, 5e4}, {0.25, 4e6}, {-0.2, 1e4}, {0.48, 1e5}}));
  Material material;
  material.youngs_modulus = E;
  material.poissons_ratio = nu;
  material.fibre = Fibre{Vector3(1, 2, -2) / 3, StressStrain::linear(fibres)};
  Voigt stiffness = Voigt::Zero();
  stiffness.topLeftCorner<3, 3>().setConstant(E * nu / ((1 + nu) * (1 - 2 * nu)));
  stiffness.diagonal().head<3>().array() += E / (1 + nu);
  stiffness.diagonal().tail<3>().setConstant(E / (2 * (1 + nu)));
  stiffness += fibres * dyad(material.fibre->direction, 1) * dyad(material.fibre->direction, 1).transpose();
  for (const Vector3& towards : {Vector3(1, 2, -2), Vector3(2, 0, 1), Vector3(0.1, -0.5, 0.9), Vector3(1, 0, 0)}) {
    const Vector3 d = towards.normalized();
    const Eigen::Matrix<double, 6, 1> strain = stiffness.inverse() * dyad(d, 1);
    const double along = dyad(d, 1).dot(strain), volume = strain.head<3>().sum();
    const UniaxialResponse response = uniaxial_response(material, d);
    CHECK(response.youngs_modulus == Approx(1 / along).epsilon(1e-10));
    CHECK(response.poissons_ratio == Approx(-(volume - along) / 2 / along).epsilon(1e-9));
  }
}

TEST_CASE("the stress that a material should show", "[material]") {
  Material material;
  material.youngs_modulus = 100;
  const Vector3 z = Vector3::UnitZ();
  CHECK_FALSE(uniaxial_stress(material, z, 0.1));
  material.curve = StressStrain::toe(0.1, 100, 300);
  CHECK(*uniaxial_stress(material, z, 0.1) == Approx(20));
  material.fibre = Fibre{z, StressStrain::linear(1000)};
  CHECK(*uniaxial_stress(material, -z, 0.1) == Approx(120));
  CHECK_FALSE(uniaxial_stress(material, Vector3::UnitX(), 0.1));
  material.curve.reset();
  CHECK(*uniaxial_stress(material, z, 0.1) == Approx(110));
}
