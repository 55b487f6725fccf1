#include <algorithm>
#include <cmath>
#include <utility>

#include "core/model/visit_state.h"
#include "core/simulation/host_loads.h"
#include "core/simulation/simulation_impl.h"
#include "core/solve/steppers.h"
#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"

namespace elastin {
namespace {

bool is_projector(const Matrix3& matrix) {
  return (matrix - matrix.transpose()).norm() < 1e-9 && (matrix * matrix - matrix).norm() < 1e-9;
}

void check_finite(const Vector3& position) {
  if (!position.allFinite())
    throw InputError("the position (" + number(position.x()) + ", " + number(position.y()) + ", " +
                     number(position.z()) + ") m is not finite");
}

}  // namespace

void Simulation::Impl::check_molecule(int molecule) const {
  if (molecule < 0 || molecule >= body.size())
    throw InputError("no molecule " + std::to_string(molecule) + ": the body has molecules 0 to " +
                     std::to_string(body.size() - 1));
}

Coupling& Simulation::Impl::find(CouplingId id) {
  const auto found =
      std::find_if(couplings.begin(), couplings.end(), [id](const Coupling& coupling) { return coupling.id == id; });
  if (found == couplings.end())
    throw InputError("no coupling " + std::to_string(id) +
                     (id > 0 && id < next_coupling ? ": it was taken off, or its molecule is gone"
                                                   : ": couple() gives their numbers"));
  return *found;
}

/// Within a step they are kept for the next.
void Simulation::Impl::ensure_host_forces() {
  if (has_host_forces) return;
  if (host_forces.cols() == 0) host_forces.setZero(3, body.size());
  if (in_use) return;
  has_host_forces = true;
  model.add(std::make_unique<HostForces>(body, host_forces));
  ++known;
  order_loads();
}

void Simulation::Impl::ensure_couplings() {
  if (std::exchange(has_couplings, true)) return;
  model.add(std::make_unique<Couplings>(couplings));
  ++known;
  order_loads();
}

/// The host's forces and couplings last, whenever they came: sums of forces, too, are then those of another simulation
/// that goes on from a saved state.
void Simulation::Impl::order_loads() {
  std::vector<std::unique_ptr<Load>> all = model.extract_loads();
  const auto last = [](const std::unique_ptr<Load>& load) {
    return dynamic_cast<const Couplings*>(load.get()) ? 2 : dynamic_cast<const HostForces*>(load.get()) ? 1 : 0;
  };
  std::stable_sort(all.begin(), all.end(), [&](const auto& a, const auto& b) { return last(a) < last(b); });
  for (auto& load : all) model.add(std::move(load));
}

Positions& Simulation::host_forces() noexcept {
  impl_->ensure_host_forces();
  return impl_->host_forces;
}

void Simulation::fix(int molecule, const Matrix3& free) {
  impl_->check_idle("fix");
  impl_->check_molecule(molecule);
  if (!is_projector(free)) throw InputError("fix: 'free' is no projector (symmetric, its own square)");
  impl_->host_supports.fix(molecule, free, impl_->shown.positions.col(molecule));
}

void Simulation::release(int molecule) {
  impl_->check_idle("release");
  impl_->check_molecule(molecule);
  impl_->host_supports.release(molecule);
}

void Simulation::move_to(int molecule, const Vector3& position) {
  impl_->check_molecule(molecule);
  check_finite(position);
  if (!impl_->host_supports.move_to(molecule, position))
    throw InputError("move_to: molecule " + std::to_string(molecule) + " is not fixed; fix it first");
}

Vector3 Simulation::reaction(int molecule) const noexcept {
  const bool known = molecule >= 0 && molecule < impl_->body.size();
  const Support* support = known ? impl_->host_supports.find(molecule) : nullptr;
  if (!support) return Vector3::Zero();
  const Vector3 force = forces().col(molecule);
  return support->free * force - force;
}

CouplingId Simulation::couple(int molecule, const Vector3& position, double stiffness, double damping) {
  impl_->check_idle("couple");
  impl_->check_molecule(molecule);
  check_finite(position);
  if (!(stiffness > 0 && std::isfinite(stiffness)))
    throw InputError("couple: a stiffness of " + number(stiffness) + " N/m is out of range: above 0");
  if (!(damping >= 0 && std::isfinite(damping)))
    throw InputError("couple: a damping of " + number(damping) + " N s/m is out of range: 0 or more");
  impl_->ensure_couplings();
  impl_->couplings.push_back({impl_->next_coupling, molecule, stiffness, damping, position, Vector3::Zero()});
  return impl_->next_coupling++;
}

void Simulation::move_coupling(CouplingId id, const Vector3& position, const Vector3& velocity) {
  Coupling& coupling = impl_->find(id);
  coupling.position = position;
  coupling.velocity = velocity;
}

Vector3 Simulation::coupling_force(CouplingId id) const { return force_of(impl_->find(id), impl_->shown); }

void Simulation::decouple(CouplingId id) {
  impl_->check_idle("decouple");
  impl_->couplings.erase(impl_->couplings.begin() + (&impl_->find(id) - impl_->couplings.data()));
}

void Simulation::observe(int every, std::function<void(const Simulation&)> see) {
  if (every < 1) throw InputError("observe: every " + std::to_string(every) + " steps is out of range: 1 or more");
  if (!see) throw InputError("observe: there is no function to call");
  impl_->observers.push_back({every, 0, std::move(see)});
}

SimulationState Simulation::save() const {
  SimulationState saved{impl_->shown,
                        impl_->model.supports,
                        impl_->host_forces,
                        impl_->couplings,
                        {},
                        0,
                        impl_->tools->all,
                        impl_->shared_topology(),
                        impl_->effort,
                        impl_->watch ? impl_->watch->seen() : SeenFrequency(),
                        impl_->bound(),
                        impl_->rest_moments()};
  if (saved.seen.turn != 1) saved.seen.positions.resize(3, 0), saved.seen.elastic_forces.resize(3, 0);
  impl_->host_supports.save(saved);
  return saved;
}

namespace {

/// The state with other values in one of its arrays.
SimulationState changed(SimulationState state, Positions State::*array, const Positions& values, const char* name) {
  const auto molecules = state.state.positions.cols();
  if (values.cols() != molecules)
    throw InputError(std::string(name) + ": " + std::to_string(values.cols()) + " molecules for " +
                     std::to_string(molecules));
  for (Eigen::Index molecule = 0; molecule < molecules; ++molecule)
    if (!values.col(molecule).allFinite())
      throw InputError(std::string(name) + ": those of molecule " + std::to_string(molecule) + " are not finite");
  state.state.*array = values;
  state.state.accelerations = {};  // of the state before
  state.seen = {};
  return state;
}

}  // namespace

void Simulation::set_positions(const Positions& positions) {
  impl_->check_host_forces();
  restore(changed(save(), &State::positions, positions, "positions"));
}

void Simulation::set_velocities(const Positions& velocities) {
  impl_->check_host_forces();
  restore(changed(save(), &State::velocities, velocities, "velocities"));
}

void Simulation::Impl::restore(const SimulationState& saved) {
  Impl& in = *this;
  check_idle("restore, set_positions, set_velocities");
  check_state(saved.state, in.body.size(), in.model.history(), "the saved state");
  if (saved.host_forces.cols() > 0 && (saved.host_forces.cols() != in.body.size() || !saved.host_forces.allFinite()))
    throw InputError("the saved state has host forces on " + std::to_string(saved.host_forces.cols()) +
                     " molecules, or forces that are not finite");
  const Eigen::Index seen = saved.seen.turn == 1 ? in.body.size() : 0;
  if (saved.seen.positions.cols() != seen || saved.seen.elastic_forces.cols() != seen || !(saved.seen.frequency >= 0) ||
      saved.seen.turn < 0)
    throw InputError("the saved state has seen frequencies of another body");
  const auto& [frequency, rate, added_square, added_rate] = saved.bound;
  for (const double part : {frequency, rate, added_square, added_rate})
    if (!(part >= 0 && std::isfinite(part)))
      throw InputError("the saved state has a bound of explicit steps of " + number(part) + ", below 0 or not finite");
  for (const Support& support : saved.supports) in.check_molecule(support.molecule);
  if (saved.others_supports < 0 || static_cast<std::size_t>(saved.others_supports) > saved.supports.size())
    throw InputError("the saved state has " + std::to_string(saved.supports.size()) + " supports, " +
                     std::to_string(saved.others_supports) + " of them from elsewhere");
  for (const Coupling& coupling : saved.couplings) {
    in.check_molecule(coupling.molecule);
    if (coupling.id < 1 || coupling.id > 2000000000 || !(coupling.stiffness > 0) || !(coupling.damping >= 0))
      throw InputError("the saved state has a coupling " + std::to_string(coupling.id) + " that cannot be");
  }
  for (const SimulationState::HostSupport& one : saved.host_supports)
    if (std::none_of(saved.supports.begin(), saved.supports.end(),
                     [&](const Support& support) { return support.molecule == one.molecule; }))
      throw InputError("the saved state fixes molecule " + std::to_string(one.molecule) + " without a support");
  if (saved.tools.size() < in.tools->all.size())
    throw InputError("the saved state has " + std::to_string(saved.tools.size()) + " tools; the simulation has " +
                     std::to_string(in.tools->all.size()));
  if (!saved.couplings.empty()) in.ensure_couplings();
  if (saved.host_forces.cols() > 0) in.ensure_host_forces();
  in.work = in.shown = saved.state;
  in.model.begin_step(in.work, in.work.time);
  if (in.has_host_forces && saved.host_forces.cols() > 0) in.host_forces = saved.host_forces;
  if (in.has_host_forces && saved.host_forces.cols() == 0) in.host_forces.setZero();
  in.couplings = saved.couplings;
  for (const Coupling& coupling : in.couplings) in.next_coupling = std::max(in.next_coupling, coupling.id + 1);
  in.host_supports.restore(saved);
  in.tools->all = saved.tools;
  in.tools->start = in.tools->end = in.shown.time;
  if (saved.effort > 0 && saved.effort != in.effort) in.set_effort(saved.effort);
  if (in.watch) in.watch->watch(saved.seen);
  const StepBound own = in.bound(), none;
  const bool whole = in.restored == none && own.added_square == 0 && own.added_rate == 0;
  if (saved.bound != own && !(saved.bound == none && whole)) {  // of no step yet: the next would find the whole model's
    in.restored = saved.bound;
    in.stable.reset();
    for (Added& added : in.recipe.added) added.frequency = added.damping_rate = 0;
  }
  in.forces_known = in.tensions_known = false;
}

}  // namespace elastin
