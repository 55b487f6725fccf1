#pragma once
#include <vector>

#include "elastin/model/body.h"
#include "experiment/tributary.h"

namespace elastin {

/// Two directions that span the plane across an axis, as columns.
Eigen::Matrix<double, 3, 2> across(const Vector3& axis);

/// The molecules at one end of a body.
struct Face {
  std::vector<int> molecules;
  double area = 0;  ///< of their hull, seen along the direction [m²]; 0 where they lie on a line
  /// What part of the area each carries, sum 1: a third of its triangles on the face where the body has tetrahedra (the
  /// consistent load of linear cells), else the part of the hull nearest to it; equal parts where there is no area.
  VectorX share;
};

/// The molecules furthest along `direction` (unit), and those less than `depth` [m] behind them; 0 = the end plane
/// alone, to 1e-6 of the body's length. Throws InputError if that is the whole body.
Face end_face(const Body& body, const Vector3& direction, double depth);

}  // namespace elastin
