#include "core/forces/surface_load.h"

#include <algorithm>

#include "core/base/cross_matrix.h"
#include "core/geometry/boundary.h"

namespace elastin {

std::vector<LoadedFace> outer_faces(const Body& body, const std::vector<int>& molecules) {
  std::vector<char> among(static_cast<std::size_t>(body.size()), 0);
  for (const int molecule : molecules) among[molecule] = 1;
  const auto whole = [&](const auto& nodes) {
    return std::all_of(nodes.begin(), nodes.end(), [&](int molecule) { return among[molecule] != 0; });
  };
  std::vector<LoadedFace> faces;
  if (has_blocks(body, 3)) {
    for (BlockFace& face : boundary_faces(body))
      if (whole(face.nodes)) faces.push_back({face.kind, std::move(face.nodes)});
    return faces;
  }
  for (const auto& triangle : boundary_of(body.tetrahedra))
    if (whole(triangle)) faces.push_back({&cell_kind("triangle3"), {triangle.begin(), triangle.end()}});
  return faces;
}

void SurfaceForces::add_forces(const State& state, Positions& forces) const {
  visit_face_points(load_.faces, load_.at_rest ? body_.rest : state.positions, [&](const FacePoint& at) {
    const Vector3 area = at.edges.col(0).cross(at.edges.col(1));
    const Vector3 force = factor_ * at.weight * (load_.pressure ? Vector3(-area) : area.norm() * load_.traction);
    for (Eigen::Index a = 0; a < at.values.size(); ++a) forces.col(at.nodes[a]) += at.values[a] * force;
  });
}

double SurfaceForces::energy(const State& state) const {
  if (!load_.at_rest) return 0;
  Positions forces = Positions::Zero(3, body_.size());
  add_forces(state, forces);
  return -forces.cwiseProduct(state.positions - body_.rest).sum();
}

void SurfaceForces::add_change(const State& state, const Positions& dx, const Positions&, Positions& change) const {
  if (!load_.at_rest)
    visit_blocks(state, 0, [&](int a, int b, const Matrix3& block) { change.col(a) -= block * dx.col(b); });
}

void SurfaceForces::visit_blocks(const State& state, double, const BlockVisitor& visit) const {
  if (load_.at_rest) return;
  visit_face_points(load_.faces, state.positions, [&](const FacePoint& at) {
    const Vector3 r = at.edges.col(0), s = at.edges.col(1), n = r.cross(s).normalized();
    for (Eigen::Index b = 0; b < at.values.size(); ++b) {
      const double by_r = at.slopes(0, b), by_s = at.slopes(1, b);
      // The change of the area vector, or of its length, with node b.
      const Matrix3 block = load_.pressure
                                ? Matrix3(by_s * cross_matrix(r) - by_r * cross_matrix(s))
                                : Matrix3(-load_.traction * (by_r * s.cross(n) + by_s * n.cross(r)).transpose());
      for (Eigen::Index a = 0; a < at.values.size(); ++a)
        visit(at.nodes[a], at.nodes[b], factor_ * at.weight * at.values[a] * block);
    }
  });
}

}  // namespace elastin
