#include "core/simulation/tensions.h"

#include <cmath>

#include "core/parallel/parallel.h"

namespace elastin {

void set_tensions(const Model& model, const State& state, VectorX& tensions, Scratch& scratch) {
  const Connections& connections = model.body().connections;
  const int count = connections.size();
  const auto ends_of = [&](int c) { return connections.ends[static_cast<std::size_t>(c)]; };
  tensions.setZero(count);
  for (const auto& part : model.elasticity()) part->add_force_densities(state.positions, tensions, scratch);
  scratch.squares.resize(count);
  scratch.rates.resize(count);
  parallel_for(count, [&](int c) {
    const auto [a, b] = ends_of(c);
    const Vector3 d = state.positions.col(b) - state.positions.col(a);
    scratch.squares[c] = d.squaredNorm();
    scratch.rates[c] = 2 * d.dot(state.velocities.col(b) - state.velocities.col(a));
  });
  for (const auto& part : model.viscosity())
    part->add_force_densities(scratch.squares, scratch.rates, tensions, scratch);
  parallel_for(count, [&](int c) { tensions[c] *= std::sqrt(scratch.squares[c]); });
}

}  // namespace elastin
