#include "core/solve/energies.h"

#include <algorithm>

#include "core/parallel/parallel.h"
#include "elastin/core/model/share.h"
#include "elastin/core/solve/stepper.h"

namespace elastin {
namespace {

/// All that it does is work from outside, what it resists too: a belt that drags gives and takes energy by one force.
bool drives(const Load& load) { return load.acts_at_rest() && !load.steady(); }
bool resists(const Load& load) { return load.resists() && !drives(load); }

template <class Which>
bool any_load(const Model& model, Which which) {
  return std::any_of(model.loads().begin(), model.loads().end(), [&](const auto& load) { return which(*load); });
}

template <class Which>
void add_loads(const Model& model, const State& state, Which which, Positions& forces) {
  for (const auto& load : model.loads())
    if (which(*load)) load->add_forces(state, forces);
}

/// ½ (a + b)·displacement of the molecules that its process owns, 0 where there are no forces.
double work_of(const Body& body, const Positions& a, const Positions& b, const Positions& displacement) {
  if (a.cols() == 0) return 0;
  return ordered_sum(owned_molecules(body), [&](int i) { return (a.col(i) + b.col(i)).dot(displacement.col(i)) / 2; });
}

}  // namespace

Ledger::Ledger(const Model& model, const State& start)
    : positions_(start.positions), rest_part_(model.rest_part()), time_(start.time) {
  open_ = model.drive || !model.viscosity().empty() || any_load(model, resists) || any_load(model, drives);
  if (open_) last_ = border(model, start);
  follows_ = model.dissipates() || !model.has_energy();
  if (!follows_) return;
  if (model.has_energy()) taken = model.stored_energy(start.positions);
  law_forces_ = model.elastic_forces(start.positions);
}

Ledger::Border Ledger::border(const Model& model, const State& state) const {
  const Positions none = Positions::Zero(3, model.body().size());
  Border forces;
  if (!model.viscosity().empty() || any_load(model, resists)) {
    forces.resisting = none;
    if (!model.viscosity().empty())
      model.gather(state.positions, model.viscous_force_densities(state), forces.resisting);
    for (const auto& load : model.loads())
      if (resists(*load)) load->add_resistance(state, forces.resisting);
  }
  if (any_load(model, drives)) {
    forces.driving = none;
    add_loads(model, state, drives, forces.driving);
  }
  if (model.drive) {
    // What holds the supports against all other forces; what moves their own mass is counted by its kinetic energy.
    Positions all;
    model.set_forces(state, all);
    forces.supporting = none;
    for (const Support& support : model.supports) {
      const Vector3 force = all.col(support.molecule), velocity = state.velocities.col(support.molecule);
      forces.supporting.col(support.molecule) = support.free * force - force;
      if (support.molecule >= owned_molecules(model.body())) continue;
      forces.support_kinetic +=
          model.body().mass[support.molecule] * (velocity - support.free * velocity).squaredNorm() / 2;
    }
  }
  return forces;
}

namespace {

/// The same of forces that take energy. What has separated by the step's end, and feels none then, felt none that
/// counts: Newmark's method takes it out (see implicit.cpp), and energy that was not taken must not look as if it were
/// made.
double resisted_work(const Body& body, const Positions& before, const Positions& after, const Positions& displacement) {
  if (before.cols() == 0) return 0;
  return ordered_sum(owned_molecules(body), [&](int i) {
    return after.col(i).isZero(0) ? 0 : (before.col(i) + after.col(i)).dot(displacement.col(i)) / 2;
  });
}

}  // namespace

/// Over a step the force of a law is f(x) + (1 − θ) (f₀ − f(x₀)), θ from 0 to 1 on the way from x₀ to x: f is the law
/// as it stands at the end, f₀ the force at the beginning. Where f has an energy its work is known, of others to the
/// order of Simpson's rule. A stepper whose own sum differs from that makes energy.
void Ledger::record_laws(const Model& model, const State& state, const Positions& displacement) {
  Positions after = model.elastic_forces(state.positions);
  const bool has_energy = model.has_energy();
  const double energy_after = has_energy ? model.elastic_energy(state.positions) : 0;
  const double part = model.rest_part();
  if (has_energy && part != rest_part_) model.set_rest(rest_part_);
  const Positions before = model.elastic_forces(positions_);
  const double energy_before = has_energy ? model.elastic_energy(positions_) : 0;
  if (model.rest_part() != part) model.set_rest(part);
  const int owned = owned_molecules(model.body());
  const auto along = [&](const Positions& forces) {
    return ordered_sum(owned, [&](int i) { return forces.col(i).dot(displacement.col(i)); });
  };
  if (has_energy)
    taken += energy_after - energy_before;
  else
    taken -= (along(before) + 4 * along(model.elastic_forces(positions_ + displacement / 2)) + along(after)) / 6;
  if (model.dissipates()) taken -= (along(law_forces_) - along(before)) / 2;
  law_forces_ = std::move(after);
}

/// What another rest adds to the energy of a body that goes straight on meanwhile. By the trapezoidal rule it is half
/// of what it adds where the body begins and where it ends; that over the whole step and over its halves gives the
/// order 4 [Richardson 1911], which bodies need that follow their rest: they have next to no energy themselves.
double Ledger::work_of_rest(const Model& model, const State& state) const {
  const double part = model.rest_part();
  if (part == rest_part_ || !model.has_energy()) return 0;
  const Positions middle = (positions_ + state.positions) / 2;
  const auto energy = [&](const Positions& positions) { return model.elastic_energy(positions); };
  double whole = energy(positions_) + energy(state.positions), halves = energy(state.positions) + energy(middle);
  model.set_rest((rest_part_ + part) / 2);
  halves += energy(positions_) - energy(state.positions);
  model.set_rest(rest_part_);
  whole -= energy(positions_) + energy(state.positions), halves -= energy(positions_) + energy(middle);
  model.set_rest(part);
  return (4 * halves - whole) / 6;
}

void Ledger::record(const Model& model, const State& state) {
  if (!open_ && !follows_ && !model.rest_in_time) return;
  const Positions displacement = state.positions - positions_;
  if (follows_) record_laws(model, state, displacement);
  work += work_of_rest(model, state);
  positions_ = state.positions;
  rest_part_ = model.rest_part();
  if (!open_) return;
  Border now = border(model, state);
  const Body& body = model.body();
  dissipated -= resisted_work(body, last_.resisting, now.resisting, displacement);
  work += work_of(body, last_.driving, now.driving, displacement) +
          work_of(body, last_.supporting, now.supporting, displacement) + now.support_kinetic - last_.support_kinetic;
  if (now.driving.cols()) {
    const double step = state.time - time_;
    const VectorX& mass = body.mass;
    jumps += ordered_sum(owned_molecules(body), [&](int i) {
      return mass[i] > 0 ? step * step * (now.driving.col(i) - last_.driving.col(i)).squaredNorm() / (2 * mass[i]) : 0;
    });
  }
  time_ = state.time;
  last_ = std::move(now);
}

Energies Ledger::energies(const Model& model, const State& state) const {
  const VectorX& mass = model.body().mass;
  const int n = owned_molecules(model.body());
  Energies found;
  found.kinetic = ordered_sum(n, [&](int i) { return mass[i] * state.velocities.col(i).squaredNorm() / 2; });
  if (model.has_energy())
    found.elastic = model.stored_energy(state.positions);
  else
    found.in_laws = taken;
  for (const auto& load : model.loads())
    if (load->acts_at_rest() && load->steady()) found.potential += load->energy(state);
  found.dissipated = dissipated + (follows_ && model.has_energy() ? taken - found.elastic : 0);
  found.work = work;
  found.momentum = ordered_sum<Vector3>(
      n, [&](int i) -> Vector3 { return mass[i] * state.velocities.col(i); }, Vector3(Vector3::Zero()));
  found.angular_momentum = ordered_sum<Vector3>(
      n,
      [&](int i) -> Vector3 {
        return mass[i] * Vector3(state.positions.col(i)).cross(Vector3(state.velocities.col(i)));
      },
      Vector3(Vector3::Zero()));
  if (!model.body().share) return found;
  Eigen::Matrix<double, 12, 1> sums;
  sums << found.kinetic, found.elastic, found.in_laws, found.potential, found.dissipated, found.work, found.momentum,
      found.angular_momentum;
  sum_over(model.body(), {sums.data(), 12});
  return {sums[0], sums[1], sums[2], sums[3], sums[4], sums[5], sums.segment<3>(6), sums.segment<3>(9)};
}

}  // namespace elastin
