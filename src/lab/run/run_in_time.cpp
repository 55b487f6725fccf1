#include "lab/run/load_path.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>
#include <thread>

#include "core/base/stopwatch.h"
#include "core/model/visit_state.h"
#include "core/solve/energies.h"
#include "core/solve/modes.h"
#include "core/solve/steppers.h"
#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"
#include "elastin/core/model/parts.h"
#include "elastin/core/model/rest.h"
#include "elastin/core/model/share.h"
#include "elastin/lab/run/experiment.h"
#include "lab/run/common_measures.h"
#include "lab/run/compression.h"
#include "lab/run/contact_measures.h"
#include "lab/run/specimen.h"
#include "lab/run/step_control.h"

namespace elastin::lab {
namespace {

/// Of the energy stored, worked or dissipated: more than that made or lost by the steps is said.
constexpr double kEnergyOpen = 0.05;
/// Of its length at rest: a connection that is longer has been torn by the steps.
constexpr double kTorn = 1000;
/// Of it to the energy that was there: nothing of such a run is worth reading on.
constexpr double kEnergyLost = 2;
/// Part of the steps that may take longer than their budget without a word.
constexpr double kLate = 0.01;

/// What happens slowly moves a body by less in a step than steps by error see, and still has its time constant: as many
/// steps as its curve needs.
TimeOptions with_steps_for(const TimedExperiment& experiment, TimeOptions options) {
  constexpr int fewest = 100;
  if (!experiment.slow()) return options;
  options.resolves_motion = false;
  if (options.choice == StepChoice::automatic) options.largest = std::min(options.largest, options.duration / fewest);
  return options;
}

/// Of steps whose length is given: what they cannot see of the functions of time; "" where they see all.
std::string overlooked(const TimeOptions& options) {
  constexpr double fewest = 4;  // steps in a swing: half a sine's period is then seen to 5 %
  const bool fixed = options.choice == StepChoice::fixed, per_frame = options.choice == StepChoice::per_frame;
  if (!fixed && !per_frame) return "";
  const double frame = options.time_of(options.frames) - options.time_of(options.frames - 1);
  const double step = fixed ? std::min(options.step, frame) : frame / options.steps_per_frame;
  double shortest = std::numeric_limits<double>::infinity();
  for (const TimeFunction& function : options.follows) shortest = std::min(shortest, function.shortest_swing());
  if (step * fewest <= shortest * (1 + 1e-9)) return "";
  return "steps of " + number(step, 4) + " s are too long for a function of time that goes to and fro within " +
         number(shortest, 4) + " s; take steps of " + number(shortest / fewest, 2) +
         " s or less, or leave `time.step` out";
}

/// Of a flat membrane that could leave its plane; else zero.
Vector3 free_flat_normal(const Model& model, const Material& material) {
  const Body& body = model.body();
  if (body.share || body.triangles.empty() || !body.tetrahedra.empty() || material.bending_rigidity > 0 ||
      contact_of(model))
    return Vector3::Zero();
  const Vector3 normal = plane_normal(body);
  std::vector<char> held(static_cast<std::size_t>(body.size()), 0);
  for (const Support& support : model.supports)
    if ((support.free * normal).norm() < 0.5) held[support.molecule] = 1;
  return std::count(held.begin(), held.end(), 1) == body.size() ? Vector3(Vector3::Zero()) : normal;
}

/// Of owned molecules; 0 of those of rigid bodies.
VectorX mass_without_rigid_parts(const Body& body) {
  VectorX mass = body.mass.head(owned_molecules(body));
  for (const Part& part : body.parts)
    if (part.rigid)
      for (const int molecule : molecules_of(part))
        if (molecule < mass.size()) mass[molecule] = 0;
  return mass;
}

/// One timed run.
class TimedRun {
 public:
  TimedRun(Model& model, const TimedExperiment& experiment, const TimedRig& rig, const RunOptions& options, Run& run,
           State start, const StepperMethod& method, const std::string& identity, bool muscles, bool contact_damps,
           const Material& material)
      : model_(model),
        experiment_(experiment),
        rig_(rig),
        options_(options),
        run_(run),
        state_(std::move(start)),
        identity_(identity),
        contact_damps_(contact_damps),
        muscles_(muscles),
        begin_(state_.positions),
        ledger_(model, state_),
        control_(model, state_, with_steps_for(experiment, *options.time), method, options.statics),
        free_mass_(mass_without_rigid_parts(model.body())),
        mass_(sum_over(model.body(), free_mass_.sum())),
        material_(material),
        flat_normal_(free_flat_normal(model, material)) {}

