#include "elastin/core/forces/model.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/dense.h"
#include "core/forces/graph.h"
#include "core/forces/sharing.h"
#include "core/model/check_indices.h"
#include "elastin/core/base/error.h"
#include "elastin/core/model/share.h"

namespace elastin {

namespace {

const Body& with_checked_indices(const Body& body) {
  check_indices(body);
  return body;
}

}  // namespace

Model::Model(const Body& body) : body_(&with_checked_indices(body)), graph_(std::make_unique<Graph>(body)) {
  if (body.share) computed_ = std::make_unique<const Subdomain>(computed_by(body));
}
Model::~Model() = default;
Model::Model(Model&&) noexcept = default;

namespace {

/// Puts blocks among others, in order of name.
void insert(std::vector<HistoryBlock> own, std::vector<HistoryBlock>& all) {
  for (HistoryBlock& block : own) {
    if (block.name.empty() || block.name.find_first_of(" \t\n") != std::string::npos)
      throw InputError("'" + block.name + "' is not a valid history name: use one word");
    const auto place =
        std::find_if(all.begin(), all.end(), [&](const HistoryBlock& other) { return other.name >= block.name; });
    if (place != all.end() && place->name == block.name)
      throw InputError("two loads declare history under the name '" + block.name + "'");
    all.insert(place, std::move(block));
  }
}

/// Projector on the directions that both leave free.
Matrix3 free_in_both(const Matrix3& a, const Matrix3& b) {
  const Matrix3 fixed = (Matrix3::Identity() - a) + (Matrix3::Identity() - b);
  const SymmetricEigen3 modes = symmetric_eigen3(fixed);
  Matrix3 free = Matrix3::Zero();
  for (Eigen::Index k = 0; k < 3; ++k)
    if (modes.values[k] < 1e-9) free += modes.vectors.col(k) * modes.vectors.col(k).transpose();
  return free;
}

}  // namespace

void Model::add_supports(const std::vector<Support>& lasting) {
  std::vector<std::ptrdiff_t> known(body_->size(), -1);
  for (std::size_t i = 0; i < supports.size(); ++i) known[supports[i].molecule] = static_cast<std::ptrdiff_t>(i);
  for (const Support& support : lasting)
    if (const auto at = known[support.molecule]; at < 0) {
      supports.push_back(support);
    } else {
      supports[at].free = free_in_both(supports[at].free, support.free);
    }
  lasting_supports_.insert(lasting_supports_.end(), lasting.begin(), lasting.end());
}

void Model::release_supports(std::size_t first, std::size_t end) {
  std::vector<Support*> released(body_->size(), nullptr);
  for (std::size_t i = first; i < end; ++i) {
    supports[i].free.setIdentity();
    released[supports[i].molecule] = &supports[i];
  }
  for (const Support& support : lasting_supports_)
    if (Support* own = released[support.molecule]) own->free = free_in_both(own->free, support.free);
}

void Model::add(std::unique_ptr<Load> load) {
  std::vector<HistoryBlock> all = history_;
  insert(load->history(), all);
  loads_.push_back(std::move(load));
  history_ = std::move(all);
}

void Model::add(ElasticTerms elasticity) {
  owners_.insert(owners_.end(), elasticity.owners.begin(), elasticity.owners.end());
  const CellRange all{0, static_cast<int>(body_->triangles.size())};
  for (std::size_t law = 0; law < elasticity.terms.size(); ++law)
    add_law(std::move(elasticity.terms[law]), elasticity.triangles.empty() ? all : elasticity.triangles[law]);
  set_rest(rest_part_);
}

void Model::add_law(std::unique_ptr<Elasticity> law, const CellRange& triangles) {
  if (computed_) {
    auto own = law->on_subdomain(*computed_);
    if (!own) throw InputError(kNotShared);
    if (has_complete_rows()) {
      counted_.push_back(std::move(own));
    } else {
      std::swap(own, law);
      if (keeps_all_) all_elements_.push_back(std::move(own));
    }
  }
  if (auto* past = dynamic_cast<LawHistory*>(law.get())) {
    const std::string name = "law" + std::to_string(elasticity_.size());
    insert(past->history(name), history_);
    law_histories_.emplace_back(past, name);
  }
  if (const auto* edges = dynamic_cast<const EdgeDensities*>(law.get())) {
    edge_laws_.push_back(edges);
    triangles_.push_back(triangles);
  }
  if (const auto* nodal = dynamic_cast<const NodalForces*>(law.get())) nodal_laws_.push_back(nodal);
  elasticity_.push_back(std::move(law));
}

void Model::remove(const Load* load) {
  std::vector<std::unique_ptr<Load>> all = extract_loads();
  for (auto& own : all)
    if (own.get() != load) add(std::move(own));
}

void Model::remove(const Viscosity* viscosity) {
  std::erase_if(viscosity_, [&](const auto& own) { return own.get() == viscosity; });
}

std::vector<std::unique_ptr<Load>> Model::extract_loads() {
  history_.clear();
  for (const auto& [law, name] : law_histories_) insert(law->history(name), history_);
  return std::exchange(loads_, {});
}

void Model::set_rest(double part) const {
  if (!body_->unstressed) return;
  for (const auto& law : elasticity_) law->set_rest(part);
  rest_part_ = part;
  // What goes back to no stress does so to the digits that it had under the largest.
  if (part != 0) rest_force_ = std::max(rest_force_, elastic_forces(body_->rest).norm());
}

void Model::measure_rest_force() const {
  constexpr double most_strain = 1e-3,
                   rounding = 1e-9;  // strains: of the comparison, and below which stress is rounding
  const Positions& rest = body_->rest;
  if (rest.cols() == 0) return;
  const Positions forces = elastic_forces(rest),
                  more = elastic_forces(rest + most_strain * (rest.colwise() - Vector3(rest.col(0)))) - forces;
  const int owned = owned_molecules(*body_);
  std::array<double, 2> squares{forces.leftCols(owned).squaredNorm(), more.leftCols(owned).squaredNorm()};
  sum_over(*body_, squares);
  if (squares[0] > std::pow(rounding / most_strain, 2) * squares[1])
    rest_force_ = std::max(rest_force_, std::sqrt(squares[0]));
}

void Model::begin_step(const State& from, double time) const {
  // rest_force stays: what it would be here hangs on the steps before, which a run that is resumed has not taken.
  if (rest_in_time) rest_part_ = rest_in_time(std::isfinite(time) ? time : from.time);
  if (rest_in_time && body_->unstressed)
    for (const auto& law : elasticity_) law->set_rest(rest_part_);
  for (const auto& [law, name] : law_histories_) law->begin_step(name, from, time);
}

bool Model::dissipates() const {
  return std::any_of(elasticity_.begin(), elasticity_.end(), [](const auto& term) { return term->dissipates(); });
}

void Model::declare_history(State& state) const {
  const bool has_them = std::equal(state.history.begin(), state.history.end(), history_.begin(), history_.end(),
                                   [](const HistoryBlock& own, const HistoryBlock& declared) {
                                     return own.name == declared.name && own.values.size() == declared.values.size();
                                   });
  if (!has_them) state.history = history_;
}

bool Model::has_energy() const {
  return std::all_of(elasticity_.begin(), elasticity_.end(), [](const auto& term) { return term->has_energy(); });
}

bool Model::conservative() const {
  return has_energy() && std::all_of(loads_.begin(), loads_.end(), [](const auto& load) { return load->has_energy(); });
}

bool Model::symmetric() const {
  return std::all_of(loads_.begin(), loads_.end(), [](const auto& load) { return load->symmetric(); });
}

void Model::commit_step(State& state) const {
  for (const auto& [law, name] : law_histories_) law->commit_step(name, state);
  for (const auto& load : loads_) load->commit_step(state);
}

bool Model::update_multipliers(State& state) const {
  bool changed = false;
  for (const auto& load : loads_) changed |= load->update_multipliers(state);
  return changed;
}

double Model::max_step_fraction(const State& from, const State& to) const {
  double fraction = 1;
  for (const auto& load : loads_) fraction = std::min(fraction, load->max_step_fraction(from, to));
  return fraction;
}

double Model::square_frequency(const State& state, double ahead) const {
  double sum = 0;
  for (const auto& load : loads_) sum += load->square_frequency(state, ahead);
  const bool may_set_in = std::any_of(loads_.begin(), loads_.end(), [](const auto& load) { return load->changes(); });
  return may_set_in ? largest_over(*body_, sum) : sum;
}

bool Model::has_full_tangent() const {
  return std::all_of(elasticity_.begin(), elasticity_.end(), [](const auto& term) { return term->has_full_tangent(); });
}

bool Model::admissible(const Positions& positions) const {
  return std::all_of(elasticity_.begin(), elasticity_.end(),
                     [&](const auto& term) { return term->admissible(positions); });
}

bool Model::feels_velocity() const {
  return !viscosity_.empty() ||
         std::any_of(loads_.begin(), loads_.end(), [](const auto& load) { return load->feels_velocity(); });
}

double Model::elastic_energy(const Positions& positions) const {
  double energy = 0;
  for (const auto& term : has_complete_rows() ? counted_ : elasticity_) energy += term->energy(positions);
  return energy;
}

double Model::stored_energy(const Positions& positions) const {
  double energy = 0;
  for (const auto& term : has_complete_rows() ? counted_ : elasticity_) energy += term->stored_energy(positions);
  return energy;
}

double Model::load_energy(const State& state) const {
  double energy = 0;
  for (const auto& load : loads_) energy += load->energy(state);
  return energy;
}

VectorX Model::force_densities(const Positions& positions) const {
  VectorX all = VectorX::Zero(body_->connections.size());
  Workspace workspace;
  for (const auto& term : all_elements_.empty() ? elasticity_ : all_elements_) {
    if (const auto* edges = dynamic_cast<const EdgeDensities*>(term.get()))
      edges->add_force_densities(positions, all, workspace);
    if (const auto* nodal = dynamic_cast<const NodalForces*>(term.get()))
      nodal->show(positions, all, [](std::span<const int>, const CellState&) {});
  }
  return all;
}

VectorX Model::show_cells(const Positions& positions, const Elasticity::StateVisitor& visit) const {
  VectorX others = VectorX::Zero(body_->connections.size()), within = others;
  for (const auto& term : all_elements_.empty() ? elasticity_ : all_elements_) {
    if (const auto* edges = dynamic_cast<const EdgeDensities*>(term.get())) edges->show(positions, others, visit);
    if (const auto* nodal = dynamic_cast<const NodalForces*>(term.get())) nodal->show(positions, within, visit);
  }
  return others;
}

Positions Model::elastic_forces(const Positions& positions) const {
  Positions forces = Positions::Zero(3, body_->size());
  Workspace workspace;
  add_elastic_forces(positions, forces, workspace);
  return forces;
}

Positions Model::load_forces(const State& state) const {
  Positions forces = Positions::Zero(3, body_->size());
  for (const auto& load : loads_) load->add_forces(state, forces);
  return forces;
}

std::pair<VectorX, VectorX> Model::squared_lengths_and_rates(const State& state) const {
  std::pair<VectorX, VectorX> both;
  set_squared_lengths_and_rates(state, both.first, both.second);
  return both;
}

void Model::set_squared_lengths_and_rates(const State& state, VectorX& squared_lengths, VectorX& rates) const {
  const auto& ends = body_->connections.ends;
  squared_lengths.resize(body_->connections.size());
  rates.resize(body_->connections.size());
  parallel_for(body_->connections.size(), [&](int c) {
    const auto& [a, b] = ends[c];
    const Vector3 d = state.positions.col(b) - state.positions.col(a);
    squared_lengths[c] = d.squaredNorm();
    rates[c] = 2 * d.dot(state.velocities.col(b) - state.velocities.col(a));
  });
}

VectorX Model::viscous_force_densities(const State& state) const {
  VectorX force_densities = VectorX::Zero(body_->connections.size());
  if (viscosity_.empty()) return force_densities;
  const auto [squared_lengths, rates] = squared_lengths_and_rates(state);
  Workspace workspace;
  for (const auto& term : viscosity_) term->add_force_densities(squared_lengths, rates, force_densities, workspace);
  return force_densities;
}

void Model::set_forces(const State& state, Positions& forces) const {
  Workspace workspace;
  set_forces(state, forces, workspace);
}

void Model::set_forces(const State& state, Positions& forces, Workspace& workspace) const {
  forces.setZero(3, body_->size());
  add_elastic_forces(state.positions, forces, workspace);
  add_other_forces(state, forces, workspace);
  spread(forces);
}

void Model::add_other_forces(const State& state, Positions& forces, Workspace& workspace) const {
  if (!viscosity_.empty()) {
    set_squared_lengths_and_rates(state, workspace.squared_lengths, workspace.rates);
    workspace.force_densities.setZero(body_->connections.size());
    for (const auto& term : viscosity_)
      term->add_force_densities(workspace.squared_lengths, workspace.rates, workspace.force_densities, workspace);
    gather(state.positions, workspace.force_densities, forces);
  }
  for (const auto& load : loads_) load->add_forces(state, forces);
}

void Model::add_triangle_force_densities(const Positions& positions, Eigen::Matrix3Xd& of_triangles,
                                         VectorX& of_connections, Workspace& workspace) const {
  for (std::size_t law = 0; law < edge_laws_.size(); ++law)
    edge_laws_[law]->add_triangle_force_densities(
        positions, of_triangles.middleCols(triangles_[law].first, triangles_[law].count), of_connections, workspace);
}

void Model::gather(const Positions& positions, const VectorX& force_densities, Positions& forces) const {
  graph_->add_forces(positions, force_densities, forces);
}

void Model::add_elastic_forces(const Positions& positions, Positions& forces, Workspace& workspace) const {
  for (const auto& term : elasticity_) term->add_forces(positions, *graph_, forces, workspace);
}

}  // namespace elastin
