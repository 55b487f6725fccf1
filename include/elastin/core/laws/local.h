#pragma once
#include <array>
#include <span>
#include <vector>

#include "elastin/core/base/types.h"

namespace elastin {

/// One molecule of one element of an elastic law: the `node`-th of element `element`.
struct LocalSlot {
  int element = 0, node = 0;
};

/// What an energy makes of the position of one molecule while all others stay: ∂W/∂x_a [N] and ∂²W/∂x_a² [N/m].
struct LocalBlock {
  Vector3 gradient = Vector3::Zero();
  Matrix3 hessian = Matrix3::Zero();
};

/// A spring as position-based steppers project it: energy ½ k (l − L)².
struct SpringConstraint {
  std::array<int, 2> molecules;
  double constant, rest_length;  ///< k > 0 [N/m], L [m]
};

/// A tetrahedron as they project it, by two measures of its own: W = V (μ/2 (tr C − 3) + U(J)), U = −μ ln J + λ/2 (J −
/// 1)². tr C = −Σ s_ab G⁰_ab over its pairs 01 02 03 12 13 23.
struct NeoHookeanConstraint {
  std::array<int, 4> molecules;
  std::array<double, 6> rest_products;  ///< G⁰ [1/m²]
  double volume, lambda, mu;            ///< at rest [m³]; [Pa]
};

/// All that a law consists of, for position-based steppers.
struct Constraints {
  std::vector<SpringConstraint> springs;
  std::vector<NeoHookeanConstraint> tetrahedra;
};

/// An elastic law with an energy as a sum over elements (connections, cells), each of a few molecules: what vertex
/// block descent, colouring and tests of conformance go by. Element numbers go from 0 to elements() − 1.
class LocalElasticity {
 public:
  virtual ~LocalElasticity() = default;
  virtual int elements() const = 0;
  virtual std::span<const int> molecules_of(int element) const = 0;
  /// W of one element [J]; +infinity where it is inverted.
  virtual double element_energy(const Positions& positions, int element) const = 0;
  /// Adds what these elements make of the position of one molecule, which each of them has at its node. The Hessian may
  /// leave out what is negative. Finite for any finite positions but those of a flat cell.
  virtual void add_blocks(const Positions& positions, std::span<const LocalSlot> slots, LocalBlock& block) const = 0;
  /// How much a motion [m] of that molecule changes one of these elements at most, over its own size: the motion over a
  /// length, the change of volume over the volume. Infinite where a cell is or would be inverted.
  virtual double relative_change(const Positions& positions, std::span<const LocalSlot> slots,
                                 const Vector3& motion) const = 0;
  /// Adds all elements as constraints; false, and nothing added, where the law has no such form.
  virtual bool add_constraints(Constraints&) const { return false; }
};

}  // namespace elastin