  void resume() {
    const std::string& path = options_.restart_path;
    const std::string what = (path.empty() ? "" : path + ": ") + "the restart file";
    const RestartPoint point = parse_restart(options_.restart, identity_, path);
    check_state(point.state, model_.body().size(), model_.history(), what);
    if (point.frame < 0) throw InputError(what + " is damaged: frame " + std::to_string(point.frame));
    if (point.frame > options_.time->frames)
      throw InputError(what + " is of frame " + std::to_string(point.frame) +
                       ", at t = " + number(point.state.time, 6) + " s, and this run ends with frame " +
                       std::to_string(options_.time->frames) + ", at t = " + number(options_.time->duration, 6) +
                       " s: write a longer `time.duration`, and `time.frames` in proportion");
    state_ = point.state;
    model_.begin_step(state_, state_.time);
    if (model_.drive) model_.drive(state_.time, model_.supports);
    begin_ledger({point.dissipated, point.work, point.taken, point.jumps});
    control_.memory = point.memory;
    run_.newton_iterations = point.newton_iterations;
    run_.linear_iterations = point.linear_iterations;
    run_.curve = point.curve;
    history_ = point.history;
    frame_ = point.frame;
  }

  void go() {
    const Stopwatch watch;
    began_ = {}, began_at_ = state_.time;
    const TimeOptions& time = *options_.time;
    const double critical = control_.memory.critical;
    if (time.choice == StepChoice::fixed && critical > 0 && time.step > critical)
      run_.warnings.push_back("a step of " + number(time.step, 4) + " s is longer than the longest stable one, " +
                              number(critical, 4) + " s");
    if (const std::string text = overlooked(time); !text.empty()) run_.warnings.push_back(text);
    if (run_.curve.empty()) keep_row({});
    keep_snapshot();
    double looked = 0;  // [s], at what a budget leaves: no part of the steps
    const double first = state_.time;
    const int first_step = control_.memory.steps, first_frame = frame_;
    while (frame_ < time.frames && run_.outcome == Outcome::converged) {
      if (!advance_frame(time.time_of(frame_ + 1))) break;
      ++frame_;
      keep_snapshot();
      note_flat_compression();
      const Stopwatch look;
      control_.look(model_, state_);
      looked += look.seconds();
      if (options_.checkpoint && time.checkpoint && frame_ % time.checkpoint == 0) save();
      if (options_.live) wait(watch, (frame_ - first_frame) / time.frame_rate);
      if (frame_ < time.frames && is_stopped()) interrupt();
    }
    run_.time->simulated = state_.time - first;
    run_.time->seconds = watch.seconds() - looked;
    run_.end = state_.positions;
    report(control_.memory.steps - first_step);
  }

 private:
  /// Of the ledger [J].
  struct Account {
    double dissipated, work, taken, jumps;
  };
  /// What a frame began with.
  struct Before {
    State state;
    Account account;
    StepControl::Memory memory;
    std::size_t history;
  };

  /// A flat sheet that is pressed stays in its plane, where it is not stable, as long as nothing moves it out.
  void note_flat_compression() {
    constexpr double flat = 1e-9, rounding = 1e-6, much = 0.01;
    if (flat_normal_.isZero(0)) return;
    const Compression found = find_compression(model_, state_.positions);
    const double strain = -found.tension / (material_.youngs_modulus * material_.thickness);
    largest_strain_ = std::max(largest_strain_, run_.curve.back().measures.get("largest_strain"));
    if (!(strain > std::max(rounding, much * largest_strain_))) return;  // a wave
    const Eigen::RowVectorXd heights = flat_normal_.transpose() * state_.positions;
    const auto [low, high] = outline_of_whole(model_.body());
    if (heights.maxCoeff() - heights.minCoeff() < flat * (high - low).norm())
      run_.warnings.push_back("the flat sheet is not stable from t = " + number(state_.time, 4) +
                              " s on, and stays flat: " + compression_text(model_, state_.positions, found, material_) +
                              ", and `initial: {scatter: {amount: …}}` lets it fold");
    flat_normal_.setZero();
  }

