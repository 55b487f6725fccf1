#include "elastin/core/solve/trajectory.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "core/solve/stable_step.h"
#include "core/solve/stiffness_slopes.h"
#include "core/solve/transposed_step.h"
#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"
#include "elastin/core/laws/local.h"

namespace elastin {
namespace {

/// Why a model's steps have no derivatives, or "".
std::string without_derivatives(const Model& model) {
  if (!model.has_energy() || !model.has_full_tangent())
    return "a law has no energy, or constants that change, as those of angles_update";
  if (!model.symmetric()) return "friction, or a load that follows the surface, has no symmetric stiffness";
  for (std::size_t law = 0; law < model.elasticity().size(); ++law)
    if (const auto* past = dynamic_cast<const LawHistory*>(model.elasticity()[law].get())) {
      const std::size_t blocks = past->history("law").size();
      if (blocks > 1 || (blocks == 1 && !dynamic_cast<const TransposedHistory*>(model.elasticity()[law].get())))
        return "of laws with a history, those that relax or soften have a transpose, not those that do both";
    }
  for (const auto& load : model.loads())
    if (!load->history().empty()) return "a load has a history";
  return "";
}

/// λ·(f − M a) of another model at the same state.
double power(Model& model, const State& from, const State& at, const Positions& lambda) {
  if (model.body().size() != lambda.cols()) throw InputError("a varied model has other molecules");
  model.begin_step(from, at.time);
  Positions forces;
  model.set_forces(at, forces);
  forces -= at.accelerations * model.body().mass.asDiagonal();
  return forces.cwiseProduct(lambda).sum();
}

/// Of the history that another model would make of the end of a step, with these slopes.
double past(const Model& model, const State& from, const State& to, const std::vector<HistoryBlock>& slopes) {
  State end = to;
  end.history = from.history;
  model.commit_step(end);
  double sum = 0;
  for (std::size_t block = 0; block < slopes.size(); ++block)
    for (std::size_t i = 0; i < slopes[block].values.size(); ++i)
      sum += slopes[block].values[i] * end.history[block].values[i];
  return sum;
}

std::size_t numbers_in(const State& state) {
  std::size_t sum =
      static_cast<std::size_t>(state.positions.size() + state.velocities.size() + state.accelerations.size());
  for (const HistoryBlock& block : state.history) sum += block.values.size();
  return sum;
}

}  // namespace

struct Trajectory::Impl {
  Impl(Model& a_model, State start, double a_step, int some_steps, const StepperOptions& options)
      : model(a_model), dt(a_step), steps(some_steps), stepper(make_stepper(options)) {
    backward = dynamic_cast<TransposedStep*>(stepper.get());
    const std::string why =
        backward ? without_derivatives(model) : "stepper '" + options.method->name + "' has no transpose";
    if (!why.empty()) throw InputError("no derivatives of a run in time: " + why);
    if (!(dt > 0 && std::isfinite(dt)) || steps < 1)
      throw InputError("a run of " + std::to_string(steps) + " steps of " + std::to_string(dt) +
                       " s: at least one step above 0 s is needed");
    model.declare_history(start);
    model.begin_step(start, start.time);
    if (options.method->is_explicit) {
      const double longest = find_stable_step(model, start).step;
      if (dt > longest)
        throw InputError("steps of " + number(dt, 3) + " s of '" + options.method->name +
                         "' are not stable: the longest stable one is " + number(longest, 3) + " s");
    }
    set_accelerations(model, start);
    stored.push_back(std::move(start));
    end = stored.front();
    for (int step = 0; step < steps; ++step) {
      if (step > 0 && step % stride() == 0) stored.push_back(end);
      advance(end, step);
    }
  }

  int stride() const { return static_cast<int>(std::ceil(std::sqrt(steps))); }
  void advance(State& state, int step) const {
    const StepResult taken = stepper->advance(model, state, dt);
    const std::string number = "step " + std::to_string(step + 1) + " of " + std::to_string(steps);
    if (taken.outcome != Outcome::converged) throw InputError(number + " failed: " + taken.cause);
    if (taken.substeps != 1)
      throw InputError(number + " was taken in " + std::to_string(taken.substeps) +
                       " substeps: a run with derivatives needs steps that are taken at once; take shorter ones");
  }

