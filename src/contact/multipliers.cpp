// Depth bounded by augmented Lagrange multipliers, one for each molecule and what it touches: a pressure p of the
// surface about the molecule, linear on the triangles between. A sample s of area A and weights w is pressed with
// λ = A Σ w p in addition to its penalty, and p grows by what the penalty presses on the molecule's share of the
// surface,
//
//     p ← max(0, p + Σ_s w_s (N_s − λ_s) / Σ_s w_s A_s),
//
// until no p changes by more than stiffness · penetration: then the mean gap of each share is zero where p is not. A
// multiplier for each sample would constrain more than the molecules between are free to do: three samples of each
// triangle cannot all lie on a round tool, and most of them would be released. [Wriggers 2006, ch. 5 and 9]
//
// Each update leaves K / (K + k) of the depth, K being what the body resists with and k the penalty. Where that is much
// the penalty is raised while the updates go on; the last solve is with the penalty itself, which the pressures then
// leave less depth than the raised one did. So nothing but pressures is kept.

#include <algorithm>
#include <cmath>

#include "contact/contact_force.h"

namespace elastin::contact {
namespace {

/// After so many updates one is slow that leaves more than a part of the depth; the penalty is then raised by a factor,
/// up to a limit that its stiffness against the body's sets for the linear solver.
constexpr int kPatience = 25;
constexpr double kSlow = 0.25, kRaise = 4, kMostRaised = 4096;

template <class Item>
auto place_of(std::vector<Item>& sorted, std::pair<int, int> key) {
  return std::lower_bound(sorted.begin(), sorted.end(), key,
                          [](const Item& item, const auto& other) { return key_of(item) < other; });
}

/// The item of this key, added if it does not exist yet.
MoleculePressure& entry_of(std::vector<MoleculePressure>& all, int molecule, int target) {
  auto at = place_of(all, {molecule, target});
  if (at == all.end() || key_of(*at) != std::pair{molecule, target}) at = all.insert(at, {molecule, target});
  return *at;
}

}  // namespace

void ContactForce::set_pressures(const State& state) const {
  pressures_.clear();
  raised_ = 1;
  if (options_.penetration == 0) return;
  for (const ContactHistory& memory : state.contact_history)
    if (memory.multiplier > 0) pressures_.push_back({molecule_of(memory), memory.target, memory.multiplier});
  std::sort(pressures_.begin(), pressures_.end(),
            [](const MoleculePressure& a, const MoleculePressure& b) { return key_of(a) < key_of(b); });
  const auto same = [](const MoleculePressure& a, const MoleculePressure& b) { return key_of(a) == key_of(b); };
  pressures_.erase(std::unique(pressures_.begin(), pressures_.end(), same), pressures_.end());
  if (pressures_ == updates_.made) raised_ = updates_.raised;
}

double ContactForce::pressure_at(int molecule, int target) const {
  const auto at = place_of(pressures_, {molecule, target});
  return at != pressures_.end() && key_of(*at) == std::pair{molecule, target} ? at->pressure : 0;
}

double ContactForce::multiplier_of(const ContactPoint& contact_point) const {
  if (pressures_.empty()) return 0;
  const Sample& sample = search_.samples()[contact_point.sample];
  double sum = 0;
  for (int i = 0; i < sample.count; ++i)
    sum += sample.weights[i] * pressure_at(sample.molecules[i], contact_point.target);
  return area_of(contact_point) * sum;
}

void ContactForce::add_entry(const State& state, int sample, const ContactPoint& contact_point) const {
  const std::pair<int, int> key{sample, contact_point.target};
  auto at = place_of(next_history_, key);
  if (at != next_history_.end() && key_of(*at) == key) return;
  at = next_history_.insert(at, {sample, contact_point.target});
  anchor(state, contact_point, sample_position(state, sample), *at);
}

void ContactForce::keep_pressures(const State& state) const {
  for (const ContactPoint& contact_point : contact_points_) {
    const Sample& sample = search_.samples()[contact_point.sample];
    for (int j = 0; j < sample.count; ++j)
      if (pressure_at(sample.molecules[j], contact_point.target) > 0)
        add_entry(state, contact_point.sample - nearest_of(sample) + j, contact_point);
  }
  for (ContactHistory& memory : next_history_) memory.multiplier = pressure_at(molecule_of(memory), memory.target);
}

bool ContactForce::update_multipliers(State& state) const {
  if (options_.penetration == 0) return false;
  evaluate(state, 0, false);
  cached_ = false;
  next_pressures_ = pressures_;
  for (std::size_t i = 0; i < responses_.size(); ++i) {
    const ContactPoint& contact_point = contact_points_[i];
    const Sample& sample = search_.samples()[contact_point.sample];
    const double excess = (responses_[i].elastic - multipliers_[i]) * sample.area / area_of(contact_point);
    for (int j = 0; j < sample.count; ++j)
      entry_of(next_pressures_, sample.molecules[j], contact_point.target).pressure +=
          sample.weights[j] * excess / area_[sample.molecules[j]];
  }
  double largest_change = 0;
  for (MoleculePressure& next : next_pressures_) {
    next.pressure = std::max(0., next.pressure);
    largest_change = std::max(largest_change, std::abs(next.pressure - pressure_at(next.molecule, next.target)));
  }
  const double depth = largest_change / (raised_ * options_.stiffness);
  const bool deep = depth > options_.penetration;
  if (!deep && raised_ == 1) {
    updates_ = {};
    return false;
  }
  if (pressures_ != updates_.made) updates_ = {};
  if (!deep)
    updates_.raised = 1;
  else if (++updates_.count > kPatience && depth > kSlow * updates_.depth)
    updates_.raised = std::min(kRaise * raised_, kMostRaised);
  updates_.depth = depth;
  next_history_ = state.contact_history;
  for (const ContactPoint& contact_point : contact_points_) add_entry(state, contact_point.sample, contact_point);
  pressures_.swap(next_pressures_);
  keep_pressures(state);
  state.contact_history = next_history_;
  set_pressures(state);
  updates_.made = pressures_;
  return true;
}

}  // namespace elastin::contact
