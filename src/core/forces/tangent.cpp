#include "elastin/core/forces/tangent.h"

#include <algorithm>
#include <array>

#include "core/forces/graph.h"
#include "core/forces/grid_springs.h"
#include "core/forces/spring_kernel.h"
#include "core/parallel/large_memory.h"
#include "core/parallel/parallel.h"
#include "elastin/core/shapes/cell_shape.h"

namespace elastin {
namespace {

/// Of each node of a cell, its sides to the others.
template <int n>
constexpr auto sides_at_nodes() {
  std::array<std::array<int, n - 1>, n> sides{};
  for (int a = 0, pair = 0; a < n; ++a)
    for (int b = a + 1; b < n; ++b, ++pair) sides[a][b - 1] = sides[b][a] = pair;
  return sides;
}
template <int n>
constexpr auto kSidesAt = sides_at_nodes<n>();

}  // namespace

Tangent::Tangent(const Model& model) : model_(model), grid_(std::make_unique<GridLinks>()) { set_laws(); }
Tangent::~Tangent() = default;
Tangent::Tangent(const Model& model, const State& state, const Weights& weights, bool small) : Tangent(model) {
  small_ = small;
  linearise_at(state, weights);
}

void Tangent::set_laws() {
  laws_.clear(), edges_.clear(), nodes_.clear();
  for (const auto& law : model_.elasticity()) {
    if (const auto* edges = dynamic_cast<const EdgeDensities*>(law.get())) {
      auto own = edges->slopes();
      edges_.push_back(own.get());
      laws_.push_back(std::move(own));
    } else if (const auto* nodal = dynamic_cast<const NodalForces*>(law.get())) {
      auto own = nodal->stiffness();
      nodes_.push_back(own.get());
      laws_.push_back(std::move(own));
    }
  }
  known_laws_ = model_.elasticity().size();
}

void Tangent::linearise_at(const State& state, const Weights& weights) {
  if (known_laws_ != model_.elasticity().size()) set_laws();
  set_zero(force_densities_, model_.body().connections.size());
  for (const auto* law : model_.edge_laws()) law->add_force_densities(state.positions, force_densities_, workspace_);
  for (const auto& law : laws_) law->linearise_at(state.positions);
  set_links(state, weights);
}

bool Tangent::predicts() const {
  return std::all_of(laws_.begin(), laws_.end(), [](const auto& law) { return law->predicts(); });
}

void Tangent::linearise_onward(const State& next, Positions& forces) {
  const Positions &from = positions(), &to = next.positions;
  for (const auto& law : laws_) law->linearise_onward(from, to);
  VectorX linear = VectorX::Zero(model_.body().connections.size());
  force_densities_.setZero(linear.size());
  for (const auto* edges : edges_) edges->add_onward(from, to, force_densities_, linear, workspace_);
  forces.setZero(3, to.cols());
  if (!edges_.empty())
    model_.graph_->add_flows(forces,
                             [&](int c, int a, int b) -> Vector3 { return linear[c] * (to.col(b) - to.col(a)); });
  for (const auto* nodes : nodes_) nodes->add_onward_forces(from, to, forces, workspace_);
  set_links(next, {});
}

/// What connections have of the laws, which are linearised, and of damping; with the force densities of the former.
void Tangent::set_links(const State& state, const Weights& weights) {
  state_ = &state;
  weights_ = weights;
  set_zero(slopes_, model_.body().connections.size());
  coupled_ = false;
  for (const auto* law : model_.edge_laws()) coupled_ |= law->coupled();
  for (const auto* edges : edges_) edges->add_own_slopes(slopes_);
  if (!model_.viscosity().empty()) {
    model_.set_squared_lengths_and_rates(state, workspace_.squared_lengths, workspace_.rates);
    for (const auto& term : model_.viscosity()) {
      term->add_force_densities(workspace_.squared_lengths, workspace_.rates, force_densities_, workspace_);
      term->add_own_slopes(workspace_.squared_lengths, workspace_.rates, weights.velocity, slopes_);
      coupled_ |= term->coupled();
    }
  }
  stressed_ = !force_densities_.isZero(0);
  linked_ = stressed_ || coupled_ || !slopes_.isZero(0);
  on_grid_ = linked_ && !coupled_ && !stressed_ && weights.acceleration == 0 &&
             grid_->set(model_.body(), state.positions, slopes_);
  if (!stressed_ && weights.acceleration == 0) force_densities_.resize(0);
  const auto& loads = model_.loads();
  loads_change_ = std::any_of(loads.begin(), loads.end(), [&](const auto& load) {
    return !stays(*load) && load->changes() && (load->acts_at_rest() || weights.velocity != 0);
  });
  wide_.clear();
  for (const auto& load : loads)
    if (stays(*load))
      for (WideTerm& term : load->wide_terms(state)) wide_.push_back(std::move(term));
  loads_change_ |= !wide_.empty();
  set_diagonal();
}

void Tangent::apply(const Positions& motion, Positions& result, ApplyWorkspace& workspace) const {
  if (on_grid_)
    grid_->set_changes(motion, result, workspace.force_pass);
  else if (weights_.acceleration != 0)
    parallel_for(
        static_cast<int>(motion.cols()),
        [&](int a) { result.col(a) = weights_.acceleration * model_.body().mass[a] * motion.col(a); },
        kParallelThreshold / 10);
  else
    result.setZero();
  if (linked_ && !on_grid_) apply_links(motion, result, workspace);
  for (const auto* nodes : nodes_) nodes->add_stiffness(motion, result, workspace.force_pass);
  if (!loads_change_) return;
  add_load_changes(motion, workspace);
  result -= workspace.change;
}

void Tangent::add_load_changes(const Positions& motion, ApplyWorkspace& workspace) const {
  workspace.rates = weights_.velocity * motion;
  workspace.change.setZero(3, motion.cols());
  for (const auto& load : model_.loads())
    if (load->changes() && !stays(*load)) load->add_change(*state_, motion, workspace.rates, workspace.change);
  for (const WideTerm& wide : wide_) {
    const double along =
        ordered_sum(static_cast<int>(motion.cols()), [&](int a) { return wide.direction.col(a).dot(motion.col(a)); });
    workspace.change -= wide.factor * along * wide.direction;
  }
}

bool Tangent::symmetric() const {
  const auto& loads = model_.loads();
  return std::all_of(loads.begin(), loads.end(), [&](const auto& load) { return stays(*load) || load->symmetric(); });
}

void Tangent::apply_links(const Positions& motion, Positions& result, ApplyWorkspace& workspace) const {
  const Connections& connections = model_.body().connections;
  const Graph& graph = *model_.graph_;
  if (!coupled_) {
    if (graph.gathers())
      return graph.gather(result, [&](int c, int a, int b) -> Vector3 {
        const Vector3 d = positions().col(b) - positions().col(a), delta = motion.col(a) - motion.col(b);
        const Vector3 along = (2 * slopes_[c] * (d.x() * delta.x() + d.y() * delta.y() + d.z() * delta.z())) * d;
        if (!stressed_) return along;
        return force_densities_[c] * delta + along;
      });
    return graph.for_each_range([&](const Graph::Range& range) {
      spring_kernel().add_listed_changes(
          {connections.ends.data(), slopes_.data(), stressed_ ? force_densities_.data() : nullptr}, range.first,
          range.last, range.begin, range.end, positions().data(), motion.data(), result.data());
    });
  }
  VectorX &squared_lengths = workspace.squared_lengths, &force_densities = workspace.force_densities;
  squared_lengths.resize(connections.size());
  force_densities.resize(connections.size());
  parallel_for(connections.size(), [&](int c) {
    const auto& [a, b] = connections.ends[c];
    squared_lengths[c] = 2 * (positions().col(b) - positions().col(a)).dot(motion.col(b) - motion.col(a));
    force_densities[c] = slopes_[c] * squared_lengths[c];
  });
  for (const auto* edges : edges_) edges->add_change(squared_lengths, force_densities, workspace.force_pass);
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
  for (int c = 0; linked_ && c < model_.body().connections.size(); ++c) visit_pair(c, c, link_block(c));
  visit_cells([&](const CellSlopes& cells) {
    for (int cell = 0; cell < cells.size(); ++cell) {
      const auto connections = cells.connections_of(cell);
      const double* slope = cells.slopes_of(cell);
      for (const int own : connections)
        for (const int other : connections)
          visit_pair(own, other, 2 * cells.factor * *slope++ * link(own).d * link(other).d.transpose());
    }
  });
  for (const auto& load : model_.loads())
    if (!stays(*load)) load->visit_blocks(*state_, weights_.velocity, visit);
}

void Tangent::visit_blocks(const BlockVisitor& visit) const {
  visit_local_blocks(visit);
  for (const auto& law : laws_) law->visit_blocks(visit);
}

std::vector<WideTerm> Tangent::wide_terms() const {
  std::vector<WideTerm> terms;
  for (const auto& load : model_.loads())
    for (WideTerm& term : load->wide_terms(*state_)) terms.push_back(std::move(term));
  return terms;
}

void Tangent::visit_points(const NodalStiffness::PointsVisitor& visit) const {
  for (const auto* nodes : nodes_) nodes->visit_points(visit);
}

void Tangent::visit_gradients(const Linearisation::GradientVisitor& visit) const {
  for (const auto& law : laws_) law->visit_gradients(visit);
}

void Tangent::visit_cells(const EdgeSlopes::CellVisitor& visit) const {
  for (const auto* edges : edges_) edges->visit_cells(visit);
  for (const auto& term : model_.viscosity())
    term->visit_cells([&](CellSlopes cells) {
      cells.factor *= weights_.velocity;
      visit(cells);
    });
}

void Tangent::visit_other_diagonal(const std::function<void(int, const Matrix3&)>& visit) const {
  for (const auto& load : model_.loads())
    if (!stays(*load))
      load->visit_blocks(*state_, weights_.velocity, [&](int a, int b, const Matrix3& block) {
        if (a == b) visit(a, block);
      });
  const auto nothing = [](std::span<const std::pair<int, Vector3>>, double) {};
  Workspace workspace;
  for (const auto& law : laws_)
    if (!law->visit_gradients(nothing)) law->visit_diagonal(visit, workspace);
}

/// visit_blocks gives the same; but few of its blocks are on the diagonal, and every solve needs these.
void Tangent::set_diagonal() {
  const Body& body = model_.body();
  diagonal_.assign(body.size(), Six::Zero());
  const auto add = [&](int a, const Matrix3& block) {
    diagonal_[a] += Six{block(0, 0), block(0, 1), block(0, 2), block(1, 1), block(1, 2), block(2, 2)};
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
    cells.sides == 3 ? add_diagonal_of<3>(cells) : add_diagonal_of<4>(cells);
  };
  visit_cells(std::ref(add_cells));  // a function that owns it would allocate
  const BlockVisitor add_own = [&](int a, int b, const Matrix3& block) {
    if (a == b) add(a, block);
  };
  for (const auto& load : model_.loads())
    if (!stays(*load)) load->visit_blocks(*state_, weights_.velocity, add_own);
  for (const auto& law : laws_) law->visit_diagonal(std::ref(add), workspace_);
}

/// Of cells: 2 Σ_bc ∂q_ab/∂s_ac d_ab d_acᵀ. Each range of molecules goes through all cells in order and adds to its own
/// alone, so that the bits do not hang on the number of threads.
template <int n>
void Tangent::add_diagonal_of(const CellSlopes& cells) {
  constexpr int sides = pairs_of(n);
  const int molecules = model_.body().size(), ranges = cells.size() < kMoleculeThreshold ? 1 : threads();
  auto add_to_range = [&](int range) {
    const auto border = [&](int number) {
      return static_cast<int>(static_cast<long long>(molecules) * number / ranges);
    };
    const int begin = border(range), end = border(range + 1);
    for (int cell = 0; cell < cells.size(); ++cell) {
      const int* nodes = cells.nodes.data() + static_cast<std::ptrdiff_t>(cell) * n;
      const Eigen::Map<const Eigen::Matrix<double, sides, sides, Eigen::RowMajor>> slopes(cells.slopes_of(cell));
      for (int a = 0; a < n; ++a) {
        if (nodes[a] < begin || nodes[a] >= end) continue;
        Eigen::Matrix<double, 3, n - 1> d;
        Eigen::Matrix<double, n - 1, n - 1> own;
        for (int b = 0; b < n - 1; ++b)
          d.col(b) = positions().col(nodes[a]) - positions().col(nodes[b < a ? b : b + 1]);
        for (int b = 0; b < n - 1; ++b)
          for (int c = 0; c < n - 1; ++c) own(b, c) = slopes(kSidesAt<n>[a][b], kSidesAt<n>[a][c]);
        const Matrix3 block = 2 * cells.factor * d * own * d.transpose();
        diagonal_[nodes[a]] += Six{block(0, 0), block(0, 1), block(0, 2), block(1, 1), block(1, 2), block(2, 2)};
      }
    }
  };
  parallel_for(ranges, add_to_range, 1);
}

}  // namespace elastin
