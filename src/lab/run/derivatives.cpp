#include "lab/run/derivatives.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "core/solve/newton.h"
#include "core/solve/responses.h"
#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"
#include "lab/run/common_measures.h"
#include "lab/run/contact_measures.h"
#include "lab/run/load_path.h"

namespace elastin::lab {
namespace {

constexpr double kTolerance = 1e-11;  ///< of the linear solves
constexpr double kFollows = 1e-9;     ///< a deviation from the material's curve below which it is rounding
/// |f(p + h) − 2 f(p) + f(p − h)| / |f(p + h) − f(p − h)|: a difference is off by about its square.
constexpr double kBend = 3e-5, kCalibratedBend = 1e-3;
/// Of the displacements and reactions, over which measures are differenced: the most that leaves no error of fourth
/// order worth naming, for the positions of small displacements have few digits.
constexpr double kMotion = 1e-3;
/// Of what touches: how often its motion is corrected, and by which part of it for the last time.
constexpr int kTouchingRounds = 4;
constexpr double kTouchingChange = 1e-10;
/// Of the start: the part of its forces below which its motion needs no correction.
constexpr double kStartForces = 1e-9;
constexpr double kEnough = 1e-7;         ///< residual with which a solve that rounding stops is taken
constexpr double kSameDirection = 1e-9;  ///< of projectors
/// The same ratio of a number at which the forces have a kink or jump.
constexpr double kKink = 0.01;
/// Times rounding, a difference that has enough digits; how often a step may grow tenfold until it is that.
constexpr double kClear = 3e3;
constexpr int kLargerSteps = 3;
/// Of all forces, and of what the positions' last digits make of them: differences below these are rounding.
constexpr double kRounding = 1e-13, kCalibratedRounding = 1e-8, kRoundedPositions = 4;

/// Of whole runs: the step over the number.
constexpr double kWholeStep = 1e-4;
/// The slope over m/p below which m does not change with p; doubt of a slope that needs a shorter step, and that then
/// is none; of what touches, between a step and half of it.
constexpr double kInsensitive = 1e-6, kDoubtful = 1e-3, kTouchingDoubt = 0.03;
/// Where a measure may jump next to an equilibrium, as a tangent does at a corner of a curve: part of the motion.
constexpr double kShorter = 0.01;
/// There, the slope over m/p below which that of rounding counts less.
constexpr double kBarely = 1e-3;
/// Of a measure, over four such steps: what changes more is next to zero, where digits say nothing of jumps.
constexpr double kNextToZero = 0.1;

/// Second over first differences of a measure over a number's deviation: a tenth and a half make its own deviation 2 %
/// larger than first order says. Of a measure, what changes less is not looked at.
constexpr double kUneven = 0.15, kSeen = 0.01;

/// A state at rest: velocities are there, and zero, where a force depends on them.
State still(const Model& model, const Positions& positions, const State& like) {
  State state = like;
  state.positions = positions;
  state.velocities = model.feels_velocity() ? Positions(Positions::Zero(3, positions.cols())) : Positions();
  model.declare_history(state);
  return state;
}

/// All forces on each molecule; of small displacements those that the linear problem has.
Positions all_forces(Model& model, const State& state, bool linear) {
  const State at = linear ? still(model, model.body().rest, state) : state;
  model.begin_step(at, std::numeric_limits<double>::infinity());
  Positions forces = model.elastic_forces(at.positions) + model.load_forces(at);
  if (!linear) return forces;
  Positions change(3, forces.cols());
  Tangent(model, at, {}, linear).apply(state.positions - at.positions, change);
  return forces - change;
}

/// What is left on free molecules of a change of the supports' forces alone is rounding, which no motion balances.
void leave_out_rounding(const Model& model, double rounding, Positions& change) {
  Positions free = change;
  keep_free(model.supports, free);
  if (free.norm() < rounding) change -= free;
}

/// |change| / |whole|, as norms; of a whole that is nothing 0.
double relative(const Positions& change, const Positions& whole) {
  const double size = whole.norm();
  return size > 0 ? change.norm() / size : 0;
}

/// A slope from values at −2, −1, 1 and 2 steps.
struct Slope {
  double value, doubt;  ///< difference of the slopes over one and two steps, over the size of the slope
};

/// @param other part of the same slope; `least`: of its size
Slope slope_of(const std::array<double, 4>& at, double step, double other, double least) {
  const double near = (at[2] - at[1]) / (2 * step), far = (at[3] - at[0]) / (4 * step), best = (4 * near - far) / 3,
               size = std::max({std::abs(best), std::abs(other), least});
  return {best, size > 0 ? std::abs(near - far) / size : 0};
}

/// The slope of a measure by a number, from motions by −2, −1, 1 and 2 steps.
Slope slope_along(const std::array<Measures, 4>& measures, const std::string& name, double step, double other,
                  double number) {
  std::array<double, 4> at{};
  for (std::size_t i = 0; i < at.size(); ++i) at[i] = measures[i].get(name);
  const double size = std::max(std::abs(at[0]), std::abs(at[3]));
  Slope slope = slope_of(at, step, other, kBarely * size / std::abs(number));
  if (std::abs(at[3] - at[0]) > kNextToZero * size) slope.doubt = 0;
  return slope;
}

std::string doubts_text(const std::string& key, const std::string& measures) {
  return "no derivatives by " + key + " of " + measures + ": they jump there, or too few of their digits are known";
}

/// Null: it has none.
double* find_gradient(Gradients& gradients, const std::string& measure, const std::string& key) {
  for (auto& [name, slopes] : gradients)
    for (auto& [by, slope] : slopes)
      if (name == measure && by == key) return &slope;
  return nullptr;
}

double gradient_of(Gradients& gradients, const std::string& measure, const std::string& key) {
  const double* slope = find_gradient(gradients, measure, key);
  return slope ? *slope : std::numeric_limits<double>::quiet_NaN();
}

void put_gradient(Gradients& gradients, const std::string& measure, const std::string& key, double value) {
  auto row = std::find_if(gradients.begin(), gradients.end(), [&](const auto& one) { return one.first == measure; });
  if (row == gradients.end()) row = gradients.insert(row, {measure, {}});
  row->second.emplace_back(key, value);
}

/// Weighted sums of measures: of those that all of them have.
class Slopes {
 public:
  void add(const Measures& measures, double weight) {
    ++count_;
    for (const auto& [name, value] : measures.all()) {
      auto own = std::find_if(sums_.begin(), sums_.end(), [&name = name](const Sum& sum) { return sum.name == name; });
      if (own == sums_.end()) own = sums_.insert(own, {name, 0, 0});
      own->value += weight * value, ++own->count;
    }
  }
  std::vector<std::pair<std::string, double>> taken() const {
    std::vector<std::pair<std::string, double>> list;
    for (const Sum& sum : sums_)
      if (sum.count == count_ && std::isfinite(sum.value)) list.emplace_back(sum.name, sum.value);
    return list;
  }

