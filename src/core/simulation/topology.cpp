#include "elastin/core/model/topology.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/base/rows.h"
#include "core/simulation/simulation_impl.h"
#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"

namespace elastin {
namespace {

/// What a simulation keeps, on what its body has become. `images` has the numbers of what each molecule has become.
SimulationState carried_over(const SimulationState& before, const ChangedBody& changed, const Rows& images) {
  SimulationState after;
  after.state.time = before.state.time;
  after.state.positions = before.state.positions(Eigen::all, changed.molecule_from);
  after.state.velocities = before.state.velocities(Eigen::all, changed.molecule_from);
  if (before.state.accelerations.cols() > 0)
    after.state.accelerations = before.state.accelerations(Eigen::all, changed.molecule_from);
  after.tools = before.tools;
  after.effort = before.effort;
  after.seen.frequency = before.seen.frequency;
  std::vector<Support> copies;
  for (std::size_t number = 0; number < before.supports.size(); ++number) {
    bool first = true;
    for (const int image : images[before.supports[number].molecule]) {
      Support support = before.supports[number];
      support.molecule = image;
      (std::exchange(first, false) ? after.supports : copies).push_back(support);
    }
    after.others_supports += !first && static_cast<int>(number) < before.others_supports;
  }
  after.supports.insert(after.supports.end(), copies.begin(), copies.end());
  for (const SimulationState::HostSupport& one : before.host_supports)
    for (const int image : images[one.molecule]) after.host_supports.push_back({image, one.next});
  for (Coupling coupling : before.couplings) {
    const auto own = images[coupling.molecule];
    if (own.empty()) continue;
    coupling.molecule = own.front();
    after.couplings.push_back(coupling);
  }
  if (before.host_forces.cols() > 0) {
    after.host_forces = before.host_forces(Eigen::all, changed.molecule_from);
    for (Eigen::Index molecule = 0; molecule < after.host_forces.cols(); ++molecule)
      after.host_forces.col(molecule) *= changed.molecule_share[molecule];
  }
  return after;
}

/// These molecules on another body; of each, in `images`, what it has become.
std::vector<int> images_of(const std::vector<int>& molecules, const Rows& images, bool one_each) {
  std::vector<int> all;
  for (const int molecule : molecules) {
    const auto own = images[molecule];
    all.insert(all.end(), own.begin(), one_each && !own.empty() ? own.begin() + 1 : own.end());
  }
  return all;
}

/// Throws InputError where a body that was read somewhere cannot be one.
void check_read(const Topology& topology, bool carries) {
  const Body& body = topology.body;
  const auto n = body.size();
  bool fits = n > 0 && body.mass.size() == n && body.radius.size() == n && body.rest.allFinite() &&
              topology.origin.size() == static_cast<std::size_t>(n) && (body.mass.array() > 0).all() &&
              body.connections.rest_length.size() == body.connections.ends.size() &&
              topology.constants.size() == (carries ? body.connections.size() : 0);
  const auto check = [&](const auto& cells) {
    for (const auto& cell : cells)
      for (const int molecule : cell) fits = fits && molecule >= 0 && molecule < n;
  };
  check(body.connections.ends), check(body.triangles), check(body.tetrahedra), check(body.cubes);
  for (const Cable& cable : body.cables)
    fits = fits && cable.connection >= 0 && cable.connection < body.connections.size();
  if (!fits) throw InputError("the saved state has a body that cannot be this simulation's");
}

/// Three sums over the molecules that no two bodies have alike, unless they lie alike: of positions [m], of positions
/// by the molecules' numbers [m], and of squares [m²].
Matrix3 moments_of(const Positions& positions) {
  const auto molecules = static_cast<double>(positions.cols());
  const VectorX part = VectorX::LinSpaced(positions.cols(), 1 / molecules, 1);
  Matrix3 moments;
  moments.col(0) = positions.rowwise().mean();
  moments.col(1) = positions * part / molecules;
  moments.col(2) = positions.cwiseAbs2().rowwise().mean();
  return moments;
}

/// Whether what a cut has left of a body has it where another body lies at rest.
bool lies_as(const Topology& topology, const Positions& rest, double rounding) {
  for (int molecule = 0; molecule < topology.body.size(); ++molecule) {
    const int from = topology.origin[molecule];
    if (from < 0 || from >= rest.cols()) return false;
    if (!((topology.body.rest.col(molecule) - rest.col(from)).cwiseAbs().maxCoeff() <= rounding)) return false;
  }
  return true;
}

}  // namespace

Matrix3 Simulation::Impl::rest_moments() const { return moments_of(body.rest); }

double Simulation::Impl::first_stiffness() const {
  if (original) return carried_stiffness;
  if (constants.size() > 0) return constants.sum();
  return recipe.constants ? recipe.constants(*this).sum() : 0;
}

void Simulation::Impl::check_own(const SimulationState& saved) const {
  constexpr double rounding = 1e-9;
  const auto refuse = [](const std::string& why) { throw InputError("the saved state is another body's: " + why); };
  const std::string elsewhere = "its molecules lie elsewhere at rest";
  const Body& first = original ? original->body : body;
  if (!saved.topology || saved.topology == shared_topology()) {
    const Positions& rest = saved.topology ? body.rest : first.rest;
    if (saved.state.positions.cols() != rest.cols()) return;  // which is found with the rest of the state
    const Matrix3 own = moments_of(rest);
    const double reach = std::sqrt(own.col(2).sum());
    const Vector3 sizes(reach, reach, reach * reach);
    for (int column = 0; column < 3 && !saved.rest_moments.isZero(0); ++column)
      if (!((saved.rest_moments - own).col(column).norm() <= rounding * sizes[column])) refuse(elsewhere);
    return;
  }
  if (!lies_as(*saved.topology, first.rest, rounding * first.rest.cwiseAbs().maxCoeff())) refuse(elsewhere);
  const double stiffness = saved.topology->stiffness, own = first_stiffness();
  if (!(std::abs(stiffness - own) <= rounding * std::abs(own)))
    refuse("its springs had constants with a sum of " + number(stiffness) +
           " N/m before it was cut; those of this body had " + number(own) + " N/m");
}

void Simulation::Impl::check_follows() const {
  const auto refuse = [](const std::string& why) { throw InputError("the topology cannot change: " + why); };
  if (!recipe.fixed.empty()) refuse(recipe.fixed);
  if (terms() != known)
    refuse("something was added to model() directly; Simulation::add takes a function that adds it again");
  if (!model.history().empty()) refuse("the history '" + model.history().front().name + "' cannot follow");
  if (host_supports.has_others()) refuse("Model::drive moves supports, which it knows by their index in the list");
}

std::shared_ptr<const Topology> Simulation::Impl::shared_topology() const {
  if (!topology && original)
    topology = std::make_shared<const Topology>(Topology{body, constants, origin, carried_stiffness});
  return topology;
}

std::unique_ptr<Simulation::Impl> Simulation::Impl::on(Topology other,
                                                       const std::function<LoadValues(const Added&)>& moved) const {
  other.body.unstressed = body.unstressed;  // which saved states do not have
  auto made = std::make_unique<Impl>(std::move(other.body), options);
  made->material = material;
  made->recipe = recipe;
  made->constants = std::move(other.constants);
  made->carried_stiffness = other.stiffness;
  made->origin = std::move(other.origin);
  made->tools = tools;
  made->effort_is_given = effort_is_given;
  made->budget = budget;
  made->budget.restart();
  for (Added& load : made->recipe.added) {
    if (!load.kind || load.values.molecules.empty()) continue;
    LoadValues values = moved(load);
    try {
      made->set_values(load, values);
    } catch (const InputError&) {  // nothing is left there that it acts on
      load.add = nullptr;
      load.values = std::move(values);
      load.loads.clear(), load.viscosity.clear();
    }
  }
  made->next_coupling = next_coupling;
  made->make_model();
  if (const std::string why = unsuited_for(*options.stepper.method, made->model); !why.empty())
    throw InputError("stepper '" + options.stepper.method->name + "': " + why);
  return made;
}

TopologyReport Simulation::change(ChangedBody changed) {
  Impl& in = *impl_;
  in.check_idle("cut, tear, remove");
  in.check_host_forces();
  TopologyReport report{changed.changed,
                        changed.split_molecules,
                        changed.removed_connections,
                        changed.removed_cells,
                        std::move(changed.molecule_from),
                        std::move(changed.connection_from),
                        nullptr};
  if (!changed.changed) {
    report.connection_from.resize(in.body.connections.size());
    std::iota(report.connection_from.begin(), report.connection_from.end(), 0);
    return report;
  }
  in.check_follows();
  if (in.recipe.constants && in.constants.size() == 0) in.constants = in.recipe.constants(in);
  Topology next{std::move(changed.body), {}, std::vector<int>(report.molecule_from.size()), in.first_stiffness()};
  for (std::size_t molecule = 0; molecule < next.origin.size(); ++molecule)
    next.origin[molecule] = origin()[report.molecule_from[molecule]];
  if (in.constants.size()) {
    next.constants = in.constants(report.connection_from);
    for (std::size_t c = 0; c < report.connection_from.size(); ++c)
      next.constants[static_cast<Eigen::Index>(c)] *= changed.connection_share[c];
  }
  const Rows images = rows_by_target(in.body.size(), report.molecule_from);
  changed.molecule_from = report.molecule_from;
  auto made = in.on(std::move(next), [&](const Impl::Added& load) {
    LoadValues values = load.values;
    for (auto& [name, molecules] : values.molecules) molecules = images_of(molecules, images, load.kind->of_each);
    return values;
  });
  made->restore(carried_over(save(), changed, images));
  made->original = in.original ? in.original : std::make_shared<const Topology>(Topology{in.body, {}, origin()});
  made->observers = std::move(in.observers);
  report.before = std::shared_ptr<const void>(std::move(impl_));
  impl_ = std::move(made);
  return report;
}

TopologyReport Simulation::cut(const CutSurface& surface) {
  return change(elastin::cut(impl_->body, impl_->shown.positions, surface));
}

TopologyReport Simulation::tear(double strain) {
  return change(elastin::tear(impl_->body, impl_->shown.positions, strain));
}

TopologyReport Simulation::remove(const std::vector<int>& connections, const std::vector<int>& cells) {
  return change(without(impl_->body, connections, cells));
}

const std::vector<int>& Simulation::Impl::origin_of_molecules() {
  if (origin.empty()) {
    origin.resize(body.size());
    std::iota(origin.begin(), origin.end(), 0);
  }
  return origin;
}

const std::vector<int>& Simulation::origin() const noexcept { return impl_->origin_of_molecules(); }

std::shared_ptr<const void> Simulation::restore(const SimulationState& saved) {
  Impl& in = *impl_;
  if (saved.topology == in.shared_topology()) {
    in.check_own(saved);
    in.restore(saved);
    return nullptr;
  }
  in.check_idle("restore");
  in.check_follows();
  if (saved.topology) check_read(*saved.topology, static_cast<bool>(in.recipe.constants));
  in.check_own(saved);
  const Topology& target = saved.topology ? *saved.topology : *in.original;
  int count = 0;  // of the molecules at first, as far as they are known here
  const auto see = [&](const std::vector<int>& numbers) {
    for (const int molecule : numbers) count = std::max(count, molecule + 1);
  };
  see(target.origin);
  for (const Impl::Added& load : in.recipe.added) see(load.given_on);
  const Rows images = rows_by_target(count, target.origin);  // of each of these
  auto made = in.on(target, [&](const Impl::Added& load) {
    LoadValues values = load.given;
    if (load.given_on == target.origin) return values;
    for (auto& named : values.molecules) {
      std::vector<int>& own = named.second;
      for (int& molecule : own) molecule = load.given_on[molecule];
      std::sort(own.begin(), own.end());
      own.erase(std::unique(own.begin(), own.end()), own.end());
      own = images_of(own, images, load.kind->of_each);
    }
    return values;
  });
  made->restore(saved);
  if (saved.topology) {
    made->original = in.original ? in.original : std::make_shared<const Topology>(Topology{in.body, {}, origin()});
    made->topology = saved.topology;
  }
  made->observers = std::move(in.observers);
  std::shared_ptr<const void> before(std::move(impl_));
  impl_ = std::move(made);
  return before;
}

}  // namespace elastin