  /// Where the run is, and how long the rest takes at this pace: four times a second.
  void report_progress(double now) {
    if (!options_.progress || reported_.seconds() < 0.25) return;
    const double left = (options_.time->duration - now) / (now - began_at_) * began_.seconds();
    options_.progress("t = " + number(now, 4) + " s of " + number(options_.time->duration, 4) + " s, about " +
                      number(left, 2) + " s left");
    reported_ = {};
  }

  bool advance_frame(double until) {
    const int steps = control_.memory.steps;
    std::optional<Before> before;
    if (options_.stop) before = {state_, account(), control_.memory, history_.size()};
    const StepResult stepped = control_.advance(model_, state_, until, [&](const State& now) {
      ledger_.record(model_, now);
      if (now.time < until && is_sampled()) history_.push_back(read({}));
      report_progress(now.time);
      return now.time >= until || model_.body().share || !is_stopped();  // processes that share it stop at frames
    });
    if (stepped.outcome == Outcome::interrupted) {
      go_back(*before);
      interrupt();
      return false;
    }
    run_.newton_iterations += stepped.newton_iterations;
    run_.linear_iterations += stepped.linear_iterations;
    if (stepped.outcome != Outcome::converged) {
      fail(stepped.outcome, stepped.cause);
      return false;
    }
    CurvePoint row;
    row.newton_iterations = stepped.newton_iterations;
    row.linear_iterations = stepped.linear_iterations;
    row.steps = control_.memory.steps - steps;
    row.step = control_.memory.last;
    return keep_row(row);
  }

  void fail(Outcome outcome, const std::string& cause) {
    run_.outcome = outcome;
    run_.cause = cause + " (at t = " + number(state_.time, 4) + " s, after " + counted(control_.memory.steps, "step") +
                 ", in one of " + number(control_.memory.last, 4) + " s" +
                 (control_.memory.critical > 0 && std::isfinite(control_.memory.critical)
                      ? "; the longest stable one was " + number(control_.memory.critical, 4) + " s"
                      : "") +
                 ")";
  }

  /// Measures of the whole history are read from the steps, however few frames are kept: at 50 moments of a frame at
  /// most, of explicit steps, where reading costs as much as a step, at every fourth; until there are 5000 of them.
  bool is_sampled() const {
    const double step = control_.memory.last,
                 frame = options_.time->time_of(frame_ + 1) - options_.time->time_of(frame_);
    const double every = std::max(frame / 50, control_.memory.critical > 0 ? 4 * step : 0);
    return history_.size() < 5000 && std::floor(state_.time / every) > std::floor((state_.time - step) / every);
  }

  CurvePoint read(CurvePoint row) {
    row.time = state_.time;
    row.measures = rig_.read(state_);
    Measures& m = row.measures;
    const Energies e = ledger_.energies(model_, state_);
    if (mass_ > 0) {
      m.set("speed", moment(state_.velocities).norm() / mass_);
      m.set("centre_displacement", moment(state_.positions - begin_).norm() / mass_);
    }
    m.set("largest_strain", largest_strain(model_, state_.positions));
    m.set("kinetic_energy", e.kinetic);
    m.set("potential_energy", e.potential);
    m.set("dissipated_energy", e.dissipated);
    m.set("work", e.work);
    m.set("momentum", e.momentum.norm());
    m.set("angular_momentum", e.angular_momentum.norm());
    if (const contact::Contact* contact = contact_of(model_)) {
      run_.contact = contact->report(state_);
      note_contact(*run_.contact, experiment_.copies(), m);
    }
    if (model_.has_energy()) m.set("energy", e.elastic);
    const Measures& first = first_measures(m);
    m.set("energy_balance", e.balance() - first.get("kinetic_energy") - stored(first) - first.get("potential_energy"));
    return row;
  }

