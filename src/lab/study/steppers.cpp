#include "lab/run/load_path.h"
#include "lab/study/study.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "core/base/stopwatch.h"
#include "core/solve/energies.h"
#include "core/solve/newton.h"
#include "core/solve/stable_step.h"
#include "elastin/core/base/error.h"
#include "elastin/core/parallel/threads.h"
#include "lab/report/files.h"
#include "lab/report/machine.h"
#include "lab/report/screen.h"
#include "lab/report/table.h"
#include "lab/scene/scene.h"

namespace elastin::lab {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
/// States of the released body that are compared, in one period.
constexpr int kFrames = 20;
/// Of the explicit steps, over the longest stable one; and of those that stand for the limit of short steps.
constexpr double kStable = 0.8, kShort = 0.1;
constexpr int kShortSteps = 20;  // in each step that is compared with them, at least
/// A body rests whose measure changes by less than this in a tenth of a period, twice; it has this number of periods
/// for that.
constexpr double kResting = 1e-6;
constexpr int kMostPeriods = 10;

/// The scene's model, loaded, and what is measured on it.
struct Held {
  HeldModel model;
  StaticRig* rig;
  Start start;
  double stable = 0;  ///< longest stable step [s]

  Measures measure(const State& state) const {
    Positions forces;
    model.model->set_forces(state, forces);
    StaticResult fixed;
    fixed.reactions = -fixed_components(model.model->supports, forces);
    return rig->measure(start, state, {}, fixed);
  }
};

Held held_model(const Scene& scene, const StaticExperiment& fixture, const RunOptions& options) {
  Run run;
  auto made = make_model(scene.specimen, fixture, scene.stiffness, options, run);
  if (!made) throw InputError("the strategy '" + scene.stiffness.label + "' cannot run here: " + run.cause);
  Held held{std::move(*made), nullptr, {}};
  held.rig = held.model.rig->at_rest();
  Model& model = *held.model.model;
  State state = state_at_rest(model.body());
  held.start = {state.positions, Positions::Zero(3, static_cast<Eigen::Index>(model.supports.size()))};
  set_load(model, *held.rig, 0);
  if (model.load_forces(state).isZero(0)) return held;
  const StaticResult result = solve_static(model, state, options.statics);
  if (result.outcome != Outcome::converged) throw InputError("no equilibrium before the load: " + result.cause);
  held.start = {state.positions, result.reactions};
  return held;
}

/// One row's stepper.
struct Variant {
  StepperMethod method;
  ParameterValues parameters;
  int iterations = 0;
};

const ParameterInfo* effort_of(const StepperKind& method) {
  for (const ParameterInfo& info : method.parameters)
    if (info.name == method.effort) return &info;
  return nullptr;
}

/// A stepper's parameters with this number of iterations in each step; 0: until it converges.
Variant variant_of(const StepperChoice& choice, int iterations) {
  Variant variant{choice.method, choice.parameters, iterations};
  if (const ParameterInfo* effort = effort_of(*choice.method)) variant.parameters[effort->name] = iterations;
  for (const ParameterInfo& info : choice.method->parameters)  // its substeps would be another step
    if (info.name == "substeps" && !variant.parameters.contains(info.name)) variant.parameters[info.name] = 1;
  return variant;
}

std::vector<Variant> variants_of(const StepperChoice& choice, const std::vector<int>& iterations) {
  const ParameterInfo* effort = effort_of(*choice.method);
  if (!effort || choice.parameters.contains(effort->name)) {
    Variant fixed = variant_of(choice, 0);
    if (!effort) return {fixed};
    fixed.iterations = static_cast<int>(choice.parameters.at(effort->name));
    fixed.parameters[effort->name] = fixed.iterations;
    return {fixed};
  }
  std::vector<Variant> all;
  const bool newton = effort->low == 0 && effort->fallback == 0;
  if (newton) all.push_back(variant_of(choice, 1));
  for (const int count : iterations)
    if (!newton && count >= effort->low && count <= effort->high) all.push_back(variant_of(choice, count));
  if (effort->low == 0) all.push_back(variant_of(choice, 0));
  return all;
}

/// The released body at equal times over one period.
struct Motion {
  std::vector<Positions> frames;
  StepResult end;
  double energy = kNaN, seconds = kNaN;
};

class StepperRuns {
 public:
  StepperRuns(Scene& scene, const StepperStudy& study) : scene_(scene), study_(study) {
    options_.statics = scene.statics;
    const StaticExperiment* fixture = scene.experiment->calibration();
    if (!fixture)
      throw InputError(
          "steppers are compared on an experiment at rest, which the body is let come to and released from; " +
          scene.experiment->name() + " has none");
    fixture_ = fixture;
    prepare(scene.specimen, scene.stiffness.strategy);
    loaded_ = held_model(scene, *fixture, options_);
    released_ = held_model(scene, *fixture, options_);
    find_equilibrium();
    for (const Held* held : {&*loaded_, &*released_}) {
      State state = state_at_rest(held->model.model->body());
      const_cast<Held*>(held)->stable = find_stable_step(*held->model.model, state).step;
    }
  }