 private:
  struct Sum {
    std::string name;
    double value;
    int count;
  };
  std::vector<Sum> sums_;
  int count_ = 0;
};

}  // namespace

/// The problem with a number a little above or below.
struct Derivatives::Side {
  Side(const SceneNumber& number, double value, const Model& model, const RunOptions& options)
      : problem(number.at(value)) {
    Run ignored;
    RunOptions exact = options;
    exact.keep_snapshots = false;
    exact.statics.tolerance = std::min(exact.statics.tolerance, 1e-13);  // of what calibrates
    held = make_model(*problem.specimen, *problem.experiment, problem.choice, exact, ignored);
    const auto fail = [&](const std::string& why) { throw InputError("no derivative by " + number.key + ": " + why); };
    if (!held) fail(ignored.cause);
    const Body &body = held->model->body(), &own = model.body();
    if (body.size() != own.size() || body.connections.ends != own.connections.ends)
      fail("it changes which molecules there are, or what joins them");
    if (!std::equal(model.supports.begin(), model.supports.end(), held->model->supports.begin(),
                    held->model->supports.end(), [](const Support& a, const Support& b) {
                      return a.molecule == b.molecule && (a.free - b.free).norm() < kSameDirection;
                    }))
      fail("it changes which molecules are fixed, or in which directions");
  }
  StaticRig& rig() const { return *held->rig->at_rest(); }

