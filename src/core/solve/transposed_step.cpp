#include "core/solve/transposed_step.h"

#include <string>

namespace elastin {
namespace {

/// Calls visit(law, block) for each law whose history has slopes.
template <class Blocks, class Visit>
void for_each_history(const Model& model, Blocks& blocks, const Visit& visit) {
  for (std::size_t law = 0; law < model.elasticity().size(); ++law) {
    const auto* own = dynamic_cast<const TransposedHistory*>(model.elasticity()[law].get());
    const std::string name = "law" + std::to_string(law);
    for (auto& block : blocks)
      if (own && (block.name == name || block.name.starts_with(name + "."))) visit(*own, block);
  }
}

}  // namespace

void TransposedForces::begin(const State& from, double time, const State& at, double dt) {
  from_ = &from, at_ = &at, time_ = time;
  model_.begin_step(from, time);
  still_.linearise_at(at, {});
  if (model_.feels_velocity()) tangent_.linearise_at(at, {1 / dt, 0});
}

Positions TransposedForces::damping(const Positions& lambda) const {
  Positions result(3, lambda.cols()), still(3, lambda.cols());
  if (!model_.feels_velocity()) return Positions::Zero(3, lambda.cols());
  tangent_.apply(lambda, result);
  still_.apply(lambda, still);
  return (result - still) / tangent_.weights().velocity;
}

void TransposedForces::add(const Positions& lambda, StateSlopes& slopes) {
  Positions change(3, lambda.cols());
  still_.apply(lambda, change);
  slopes.positions -= change;
  if (model_.feels_velocity()) slopes.velocities -= damping(lambda);
  add_turning(lambda, slopes.positions);
  add_past(lambda, slopes);
}

/// q = G ṡ, ṡ = 2 d·w of a connection: by d it has 2 G w, of which m has 2 w (G z) with z = d·(λ_a − λ_b).
void TransposedForces::add_turning(const Positions& lambda, Positions& of_positions) const {
  if (model_.viscosity().empty()) return;
  const Connections& connections = model_.body().connections;
  const auto [squared_lengths, rates] = model_.squared_lengths_and_rates(*at_);
  VectorX work(connections.size()), change = VectorX::Zero(connections.size());
  const auto difference = [&](const Positions& of, int c) -> Vector3 {
    return of.col(connections.ends[c][1]) - of.col(connections.ends[c][0]);
  };
  for (int c = 0; c < connections.size(); ++c) work[c] = -difference(at_->positions, c).dot(difference(lambda, c));
  Workspace workspace;
  for (const auto& term : model_.viscosity()) {
    VectorX own = VectorX::Zero(connections.size()), at_rest = own;
    term->add_own_slopes(squared_lengths, rates, 1, own);
    term->add_own_slopes(squared_lengths, rates, 0, at_rest);
    change += (own - at_rest).cwiseProduct(work);
    term->add_change(work, change, workspace);
  }
  for (int c = 0; c < connections.size(); ++c) {
    const Vector3 slope = 2 * change[c] * difference(at_->velocities, c);
    of_positions.col(connections.ends[c][1]) += slope;
    of_positions.col(connections.ends[c][0]) -= slope;
  }
}

void TransposedForces::add_past(const Positions& lambda, StateSlopes& slopes) const {
  for_each_history(model_, slopes.history, [&](const TransposedHistory& law, HistoryBlock& block) {
    law.transpose_forces(*from_->find_history(block.name), time_, at_->positions, lambda, block.values);
  });
}

void transpose_commit(const Model& model, const State& from, const State& to, StateSlopes& slopes) {
  for_each_history(model, slopes.history, [&](const TransposedHistory& law, HistoryBlock& block) {
    law.transpose_commit(*from.find_history(block.name), to.time, to.positions, block.values, slopes.positions);
  });
}

}  // namespace elastin