  /// Energy stored [J]; of laws that have none 0.
  static double stored(const Measures& m) { return std::isfinite(m.get("energy")) ? m.get("energy") : 0; }
  /// What muscles and laws without an energy have given since the start [J]: what is in no other account. 0 where they
  /// took some.
  double given_by_laws(const Measures& m) const {
    if (muscles_ && model_.has_energy()) return std::max(0., -m.get("dissipated_energy"));
    if (model_.has_energy()) return 0;
    const Measures& first = first_measures(m);
    return std::max(0., m.get("kinetic_energy") + m.get("potential_energy") + m.get("dissipated_energy") -
                            m.get("work") - m.get("energy_balance") - first.get("kinetic_energy") -
                            first.get("potential_energy"));
  }

  /// Mass times what the centre has of these vectors, rigid bodies left out.
  Vector3 moment(const Positions& vectors) const {
    return vector_sum_over(model_.body(), Vector3(vectors.leftCols(free_mass_.size()) * free_mass_));
  }

  const Measures& first_measures(const Measures& now) const {
    return history_.empty() ? now : history_.front().measures;
  }

  /// False if the row shows that energy came from nowhere, or the body was torn.
  bool keep_row(CurvePoint row) {
    row = read(std::move(row));
    if (!is_accounted_for(row.measures)) return false;
    history_.push_back(row);
    run_.curve.push_back(std::move(row));
    return true;
  }

  bool is_accounted_for(const Measures& m) {
    const Measures& first = first_measures(m);
    const double released = std::abs(m.get("potential_energy") - first.get("potential_energy"));
    const double available = first.get("kinetic_energy") + stored(first) + released + std::abs(m.get("work")) +
                             given_by_laws(m) + sum_over(model_.body(), ledger_.jumps) + rounding_energy();
    const double now = m.get("kinetic_energy") + stored(m);
    available_ = std::max(available_, available);
    const bool made = m.get("energy_balance") > kEnergyLost * available_;
    const double strain = m.get("largest_strain");
    if (!made && !(strain > kTorn)) return true;
    fail(Outcome::diverged,
         made ? "the steps make energy from nothing: " + number(now, 4) + " J where " + number(available_, 4) +
                    " J were there"
              : "a connection is " + number(strain, 2) + " times as long as at rest: take shorter steps");
    return false;
  }

  /// With less than this [J] the body moves by 1e-10 of its size within the duration, or by 1e-12 within a step:
  /// rounding, of positions in each step.
  double rounding_energy() const {
    const auto [low, high] = outline_of_whole(model_.body());
    const double a_step = control_.memory.last > 0 ? 1e-12 / control_.memory.last : 0;
    const double speed = std::max(1e-10 / options_.time->duration, a_step) * (high - low).norm();
    return mass_ * speed * speed / 2;
  }

  void keep_snapshot() { lab::keep_snapshot(model_, state_, state_.time, frame_, options_, run_); }

  void save() const {
    options_.checkpoint(
        restart_text({frame_, state_, ledger_.dissipated, ledger_.work, ledger_.taken, ledger_.jumps, control_.memory,
                      run_.newton_iterations, run_.linear_iterations, run_.curve, history_},
                     identity_));
  }

  bool is_stopped() const { return options_.stop && any_over(model_.body(), options_.stop()); }

  /// To the frame that was begun: whoever goes on takes the same steps as a run that nobody stopped.
  void go_back(const Before& before) {
    state_ = before.state;
    model_.begin_step(state_, state_.time);
    begin_ledger(before.account);
    control_.memory = before.memory;
    history_.resize(before.history);
  }

  Account account() const { return {ledger_.dissipated, ledger_.work, ledger_.taken, ledger_.jumps}; }
  void begin_ledger(const Account& account) {
    ledger_ = Ledger(model_, state_);
    ledger_.dissipated = account.dissipated;
    ledger_.work = account.work;
    ledger_.taken = account.taken;
    ledger_.jumps = account.jumps;
  }

