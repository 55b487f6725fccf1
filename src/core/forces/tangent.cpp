#include "core/forces/tangent.h"

#include <algorithm>

#include "core/forces/graph.h"

namespace elastin {

Tangent::Tangent(Model& model, const State& state, const Weights& weights) : model_(model) { take(state, weights); }

void Tangent::take(const State& state, const Weights& weights) {
  state_ = &state;
  weights_ = weights;
  const int connections = model_.body().connections.size();
  densities_.setZero(connections);
  slopes_.setZero(connections);
  coupled_ = false;
  for (const auto& part : model_.elasticity()) part->add_force_densities(state.positions, densities_, scratch_);
  for (const auto& part : model_.elasticity()) {
    part->linearise(state.positions);
    part->add_own_slopes(slopes_);
    coupled_ |= part->coupled();
  }
  if (!model_.viscosity().empty()) {
    model_.set_squares_and_rates(state, scratch_.squares, scratch_.rates);
    for (const auto& part : model_.viscosity()) {
      part->add_force_densities(scratch_.squares, scratch_.rates, densities_, scratch_);
      part->add_own_slopes(scratch_.squares, scratch_.rates, weights.velocity, slopes_);
      coupled_ |= part->coupled();
    }
  }
  stressed_ = !densities_.isZero(0);
  if (!stressed_ && weights.acceleration == 0) densities_.resize(0);
  const auto& loads = model_.loads();
  loads_change_ = std::any_of(loads.begin(), loads.end(), [&](const auto& load) {
    return load->changes() && (load->acts_at_rest() || weights.velocity != 0);
  });
  set_diagonal();
}

void Tangent::apply(const Positions& motion, Positions& result, Room& room) const {
  if (weights_.acceleration != 0)
    parallel_for(
        static_cast<int>(motion.cols()),
        [&](int a) { result.col(a) = weights_.acceleration * model_.body().mass[a] * motion.col(a); },
        kParallelThreshold / 10);
  else
    result.setZero();
  apply_links(motion, result, room);
  if (!loads_change_) return;
  room.rates = weights_.velocity * motion;
  room.change.setZero(3, motion.cols());
  for (const auto& load : model_.loads())
    if (load->changes()) load->add_change(*state_, motion, room.rates, room.change);
  result -= room.change;
}

void Tangent::apply_links(const Positions& motion, Positions& result, Room& room) const {
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
  VectorX &squares = room.squares, &densities = room.densities;
  squares.resize(connections.size());
  densities.resize(connections.size());
  parallel_for(connections.size(), [&](int c) {
    const auto& [a, b] = connections.ends[c];
    squares[c] = 2 * (positions().col(b) - positions().col(a)).dot(motion.col(b) - motion.col(a));
    densities[c] = slopes_[c] * squares[c];
  });
  for (const auto& part : model_.elasticity()) part->add_change(squares, densities, room.scratch);
  if (!model_.viscosity().empty()) {
    squares *= weights_.velocity;
    for (const auto& part : model_.viscosity()) part->add_change(squares, densities, room.scratch);
  }
  graph.add_flows(result, [&](int c, int a, int b) -> Vector3 {
    const Link link = this->link(c);
    return link.density * (motion.col(a) - motion.col(b)) - densities[c] * link.d;
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
  const auto visit_cell = [&](double weight) {
    return [&, weight](std::span<const int> connections, const double* slopes) {
      const std::size_t sides = connections.size();
      for (std::size_t i = 0; i < sides; ++i)
        for (std::size_t j = 0; j < sides; ++j)
          visit_pair(connections[i], connections[j],
                     2 * weight * slopes[i * sides + j] * link(connections[i]).d * link(connections[j]).d.transpose());
    };
  };
  for (const auto& part : model_.elasticity()) part->visit_cells(visit_cell(1));
  for (const auto& part : model_.viscosity()) part->visit_cells(visit_cell(weights_.velocity));
  for (const auto& load : model_.loads()) load->visit_blocks(*state_, weights_.velocity, visit);
}

void Tangent::visit_blocks(const BlockVisitor& visit) const {
  visit_local_blocks(visit);
  for (const auto& part : model_.elasticity()) part->visit_blocks(visit);
}

std::vector<WidePart> Tangent::wide_parts() const {
  std::vector<WidePart> parts;
  for (const auto& load : model_.loads())
    for (WidePart& part : load->wide_parts(*state_)) parts.push_back(std::move(part));
  return parts;
}

void Tangent::visit_cells(const std::function<void(double, std::span<const int>, const double*)>& visit) const {
  for (const auto& part : model_.elasticity())
    part->visit_cells([&](std::span<const int> connections, const double* slopes) { visit(1, connections, slopes); });
  for (const auto& part : model_.viscosity())
    part->visit_cells(
        [&](std::span<const int> connections, const double* slopes) { visit(weights_.velocity, connections, slopes); });
}

void Tangent::visit_other_diagonal(const std::function<void(int, const Matrix3&)>& visit) const {
  for (const auto& load : model_.loads())
    load->visit_blocks(*state_, weights_.velocity, [&](int a, int b, const Matrix3& part) {
      if (a == b) visit(a, part);
    });
  const auto nothing = [](std::span<const std::pair<int, Vector3>>, double) {};
  for (const auto& part : model_.elasticity()) {
    if (part->visit_gradients(nothing)) continue;
    part->visit_diagonal(visit);
  }
}

/// visit_blocks gives the same; but few of its blocks are on the diagonal, and every solve needs these.
void Tangent::set_diagonal() {
  const Body& body = model_.body();
  const auto& ends = body.connections.ends;
  diagonal_.assign(static_cast<std::size_t>(body.size()), Six::Zero());
  const auto add = [&](int a, const Matrix3& part) {
    diagonal_[static_cast<std::size_t>(a)] +=
        Six{part(0, 0), part(0, 1), part(0, 2), part(1, 1), part(1, 2), part(2, 2)};
  };
  if (weights_.acceleration != 0)  // bodies that never move need no masses
    for (int a = 0; a < body.size(); ++a) add(a, weights_.acceleration * body.mass[a] * Matrix3::Identity());
  model_.graph_->add_to_ends(diagonal_, [&](int c) {
    const auto [d, density, slope] = link(c);
    const Vector3 s = slope * d;
    return Six{s.x() * d.x() + density, s.x() * d.y(), s.x() * d.z(),
               s.y() * d.y() + density, s.y() * d.z(), s.z() * d.z() + density};
  });
  const auto add_cell = [&](double weight) {
    return [&, weight](std::span<const int> connections, const double* slopes) {
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
          add(molecule, 2 * weight * link(c).d * sum.transpose());
        }
        slopes += connections.size();
      }
    };
  };
  const auto add_elastic = add_cell(1), add_viscous = add_cell(weights_.velocity);
  for (const auto& part : model_.elasticity()) part->visit_cells(std::ref(add_elastic));
  for (const auto& part : model_.viscosity()) part->visit_cells(std::ref(add_viscous));
  const BlockVisitor add_own = [&](int a, int b, const Matrix3& part) {
    if (a == b) add(a, part);
  };
  for (const auto& load : model_.loads()) load->visit_blocks(*state_, weights_.velocity, add_own);
  for (const auto& part : model_.elasticity()) part->visit_diagonal(std::ref(add));
}

}  // namespace elastin
