#pragma once
#include <vector>

#include "core/model/block_geometry.h"
#include "elastin/core/geometry/cell_kind.h"

namespace elastin::febio {

/// A face on which a pressure or a traction acts.
struct LoadedFace {
  const CellKind* kind;    ///< of two dimensions
  std::vector<int> nodes;  ///< molecules in its order; the normal is by the right hand
};

/// A quadrature point of a face.
struct FacePoint {
  const std::vector<int>& nodes;
  double weight;
  VectorX values;                     ///< of the shape functions
  const Eigen::MatrixXd& slopes;      ///< of these, ∂N/∂ξ, 2 × nodes
  Eigen::Matrix<double, 3, 2> edges;  ///< ∂x/∂ξ [m]: the area vector is weight · edge 0 × edge 1
  Vector3 position;                   ///< [m]
};

template <class Visit>
void visit_face_points(const std::vector<LoadedFace>& faces, const Positions& positions, const Visit& visit) {
  for (const LoadedFace& face : faces) {
    const Eigen::MatrixXd own = positions_of(positions, face.nodes);
    for (std::size_t g = 0; g < face.kind->slopes.size(); ++g) {
      const auto point = static_cast<Eigen::Index>(g);
      const VectorX values = face.kind->values.col(point);
      const Eigen::MatrixXd& slopes = face.kind->slopes[g];
      visit(FacePoint{face.nodes, face.kind->weights[point], values, slopes, own * slopes.transpose(), own * values});
    }
  }
}

}  // namespace elastin::febio