  VariedProblem problem;
  std::optional<HeldModel> held;
};

struct Derivatives::Number {
  SceneNumber of;
  std::array<std::unique_ptr<Side>, 2> sides = {};  ///< p − h, p + h
  std::unique_ptr<Side> middle = {};                ///< p, of what calibrates: with the same tolerance as the sides
  Positions start = {}, start_reactions = {};       ///< what it changes of the start; empty: that is at rest
  /// Of what touches: p ∓ h and p ∓ h/2, h the step that was given.
  std::array<std::array<std::unique_ptr<Side>, 2>, 2> touching = {};
  double touching_step = of.step;

  void make_sides(const Model& model, const RunOptions& options) {
    for (const double sign : {-1., 1.})
      sides[sign > 0] = std::make_unique<Side>(of, of.value + sign * of.step, model, options);
    if (of.calibrated && !middle) middle = std::make_unique<Side>(of, of.value, model, options);
  }
  Positions forces_of(Side& side, const Positions& displaced, const State& like, double load_factor, bool linear) {
    Model& varied = *side.held->model;
    lab::set_load(varied, side.rig(), load_factor);
    return all_forces(varied, still(varied, varied.body().rest + displaced, like), linear);
  }

  /// What moves an equilibrium, over the change of the number: forces on molecules, and prescribed displacements.
  struct Change {
    Positions forces, displacement;
  };
  Change change(Model& model, const Tangent& tangent, const State& state, double load_factor,
                const RunOptions& options) {
    if (!sides[0]) make_sides(model, options);
    const bool linear = options.statics.linear;
    const Positions displaced = state.positions - model.body().rest;
    const Positions now =
        middle ? forces_of(*middle, displaced, state, load_factor, linear) : all_forces(model, state, linear);
    const double given = of.step;
    for (int larger = kLargerSteps, smaller = 1;;) {
      std::array<Positions, 2> forces, moved;
      for (int side = 0; side < 2; ++side) {
        forces[side] = forces_of(*sides[side], displaced, state, load_factor, linear);
        const Model& varied = *sides[side]->held->model;
        const Positions at = varied.body().rest + displaced;
        moved[side] = at;
        apply_supports(varied, moved[side]);
        moved[side] -= at;
      }
      const double rounding = std::max((of.calibrated ? kCalibratedRounding : kRounding) * now.norm(),
                                       kRoundedPositions * rounding_floor(tangent, state.positions));
      Positions difference = forces[1] - forces[0];
      const double bend = (forces[1] - 2 * now + forces[0]).norm() - rounding,
                   most = (of.calibrated ? kCalibratedBend : kBend) * difference.norm();
      // A number that changes little is changed more, as far as rounding hides what it does; not one that moves
      // supports, for a turn is no straight line.
      if (larger > 0 && moved[1] == moved[0] && difference.norm() > 0 && difference.norm() < kClear * rounding &&
          10 * of.step < std::abs(of.value)) {
        of.step *= 10, --larger;
        make_sides(model, options);
        continue;
      }
      if (smaller > 0 && bend > most && std::isfinite(bend)) {
        of.step *= std::max(most / bend, 1e-5), --smaller, larger = 0;
        make_sides(model, options);
        continue;
      }
      if (bend > kKink * difference.norm() && difference.norm() > 0)
        throw InputError("no derivative by " + of.key + ": the forces have a kink or a jump at this value of it");
      leave_out_rounding(model, rounding, difference);
      const Change found{difference / (2 * of.step), (moved[1] - moved[0]) / (2 * of.step)};
      // What is rounding after all says nothing of a step: what is measured may change more than forces here do.
      if (of.step > given && difference.norm() < kClear * rounding) {
        of.step = given;
        make_sides(model, options);
      }
      return found;
    }
  }

