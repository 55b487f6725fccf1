#pragma once
#include <algorithm>
#include <cmath>

#include "core/base/dense.h"
#include "core/laws/exponential.h"
#include "core/laws/solids/isochoric.h"
#include "elastin/core/laws/material_law.h"

namespace elastin {

/// ψ = c/2 (e^Q − 1), c Q = Ẽ : ℂ : Ẽ, Ẽ = (C̃ − I)/2, ℂ the orthotropic stiffness of nine engineering constants in
/// three axes; at small strain without a change of volume it is ℂ.         [Fung 1979; Ateshian & Costa 2009, eq. 3]
struct FungOrthotropic : NearlyIncompressible<FungOrthotropic> {
  static constexpr std::string_view name = "fung_orthotropic";
  static constexpr std::string_view summary =
      "tissue with three axes that stiffens exponentially, nearly incompressible";
  static constexpr std::string_view source = "[Fung 1979; Ateshian & Costa 2009]";

  struct Shape {
    double c;                    ///< [Pa]
    TangentModuli<3> stiffness;  ///< ℂ [Pa], of strain components whose off-diagonal ones stand twice

    /// S = D^(−1/3) (S̃ − ⅓ (S̃:C) C⁻¹), S̃ = e^Q ℂ Ẽ.
    Matrix3 stress(const Strained& point) const {
      const Present now(*this, point);
      return tensor(now.S);
    }

    /// r² P T Pᵀ − ⅓ (S ⊗ G + G ⊗ S) + r/3 (S̃:C)(G ⊙ G − G ⊗ G/3), r = D^(−1/3), G = C⁻¹, P = 1 − ⅓ G ⊗ C and
    /// T = ∂S̃/∂C̃.
    TangentModuli<3> tangent(const Strained& point) const {
      const Present now(*this, point);
      TangentModuli<3> T = now.growth / 2 * stiffness;
      add_square(now.growth / c, now.linear, T);
      const Components TC = T * now.C;
      const Components& G = now.G;
      add_square(now.C.dot(TC) / 9, G, T);
      add_both_ways(-1. / 3, TC, G, T);
      TangentModuli<3> result = now.root * now.root * T;
      add_both_ways(-1. / 3, now.S, G, result);
      add_symmetric_squares(point.volume.inverse, -now.root / 9 * now.S_C, now.root / 3 * now.S_C, result);
      return result;
    }

    double energy(const Strained& point) const { return c / 2 * std::expm1(Present(*this, point).power); }

   private:
    struct Present {
      double root, power, growth, S_C;  ///< r, Q, e^Q, S̃:C
      Components G, C, linear, S;       ///< C with its off-diagonal components twice; ℂ Ẽ

      Present(const Shape& law, const Strained& point) {
        const auto& [A, volume, cube_root] = point;
        root = cube_root;
        const double shrink = -volume.excess / ((1 + volume.excess) * (1 + root + root * root));  // r − 1
        const double half = root / 2, even = shrink / 2;
        const double strain[6] = {half * A(0, 0) + even, half * A(1, 1) + even, half * A(2, 2) + even,
                                  root * A(0, 1),        root * A(0, 2),        root * A(1, 2)};
        linear = law.stiffness.col(0) * strain[0];
        for (int i = 1; i < 6; ++i) linear += law.stiffness.col(i) * strain[i];
        double energy = 0;
        for (int i = 0; i < 6; ++i) energy += strain[i] * linear[i];
        power = std::min(energy / law.c, kMostPower);
        growth = 1 + limited_expm1(power);
        G = components(volume.inverse);
        C << 1 + A(0, 0), 1 + A(1, 1), 1 + A(2, 2), 2 * A(0, 1), 2 * A(0, 2), 2 * A(1, 2);
        S_C = growth * (linear[0] + linear[1] + linear[2] + double_product(linear, A));
        S = each_component([&](int row) { return root * (growth * linear[row] - S_C / 3 * G[row]); });
      }
    };
  };

  static MaterialLaw constants() {
    constexpr double inf = std::numeric_limits<double>::infinity(), none = std::numeric_limits<double>::quiet_NaN();
    MaterialLaw row;
    const auto add = [&](const char* name, const Dimension& unit, double low, double high, const char* text) {
      row.parameters.push_back(
          {name, unit, low, high, none, text, unit == dimension::pressure, ValueKind::number, true});
    };
    add("c", dimension::pressure, 0, inf, "c, scale of the exponential");
    add("E1", dimension::pressure, 0, inf, "Young's modulus along axis 1");
    add("E2", dimension::pressure, 0, inf, "Young's modulus along axis 2");
    add("E3", dimension::pressure, 0, inf, "Young's modulus along axis 3");
    add("G12", dimension::pressure, 0, inf, "shear modulus between axes 1 and 2");
    add("G23", dimension::pressure, 0, inf, "shear modulus between axes 2 and 3");
    add("G31", dimension::pressure, 0, inf, "shear modulus between axes 3 and 1");
    add("nu12", dimension::none, -100, 100, "contraction along 2 over extension along 1, stress along 1");
    add("nu23", dimension::none, -100, 100, "contraction along 3 over extension along 2, stress along 2");
    add("nu31", dimension::none, -100, 100, "contraction along 1 over extension along 3, stress along 3");
    for (const char* axis : {"axis_1", "axis_2"})
      row.parameters.push_back({axis, dimension::none, 0, 0, none, "axis of the tissue at rest; axis 3 is across both",
                                false, ValueKind::direction, true});
    add_bulk_modulus(row);
    return row;
  }

  /// Throws InputError unless the axes are at right angles, and unless ℂ resists every strain.
  Shape shape(const Material& material) const {
    const ConstantsOf own(material, name);
    const Vector3 &one = own.direction("axis_1"), &two = own.direction("axis_2");
    if (!(std::abs(one.dot(two)) < 1e-6))
      throw InputError("fung_orthotropic: axis_1 and axis_2 are not at right angles");
    const double E1 = own.modulus("E1"), E2 = own.modulus("E2"), E3 = own.modulus("E3");
    Matrix3 compliance;
    compliance << 1 / E1, -own.number("nu12") / E1, -own.number("nu31") / E3,  //
        -own.number("nu12") / E1, 1 / E2, -own.number("nu23") / E2,            //
        -own.number("nu31") / E3, -own.number("nu23") / E2, 1 / E3;
    const Vector3 root(std::sqrt(E1), std::sqrt(E2), std::sqrt(E3));
    if (!(symmetric_eigenvalues3(root.asDiagonal() * compliance * root.asDiagonal())[0] > 1e-12))
      throw InputError("fung_orthotropic: with these Poisson's ratios there is a strain that takes no energy");
    const Matrix3 direct = compliance.inverse(), axes = (Matrix3() << one, two, one.cross(two)).finished();
    Eigen::Matrix<double, 6, 3> along;
    for (int i = 0; i < 3; ++i) along.col(i) = symmetric_product(axes.col(i), axes.col(i));
    TangentModuli<3> stiffness = along * direct * along.transpose();
    const double shear[3] = {own.modulus("G12"), own.modulus("G31"), own.modulus("G23")};
    for (int pair = 0; pair < 3; ++pair) {
      const Components across =
          symmetric_product(axes.col(kComponents[3 + pair][0]), axes.col(kComponents[3 + pair][1]));
      stiffness += 4 * shear[pair] * across * across.transpose();
    }
    return {own.modulus("c"), stiffness};
  }
};

}  // namespace elastin
