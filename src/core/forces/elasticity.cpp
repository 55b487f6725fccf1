#include "elastin/core/forces/elasticity.h"

#include "core/forces/graph.h"

namespace elastin {

void Elasticity::add_forces(const Positions& positions, const Graph& graph, Positions& forces, Scratch& scratch) const {
  scratch.densities.setZero(graph.size());
  add_force_densities(positions, scratch.densities, scratch);
  graph.add_forces(positions, scratch.densities, forces);
}

}  // namespace elastin
