#pragma once
#include "elastin/core/forces/elasticity.h"

namespace elastin {

/// Stiff points of cells whose volume is kept by pressures of whole cells: of their stiffness K = K̂ + Gᵀ Q G the part
/// of these pressures, for solvers that take it apart. As linearise_at() left it.
class CellPressures {
 public:
  virtual ~CellPressures() = default;
  /// How many: of all cells together.
  virtual Eigen::Index pressures() const = 0;
  /// Of each cell: 1 where the pressure is constant in it, 4 where it is linear.
  virtual int of_each_cell() const = 0;
  /// Stiffness against a change of volume over the shear modulus, λ / μ at rest, the largest of all cells.
  virtual double stiffness_ratio() const = 0;
  /// swelling = G motion: what a motion [m] adds to each pressure's part of the volume [m³].
  virtual void swell(const Positions& motion, Eigen::Ref<VectorX> swelling) const = 0;
  /// Adds Gᵀ pressures [N], of pressures in Pa.
  virtual void add_forces_of(const Eigen::Ref<const VectorX>& pressures, Positions& forces,
                             Workspace& workspace) const = 0;
  /// pressures = Q swelling.
  virtual void resist(const Eigen::Ref<const VectorX>& swelling, Eigen::Ref<VectorX> pressures) const = 0;
  /// From the next linearise_at() on Q is this part of what it is by the law.
  virtual void take_part(double part) = 0;
};

}  // namespace elastin
