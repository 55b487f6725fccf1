#pragma once
#include <memory>
#include <vector>

#include "core/model/block_geometry.h"
#include "elastin/core/forces/loads.h"
#include "elastin/core/geometry/cell_kind.h"

namespace elastin {

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

/// The outer faces of a solid's cells all of whose nodes are among these molecules, ascending; of all its molecules the
/// whole surface.
std::vector<LoadedFace> outer_faces(const Body& body, const std::vector<int>& molecules);

/// A pressure against the present normals of faces, or a traction on them, times a factor.
struct SurfaceLoad {
  std::vector<LoadedFace> faces;
  bool pressure = true;                ///< against the normal, of 1 Pa; else a traction
  Vector3 traction = Vector3::Zero();  ///< [Pa]
  bool at_rest = false;                ///< on the area at rest, a dead load
};

/// Exact tangent, not symmetric unless dead; no energy, for that needs a closed surface or a fixed rim.
class SurfaceForces final : public Load {
 public:
  SurfaceForces(const Body& body, SurfaceLoad load, double factor = 1)
      : body_(body), load_(std::move(load)), factor_(factor) {}
  void set_factor(double factor) { factor_ = factor; }
  bool changes() const override { return !load_.at_rest; }
  bool has_energy() const override { return load_.at_rest; }
  bool follows_surface() const override { return !load_.at_rest; }
  bool symmetric() const override { return load_.at_rest; }
  bool feels_velocity() const override { return false; }
  void add_forces(const State& state, Positions& forces) const override;
  double energy(const State& state) const override;
  void add_change(const State& state, const Positions& dx, const Positions& dv, Positions& change) const override;
  void visit_blocks(const State& state, double velocity_weight, const BlockVisitor& visit) const override;

 private:
  const Body& body_;
  SurfaceLoad load_;
  double factor_;
};

}  // namespace elastin
