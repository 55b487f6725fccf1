#include "elastin/core/forces/model.h"

#include <algorithm>

#include "core/forces/graph.h"

namespace elastin {

Model::Model(const Body& body) : body_(&body), graph_(std::make_unique<Graph>(body)) {}
Model::~Model() = default;
Model::Model(Model&&) noexcept = default;

bool Model::has_energy() const {
  return std::all_of(elasticity_.begin(), elasticity_.end(), [](const auto& part) { return part->has_energy(); });
}

bool Model::conservative() const {
  return has_energy() && std::all_of(loads_.begin(), loads_.end(), [](const auto& load) { return load->has_energy(); });
}

bool Model::symmetric() const {
  return std::all_of(loads_.begin(), loads_.end(), [](const auto& load) { return load->symmetric(); });
}

void Model::remember(State& state) const {
  for (const auto& load : loads_) load->remember(state);
}

bool Model::tighten(State& state) const {
  bool changed = false;
  for (const auto& load : loads_) changed |= load->tighten(state);
  return changed;
}

double Model::free_way(const State& from, const State& to) const {
  double part = 1;
  for (const auto& load : loads_) part = std::min(part, load->free_way(from, to));
  return part;
}

double Model::square_frequency(const State& state, double ahead) const {
  double sum = 0;
  for (const auto& load : loads_) sum += load->square_frequency(state, ahead);
  return sum;
}

bool Model::has_full_tangent() const {
  return std::all_of(elasticity_.begin(), elasticity_.end(), [](const auto& part) { return part->has_full_tangent(); });
}

bool Model::admissible(const Positions& positions) const {
  return std::all_of(elasticity_.begin(), elasticity_.end(),
                     [&](const auto& part) { return part->admissible(positions); });
}

bool Model::feels_velocity() const {
  return !viscosity_.empty() ||
         std::any_of(loads_.begin(), loads_.end(), [](const auto& load) { return load->feels_velocity(); });
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
  Scratch scratch;
  for (const auto& part : elasticity_) part->add_force_densities(positions, densities, scratch);
  return densities;
}

Positions Model::elastic_forces(const Positions& positions) const {
  Positions forces = Positions::Zero(3, body_->size());
  Scratch scratch;
  add_elastic_forces(positions, forces, scratch);
  return forces;
}

Positions Model::load_forces(const State& state) const {
  Positions forces = Positions::Zero(3, body_->size());
  for (const auto& load : loads_) load->add_forces(state, forces);
  return forces;
}

std::pair<VectorX, VectorX> Model::squares_and_rates(const State& state) const {
  std::pair<VectorX, VectorX> both;
  set_squares_and_rates(state, both.first, both.second);
  return both;
}

void Model::set_squares_and_rates(const State& state, VectorX& squares, VectorX& rates) const {
  const auto& ends = body_->connections.ends;
  squares.resize(body_->connections.size());
  rates.resize(body_->connections.size());
  parallel_for(body_->connections.size(), [&](int c) {
    const auto& [a, b] = ends[c];
    const Vector3 d = state.positions.col(b) - state.positions.col(a);
    squares[c] = d.squaredNorm();
    rates[c] = 2 * d.dot(state.velocities.col(b) - state.velocities.col(a));
  });
}

VectorX Model::viscous_densities(const State& state) const {
  VectorX densities = VectorX::Zero(body_->connections.size());
  if (viscosity_.empty()) return densities;
  const auto [squares, rates] = squares_and_rates(state);
  Scratch scratch;
  for (const auto& part : viscosity_) part->add_force_densities(squares, rates, densities, scratch);
  return densities;
}

void Model::set_forces(const State& state, Positions& forces) const {
  Scratch scratch;
  set_forces(state, forces, scratch);
}

void Model::set_forces(const State& state, Positions& forces, Scratch& scratch) const {
  forces.setZero(3, body_->size());
  add_elastic_forces(state.positions, forces, scratch);
  if (!viscosity_.empty()) {
    set_squares_and_rates(state, scratch.squares, scratch.rates);
    scratch.densities.setZero(body_->connections.size());
    for (const auto& part : viscosity_)
      part->add_force_densities(scratch.squares, scratch.rates, scratch.densities, scratch);
    gather(state.positions, scratch.densities, forces);
  }
  for (const auto& load : loads_) load->add_forces(state, forces);
}

void Model::gather(const Positions& positions, const VectorX& densities, Positions& forces) const {
  graph_->add_forces(positions, densities, forces);
}

void Model::add_elastic_forces(const Positions& positions, Positions& forces, Scratch& scratch) const {
  for (const auto& part : elasticity_) part->add_forces(positions, *graph_, forces, scratch);
}

}  // namespace elastin