  StepperComparison run(const std::function<void(const std::string&)>& progress, const std::function<bool()>& stop) {
    describe();
    std::vector<double> steps = study_.steps;
    if (steps.empty()) steps = {result_.period / 25, result_.period / 100};
    for (const double wanted : steps) {
      const int count = std::max(1, static_cast<int>(std::lround(result_.period / wanted)));
      const double step = result_.period / count;
      if (progress) progress(fmt::format("reference at steps of {}", readable(step, dimension::time, 3)));
      exact_ = released_by_short_steps(step);
      converged_.clear();
      for (const StepperChoice& choice : study_.methods)
        for (const Variant& variant : variants_of(choice, study_.iterations)) {
          if (progress)
            progress(fmt::format("{}, {} iterations, steps of {}", variant.method->name, variant.iterations,
                                 readable(step, dimension::time, 3)));
          result_.rows.push_back(row(variant, step));
          if (stop && stop()) return std::move(result_);
        }
    }
    return std::move(result_);
  }

 private:
  Model& model(const Held& held) const { return *held.model.model; }

  /// The loaded equilibrium, the period of its shape, and the damping that is critical for it.
  void find_equilibrium() {
    Model& model = this->model(*loaded_);
    set_load(model, *loaded_->rig, 1);
    equilibrium_ = state_at_rest(model.body());
    loaded_->rig->shape_start(equilibrium_.positions);
    const StaticResult solved = solve_static(model, equilibrium_, scene_.statics);
    if (solved.outcome != Outcome::converged) throw InputError("no equilibrium under the load: " + solved.cause);
    measures_ = loaded_->rig->measure(loaded_->start, equilibrium_, scene_.statics, const_cast<StaticResult&>(solved));
    const Positions u = equilibrium_.positions - loaded_->start.positions;
    const VectorX& mass = model.body().mass;
    double inertia = 0;
    for (int i = 0; i < model.body().size(); ++i) inertia += mass[i] * u.col(i).squaredNorm();
    size_ = std::sqrt(inertia);
    Model& free = this->model(*released_);
    State at{equilibrium_.positions, Positions::Zero(3, u.cols())};
    released_->rig->release(at);
    Positions forces;
    free.set_forces(at, forces);
    keep_free(free.supports, forces);
    const double work = -forces.cwiseProduct(u).sum();
    if (!(work > 0 && inertia > 0))
      throw InputError("the body does not come back when it is released: there is nothing to compare steppers by");
    frequency_ = std::sqrt(work / inertia);
    result_.period = 2 * std::numbers::pi / frequency_;
    model.add(make_mass_damping(model.body(), 2 * frequency_));
  }

  void describe() {
    const Body& body = scene_.specimen.body;
    result_.scene = scene_.name, result_.title = scene_.title, result_.strategy = scene_.stiffness.label;
    result_.molecules = body.size(), result_.connections = body.connections.proper();
    result_.cells = static_cast<int>(count_cells(body));
    result_.threads = threads();
    result_.machine = this_machine().text();
    for (const MainMeasure& measure : fixture_->main_measures(scene_.specimen.material, measures_)) {
      const double value = measures_.get(std::string(measure.name));
      if (result_.measures.size() == 2 || !std::isfinite(value)) continue;
      result_.measures.push_back(scene_.measures->at(measure.name));
      result_.equilibrium.push_back(value);
    }
    if (result_.measures.empty()) throw InputError("a " + fixture_->name() + " experiment measures nothing at rest");
    result_.warnings = scene_.warnings;
  }

  StepperRow row(const Variant& variant, double step) {
    StepperRow row{
        variant.method->name, variant.iterations, step, {}, {}, true, true, {}, kNaN, kNaN, kNaN, kNaN, kNaN};
    row.cause = unsuited_for(*variant.method, model(*loaded_));
    row.suited = row.cause.empty();
    if (!row.suited) return row;
    if (variant.method->is_explicit) row.substeps = substeps_of(variant, *released_, step);
    const auto note = [&](const StepResult& end) {
      if (end.outcome == Outcome::converged || row.outcome != Outcome::converged) return;
      row.outcome = end.outcome, row.cause = end.cause;
    };
    const Motion motion = released(variant, step);
    note(motion.end);
    if (motion.end.outcome == Outcome::converged) {
      row.energy = motion.energy, row.seconds = motion.seconds;
      row.time_error = distance(motion, exact_);
      if (const Motion* reference = converged_reference(variant, step))
        row.iteration_error = distance(motion, *reference);
    }
    note(settle(variant, step, row));
    return row;
  }

