#pragma once
#include <vector>

#include "elastin/core/forces/model.h"

namespace elastin {

/// Tension of each triangle [N/m of present length], a tensor in its plane: Σ q d dᵀ / T over its sides d, T its
/// present area; zero of a flat one. Laws of triangles say each triangle's own; force densities that belong to
/// connections are shared equally among the triangles at a connection.
std::vector<Matrix3> triangle_tensions(const Model& model, const Positions& positions);

/// Where a membrane is pressed.
struct Compression {
  int triangles = 0;   ///< with a principal tension below −1e-3 of the largest one there is
  int worst = 0;       ///< the most pressed triangle
  double tension = 0;  ///< there, ≤ 0 [N/m]
};
Compression find_compression(const Model& model, const Positions& positions);

}  // namespace elastin
