#include "elastin/core/forces/tangent.h"

#include <algorithm>

#include "core/forces/graph.h"

namespace elastin {

Tangent::Tangent(Model& model, const State& state, const Weights& weights) : model_(model) {
  linearise_at(state, weights);
}

void Tangent::linearise_at(const State& state, const Weights& weights) {
  state_ = &state;
  weights_ = weights;
  const int connections = model_.body().connections.size();
  force_densities_.setZero(connections);
  slopes_.setZero(connections);
  coupled_ = false;
  for (const auto& term : model_.elasticity()) term->add_force_densities(state.positions, force_densities_, workspace_);
  for (const auto& term : model_.elasticity()) {
    term->linearise(state.positions);
    term->add_own_slopes(slopes_);
    coupled_ |= term->coupled();
  }
  if (!model_.viscosity().empty()) {
    model_.set_squared_lengths_and_rates(state, workspace_.squared_lengths, workspace_.rates);
    for (const auto& term : model_.viscosity()) {
      term->add_force_densities(workspace_.squared_lengths, workspace_.rates, force_densities_, workspace_);
      term->add_own_slopes(workspace_.squared_lengths, workspace_.rates, weights.velocity, slopes_);
      coupled_ |= term->coupled();
    }
  }
  stressed_ = !force_densities_.isZero(0);
  if (!stressed_ && weights.acceleration == 0) force_densities_.resize(0);
  const auto& loads = model_.loads();
  loads_change_ = std::any_of(loads.begin(), loads.end(), [&](const auto& load) {
    return load->changes() && (load->acts_at_rest() || weights.velocity != 0);
  });
  set_diagonal();
}

void Tangent::apply(const Positions& motion, Positions& result, ApplyWorkspace& workspace) const {
  if (weights_.acceleration != 0)
    parallel_for(
        static_cast<int>(motion.cols()),
        [&](int a) { result.col(a) = weights_.acceleration * model_.body().mass[a] * motion.col(a); },
        kParallelThreshold / 10);
  else
    result.setZero();
  apply_links(motion, result, workspace);
  for (const auto& term : model_.elasticity())
    if (term->at_nodes()) term->add_stiffness(motion, result, workspace.force_pass);
  if (!loads_change_) return;
  workspace.rates = weights_.velocity * motion;
  workspace.change.setZero(3, motion.cols());
  for (const auto& load : model_.loads())
    if (load->changes()) load->add_change(*state_, motion, workspace.rates, workspace.change);
  result -= workspace.change;
}

void Tangent::apply_links(const Positions& motion, Positions& result, ApplyWorkspace& workspace) const {
  const Connections& connections = model_.body().connections;
  const Graph& graph = *model_.graph_;
  if (!coupled_ && !stressed_) {
    graph.add_flows(result, [&](int c, int a, int b) -> Vector3 {
      const Vector3 d = positions().col(b) - positions().col(a);
      return (2 * slopes_[c] * d.dot(motion.col(a) - motion.col(b))) * d;
    });
    return;
  }
  if (!coupled_) {
    graph.add_flows(result, [&](int c, int a, int b) -> Vector3 {
      const Link link = this->link(c);
      const Vector3 delta = motion.col(a) - motion.col(b);
      return link.density * delta + (link.slope * link.d.dot(delta)) * link.d;
    });
    return;
  }
  VectorX &squared_lengths = workspace.squared_lengths, &force_densities = workspace.force_densities;
  squared_lengths.resize(connections.size());
  force_densities.resize(connections.size());
  parallel_for(connections.size(), [&](int c) {
    const auto& [a, b] = connections.ends[c];
    squared_lengths[c] = 2 * (positions().col(b) - positions().col(a)).dot(motion.col(b) - motion.col(a));
    force_densities[c] = slopes_[c] * squared_lengths[c];
  });
  for (const auto& term : model_.elasticity()) term->add_change(squared_lengths, force_densities, workspace.force_pass);
  if (!model_.viscosity().empty()) {
    squared_lengths *= weights_.velocity;
    for (const auto& term : model_.viscosity())
      term->add_change(squared_lengths, force_densities, workspace.force_pass);
  }
  graph.add_flows(result, [&](int c, int a, int b) -> Vector3 {
    const Link link = this->link(c);
    return link.density * (motion.col(a) - motion.col(b)) - force_densities[c] * link.d;
  });
}

/// Of inertia, links, cells and loads: all but what a law visits as blocks itself.
void Tangent::visit_local_blocks(const BlockVisitor& visit) const {
  if (weights_.acceleration != 0)
    for (int a = 0; a < model_.body().size(); ++a)
      visit(a, a, weights_.acceleration * model_.body().mass[a] * Matrix3::Identity());
  const auto& ends = model_.body().connections.ends;
  const auto visit_pair = [&](int c, int other, const Matrix3& block) {
    for (const int i : {0, 1})
      for (const int j : {0, 1}) visit(ends[c][i], ends[other][j], i == j ? block : Matrix3(-block));
  };
  for (int c = 0; c < model_.body().connections.size(); ++c) visit_pair(c, c, link_block(c));
  visit_cells([&](const CellSlopes& cells) {
    for (int cell = 0; cell < cells.size(); ++cell) {
      const auto connections = cells.connections_of(cell);
      const double* slope = cells.slopes_of(cell);
      for (const int own : connections)
        for (const int other : connections)
          visit_pair(own, other, 2 * cells.factor * *slope++ * link(own).d * link(other).d.transpose());
    }
  });
  for (const auto& load : model_.loads()) load->visit_blocks(*state_, weights_.velocity, visit);
}

void Tangent::visit_blocks(const BlockVisitor& visit) const {
  visit_local_blocks(visit);
  for (const auto& term : model_.elasticity()) term->visit_blocks(visit);
}

std::vector<WideTerm> Tangent::wide_terms() const {
  std::vector<WideTerm> terms;
  for (const auto& load : model_.loads())
    for (WideTerm& term : load->wide_terms(*state_)) terms.push_back(std::move(term));
  return terms;
}

void Tangent::visit_cells(const Elasticity::CellVisitor& visit) const {
  for (const auto& term : model_.elasticity()) term->visit_cells(visit);
  for (const auto& term : model_.viscosity())
    term->visit_cells([&](CellSlopes cells) {
      cells.factor *= weights_.velocity;
      visit(cells);
    });
}

void Tangent::visit_other_diagonal(const std::function<void(int, const Matrix3&)>& visit) const {
  for (const auto& load : model_.loads())
    load->visit_blocks(*state_, weights_.velocity, [&](int a, int b, const Matrix3& block) {
      if (a == b) visit(a, block);
    });
  const auto nothing = [](std::span<const std::pair<int, Vector3>>, double) {};
  for (const auto& term : model_.elasticity()) {
    if (term->visit_gradients(nothing)) continue;
    term->visit_diagonal(visit);
  }
}

/// visit_blocks gives the same; but few of its blocks are on the diagonal, and every solve needs these.
void Tangent::set_diagonal() {
  const Body& body = model_.body();
  const auto& ends = body.connections.ends;
  diagonal_.assign(static_cast<std::size_t>(body.size()), Six::Zero());
  const auto add = [&](int a, const Matrix3& block) {
    diagonal_[static_cast<std::size_t>(a)] +=
        Six{block(0, 0), block(0, 1), block(0, 2), block(1, 1), block(1, 2), block(2, 2)};
  };
  if (weights_.acceleration != 0)  // bodies that never move need no masses
    for (int a = 0; a < body.size(); ++a) add(a, weights_.acceleration * body.mass[a] * Matrix3::Identity());
  model_.graph_->add_to_ends(diagonal_, [&](int c) {
    const auto [d, density, slope] = link(c);
    const Vector3 s = slope * d;
    return Six{s.x() * d.x() + density, s.x() * d.y(), s.x() * d.z(),
               s.y() * d.y() + density, s.y() * d.z(), s.z() * d.z() + density};
  });
  const auto add_cells = [&](const CellSlopes& cells) {
    for (int cell = 0; cell < cells.size(); ++cell) {
      const auto connections = cells.connections_of(cell);
      const double* slopes = cells.slopes_of(cell);
      for (const int c : connections) {
        // Of one side all that the cell's sides make of it: Σ over those with which it shares a molecule.
        for (const int end : {0, 1}) {
          const int molecule = ends[c][end];
          Vector3 sum = Vector3::Zero();
          for (std::size_t other = 0; other < connections.size(); ++other) {
            const auto& [first, second] = ends[connections[other]];
            if (first != molecule && second != molecule) continue;
            const double sign = ends[connections[other]][end] == molecule ? 1 : -1;
            sum += sign * slopes[other] * link(connections[other]).d;
          }
          add(molecule, 2 * cells.factor * link(c).d * sum.transpose());
        }
        slopes += connections.size();
      }
    }
  };
  visit_cells(std::ref(add_cells));  // a function that holds it would ask for memory
  const BlockVisitor add_own = [&](int a, int b, const Matrix3& block) {
    if (a == b) add(a, block);
  };
  for (const auto& load : model_.loads()) load->visit_blocks(*state_, weights_.velocity, add_own);
  for (const auto& term : model_.elasticity()) term->visit_diagonal(std::ref(add));
}

}  // namespace elastin