  int substeps_of(const Variant& variant, const Held& held, double step) const {
    return variant.method->is_explicit ? std::max(1, static_cast<int>(std::ceil(step / (kStable * held.stable)))) : 1;
  }

  std::unique_ptr<Stepper> made(const Variant& variant) const {
    return make_stepper({variant.method, variant.parameters, scene_.statics});
  }

  static StepResult advance(Stepper& stepper, Model& model, State& state, double step, int substeps) {
    StepResult result;
    for (int part = 0; part < substeps && result.outcome == Outcome::converged; ++part)
      result = stepper.advance(model, state, step / substeps);
    return result;
  }

  Motion released(const Variant& variant, double step) const {
    return released(variant, step, substeps_of(variant, *released_, step));
  }

  Motion released(const Variant& variant, double step, int substeps) const {
    Model& model = this->model(*released_);
    const int steps = static_cast<int>(std::lround(result_.period / step)), frame = std::max(1, steps / kFrames);
    State state{equilibrium_.positions, Positions::Zero(3, equilibrium_.positions.cols())};
    if (model.drive) model.drive(0, model.supports);
    model.declare_history(state);
    const auto stepper = made(variant);
    Ledger ledger(model, state);
    const Energies first = ledger.energies(model, state);
    const double rest = model.elastic_energy(released_->start.positions);
    Motion motion;
    std::vector<double> times;
    for (int i = 1; i <= steps; ++i) {
      const Stopwatch watch;
      motion.end = advance(*stepper, model, state, step, substeps);
      times.push_back(watch.seconds());
      if (motion.end.outcome != Outcome::converged) return motion;
      ledger.record(model, state);
      if (i % frame == 0) motion.frames.push_back(state.positions);
    }
    std::nth_element(times.begin(), times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2), times.end());
    motion.seconds = times[times.size() / 2];
    if (model.has_energy() && first.elastic > rest)
      motion.energy = (ledger.energies(model, state).balance() - first.balance()) / (first.elastic - rest);
    return motion;
  }

  /// By velocity Verlet's steps far below the longest stable one, at the frames of `step`.
  Motion released_by_short_steps(double step) const {
    const Variant verlet{"velocity_verlet", {}, 0};
    Motion motion =
        released(verlet, step, std::max(kShortSteps, static_cast<int>(std::ceil(step / (kShort * released_->stable)))));
    if (motion.end.outcome != Outcome::converged)
      throw InputError("the limit of short steps was not found: " + motion.end.cause);
    return motion;
  }

  /// The same steps solved in full; null where the stepper solves nothing, or that fails.
  const Motion* converged_reference(const Variant& variant, double step) {
    if (variant.method->is_explicit || !effort_of(*variant.method)) return nullptr;
    Variant full = variant_of({variant.method->order == 1 ? StepperMethod("backward_euler") : variant.method, {}}, 0);
    if (variant.method->order > 1) {
      full.parameters = variant.parameters;
      full.parameters[variant.method->effort] = 0;
    }
    for (const auto& [name, motion] : converged_)
      if (name == full.method->name) return motion.end.outcome == Outcome::converged ? &motion : nullptr;
    converged_.emplace_back(full.method->name, released(full, step));
    const Motion& made = converged_.back().second;
    return made.end.outcome == Outcome::converged ? &made : nullptr;
  }

  double distance(const Motion& a, const Motion& b) const {
    const VectorX& mass = scene_.specimen.body.mass;
    double sum = 0;
    for (std::size_t i = 0; i < a.frames.size(); ++i)
      sum += (a.frames[i] - b.frames[i]).colwise().squaredNorm().dot(mass.transpose());
    return std::sqrt(sum / static_cast<double>(a.frames.size())) / size_;
  }

  /// The load at once, then time until nothing changes.
  StepResult settle(const Variant& variant, double step, StepperRow& row) const {
    Model& model = this->model(*loaded_);
    State state{loaded_->start.positions, Positions::Zero(3, equilibrium_.positions.cols())};
    if (model.drive) model.drive(0, model.supports);
    model.declare_history(state);
    const auto stepper = made(variant);
    const int substeps = substeps_of(variant, *loaded_, step);
    const int between = std::max(1, static_cast<int>(std::lround(result_.period / 10 / step)));
    double last = kNaN;
    int resting = 0;
    StepResult result;
    for (double time = 0; time < kMostPeriods * result_.period && resting < 2;) {
      for (int i = 0; i < between && result.outcome == Outcome::converged; ++i, time += step)
        result = advance(*stepper, model, state, step, substeps);
      if (result.outcome != Outcome::converged) return result;
      const double now = loaded_->measure(state).get(result_.measures.front().name);
      resting = std::abs(now - last) <= kResting * std::abs(now) ? resting + 1 : 0;
      last = now;
    }
    row.settled = resting >= 2;
    const Measures measures = loaded_->measure(state);
    for (const MeasureInfo& info : result_.measures) row.at_rest.push_back(measures.get(info.name));
    row.rest_error = row.at_rest.front() / result_.equilibrium.front() - 1;
    return result;
  }

