#include "elastin/forces/model.h"

#include <algorithm>

#include "forces/graph.h"

namespace elastin {

Model::Model(const Body& body) : body_(&body) {
  if (body.connections.size() >= kParallelThreshold)
    graph_ = std::make_unique<Graph>(Graph{connections_of_molecules(body.size(), body.connections)});
}
Model::~Model() = default;
Model::Model(Model&&) noexcept = default;

bool Model::has_energy() const {
  return std::all_of(elasticity_.begin(), elasticity_.end(), [](const auto& part) { return part->has_energy(); });
}

bool Model::has_full_tangent() const {
  return std::all_of(elasticity_.begin(), elasticity_.end(), [](const auto& part) { return part->has_full_tangent(); });
}

double Model::elastic_energy(const Positions& positions) const {
  double energy = 0;
  for (const auto& part : elasticity_) energy += part->energy(positions);
  return energy;
}

double Model::load_energy(const State& state) const {
  double energy = 0;
  for (const auto& load : loads_) energy += load->energy(state);
  return energy;
}

VectorX Model::force_densities(const Positions& positions) const {
  VectorX densities = VectorX::Zero(body_->connections.size());
  for (const auto& part : elasticity_) part->add_force_densities(positions, densities);
  return densities;
}

Positions Model::elastic_forces(const Positions& positions) const {
  Positions forces = Positions::Zero(3, body_->size());
  gather(positions, force_densities(positions), forces);
  return forces;
}

Positions Model::load_forces(const State& state) const {
  Positions forces = Positions::Zero(3, body_->size());
  for (const auto& load : loads_) load->add_forces(state, forces);
  return forces;
}

void Model::gather(const Positions& positions, const VectorX& densities, Positions& forces) const {
  add_flows(body_->connections, graph_ ? &graph_->incident : nullptr, forces,
            [&](int c, int a, int b) -> Vector3 { return densities[c] * (positions.col(b) - positions.col(a)); });
}

}  // namespace elastin
