#include "elastin/core/forces/elasticity.h"

#include "core/forces/graph.h"

namespace elastin {

void Elasticity::add_forces(const Positions& positions, const Graph& graph, Positions& forces,
                            Workspace& workspace) const {
  workspace.force_densities.setZero(graph.size());
  add_force_densities(positions, workspace.force_densities, workspace);
  graph.add_forces(positions, workspace.force_densities, forces);
}

}  // namespace elastin
