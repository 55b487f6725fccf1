#pragma once
#include <array>
#include <optional>
#include <vector>

#include "core/base/dense.h"
#include "elastin/core/laws/material_law.h"

namespace elastin {

/// A test in which every point of the body is in the same state.
enum class HomogeneousTest {
  uniaxial,     ///< stretched along axis 1, free across
  planar,       ///< stretched along axis 1, axis 2 kept, free along 3: pure shear
  equibiaxial,  ///< stretched along axes 1 and 2 alike, free along 3
  shear,        ///< simple shear: axis 2 leans towards 1
};
inline constexpr std::array kHomogeneousTests{HomogeneousTest::uniaxial, HomogeneousTest::planar,
                                              HomogeneousTest::equibiaxial, HomogeneousTest::shear};
/// "uniaxial", …
const char* name_of(HomogeneousTest test);

struct HomogeneousState {
  double stress;   ///< nominal [Pa], along axis 1; of shear on planes across 2, along 1
  Matrix3 strain;  ///< C − I in the frame of the material
  /// Drucker: dτ : dε > 0 for every small change of the principal logarithmic strains without a change of volume, τ the
  /// Kirchhoff stress.
  bool stable;
};

/// The state of a material at a nominal strain, or amount of shear, reached from rest in small steps; none where there
/// is no equilibrium on the way. Without bulk_modulus exactly incompressible.
/// @param axes of the test, a column each, orthonormal
std::optional<HomogeneousState> homogeneous_state(const MaterialLaw& law, const Material& material,
                                                  HomogeneousTest test, double amount,
                                                  const Matrix3& axes = Matrix3::Identity());

/// How anything that a material gives changes with one of its numbers θ: ∂f/∂θ = Σ weights f(materials).
struct MaterialChange {
  std::vector<Material> materials;
  std::vector<double> weights;  ///< [1/unit of θ], as many
};

struct HomogeneousStresses {
  VectorX stresses;  ///< nominal [Pa], of each amount
  MatrixX slopes;    ///< ∂stress/∂θ, amounts × changes
};

/// The stresses of a material at several amounts in any order, and how they change with the material: that of the law
/// at each state, and by the change of the state, one small linear solve. None where one of them has no equilibrium.
std::optional<HomogeneousStresses> homogeneous_stresses(const MaterialLaw& law, const Material& material,
                                                        HomogeneousTest test, const VectorX& amounts,
                                                        const std::vector<MaterialChange>& changes = {},
                                                        const Matrix3& axes = Matrix3::Identity());

}  // namespace elastin
