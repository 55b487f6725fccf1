#include "core/simulation/tensions.h"

#include <cmath>

#include "core/parallel/parallel.h"

namespace elastin {

void set_tensions(const Model& model, const State& state, VectorX& tensions, Workspace& workspace) {
  const Connections& connections = model.body().connections;
  const int count = connections.size();
  const auto ends_of = [&](int c) { return connections.ends[c]; };
  tensions.setZero(count);
  for (const auto* law : model.edge_laws()) law->add_force_densities(state.positions, tensions, workspace);
  workspace.squared_lengths.resize(count);
  workspace.rates.resize(count);
  parallel_for(count, [&](int c) {
    const auto [a, b] = ends_of(c);
    const Vector3 d = state.positions.col(b) - state.positions.col(a);
    workspace.squared_lengths[c] = d.squaredNorm();
    workspace.rates[c] = 2 * d.dot(state.velocities.col(b) - state.velocities.col(a));
  });
  for (const auto& term : model.viscosity())
    term->add_force_densities(workspace.squared_lengths, workspace.rates, tensions, workspace);
  parallel_for(count, [&](int c) { tensions[c] *= std::sqrt(workspace.squared_lengths[c]); });
}

}  // namespace elastin
