#include "elastin/core/forces/elasticity.h"

#include "core/forces/graph.h"

namespace elastin {

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
