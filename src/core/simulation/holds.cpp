#include "core/simulation/holds.h"

#include <algorithm>
#include <utility>

namespace elastin {

void Holds::hold(int molecule, const Matrix3& free, const Vector3& place) {
  if (held_.empty()) others_supports_ = static_cast<int>(model_.supports.size());
  if (support_of(molecule) < 0) {
    model_.supports.push_back({molecule});
    if (!seen_.empty())
      seen_[static_cast<std::size_t>(molecule)].support = static_cast<int>(model_.supports.size()) - 1;
  }
  Held& held = take(molecule);
  Support& now = support(held);
  now.free = free;
  now.displacement = held.displacement = place - model_.body().rest.col(molecule);
  now.velocity.setZero();
  held.next.reset();
}

/// Supports from elsewhere stay in the list, free in all directions: what drives them knows them by their number.
void Holds::release(int molecule) {
  const int at = support_of(molecule);
  if (at < 0) return;
  const auto mine =
      std::find_if(held_.begin(), held_.end(), [molecule](const Held& held) { return held.molecule == molecule; });
  if (mine != held_.end() && at >= others_supports_)
    model_.supports.erase(model_.supports.begin() + at);
  else
    model_.supports[static_cast<std::size_t>(at)].free.setIdentity();
  if (mine != held_.end()) held_.erase(mine);
  index();
}

bool Holds::move_to(int molecule, const Vector3& place) {
  if (support_of(molecule) < 0) return false;
  if (held_.empty()) others_supports_ = static_cast<int>(model_.supports.size());
  take(molecule).next = place - model_.body().rest.col(molecule);
  return true;
}

const Support* Holds::find(int molecule) const {
  const int at = support_of(molecule);
  return at < 0 ? nullptr : &model_.supports[static_cast<std::size_t>(at)];
}

void Holds::begin(double start, double end) {
  start_ = start;
  end_ = end;
  if (held_.empty()) return;
  // What the host took out of the model's list itself is not held.
  if (std::erase_if(held_, [this](const Held& held) { return support_of(held.molecule) < 0; })) index();
  attach();
}

void Holds::jump() {
  for (const Held& held : held_)
    if (held.next) support(held).displacement = *held.next;
}

void Holds::arrive() {
  for (Held& held : held_) {
    if (!held.next) continue;
    support(held).displacement = held.displacement = *std::exchange(held.next, std::nullopt);
    support(held).velocity.setZero();
  }
  start_ = end_;
}

void Holds::go_back() {
  for (const Held& held : held_) {
    support(held).displacement = held.displacement;
    support(held).velocity.setZero();
  }
  end_ = start_;
}

void Holds::save(SimulationState& saved) const {
  for (const Held& held : held_) saved.holds.push_back({held.molecule, held.next});
  saved.others_supports = others_supports_;
}

void Holds::restore(const SimulationState& saved) {
  model_.supports = saved.supports;
  others_supports_ = saved.others_supports;
  held_.clear();
  index();
  for (const SimulationState::Hold& hold : saved.holds) take(hold.molecule).next = hold.next;
}

void Holds::drive(double time, std::vector<Support>& supports) {
  if (others_) others_(time, supports);
  double part = end_ > start_ ? std::clamp((time - start_) / (end_ - start_), 0., 1.) : 0;
  if (part > 1 - 1e-9) part = 1;  // the sum of a step's parts is off by its rounding
  for (const Held& held : held_) {
    const Vector3 way = held.next ? Vector3(*held.next - held.displacement) : Vector3(Vector3::Zero());
    support(held).displacement = held.displacement + part * way;
    support(held).velocity = end_ > start_ ? Vector3(way / (end_ - start_)) : Vector3(Vector3::Zero());
  }
}

/// A drive that the host has set since is taken in: it goes first.
void Holds::attach() {
  if (model_.drive.target<Driver>()) return;
  others_ = std::move(model_.drive);
  model_.drive = Driver{this};
}

void Holds::index() {
  seen_.assign(static_cast<std::size_t>(model_.body().size()), {});
  for (std::size_t at = 0; at < model_.supports.size(); ++at)
    seen_[static_cast<std::size_t>(model_.supports[at].molecule)].support = static_cast<int>(at);
  for (std::size_t at = 0; at < held_.size(); ++at)
    seen_[static_cast<std::size_t>(held_[at].molecule)].held = static_cast<int>(at);
}

int Holds::support_of(int molecule) const {
  const auto& supports = model_.supports;
  if (!seen_.empty()) {
    const int at = seen_[static_cast<std::size_t>(molecule)].support;
    if (at >= 0 && at < static_cast<int>(supports.size()) &&
        supports[static_cast<std::size_t>(at)].molecule == molecule)
      return at;
  }
  const auto found = std::find_if(supports.begin(), supports.end(),
                                  [molecule](const Support& support) { return support.molecule == molecule; });
  return found == supports.end() ? -1 : static_cast<int>(found - supports.begin());
}

/// The record of a molecule that has a support; from where that is now, if it is new.
Holds::Held& Holds::take(int molecule) {
  if (seen_.empty()) index();
  int& at = seen_[static_cast<std::size_t>(molecule)].held;
  if (at < 0) {
    at = static_cast<int>(held_.size());
    held_.push_back({molecule, find(molecule)->displacement, std::nullopt});
  }
  return held_[static_cast<std::size_t>(at)];
}

}  // namespace elastin