  void interrupt() {
    if (options_.checkpoint && !model_.body().share) save();
    run_.outcome = Outcome::interrupted;
    run_.cause = "stopped after frame " + std::to_string(frame_) + " of " + std::to_string(options_.time->frames) +
                 ", at t = " + number(state_.time, 4) + " s";
  }

  static void wait(const Stopwatch& watch, double until) {
    std::this_thread::sleep_for(std::chrono::duration<double>(until - watch.seconds()));
  }

  void report(int steps) {
    TimeReport& time = *run_.time;
    const StepControl::Memory& memory = control_.memory;
    time.steps = steps;
    time.rejected = memory.rejected;
    time.shortest_step = memory.shortest;
    time.last_step = memory.last;
    time.critical_step = memory.critical;
    time.frequency = memory.frequency;
    time.budget = control_.budget();
    if (time.budget && time.budget->late > kLate)
      run_.warnings.push_back(number(100 * time.budget->late, 3) + " % of the steps took longer than their budget of " +
                              number(time.budget->budget, 3) + " s" +
                              (time.budget->median == 1
                                   ? ", with one of the " + time.budget->effort + " each: the body is too large for it"
                                   : ""));
    experiment_.read_history(history_, run_.measures);
    if (run_.relaxes && material_.relaxation)
      experiment_.read_relaxation(history_, *material_.relaxation, run_.measures);
    for (const auto& [name, value] : run_.curve.back().measures.all())
      if (!std::isfinite(run_.measures.get(name))) run_.measures.set(name, value);
    double largest = 0, drift = 0, made = 0, released = 0;  // [J]; released: by loads that stay, as weight
    for (const CurvePoint& row : history_) {
      const Measures& m = row.measures;
      largest = std::max({largest, m.get("kinetic_energy") + stored(m), std::abs(m.get("work")),
                          m.get("dissipated_energy"), given_by_laws(m)});
      drift = std::max(drift, std::abs(row.measures.get("energy_balance")));
      made = std::max(made, m.get("energy_balance"));
      released =
          std::max(released, std::abs(m.get("potential_energy") - history_.front().measures.get("potential_energy")));
    }
    const bool from_nothing = made > kEnergyOpen * largest;
    const bool open =
        drift > kEnergyOpen * std::max(largest, contact_damps_ ? released : 0) && drift > 10 * rounding_energy();
    // What is slow damps vibrations by its steps on purpose; contact that damps takes what a step does not resolve.
    const bool lost = open && !experiment_.slow() && !contact_damps_;
    if (open && (from_nothing || lost)) {
      const TimeOptions& chosen = *options_.time;  // of a budget the clock says how many
      std::string effort = chosen.stepper && !(chosen.budget > 0) ? (*chosen.stepper)->effort : "";
      if (!effort.empty()) {  // a number of 0: as many as it takes
        const StepperKind& stepper = **chosen.stepper;
        if (complete_values(stepper.name, stepper.parameters, chosen.parameters).at(effort) == 0) effort.clear();
      }
      run_.warnings.push_back((from_nothing ? "the steps make energy from nothing: " + number(made, 2) + " J where"
                                            : "the steps lose energy: " + number(drift, 2) + " J are missing where") +
                              " at most " + number(largest, 2) +
                              " J were stored, worked or dissipated; take shorter steps" +
                              (effort.empty() ? "" : ", or more " + effort + " in each: time.stepper." + effort));
    }
    if (largest > 0) run_.measures.set("energy_drift", drift / largest);
    run_.remark = experiment_.remark(run_.measures);
    if (open && !from_nothing && contact_damps_)
      run_.remark +=
          (run_.remark.empty() ? "" : "; ") + number(drift, 2) + " J of " + number(largest, 2) +
          " J are in no account: contact with a restitution below 1 takes energy within a step or two, which "
          "is added up coarsely; shorter steps show how much it is";
  }

