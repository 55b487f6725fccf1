#include "core/simulation/host_supports.h"

#include <algorithm>
#include <utility>

namespace elastin {

void HostSupports::fix(int molecule, const Matrix3& free, const Vector3& position) {
  if (fixed_.empty()) others_supports_ = static_cast<int>(model_.supports.size());
  if (support_of(molecule) < 0) {
    model_.supports.push_back({molecule});
    if (!seen_.empty()) seen_[molecule].support = static_cast<int>(model_.supports.size()) - 1;
  }
  Fixed& fixed = entry_of(molecule);
  Support& now = support(fixed);
  now.free = without_rounding(free);
  now.displacement = fixed.displacement = position - model_.body().rest.col(molecule);
  now.velocity.setZero();
  fixed.next.reset();
}

/// Supports from elsewhere stay in the list, free in all directions: what drives them knows them by their number.
void HostSupports::release(int molecule) {
  const int at = support_of(molecule);
  if (at < 0) return;
  const auto mine =
      std::find_if(fixed_.begin(), fixed_.end(), [molecule](const Fixed& fixed) { return fixed.molecule == molecule; });
  if (mine != fixed_.end() && at >= others_supports_)
    model_.supports.erase(model_.supports.begin() + at);
  else
    model_.supports[at].free.setIdentity();
  if (mine != fixed_.end()) fixed_.erase(mine);
  index();
}

bool HostSupports::move_to(int molecule, const Vector3& position) {
  if (support_of(molecule) < 0) return false;
  if (fixed_.empty()) others_supports_ = static_cast<int>(model_.supports.size());
  entry_of(molecule).next = position - model_.body().rest.col(molecule);
  return true;
}

const Support* HostSupports::find(int molecule) const {
  const int at = support_of(molecule);
  return at < 0 ? nullptr : &model_.supports[at];
}

void HostSupports::begin(double start, double end) {
  start_ = start;
  end_ = end;
  if (fixed_.empty()) return;
  // What the host took out of the model's list itself is not fixed.
  if (std::erase_if(fixed_, [this](const Fixed& fixed) { return support_of(fixed.molecule) < 0; })) index();
  attach();
}

void HostSupports::jump() {
  for (const Fixed& fixed : fixed_)
    if (fixed.next) support(fixed).displacement = *fixed.next;
}

void HostSupports::arrive() {
  for (Fixed& fixed : fixed_) {
    if (!fixed.next) continue;
    support(fixed).displacement = fixed.displacement = *std::exchange(fixed.next, std::nullopt);
    support(fixed).velocity.setZero();
  }
  start_ = end_;
}

void HostSupports::go_back() {
  for (const Fixed& fixed : fixed_) {
    support(fixed).displacement = fixed.displacement;
    support(fixed).velocity.setZero();
  }
  end_ = start_;
}

void HostSupports::save(SimulationState& saved) const {
  for (const Fixed& fixed : fixed_) saved.host_supports.push_back({fixed.molecule, fixed.next});
  saved.others_supports = others_supports_;
}

void HostSupports::restore(const SimulationState& saved) {
  model_.supports = saved.supports;
  others_supports_ = saved.others_supports;
  fixed_.clear();
  index();
  for (const SimulationState::HostSupport& one : saved.host_supports) entry_of(one.molecule).next = one.next;
}

void HostSupports::drive(double time, std::vector<Support>& supports) {
  if (others_) others_(time, supports);
  double fraction = end_ > start_ ? std::clamp((time - start_) / (end_ - start_), 0., 1.) : 0;
  if (fraction > 1 - 1e-9) fraction = 1;  // the sum of a step's parts is off by its rounding
  for (const Fixed& fixed : fixed_) {
    const Vector3 displacement = fixed.next ? Vector3(*fixed.next - fixed.displacement) : Vector3(Vector3::Zero());
    support(fixed).displacement = fixed.displacement + fraction * displacement;
    support(fixed).velocity = end_ > start_ ? Vector3(displacement / (end_ - start_)) : Vector3(Vector3::Zero());
  }
}

/// A drive that the host has set since is taken in: it goes first.
void HostSupports::attach() {
  if (model_.drive.target<Driver>()) return;
  others_ = std::move(model_.drive);
  model_.drive = Driver{this};
}

void HostSupports::index() {
  seen_.assign(model_.body().size(), {});
  for (std::size_t at = 0; at < model_.supports.size(); ++at)
    seen_[model_.supports[at].molecule].support = static_cast<int>(at);
  for (std::size_t at = 0; at < fixed_.size(); ++at) seen_[fixed_[at].molecule].fixed = static_cast<int>(at);
}

int HostSupports::support_of(int molecule) const {
  const auto& supports = model_.supports;
  if (!seen_.empty()) {
    const int at = seen_[molecule].support;
    if (at >= 0 && at < static_cast<int>(supports.size()) && supports[at].molecule == molecule) return at;
  }
  const auto found = std::find_if(supports.begin(), supports.end(),
                                  [molecule](const Support& support) { return support.molecule == molecule; });
  return found == supports.end() ? -1 : static_cast<int>(found - supports.begin());
}

/// The record of a molecule that has a support; from where that is now, if it is new.
HostSupports::Fixed& HostSupports::entry_of(int molecule) {
  if (seen_.empty()) index();
  int& at = seen_[molecule].fixed;
  if (at < 0) {
    at = static_cast<int>(fixed_.size());
    fixed_.push_back({molecule, find(molecule)->displacement, std::nullopt});
  }
  return fixed_[at];
}

}  // namespace elastin
