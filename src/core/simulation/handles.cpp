#include <algorithm>
#include <cmath>
#include <utility>

#include "core/simulation/host_loads.h"
#include "core/simulation/inside.h"
#include "elastin/core/base/error.h"

namespace elastin {
namespace {

bool is_projector(const Matrix3& matrix) {
  return (matrix - matrix.transpose()).norm() < 1e-9 && (matrix * matrix - matrix).norm() < 1e-9;
}

void check_finite(const Vector3& place) {
  if (!place.allFinite())
    throw InputError("the place (" + number(place.x()) + ", " + number(place.y()) + ", " + number(place.z()) +
                     ") m is not finite");
}

void check_shape(const char* what, const Positions& given, Eigen::Index wanted) {
  if (given.cols() != wanted)
    throw InputError("the saved state is another body's: " + std::to_string(given.cols()) + " " + what + ", not " +
                     std::to_string(wanted));
  if (!given.allFinite()) throw InputError(std::string("the saved ") + what + " are not all finite");
}

}  // namespace

void Simulation::Inside::check_molecule(int molecule) const {
  if (molecule < 0 || molecule >= body.size())
    throw InputError("molecule " + std::to_string(molecule) + " is none: the body has molecules 0 to " +
                     std::to_string(body.size() - 1));
}

Grip* Simulation::Inside::find(GripId id) {
  const auto found = std::find_if(grips.begin(), grips.end(), [id](const Grip& grip) { return grip.id == id; });
  return found == grips.end() ? nullptr : &*found;
}

void Simulation::Inside::make_room_for_host_forces() {
  if (std::exchange(has_host_forces, true)) return;
  host_forces.setZero(3, body.size());
  model.add(std::make_unique<HostForces>(body, host_forces));
}

void Simulation::Inside::make_room_for_grips() {
  if (!std::exchange(has_grips, true)) model.add(std::make_unique<Grips>(grips));
}

Positions& Simulation::host_forces() noexcept {
  inside_->make_room_for_host_forces();
  return inside_->host_forces;
}

void Simulation::hold(int molecule, const Matrix3& free) {
  inside_->check_molecule(molecule);
  if (!is_projector(free)) throw InputError("hold: 'free' is no projector (symmetric, its own square)");
  inside_->holds.hold(molecule, free, inside_->shown.positions.col(molecule));
}

void Simulation::release(int molecule) {
  inside_->check_molecule(molecule);
  inside_->holds.release(molecule);
}

void Simulation::move_to(int molecule, const Vector3& place) {
  inside_->check_molecule(molecule);
  check_finite(place);
  if (!inside_->holds.move_to(molecule, place))
    throw InputError("move_to: molecule " + std::to_string(molecule) + " is not held; hold it first");
}

Vector3 Simulation::reaction(int molecule) const noexcept {
  const bool known = molecule >= 0 && molecule < inside_->body.size();
  const Support* support = known ? inside_->holds.find(molecule) : nullptr;
  if (!support) return Vector3::Zero();
  const Vector3 force = forces().col(molecule);
  return support->free * force - force;
}

GripId Simulation::grab(int molecule, const Vector3& place, double stiffness, double damping) {
  inside_->check_molecule(molecule);
  check_finite(place);
  if (!(stiffness > 0 && std::isfinite(stiffness)))
    throw InputError("grab: a stiffness of " + number(stiffness) + " N/m is out of range: above 0");
  if (!(damping >= 0 && std::isfinite(damping)))
    throw InputError("grab: a damping of " + number(damping) + " N s/m is out of range: 0 or more");
  inside_->make_room_for_grips();
  inside_->grips.push_back({inside_->next_grip, molecule, stiffness, damping, place, Vector3::Zero()});
  return inside_->next_grip++;
}

void Simulation::move_grip(GripId id, const Vector3& place, const Vector3& velocity) noexcept {
  Grip* grip = inside_->find(id);
  if (!grip) return;
  grip->place = place;
  grip->velocity = velocity;
}

Vector3 Simulation::grip_force(GripId id) const noexcept {
  const Grip* grip = inside_->find(id);
  return grip ? force_of(*grip, inside_->shown) : Vector3(Vector3::Zero());
}

void Simulation::let_go(GripId id) noexcept {
  std::erase_if(inside_->grips, [id](const Grip& grip) { return grip.id == id; });
}

void Simulation::observe(int every, std::function<void(const Simulation&)> see) {
  if (every < 1) throw InputError("observe: every " + std::to_string(every) + " steps is out of range: 1 or more");
  if (!see) throw InputError("observe: there is no function to call");
  inside_->observers.push_back({every, 0, std::move(see)});
}

SimulationState Simulation::save() const {
  SimulationState saved{inside_->shown, inside_->model.supports, inside_->host_forces, inside_->grips, {}, 0};
  inside_->holds.save(saved);
  return saved;
}

void Simulation::restore(const SimulationState& saved) {
  Inside& in = *inside_;
  const Eigen::Index n = in.body.size();
  check_shape("positions", saved.state.positions, n);
  check_shape("velocities", saved.state.velocities, n);
  if (saved.state.accelerations.cols() > 0) check_shape("accelerations", saved.state.accelerations, n);
  if (saved.host_forces.cols() > 0) check_shape("host forces", saved.host_forces, n);
  for (const TouchMemory& touch : saved.state.touches) {
    if (touch.count < 0 || touch.count > 3)
      throw InputError("the saved state has a touch of " + std::to_string(touch.count) + " molecules");
    for (int i = 0; i < touch.count; ++i) in.check_molecule(touch.molecules[static_cast<std::size_t>(i)]);
  }
  if (!std::isfinite(saved.state.time)) throw InputError("the saved time is not finite");
  for (const Support& support : saved.supports) in.check_molecule(support.molecule);
  if (saved.others_supports < 0 || static_cast<std::size_t>(saved.others_supports) > saved.supports.size())
    throw InputError("the saved state has " + std::to_string(saved.supports.size()) + " supports, " +
                     std::to_string(saved.others_supports) + " of them from elsewhere");
  for (const Grip& grip : saved.grips) {
    in.check_molecule(grip.molecule);
    if (grip.id < 1 || grip.id > 2000000000 || !(grip.stiffness > 0) || !(grip.damping >= 0))
      throw InputError("the saved state has a grip " + std::to_string(grip.id) + " that cannot be");
  }
  for (const SimulationState::Hold& hold : saved.holds)
    if (std::none_of(saved.supports.begin(), saved.supports.end(),
                     [&](const Support& support) { return support.molecule == hold.molecule; }))
      throw InputError("the saved state holds molecule " + std::to_string(hold.molecule) + " without a support");
  if (!saved.grips.empty()) in.make_room_for_grips();
  if (saved.host_forces.cols() > 0) in.make_room_for_host_forces();
  in.work = in.shown = saved.state;
  if (in.has_host_forces && saved.host_forces.cols() > 0) in.host_forces = saved.host_forces;
  if (in.has_host_forces && saved.host_forces.cols() == 0) in.host_forces.setZero();
  in.grips = saved.grips;
  for (const Grip& grip : in.grips) in.next_grip = std::max(in.next_grip, grip.id + 1);
  in.holds.restore(saved);
  in.forces_known = in.tensions_known = false;
}

}  // namespace elastin