  Model& model_;
  const TimedExperiment& experiment_;
  const TimedRig& rig_;
  const RunOptions& options_;
  Run& run_;
  State state_;
  std::string identity_;
  bool contact_damps_;  ///< whether contact has a restitution below 1
  bool muscles_;        ///< whose work is in no other account either: dissipation below zero
  Positions begin_;
  std::vector<CurvePoint> history_;  ///< the frames, and steps between them
  Ledger ledger_;
  double available_ = 0;  ///< the most energy that there has been [J]
  StepControl control_;
  VectorX free_mass_;  ///< of each owned molecule that is in no rigid body; of the others 0 [kg]
  double mass_;        ///< its sum over the whole [kg]
  const Material& material_;
  Vector3 flat_normal_;        ///< zero: not flat, or its compression is known
  double largest_strain_ = 0;  ///< of the frames
  Stopwatch began_, reported_;
  double began_at_ = 0;  // [s] of the run, when the first was started
  int frame_ = 0;
};

}  // namespace

std::pair<StepperMethod, std::string> chosen_stepper(const TimeOptions& options, const TimedExperiment& experiment,
                                                     const Specimen& specimen, bool uses_cells) {
  if (options.stepper) return {*options.stepper, ""};
  if (experiment.slow())
    return {"backward_euler", "a " + experiment.name() + " is slow: its steps damp vibrations and grow with them"};
  if (uses_cells) return {"newmark", "cells make short stable steps: implicit steps may be as long as they are right"};
  if (specimen.contact && specimen.contact->penetration > 0)
    return {"newmark", "implicit steps alone keep the contact's `penetration`"};
  return {"velocity_verlet", "springs without cells: an explicit step costs one pass over them"};
}

void run_in_time(Model& model, const TimedExperiment& experiment, TimedRig& rig, const Specimen& specimen,
                 const RunOptions& options, Run& run) {
  if (!options.time) throw InputError("a " + experiment.name() + " experiment needs to know for how long: TimeOptions");
  const auto [method, reason] = chosen_stepper(*options.time, experiment, specimen, run.uses_cells);
  if (const std::string why = unsuited_for(*method, model); !why.empty()) {
    run.suited = false;
    run.cause = why;
    return;
  }
  if (model.body().share && !options.restart.empty())
    throw InputError(options.restart_path + ": several processes that share a body go on from no restart file");
  run.time = TimeReport{};
  run.time->stepper = method->name;
  run.time->reason = reason;
  run.time->resumed = !options.restart.empty();
  State state = state_at_rest(model.body());
  if (const auto& rest = model.body().unstressed; rest && rest->part) {
    model.rest_in_time = rest->part;
    model.set_rest(rest->part(0));
  }
  if (options.progress) options.progress("finding the state it starts from");
  const StaticResult started = rig.start(state, options.statics);
  run.newton_iterations += started.newton_iterations;
  run.linear_iterations += started.linear_iterations;
  run.solver = run.time->stepper;
  if (started.outcome != Outcome::converged) {
    run.outcome = started.outcome;
    run.cause = started.cause + " (before time 0)";
    return;
  }
  if (specimen.start) specimen.start(state);
  if (model.drive) model.drive(0, model.supports);
  if (specimen.start) move_with_supports(model.supports, state.velocities);  // what is held takes no velocity
  model.declare_history(state);
  model.commit_step(state);
  if (any_over(model.body(), !model.admissible(state.positions))) {
    run.outcome = Outcome::inverted;
    run.cause = first_over(model.body(), flat_or_inverted_text(flat_or_inverted_cells(model.body(), state.positions),
                                                               solid_cells(model.body()))) +
                " at time 0";
    return;
  }
  const std::string identity =
      restart_identity(model.body(), options.problem, run.strategy, *options.time, run.time->stepper);
  const std::vector<Material> materials = materials_of(specimen);
  const bool muscles =
      std::any_of(materials.begin(), materials.end(), [](const Material& own) { return own.active.has_value(); });
  TimedRun timed_run(model, experiment, rig, options, run, std::move(state), method, identity, muscles,
                     specimen.contact && specimen.contact->restitution < 1, specimen.material);
  if (run.time->resumed) timed_run.resume();
  timed_run.go();
}

}  // namespace elastin::lab