  Model& model;
  double dt;
  int steps;
  std::unique_ptr<Stepper> stepper;
  TransposedStep* backward = nullptr;
  std::vector<State> stored;
  State end;
};

Trajectory::Trajectory(Model& model, State start, double dt, int steps, const StepperOptions& options)
    : impl_(std::make_unique<Impl>(model, std::move(start), dt, steps, options)) {}
Trajectory::~Trajectory() = default;
Trajectory::Trajectory(Trajectory&&) noexcept = default;

const State& Trajectory::end() const { return impl_->end; }
int Trajectory::steps() const { return impl_->steps; }
std::size_t Trajectory::stored_numbers() const {
  return numbers_in(impl_->end) * (impl_->stored.size() + static_cast<std::size_t>(impl_->stride()));
}

TrajectoryAdjoint Trajectory::adjoint(const AddSlopes& add_slopes, const std::vector<VariedModels>& varied) {
  Impl& in = *impl_;
  Model& model = in.model;
  const Eigen::Index molecules = in.end.positions.cols();
  // There η has a kink of which differences by a number see one side, for W is W_max wherever it has just grown.
  for (const auto& law : model.elasticity())
    if (const auto* softens = dynamic_cast<const Softens*>(law.get());
        softens && softens->softened() && in.backward->begins_with_forces() && !varied.empty())
      throw InputError(
          "no derivative by a number of what softens by 'symplectic_euler', whose forces are those at a step's "
          "beginning: take velocity_verlet");
  const Positions none = Positions::Zero(3, molecules);
  TrajectoryAdjoint found{none, none, none, {}, std::vector<double>(varied.size(), 0)};
  const bool damps = std::any_of(model.viscosity().begin(), model.viscosity().end(), [](const auto& viscosity) {
    return dynamic_cast<const GrowsWithStiffness*>(viscosity.get());
  });
  const auto elements_of = [&](const Elasticity& law) { return damps ? nullptr : law.local(); };
  for (const auto& law : model.elasticity())
    found.stiffness.push_back(VectorX::Zero(elements_of(*law) ? elements_of(*law)->elements() : 0));
  StateSlopes slopes{none, none, none, in.end.history};
  for (HistoryBlock& block : slopes.history) std::fill(block.values.begin(), block.values.end(), 0.);
  const auto note = [&](const State& from, const State& at, const Positions& lambda) {
    found.forces += lambda;
    for (std::size_t law = 0; law < found.stiffness.size(); ++law)
      if (const LocalElasticity* local = elements_of(*model.elasticity()[law]))
        found.stiffness[law] += work_by_stiffness(*local, at.positions, lambda);
    for (std::size_t i = 0; i < varied.size(); ++i)
      found.numbers[i] += (power(*varied[i].above, from, at, lambda) - power(*varied[i].below, from, at, lambda)) /
                          varied[i].difference;
  };
  add_slopes(in.steps, in.end, slopes.positions, slopes.velocities);
  for (std::size_t part = in.stored.size(); part-- > 0;) {
    const int first = static_cast<int>(part) * in.stride(), last = std::min(in.steps, first + in.stride());
    std::vector<State> states{in.stored[part]};
    if (model.drive) model.drive(states[0].time, model.supports);
    model.begin_step(states[0], states[0].time);
    for (int step = first; step < last; ++step) {
      states.push_back(states.back());
      in.advance(states.back(), step);
    }
    for (int step = last; step-- > first;) {
      const State &from = states[step - first], &to = states[step - first + 1];
      if (model.drive) model.drive(to.time, model.supports);
      for (std::size_t i = 0; i < varied.size() && !slopes.history.empty(); ++i)
        found.numbers[i] +=
            (past(*varied[i].above, from, to, slopes.history) - past(*varied[i].below, from, to, slopes.history)) /
            varied[i].difference;
      in.backward->transpose(model, from, to, slopes,
                             [&](const State& at, const Positions& lambda) { note(from, at, lambda); });
      add_slopes(step, from, slopes.positions, slopes.velocities);
      states.pop_back();
    }
  }
  // The accelerations at the start are those of its forces.
  const State& start = in.stored.front();
  const Positions lambda = slopes.accelerations * model.body().mass.cwiseInverse().asDiagonal();
  if (!lambda.isZero(0)) {
    TransposedForces forces(model);
    forces.begin(start, start.time, start, in.dt);
    forces.add(lambda, slopes);
    note(start, start, lambda);
  }
  for (Positions* each : {&slopes.positions, &slopes.velocities}) keep_free(model.supports, *each);
  found.positions = std::move(slopes.positions), found.velocities = std::move(slopes.velocities);
  if (model.drive) model.drive(in.end.time, model.supports);
  model.begin_step(in.end, in.end.time);
  return found;
}

}  // namespace elastin
