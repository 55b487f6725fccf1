#pragma once
#include <array>

#include "elastin/core/base/types.h"

namespace elastin {

/// The position on a triangle that is nearest to a point: Σ weight · corner. Weights are exactly 0 of corners that it
/// does not lie between: three of them on the face, two on a side, one at a corner.
struct NearestPoint {
  Vector3 position;
  std::array<double, 3> weights;
};

/// Corners in space; a triangle without area gives a position on one of its sides. [Ericson 2005, ch. 5.1.5]
NearestPoint nearest_point(const Vector3& point, const std::array<Vector3, 3>& corners);

/// Gradients of the weights as the position moves in the plane of the three corners (or along the side that two weights
/// leave) [1/m]; 0 at a corner.
std::array<Vector3, 3> weight_slopes(const std::array<Vector3, 3>& corners, const std::array<double, 3>& weights);

}  // namespace elastin
