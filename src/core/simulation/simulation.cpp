#include "elastin/core/simulation/simulation.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include "core/base/within.h"
#include "core/forces/volume.h"
#include "core/model/check_indices.h"
#include "core/parallel/parallel.h"
#include "core/simulation/fibres.h"
#include "core/simulation/simulation_impl.h"
#include "core/simulation/tensions.h"
#include "core/solve/steppers.h"
#include "core/solve/trial.h"
#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"
#include "elastin/core/simulation/parts.h"
#include "elastin/core/solve/sensitivity.h"

namespace elastin {
namespace {

void check(const Body& body, const SimulationOptions& options) {
  if (body.size() == 0) throw InputError("the body has no molecules");
  if (body.mass.size() != body.size() || body.radius.size() != body.size())
    throw InputError("the body has " + std::to_string(body.size()) + " molecules, " + std::to_string(body.mass.size()) +
                     " masses and " + std::to_string(body.radius.size()) + " radii; set_matter sets them");
  check_indices(body);
  if (!body.rest.allFinite()) throw InputError("a molecule's position at rest is not finite");
  for (int i = 0; i < body.size(); ++i)
    if (!(body.mass[i] > 0 && std::isfinite(body.mass[i])))
      throw InputError("molecule " + std::to_string(i) + " has a mass of " + number(body.mass[i]) +
                       " kg: above 0 is allowed");
  if (!(options.safety > 0 && options.safety <= 1))
    throw InputError("safety " + number(options.safety) + " is out of range: above 0 to 1");
  if (options.max_substeps < 1)
    throw InputError("max_substeps " + std::to_string(options.max_substeps) + " is out of range: 1 or more");
  if (!(options.budget >= 0 && std::isfinite(options.budget)))
    throw InputError("budget " + number(options.budget) + " s is out of range: 0 or more");
  if (options.budget > 0 && options.stepper.method->effort.empty())
    throw InputError("budget: the stepper '" + options.stepper.method->name +
                     "' takes no number of sweeps or iterations that could be chosen");
  if (options.threads < 0)
    throw InputError("threads " + std::to_string(options.threads) + " is out of range: 0 or more");
}

void check(const Material& material) {
  const double E = material.youngs_modulus, nu = material.poissons_ratio;
  if (!(E > 0 && std::isfinite(E)))
    throw InputError("the material has a youngs_modulus of " + number(E) + " Pa: above 0 is allowed");
  if (!(nu > -1 && nu <= 0.5))
    throw InputError("the material has a poissons_ratio of " + number(nu) + ": above -1 to 0.5 is allowed");
}

/// Throws InputError where the stepper cannot step what the model has so far.
void check(const StepperOptions& options, const Model& model) {
  if (const std::string why = unsuited_for(*options.method, model); !why.empty())
    throw InputError("stepper '" + options.method->name + "': " + why);
}

/// Whether the spring constants are carried over when the topology changes: what is left keeps its stiffness.
bool carries_constants(const Strategy& strategy) {
  return strategy.kind == StrategyKind::spring_rule && strategy.constants && !strategy.by_parts;
}

ElasticTerms make_with(const Strategy& strategy, const Body& body, const Material& material, const VectorX& constants) {
  ElasticTerms terms = make_springs(body, constants, material);
  if (strategy.volume_modulus) terms.add(make_volume(body, strategy.volume_modulus(material)));
  return terms;
}

/// Why the strategy cannot follow a change of topology, or "".
std::string fixed_topology(const Strategy& strategy, const Material& material) {
  if (strategy.calibrates && strategy.volume_modulus)
    return "'" + strategy.name + "' has fitted its volume term to the body as it was";
  if (material.fibre && strategy.kind != StrategyKind::cell_law)
    return "the fibres among springs have sections that belong to the body as it was";
  if (material.bending_rigidity > 0)
    return "a sheet with bending stiffness has hinges that belong to the body as it was";
  return "";
}

StepResult refused(std::string cause) { return {Outcome::limit_reached, std::move(cause), 0, 0, 0, 0}; }

}  // namespace

Simulation::Impl::Impl(Body a_body, SimulationOptions some_options)
    : body(std::move(a_body)), options(std::move(some_options)) {
  make_own_stepper();
  shown = work = state_at_rest(body);
  const StepperKind& method = *options.stepper.method;
  if (!method.effort.empty()) {
    const ParameterValues values = complete_values(method.name, method.parameters, options.stepper.parameters);
    effort = static_cast<int>(values.at(method.effort));
    // Of a stepper that iterates to the end by default.
    if (options.budget > 0) set_effort(std::max(1, effort));
  }
}

void Simulation::Impl::make_own_stepper() {
  const SeenFrequency before{.frequency = watch ? watch->seen().frequency : 0};
  stepper = make_stepper(options.stepper);
  watch = dynamic_cast<FrequencyWatch*>(stepper.get());
  if (watch) watch->watch(before);
}

void Simulation::Impl::set_effort(int number) {
  effort = number;
  dynamic_cast<HasEffort&>(*stepper).set_effort(number);
}

void Simulation::Impl::make_model() {
  recipe.add_laws(*this);
  for (Added& added : recipe.added)
    if (added.add) perform(added);
  known = terms();
}

/// Of the body as it is; or as it was where a state comes from that was restored, if steps were no longer there.
void Simulation::Impl::find_bound() {
  const auto saved_couplings = std::exchange(couplings, {});
  const auto saved_supports = std::exchange(model.supports, {});
  // Tools are where they were added: the bound is the same however late in a run it is found.
  const auto saved_tools = tools->all;
  for (std::size_t i = 0; i < tools->first.size(); ++i) tools->all[i] = {tools->first[i], std::nullopt};
  // Somebody waits for the step after a cut: it does with a bound.
  stable = original ? bounded_stable_step(model, state_at_rest(body)) : find_stable_step(model, state_at_rest(body));
  model.begin_step(work, work.time);
  couplings = saved_couplings;
  model.supports = saved_supports;
  tools->all = saved_tools;
  const auto& [frequency, rate, added_square, added_rate] = restored;
  constexpr double rounding = 1 - 1e-9;
  if (frequency * frequency + added_square < rounding * stable->frequency * stable->frequency ||
      rate + added_rate < rounding * stable->damping_rate)
    restored = {};
  else
    stable->frequency = frequency, stable->damping_rate = rate;
}

StepBound Simulation::Impl::bound() const {
  if (!stable) return {};
  double square = 0, rate = 0;
  for (const Added& added : recipe.added) square += added.frequency * added.frequency, rate += added.damping_rate;
  return {stable->frequency, stable->damping_rate, restored.added_square + square, restored.added_rate + rate};
}

/// The longest part of an explicit step [s]. Where the stepper takes them at the start of a step, grips add to the
/// square of the fastest vibration's frequency, and to the largest damping rate, no more than what they are worth on
/// their own molecules.
double Simulation::Impl::longest_substep() {
  if (!options.stepper.method->is_explicit) return std::numeric_limits<double>::infinity();
  if (!stable) find_bound();
  const StepBound own = bound();
  double stiffest = 0, most_damped = 0;
  for (const Coupling& coupling : couplings) {
    if (options.stepper.method->points_at_end) break;
    double stiffness = 0, damping = 0;
    for (const Coupling& other : couplings)
      if (other.molecule == coupling.molecule) stiffness += other.stiffness, damping += other.damping;
    stiffest = std::max(stiffest, stiffness / body.mass[coupling.molecule]);
    most_damped = std::max(most_damped, damping / body.mass[coupling.molecule]);
  }
  const double frequency = std::max(own.frequency, watch ? watch->seen().frequency : 0);
  // The largest eigenvalue of a sum is at most the sum of both: the whole body is not searched for it while somebody
  // waits for the next step.
  const double square = frequency * frequency + stiffest + own.added_square,
               rate = own.damping_rate + most_damped + own.added_rate;
  if (auto* shared = dynamic_cast<SharedStep*>(stepper.get())) shared->set_own(square, rate);
  const double sum = std::sqrt(square + rate * rate) + rate;
  return sum > 0 ? options.safety * 2 / sum : std::numeric_limits<double>::infinity();
}

/// How much it may bring the longest substep down. A load out of a table shows here what it throws.
void Simulation::Impl::bound_step(Added& added) const {
  if (!added.add || !(stable || added.kind)) return;
  Model alone(body);
  added.add(alone);
  if (!stable) return;
  const auto& loads = alone.loads();
  if (alone.elasticity().empty() && alone.viscosity().empty() &&
      std::none_of(loads.begin(), loads.end(), [](const auto& load) { return load->changes(); }))
    return;
  const StableStep own = bounded_stable_step(alone, state_at_rest(body));
  added.frequency = own.frequency, added.damping_rate = own.damping_rate;
}

/// Puts it on the model, and notes what that has got.
void Simulation::Impl::perform(Added& added) {
  const std::size_t loads = model.loads().size(), viscosity = model.viscosity().size();
  added.loads.clear(), added.viscosity.clear();
  added.add(model);
  for (std::size_t i = loads; i < model.loads().size(); ++i) added.loads.push_back(model.loads()[i].get());
  for (std::size_t i = viscosity; i < model.viscosity().size(); ++i)
    added.viscosity.push_back(model.viscosity()[i].get());
}

StepResult Simulation::Impl::step(double dt) {
  if (!(dt > 0 && std::isfinite(dt)))
    return refused("a step of " + number(dt) + " s: a step must be above 0 s and finite");
  if (host_forces.cols() > 0) ensure_host_forces();
  if (const std::string why = odd_size(); !why.empty()) return refused(why);
  const Within used(in_use);
  const ThreadScope scope(options.runner, options.threads);
  StepResult result;
  bool thrown = false;
  try {
    const double substeps = std::max(1., std::ceil(dt / longest_substep() * (1 - 1e-9)));
    if (!(substeps <= options.max_substeps))
      return refused("a step of " + number(dt) + " s would take " + number(substeps) + " substeps of at most " +
                     number(longest_substep()) + " s, " + std::to_string(options.max_substeps) + " are allowed");
    result = timed_substeps(dt, static_cast<int>(substeps));
  } catch (const std::exception& error) {  // of the host's motions, loads or laws
    result.outcome = Outcome::diverged, result.cause = error.what();
    thrown = true;
  }
  if (result.outcome == Outcome::converged) {
    work.time = shown.time + dt;
    shown = work;
    host_supports.arrive();
    tools->arrive();
    forces_known = tensions_known = false;
  } else {
    go_back();
    if (const std::string odd = thrown ? "" : odd_input(shown.time + dt); !odd.empty())
      result.outcome = Outcome::diverged, result.cause = odd;
  }
  return result;
}

StepResult Simulation::Impl::timed_substeps(double dt, int substeps) {
  begin_step(shown.time, shown.time + dt);
  using Clock = std::chrono::steady_clock;
  const Clock::time_point begun = options.budget > 0 ? Clock::now() : Clock::time_point();
  if (options.budget > 0 && !effort_is_given) set_effort(budget.next(options.budget, effort));
  StepResult result = substeps_of(dt, substeps);
  if (options.budget > 0) {
    const double seconds = std::chrono::duration<double>(Clock::now() - begun).count();
    budget.took(seconds, effort);
    ++timed_steps, late_steps += effort <= 1 && seconds > options.budget;
  }
  return result;
}

void Simulation::Impl::begin_step(double start, double end) {
  host_supports.begin(start, end);
  tools->start = start, tools->end = end;
}

/// What the host's functions fail at here, as they did in the step, the next step asks them again.
void Simulation::Impl::go_back() {
  work = shown;
  host_supports.go_back();
  tools->go_back();
  try {
    model.begin_step(work, work.time);
    if (model.drive) model.drive(shown.time, model.supports);
  } catch (const std::exception&) {
  }
}

StepResult Simulation::Impl::substeps_of(double dt, int substeps) {
  StepResult all;
  all.substeps = 0;
  for (int substep = 0; substep < substeps && all.outcome == Outcome::converged; ++substep) {
    StepResult one = stepper->advance(model, work, dt / substeps);
    all.outcome = one.outcome;
    all.cause = std::move(one.cause);
    all.newton_iterations += one.newton_iterations;
    all.linear_iterations += one.linear_iterations;
    all.substeps += one.substeps;
    all.error = std::max(all.error, one.error);
  }
  return all;
}

void Simulation::Impl::check_idle(const char* call) const {
  if (in_use)
    throw InputError(std::string(call) +
                     ": the simulation is within a step or a solve, which must end first; a load "
                     "or law must not change the simulation that calls it");
}

/// Of the host's forces, which no step can do with, or "".
std::string Simulation::Impl::odd_size() const {
  if (!has_host_forces || host_forces.cols() == body.size()) return "";
  return "host_forces() has forces on " + std::to_string(host_forces.cols()) + " molecules and the body has " +
         std::to_string(body.size()) + ": write to its columns, and leave their number as it is";
}

void Simulation::Impl::check_host_forces() const {
  if (const std::string why = odd_size(); !why.empty()) throw InputError(why);
}

/// What the host has given that no step to this time [s] can go well with, or "".
std::string Simulation::Impl::odd_input(double end) const {
  for (Eigen::Index i = 0; i < host_forces.cols(); ++i)
    if (!host_forces.col(i).allFinite()) return "the host's force on molecule " + std::to_string(i) + " is not finite";
  for (const Coupling& coupling : couplings)
    if (!coupling.position.allFinite() || !coupling.velocity.allFinite())
      return "coupling " + std::to_string(coupling.id) + " was moved to a position or at a velocity that is not finite";
  for (const Support& support : model.supports)
    if (!support.displacement.allFinite() || !support.velocity.allFinite())
      return "the support of molecule " + std::to_string(support.molecule) +
             " has a displacement or velocity that is not finite";
  const auto odd = [&](const std::string& what, const auto& add) {
    Positions all = Positions::Zero(3, body.size());
    add(all);
    for (Eigen::Index i = 0; i < all.cols(); ++i)
      if (!all.col(i).allFinite()) return what + " gives molecule " + std::to_string(i) + " a force that is not finite";
    return std::string();
  };
  std::string found;
  for (std::size_t load = 0; load < model.loads().size() && found.empty(); ++load) {
    std::string name = "a load";
    for (const Added& added : recipe.added)
      if (added.kind && std::count(added.loads.begin(), added.loads.end(), model.loads()[load].get()))
        name = "the load '" + added.kind->name + "'";
    State at_end = shown;
    at_end.time = end;
    for (const State& at : {std::cref(shown), std::cref<State>(at_end)})
      if (found.empty()) found = odd(name, [&](Positions& all) { model.loads()[load]->add_forces(at, all); });
  }
  if (found.empty())
    found = odd("the elastic law", [&](Positions& all) {
      Workspace own;
      model.add_elastic_forces(shown.positions, all, own);
    });
  return found;
}

Simulation::Simulation(Body body, const Strategy& any, const Material& material, SimulationOptions options) {
  check(body, options);
  check(material);
  for (const Part& part : body.parts)
    if (part.material != 0 && !any.by_parts)
      throw InputError("the body's part '" + part.name + "' has a material of its own: make the strategy by in_parts");
  const Catalog laws = built_in_catalog();  // of a skin on a core
  const Strategy strategy = in_parts(any, body, {material}, &laws);
  if (!strategy.make) throw InputError("'" + strategy.name + "' changes other strategies; it is no strategy by itself");
  prepare(body, any, {material}, options.make_voronoi);
  impl_ = std::make_unique<Impl>(std::move(body), std::move(options));
  const Body& own = impl_->body;
  std::string why = strategy.unsuited(own);
  if (why.empty() && !strategy.by_parts) why = material_unsuited(strategy, own, material);
  if (!why.empty() && lacks_voronoi(own, any, {material}))
    why += " (SimulationOptions::make_voronoi makes Voronoi cells)";
  if (!why.empty()) throw InputError("'" + strategy.name + "' cannot run on this body: " + why);
  impl_->material = material;
  impl_->strategy = std::make_shared<const Strategy>(strategy);
  impl_->recipe.fixed = fixed_topology(strategy, material);
  if (carries_constants(strategy))
    impl_->recipe.constants = [strategy, material](const Impl& in) {
      return strategy.constants(in.body, material, in.options.parameters);
    };
  impl_->recipe.add_laws = [strategy, material](Impl& in) {
    in.model.add(in.constants.size() ? make_with(strategy, in.body, material, in.constants)
                                     : strategy.make(in.body, material, in.options.parameters));
    add_companions(in.model, strategy, material);
    fix_rigid_parts(in.model);
  };
  impl_->make_model();
  check(impl_->options.stepper, impl_->model);
}

Simulation::Simulation(Body body, const MakeElasticity& make, SimulationOptions options) {
  check(body, options);
  impl_ = std::make_unique<Impl>(std::move(body), std::move(options));
  impl_->recipe.add_laws = [make](Impl& in) {
    auto elasticity = make(in.body);
    if (elasticity.empty()) throw InputError("the function that makes the elasticity returned none");
    in.model.add(std::move(elasticity));
  };
  impl_->make_model();
  check(impl_->options.stepper, impl_->model);
}

Simulation::~Simulation() = default;
Simulation::Simulation(Simulation&&) noexcept = default;
Simulation& Simulation::operator=(Simulation&&) noexcept = default;

const Body& Simulation::body() const noexcept { return impl_->body; }
Model& Simulation::model() noexcept { return impl_->model; }
const Model& Simulation::model() const noexcept { return impl_->model; }
double Simulation::time() const noexcept { return impl_->shown.time; }
const Positions& Simulation::positions() const noexcept { return impl_->shown.positions; }
const Positions& Simulation::velocities() const noexcept { return impl_->shown.velocities; }
const State& Simulation::state() const noexcept { return impl_->shown; }

StepResult Simulation::step(double dt) noexcept {
  if (!impl_) return refused("an empty simulation: it is a moved-from object");
  if (impl_->observed || impl_->in_use)
    return refused("a step within a step or a solve: observers, loads and laws must not step what calls them");
  StepResult result = impl_->step(dt);
  if (result.outcome != Outcome::converged) return result;
  for (std::size_t i = 0; i < impl_->observers.size(); ++i)  // of another body where one cuts it
    if (Impl::Observer& observer = impl_->observers[i]; ++observer.waited == observer.every) {
      observer.waited = 0;
      impl_->observed = true;
      observer.see(*this);
      impl_->observed = false;
    }
  return result;
}

Sensitivity Simulation::sensitivity() {
  Positions free = forces();
  const double root = std::sqrt(static_cast<double>(body().size()));
  VectorX force_densities;
  const double within = internal_force(model(), positions(), force_densities, impl_->workspace) / root;
  const double all = free.norm() + std::max(tensions().norm(), within);
  keep_free(model().supports, free);
  if (free.norm() > 1e-6 * all)
    throw InputError("derivatives are those of an equilibrium, and this state is not one: call settle() first");
  return Sensitivity(model(), state());
}

StaticResult Simulation::settle(const StaticOptions& options) {
  Impl& in = *impl_;
  in.check_idle("settle");
  in.check_host_forces();
  const Within used(in.in_use);
  const ThreadScope scope(in.options.runner, in.options.threads);
  const std::vector<Coupling> moving = in.couplings;
  const auto go_back = [&] {
    in.work = in.shown;
    in.model.begin_step(in.work, in.work.time);
    in.host_supports.go_back();
    in.couplings = moving;
  };
  in.begin_step(in.shown.time, in.shown.time);
  in.host_supports.jump();
  for (Coupling& coupling : in.couplings) coupling.velocity.setZero();
  in.work.velocities.setZero();
  in.work.accelerations.setZero();
  try {
    StaticResult result = solve_static(in.model, in.work, options);
    if (result.outcome != Outcome::converged) {
      go_back();
      if (const std::string odd = in.odd_input(in.shown.time); !odd.empty())
        result.outcome = Outcome::diverged, result.cause = odd;
      return result;
    }
    in.model.commit_step(in.work);
    in.shown = in.work;
    in.host_supports.arrive();
    in.forces_known = in.tensions_known = false;
    return result;
  } catch (...) {
    go_back();
    throw;
  }
}

/// What `add` throws half-way is tried on a model of its own first.
void Simulation::add(std::function<void(Model&)> add) {
  if (!add) throw InputError("add: there is no function to call");
  Impl& in = *impl_;
  in.check_idle("add");
  Model trial(in.body);
  for (const auto& law : in.model.elasticity()) trial.add(law->clone());
  const auto has = [](const std::vector<HistoryBlock>& blocks, const std::string& name) {
    return std::any_of(blocks.begin(), blocks.end(), [&](const HistoryBlock& block) { return block.name == name; });
  };
  const std::vector<HistoryBlock> of_laws = trial.history();
  add(trial);
  for (const HistoryBlock& block : trial.history())
    if (!has(of_laws, block.name) && has(in.model.history(), block.name))
      throw InputError("two loads declare history under the name '" + block.name + "'");
  check(in.options.stepper, trial);
  in.put({std::move(add)}, in.recipe.added.size());
}

/// At this place of the recipe, in place of what stands there.
void Simulation::Impl::put(Added added, std::size_t place) {
  check_idle("add_load, set_load, remove_load");
  bound_step(added);
  if (place == recipe.added.size()) recipe.added.emplace_back();
  take_away(recipe.added[place]);
  const std::size_t before = terms();
  recipe.added[place] = std::move(added);
  if (recipe.added[place].add) perform(recipe.added[place]);
  known += terms() - before;
  order_loads();
  keep_history();
  work.accelerations = shown.accelerations = {};  // those of the loads before
  make_own_stepper();
  if (effort > 0) set_effort(effort);
  budget.restart();
  forces_known = tensions_known = false;
}

void Simulation::Impl::take_away(Added& added) {
  for (const Load* load : added.loads) model.remove(load);
  for (const Viscosity* viscosity : added.viscosity) model.remove(viscosity);
  known -= added.loads.size() + added.viscosity.size();
  added = {};
}

/// Blocks that are there keep their values.
void Simulation::Impl::keep_history() {
  std::vector<HistoryBlock> history = model.history();
  for (HistoryBlock& block : history)
    if (const HistoryBlock* own = shown.find_history(block.name); own && own->values.size() == block.values.size())
      block = *own;
  if (!shown.history.empty() || shown.time > 0) work.history = shown.history = std::move(history);
}

/// Throws InputError where they do not suit the body.
void Simulation::Impl::set_values(Added& load, const LoadValues& values) const {
  load.values = checked_values(*load.kind, body, values);
  load.add = [kind = load.kind, own = load.values, of = material](Model& its) {
    elastin::add_load(its, *kind, own, of ? &*of : nullptr);
  };
}

Simulation::Impl::Added Simulation::Impl::load_of(std::shared_ptr<const LoadKind> kind, const LoadValues& values) {
  Added load;
  load.kind = std::move(kind);
  set_values(load, values);
  load.given = load.values;
  if (!load.given.molecules.empty()) load.given_on = origin_of_molecules();
  return load;
}

Simulation::Impl::Added& Simulation::Impl::load(LoadId id) {
  const auto place = static_cast<std::size_t>(id) - 1;
  if (id < 1 || place >= recipe.added.size() || !recipe.added[place].kind)
    throw InputError("no load " + std::to_string(id) + ": none was added under this number, or it was removed");
  return recipe.added[place];
}

LoadId Simulation::add_load(const LoadKind& load, const LoadValues& values) {
  const std::size_t place = impl_->recipe.added.size();
  impl_->put(impl_->load_of(std::make_shared<const LoadKind>(load), values), place);
  return static_cast<LoadId>(place) + 1;
}

void Simulation::set_load(LoadId load, const LoadValues& values) {
  impl_->put(impl_->load_of(impl_->load(load).kind, values), static_cast<std::size_t>(load) - 1);
}

const LoadKind& Simulation::load_kind(LoadId load) const { return *impl_->load(load).kind; }

void Simulation::remove_load(LoadId load) {
  Impl::Added& added = impl_->load(load);
  impl_->put({}, static_cast<std::size_t>(&added - impl_->recipe.added.data()));
}

int Simulation::effort() const noexcept { return impl_->effort; }

void Simulation::set_effort(int effort) {
  Impl& in = *impl_;
  if (in.options.stepper.method->effort.empty())
    throw InputError("set_effort: the stepper '" + in.options.stepper.method->name +
                     "' takes no number of sweeps or iterations");
  if (effort < 1) throw InputError("set_effort: " + std::to_string(effort) + " is out of range: 1 or more");
  in.set_effort(effort);
  in.effort_is_given = true;
}

std::pair<double, double> Simulation::iteration_error(double dt) {
  Impl& in = *impl_;
  const StepperKind& method = *in.options.stepper.method;
  if (method.effort.empty())
    throw InputError("iteration_error: the stepper '" + method.name + "' takes no number of sweeps or iterations");
  if (!(dt > 0 && std::isfinite(dt)))
    throw InputError("iteration_error: a step of " + number(dt) + " s: a step must be above 0 s and finite");
  in.check_idle("iteration_error");
  if (const std::string why = in.odd_size(); !why.empty()) throw InputError(why);
  const Within used(in.in_use);
  const ThreadScope scope(in.options.runner, in.options.threads);
  const ParameterValues values = complete_values(method.name, method.parameters, in.options.stepper.parameters);
  const auto own_parts = values.find("substeps");
  StepperOptions converged = {"backward_euler", {}, in.options.stepper.newton};
  const auto reached = [&](int substeps) {
    in.begin_step(in.shown.time, in.shown.time + dt);
    const StepResult result = in.substeps_of(dt, substeps);
    const Positions positions = in.work.positions;
    in.go_back();
    return result.outcome == Outcome::converged ? positions : Positions();
  };
  const Positions cut_short = reached(1);
  auto own = std::exchange(in.stepper, make_stepper(converged));
  const Positions balance = reached(own_parts == values.end() ? 1 : static_cast<int>(own_parts->second));
  in.stepper = std::move(own);
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  if (cut_short.size() == 0 || balance.size() == 0) return {none, none};
  return {(cut_short - balance).colwise().norm().maxCoeff(),
          (balance - in.shown.positions).colwise().norm().maxCoeff()};
}

const Positions& Simulation::forces() const noexcept {
  Impl& in = *impl_;
  if (std::exchange(in.forces_known, true)) return in.forces;
  const ThreadScope scope(in.options.runner, in.options.threads);
  in.model.set_forces(in.shown, in.forces, in.workspace);
  return in.forces;
}

const VectorX& Simulation::tensions() const noexcept {
  Impl& in = *impl_;
  if (std::exchange(in.tensions_known, true)) return in.tensions;
  const ThreadScope scope(in.options.runner, in.options.threads);
  set_tensions(in.model, in.shown, in.tensions, in.workspace);
  return in.tensions;
}

}  // namespace elastin
