#pragma once
#include <array>

#include "core/laws/solids/components.h"
#include "elastin/core/base/dense.h"

namespace elastin {

/// S and ∂S/∂C of an isotropic law out of what it is in the axes of C: a column of `axes` each.
struct PrincipalAxes {
  Matrix3 axes;

  Matrix3 stress(const Vector3& S) const { return axes * S.asDiagonal() * axes.transpose(); }

  /// @param direct  ∂S_i/∂C_j of the principal values
  /// @param turning (S_i − S_j)/(C_i − C_j) of the pairs 12 13 23: how S_ij changes with C_ij
  TangentModuli<3> tangent(const Matrix3& direct, const std::array<double, 3>& turning) const {
    Eigen::Matrix<double, 6, 3> along;
    for (int i = 0; i < 3; ++i) along.col(i) = symmetric_product(axes.col(i), axes.col(i));
    TangentModuli<3> result = along * direct * along.transpose();
    for (int pair = 0; pair < 3; ++pair) {
      const auto [i, j] = kComponents[3 + pair];
      const Components across = symmetric_product(axes.col(i), axes.col(j));
      result += 2 * turning[static_cast<std::size_t>(pair)] * across * across.transpose();
    }
    return result;
  }
};

}  // namespace elastin
