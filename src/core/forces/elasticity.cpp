#include "elastin/core/forces/elasticity.h"

#include <cmath>

#include "core/forces/graph.h"

namespace elastin {
namespace {

/// Columns to the corners of a triangle or tetrahedron from the first.
using Edges = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::ColMajor, 3, 3>;

Edges edges_of(const Eigen::Ref<const Positions>& corners) {
  return corners.rightCols(corners.cols() - 1).colwise() - corners.col(0);
}

}  // namespace

CellState simplex_state(const Eigen::Ref<const Positions>& unstressed, const Eigen::Ref<const Positions>& now,
                        std::span<const double> force_densities) {
  CellState state;
  const Edges before = edges_of(unstressed), after = edges_of(now);
  const Edges inverse = before * (before.transpose() * before).inverse();  // of the edges before, in their own plane
  state.strain = inverse * (after.transpose() * after - before.transpose() * before) * inverse.transpose() / 2;
  if (!state.strain.allFinite()) state.strain.setZero();
  const bool solid = after.cols() == 3;
  const double size = solid ? std::abs(after.col(0).cross(after.col(1)).dot(after.col(2))) / 6
                            : after.col(0).cross(after.col(1)).norm() / 2;
  auto density = force_densities.begin();
  for (Eigen::Index i = 0; i < now.cols() && density != force_densities.end(); ++i)
    for (Eigen::Index j = i + 1; j < now.cols(); ++j) {
      const Vector3 d = now.col(j) - now.col(i);
      state.stress += *density++ / size * d * d.transpose();
    }
  if (!state.stress.allFinite()) state.stress.setZero();
  return state;
}

void EdgeDensities::set_part_sizes(const Positions& positions, VectorX& sizes, Workspace& workspace) const {
  sizes.setZero();
  add_force_densities(positions, sizes, workspace);
  sizes = sizes.cwiseAbs();
}

void EdgeDensities::show(const Positions& positions, VectorX& others, const StateVisitor&) const {
  Workspace workspace;
  add_force_densities(positions, others, workspace);
}

void EdgeDensities::add_forces(const Positions& positions, const Graph& graph, Positions& forces,
                               Workspace& workspace) const {
  workspace.force_densities.setZero(graph.size());
  add_force_densities(positions, workspace.force_densities, workspace);
  graph.add_forces(positions, workspace.force_densities, forces);
}

void EdgeDensities::add_triangle_force_densities(const Positions& positions, Eigen::Ref<Eigen::Matrix3Xd>,
                                                 VectorX& of_connections, Workspace& workspace) const {
  add_force_densities(positions, of_connections, workspace);
}

}  // namespace elastin