  Scene& scene_;
  const StepperStudy& study_;
  RunOptions options_;
  const StaticExperiment* fixture_ = nullptr;
  std::optional<Held> loaded_, released_;
  State equilibrium_;
  Measures measures_;
  double size_ = 0, frequency_ = 0;
  Motion exact_;
  std::vector<std::pair<std::string, Motion>> converged_;
  StepperComparison result_;
};

StepperStudy study_of(const Request& request, const Catalog& catalog, const Scene& scene) {
  StepperStudy study = scene.steppers.value_or(StepperStudy{});
  if (request.steppers.empty()) return study;
  try {
    study.methods = read_steppers(request.steppers, catalog.steppers);
  } catch (const InputError& error) {
    throw InputError(std::string("--steppers: ") + error.what());
  }
  return study;
}

}  // namespace

StepperComparison measure_steppers(Scene& scene, const StepperStudy& study,
                                   const std::function<void(const std::string&)>& progress,
                                   const std::function<bool()>& stop) {
  return StepperRuns(scene, study).run(progress, stop);
}

bool compares_steppers(const Request& request) {
  if (!request.steppers.empty()) return true;
  if (!request.strategies.empty() || !request.vary.empty()) return false;
  std::size_t with = 0;
  for (const SceneSource& source : request.scenes)
    with += !scene_format_of(source.path()) && open_scene(source, request.overrides, kMostMolecules).has("steppers");
  if (with > 0 && with < request.scenes.size())
    throw InputError(
        "some of these scenes compare steppers and others strategies: compare them apart, or name --steppers");
  return with > 0;
}

namespace {

/// Throws InputError for what a comparison of steppers would leave out.
void check_options(const Request& request) {
  const bool engines = !request.engine_commands.empty() || !request.against.empty() ||
                       std::any_of(request.overrides.begin(), request.overrides.end(),
                                   [](const std::string& override) { return override.starts_with("engines."); });
  for (const auto& [option, given] : {std::pair{"--strategies", !request.strategies.empty()},
                                      {"--vary", !request.vary.empty()},
                                      {"--repeats", request.repeats > 0},
                                      {"--engines, --engine or --against", engines},
                                      {"--gradient", !request.gradient.empty()},
                                      {"--reference", !request.reference.empty()},
                                      {"--restart", !request.restart.empty()},
                                      {"--live", request.live},
                                      {"--resume", request.resume},
                                      {"--shard", request.shard.of > 1},
                                      {"--baseline", !request.baseline.empty()},
                                      {"--peers", !request.peers.empty()},
                                      {"--summary", request.summary},
                                      {"--verbose", request.verbose}})
    if (given)
      throw InputError(std::string(option) +
                       ": is of a comparison of strategies; one of steppers takes the scene's own strategy, and --set, "
                       "--steppers, --threads, --out, --json and --quiet");
}

}  // namespace

bool compare_steppers(const Request& request, const Catalog& catalog) {
  check_options(request);
  Progress progress(progress_of(request));
  std::vector<StepperComparison> all;
  bool good = true;
  const auto write = [&] {
    if (!request.json.empty() && request.json != "-") write_whole(request.json, stepper_json(all));
    if (request.out.empty()) return;
    write_whole(request.out + "/steppers.json", stepper_json(all));
    write_whole(request.out + "/steppers.html", stepper_page(all, request.command));
  };
  write();  // an unwritable folder is an error before the first run
  for (const SceneSource& source : request.scenes) {
    const auto scene = load_scene(source, catalog, request.overrides);
    const StepperStudy study = study_of(request, catalog, *scene);
    all.push_back(measure_steppers(
        *scene, study, [&](const std::string& doing) { progress.set(scene->name + ": " + doing); },
        request.interrupted));
    progress.pause();
    for (const StepperRow& row : all.back().rows) good &= !row.suited || row.outcome == Outcome::converged;
    if (request.to_screen()) fmt::print("{}", stepper_text(all.back(), colours_on(STDOUT_FILENO)));
    write();
    if (request.interrupted && request.interrupted()) break;
  }
  if (request.json == "-") fmt::print("{}", stepper_json(all));
  if (request.to_screen() && !request.out.empty())
    fmt::print("  files in {}/: steppers.html, steppers.json\n", request.out);
  return good && !(request.interrupted && request.interrupted());
}

}  // namespace elastin::lab