  void correct(Model& model, Responses& responses, const State& state, double load_factor, const RunOptions& options,
               double enough, StaticResponse& found);
  StaticResponse response(Model& model, Responses& responses, const State& state, double load_factor,
                          const RunOptions& options) {
    const Change by = change(model, responses.tangent(), state, load_factor, options);
    StaticResponse found = responses.to(by.forces, by.displacement, std::min(kTolerance, options.statics.tolerance));
    if (found.result.outcome != Outcome::converged && found.result.residual > kEnough)
      throw InputError("no derivative by " + of.key + " at this equilibrium: " + found.result.cause);
    return found;
  }
};

/// Contact yields by next to nothing: of forces, what a number changes and what the body's motion does nearly cancel,
/// and each of them alone goes beyond what is pressed in. Along both at once nothing is left of an exact motion: what
/// is left corrects this one. Measures are differenced along both, too, over h and h/2.
/// @param enough what may be left, of the forces that resist the motion
void Derivatives::Number::correct(Model& model, Responses& responses, const State& state, double load_factor,
                                  const RunOptions& options, double enough, StaticResponse& found) {
  for (int half = 0; half < (contact_of(model) ? 2 : 1); ++half)
    for (const int side : {0, 1}) {
      const double step = touching_step / (1 + half);
      std::unique_ptr<Side>& own = touching[half][side];
      if (!own) own = std::make_unique<Side>(of, of.value + (side ? step : -step), model, options);
      lab::set_load(*own->held->model, own->rig(), load_factor);
    }
  const Positions displaced = state.positions - model.body().rest, none = Positions::Zero(3, displaced.cols());
  Positions resisting(3, displaced.cols());
  for (int round = 0; round < kTouchingRounds; ++round) {
    const auto forces = [&](int side) {
      return forces_of(*touching[0][side], displaced + (side ? touching_step : -touching_step) * found.motion, state,
                       load_factor, options.statics.linear);
    };
    Positions left = (forces(1) - forces(0)) / (2 * touching_step);
    keep_free(model.supports, left);
    responses.tangent().apply(found.motion, resisting);
    if (!(left.norm() > enough * resisting.norm())) break;
    const StaticResponse more = responses.to(left, none, std::min(kTolerance, options.statics.tolerance));
    found.motion += more.motion, found.result.reactions += more.result.reactions;
    if (!(more.motion.norm() > kTouchingChange * found.motion.norm())) break;
  }
}

Derivatives::Derivatives(std::vector<SceneNumber> numbers) {
  for (SceneNumber& number : numbers) numbers_.push_back({std::move(number)});
}
Derivatives::~Derivatives() = default;

void Derivatives::check(const Specimen& specimen, const Experiment& experiment, const StrategyChoice& choice,
                        const RunOptions& options) const {
  const auto& contact = specimen.contact;
  const std::string why =
      identification_of(experiment)              ? "the experiment finds a material"
      : !options.restart.empty()                 ? "a run that goes on from a file does not know how it came there"
      : options.time && options.time->budget > 0 ? "time.budget: the steps depend on the clock"
      : options.statics.engine                   ? "solver.engine: they are taken by one process; write engine: threads"
      : contact && contact->friction > 0         ? "contact.friction: what slipped depends on the way there"
      : contact && contact->penetration > 0
          ? "contact.penetration: its multipliers depend on the way there; leave it out, or write a stiffness"
      : choice.name.calibrated && experiment.apparent() && !specimen.calibration && !specimen.references.empty()
          ? "'" + choice.label + "' is calibrated to a computed reference"
      : choice.name.fitted ? "'" + choice.label + "' is fitted by steps that end within a tolerance; write calibrated:"
                           : "";
  if (!why.empty()) throw InputError("no derivatives of these measures: " + why);
}

bool Derivatives::by_whole_runs(const Experiment& experiment, Rig& rig, const StrategyChoice& choice,
                                const Model& model, const RunOptions& options) {
  const StaticExperiment* at_rest = experiment.at_rest();
  // What touches the body begins where its surface is under preload, which changes with the numbers.
  const auto is_preloaded = [&] {
    model.measure_rest_force();
    return model.rest_force() > 0 || model.body().unstressed ||
           !model.load_forces(state_at_rest(model.body())).isZero(0);
  };
  return !at_rest || rig.at_rest()->seeks_load() || (rig.at_rest()->withdraw() && is_preloaded()) ||
         choice.name.softened ||  // what softens knows where it has been
         (!options.statics.linear && !model.has_full_tangent());
}

/// The run with another value of a number; it has to end as the run did.
Run Derivatives::run_at(const SceneNumber& number, double value, const RunOptions& options, const Run& run) {
  RunOptions own = options;
  own.derivatives = nullptr, own.keep_snapshots = false, own.checkpoint = {};
  own.statics.tolerance = std::min(own.statics.tolerance, 1e-13);
  const VariedProblem problem = number.at(value);
  own.time = problem.time;
  const bool even = run.time && std::abs(run.time->shortest_step - run.time->last_step) < 1e-9 * run.time->last_step;
  if (even && !number.key.starts_with("time."))  // steps that follow the number would make its differences uneven
    own.time->choice = StepChoice::fixed, own.time->step = run.time->last_step;
  Run varied = run_strategy(*problem.specimen, *problem.experiment, problem.choice, own);
  if (varied.outcome != Outcome::converged || varied.curve.size() != run.curve.size())
    throw InputError("no derivative by " + number.key + ": a little away from its value the run ends differently" +
                     (varied.cause.empty() ? "" : ": " + varied.cause));
  return varied;
}

void Derivatives::check_deviations(const std::vector<std::pair<std::string, double>>& deviations,
                                   const RunOptions& options, Run& run) const {
  for (const auto& [key, deviation] : deviations) {
    const auto own = std::find_if(numbers_.begin(), numbers_.end(),
                                  [&key = key](const Number& number) { return number.of.key == key; });
    if (own == numbers_.end()) continue;
    const std::string first_order = "deviations of measures are of first order, and " + key + " is uncertain by more: ";
    try {
      const Run low = run_at(own->of, own->of.value - deviation, options, run),
                high = run_at(own->of, own->of.value + deviation, options, run);
      std::string most;
      double unevenness = kUneven;
      for (const auto& [name, value] : run.measures.all()) {
        const double below = low.measures.get(name) - value, above = high.measures.get(name) - value;
        const double uneven = std::abs(above + below) / std::abs(above - below);
        if (!is_smooth(name) || !(std::abs(above - below) > kSeen * std::abs(value)) || !(uneven > unevenness))
          continue;
        unevenness = uneven;
        most = name + " changes by " + number(100 * below / std::abs(value), 3) + " and " +
               number(100 * above / std::abs(value), 3) + " %";
      }
      if (!most.empty()) run.warnings.push_back(first_order + "a deviation below and above its value " + most);
    } catch (const InputError&) {
      if (options.stop && options.stop()) return interrupt(run);
      run.warnings.push_back(first_order + "a deviation below or above its value the run ends differently");
    }
  }
}

void Derivatives::of_whole_runs(const RunOptions& options, Run& run) const {
  for (const Number& number : numbers_) {
    const SceneNumber& of = number.of;
    using Row = std::vector<std::pair<std::string, Slope>>;
    const auto slopes_over = [&](double step) {
      const auto at = [&](double times) { return run_at(of, of.value + times * step, options, run); };
      const Run low2 = at(-2), low = at(-1), high = at(1), high2 = at(2);
      const auto slopes = [&](const Measures& own, const auto& measures_of) {
        Row row;
        for (const auto& [name, value] : own.all()) {
          const auto value_of = [&, &name = name](const Run& one) { return measures_of(one).get(name); };
          const Slope slope = slope_of({value_of(low2), value_of(low), value_of(high), value_of(high2)}, step, 0,
                                       kInsensitive * std::abs(value / of.value));
          if (is_smooth(name) && std::isfinite(slope.value)) row.emplace_back(name, slope);
        }
        return row;
      };
      std::vector<Row> rows;
      for (std::size_t i = 0; i < run.curve.size(); ++i)
        rows.push_back(slopes(
            run.curve[i].measures, [i](const Run& one) -> auto& { return one.curve[i].measures; }));
      rows.push_back(slopes(
          run.measures, [](const Run& one) -> auto& { return one.measures; }));
      return rows;
    };
    const double step = kWholeStep * std::max(std::abs(of.value), of.step / kWholeStep);
    const std::vector<Row> rows = slopes_over(step);
    std::optional<std::vector<Row>> finer;
    const auto doubted = [](const Row& row) {
      return std::any_of(row.begin(), row.end(), [](const auto& one) { return one.second.doubt > kDoubtful; });
    };
    if (std::any_of(rows.begin(), rows.end(), doubted)) finer = slopes_over(step / 10);
    std::string without;
    for (std::size_t i = 0; i < rows.size(); ++i)
      for (std::size_t j = 0; j < rows[i].size(); ++j) {
        const auto& [name, first] = rows[i][j];
        const bool takes_finer =
            finer && (*finer)[i].size() == rows[i].size() && (*finer)[i][j].second.doubt < first.doubt;
        const Slope best = takes_finer ? (*finer)[i][j].second : first;
        const bool last = i + 1 == rows.size();
        if (best.doubt < kDoubtful)
          put_gradient(last ? run.gradients : run.curve[i].gradients, name, of.key, best.value);
        else if (last)
          without += (without.empty() ? "" : ", ") + name;
      }
    if (!without.empty()) run.warnings.push_back(doubts_text(of.key, without));
  }
}

void Derivatives::start(Model& model, const StaticRig&, const Start& start, const RunOptions& options) {
  if (start.positions == model.body().rest && start.reactions.isZero(0)) return;
  const State state = still(model, start.positions, {});
  const State about = options.statics.linear ? still(model, model.body().rest, {}) : state;
  Responses responses(model, about, options.statics);
  for (Number& number : numbers_) {
    StaticResponse found = number.response(model, responses, state, 0, options);
    // A body that grows freely is without stress all along, at the corners of its law.
    if (model.body().unstressed) number.correct(model, responses, state, 0, options, kStartForces, found);
    number.start = std::move(found.motion), number.start_reactions = std::move(found.result.reactions);
  }
}

Gradients Derivatives::at(Model& model, const StaticExperiment& experiment, const StaticRig& rig, const Start& start,
                          const State& reached, const StaticResult& solved, double load_factor, bool last,
                          const RunOptions& options, LastSolve& left) {
  const State state = still(model, reached.positions, reached);
  const State about = options.statics.linear ? still(model, model.body().rest, reached) : state;
  Responses responses(model, about, options.statics, &left);
  RunOptions exact = options;
  exact.statics.tolerance = std::min(exact.statics.tolerance, 1e-13);
  const auto read = [&](Model& its, const StaticExperiment& of, const StaticRig& by, const Start& from,
                        const StaticResponse& motion, double step) {
    const State at = still(its, its.body().rest + (state.positions - model.body().rest) + step * motion.motion, state);
    its.begin_step(at, std::numeric_limits<double>::infinity());
    StaticResult balanced = solved;
    balanced.reactions += step * motion.result.reactions;
    std::optional<contact::ContactReport> ignored;
    Measures measures = measure_step(its, of, by, from, at, exact, balanced, ignored);
    int iterations = 0;
    if (last && its.has_full_tangent()) by.measure_end(at, exact.statics, measures, iterations);
    return measures;
  };
  Measures now;
  if (contact_of(model)) {
    StaticResponse still_there;
    still_there.motion = Positions::Zero(3, state.positions.cols());
    still_there.result.reactions = Positions::Zero(3, solved.reactions.cols());
    now = read(model, experiment, rig, start, still_there, 0);
  }
  Gradients gradients;
  for (Number& number : numbers_) {
    StaticResponse found = number.response(model, responses, state, load_factor, options);
    if (found.result.outcome == Outcome::interrupted) return {};
    if (contact_of(model)) {
      number.correct(model, responses, state, load_factor, options, 0, found);
      std::array<Slopes, 2> over;
      for (const int half : {0, 1})
        for (const int side : {0, 1}) {
          const Side& varied = *number.touching[half][side];
          Model& its = *varied.held->model;
          const double step = (side ? 1 : -1) * number.touching_step / (1 + half);
          Start from{its.body().rest + (start.positions - model.body().rest), start.reactions};
          if (number.start.size() > 0)
            from.positions += step * number.start, from.reactions += step * number.start_reactions;
          over[half].add(read(its, *varied.problem.experiment->at_rest(), varied.rig(), from, found, step), 0.5 / step);
        }
      const auto whole = over[0].taken(), halved = over[1].taken();
      for (std::size_t i = 0; i < whole.size() && i < halved.size(); ++i) {
        const auto& [name, value] = whole[i];
        if (!is_smooth(name) || halved[i].first != name) continue;
        const double least = kInsensitive * std::abs(now.get(name) / number.of.value);
        if (std::abs(value - halved[i].second) <= kTouchingDoubt * std::max(std::abs(value), least))
          put_gradient(gradients, name, number.of.key, value);
        else
          doubts_.push_back("no derivative by " + number.of.key + " of " + name +
                            ": over a step of half the size it is another, for contact begins, ends or slides there");
      }
      continue;
    }
    const Positions displaced = state.positions - model.body().rest;
    const double size = std::max({relative(found.motion, displaced), relative(number.start, displaced),
                                  relative(found.result.reactions, solved.reactions),
                                  relative(number.start_reactions, solved.reactions)}),
                 step = size > 0 ? kMotion / size : 0;
    const auto along = [&](double one) {
      std::array<Measures, 4> measures;
      for (std::size_t i = 0; i < 4; ++i) {
        const double moved = one * std::array{-2, -1, 1, 2}[i];
        Start from = start;
        if (number.start.size() > 0)
          from.positions += moved * number.start, from.reactions += moved * number.start_reactions;
        measures[i] = read(model, experiment, rig, from, found, moved);
      }
      return measures;
    };
    std::optional<std::array<Measures, 4>> moved, nearer;
    if (step > 0) moved = along(step);
    Slopes slopes;
    for (const int side : {0, 1}) {
      const Side& varied = *number.sides[side];
      Model& its = *varied.held->model;
      const Start from{its.body().rest + (start.positions - model.body().rest), start.reactions};
      slopes.add(read(its, *varied.problem.experiment->at_rest(), varied.rig(), from, found, 0),
                 (side ? 0.5 : -0.5) / number.of.step);
    }
    std::string without;
    for (const auto& [name, value] : slopes.taken()) {
      if (!is_smooth(name)) continue;
      Slope slope{0, 0};
      if (moved) {
        slope = slope_along(*moved, name, step, value, number.of.value);
        if (slope.doubt > kDoubtful) {
          if (!nearer) nearer = along(kShorter * step);
          const Slope other = slope_along(*nearer, name, kShorter * step, value, number.of.value);
          if (other.doubt < slope.doubt) slope = other;
        }
      }
      if (slope.doubt > kDoubtful)
        without += (without.empty() ? "" : ", ") + name;
      else if (std::isfinite(slope.value))
        put_gradient(gradients, name, number.of.key, value + slope.value);
    }
    if (!without.empty()) doubts_.push_back(doubts_text(number.of.key, without));
    if (!model.body().unstressed || number.start.size() == 0) continue;
    // The energy before the load, along the start's own motion: a body that grows freely has none all along, and what a
    // difference at fixed positions is off would be more than a small load adds.
    double slope = gradient_of(gradients, "energy_increase", number.of.key);
    for (const int side : {0, 1}) {
      const Side& varied = *number.sides[side];
      Model& its = *varied.held->model;
      const double moved_by = (side ? 1 : -1) * number.of.step;
      const Start from{its.body().rest + (start.positions - model.body().rest) + moved_by * number.start,
                       start.reactions};
      const Measures whole = read(its, *varied.problem.experiment->at_rest(), varied.rig(), from, found, 0);
      slope += 0.5 / moved_by * (whole.get("energy") - whole.get("energy_increase"));
    }
    if (double* energy = find_gradient(gradients, "energy", number.of.key); energy && std::isfinite(slope))
      *energy = slope;
  }
  return gradients;
}

void Derivatives::add_curve_error(const MeasureList& list, Run& run) const {
  const std::string strain = list.named(MeasureRole::strain), stress = list.named(MeasureRole::stress);
  const auto given = [](const CurvePoint& point) { return point.measures.get("material_stress"); };
  const auto off = [&](const CurvePoint& point) { return point.measures.get(stress) - given(point); };
  const auto largest = [&](const auto& what) -> CurvePoint& {
    return *std::max_element(run.curve.begin(), run.curve.end(), [&](const CurvePoint& a, const CurvePoint& b) {
      return std::abs(what(a)) < std::abs(what(b));
    });
  };
  CurvePoint &worst = largest(off), &highest = largest(given);
  if (!(std::abs(off(worst)) > kFollows * std::abs(given(highest)))) return;
  for (const Number& number : numbers_) {
    const std::string& key = number.of.key;
    const double step = number.of.step;
    if (!number.sides[0]) continue;  // it was stopped
    const auto slope_of_given = [&](CurvePoint& point) {
      std::array<double, 2> at{};
      for (const int side : {0, 1}) {
        const VariedProblem& problem = number.sides[side]->problem;
        const double moved = (side ? step : -step) * gradient_of(point.gradients, strain, key);
        at[side] = uniaxial_stress(problem.specimen->material, *problem.experiment->at_rest()->axis(),
                                   point.measures.get(strain) + moved)
                       .value_or(std::numeric_limits<double>::quiet_NaN());
      }
      return (at[1] - at[0]) / (2 * step);
    };
    const double scale = given(highest), error = off(worst) / scale,
                 slope = (gradient_of(worst.gradients, stress, key) - slope_of_given(worst) -
                          error * slope_of_given(highest)) /
                         scale;
    if (std::isfinite(slope)) put_gradient(run.gradients, "curve_error", key, error < 0 ? -slope : slope);
  }
}

void interrupt(Run& run) {
  run.outcome = Outcome::interrupted, run.suited = true;
  run.cause = "stopped before all of its measures were known";
  run.gradients.clear();
  for (CurvePoint& point : run.curve) point.gradients.clear();
}

void add_mean_gradient(const std::vector<CurvePoint>& curve, const std::string& measure, const std::string& mean,
                       Gradients& gradients) {
  std::vector<std::pair<std::string, double>> sum;
  for (const CurvePoint& point : curve)
    for (const auto& [name, slopes] : point.gradients) {
      if (name != measure) continue;
      if (sum.empty())
        sum = slopes;
      else
        for (std::size_t i = 0; i < slopes.size() && i < sum.size(); ++i) sum[i].second += slopes[i].second;
    }
  for (auto& [key, value] : sum) value /= static_cast<double>(curve.size());
  if (!sum.empty()) gradients.emplace_back(mean, std::move(sum));
}

}  // namespace elastin::lab
