#include "lab/run/step_control.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <map>
#include <sstream>
#include <string_view>

#include "core/base/archive.h"
#include "core/base/stopwatch.h"
#include "core/model/visit_state.h"
#include "core/solve/stable_step.h"
#include "core/solve/steppers.h"
#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"
#include "elastin/core/model/share.h"

namespace elastin::lab {

namespace {

ParameterValues values_of(const StepperMethod& method, const TimeOptions& options) {
  if (method->effort.empty())
    throw InputError("a budget chooses a number of sweeps or iterations, and '" + std::string(method->name) +
                     "' takes none");
  return complete_values(method->name, method->parameters, options.parameters);
}

int parts_of(const ParameterValues& values) {
  const auto own = values.find("substeps");
  return own == values.end() ? 1 : static_cast<int>(own->second);
}

}  // namespace

PacedSteps::PacedSteps(Stepper& stepper, const StepperMethod& method, const TimeOptions& options,
                       const StaticOptions& newton)
    : stepper_(stepper),
      converged_(make_stepper({"backward_euler", {}, newton})),
      parts_(parts_of(values_of(method, options))),
      seconds_(options.budget),
      name_(method->effort) {
  set_effort(std::max(1, static_cast<int>(values_of(method, options).at(method->effort))));
}

void PacedSteps::set_effort(int effort) {
  effort_ = effort;
  dynamic_cast<HasEffort&>(stepper_).set_effort(effort);
}

StepResult PacedSteps::advance(Model& model, State& state, double dt) {
  const Stopwatch watch;
  set_effort(budget_.next(seconds_, effort_));
  const StepResult result = stepper_.advance(model, state, dt);
  const double took = watch.seconds();
  budget_.took(took, effort_);
  efforts_.push_back(effort_);
  times_.push_back(took);
  return result;
}

void PacedSteps::look(Model& model, const State& state, double dt) {
  const auto reached = [&](Stepper& stepper, int parts) {
    State tried = state;
    bool went = true;
    for (int part = 0; part < parts && went; ++part)
      went = stepper.advance(model, tried, dt / parts).outcome == Outcome::converged;
    model.begin_step(state, state.time);
    if (model.drive) model.drive(state.time, model.supports);
    return went ? tried.positions : Positions();
  };
  const Positions own = reached(stepper_, 1), balance = reached(*converged_, parts_);
  if (own.size() == 0 || balance.size() == 0) return;
  error_ = std::max(error_, (own - balance).colwise().norm().maxCoeff());
  motion_ = std::max(motion_, (balance - state.positions).colwise().norm().maxCoeff());
}

BudgetReport PacedSteps::report() const {
  BudgetReport report;
  report.budget = seconds_;
  report.effort = name_;
  if (efforts_.empty()) return report;
  std::vector<int> efforts = efforts_;
  std::vector<double> times = times_;
  std::sort(efforts.begin(), efforts.end());
  std::sort(times.begin(), times.end());
  report.least = efforts.front(), report.median = efforts[efforts.size() / 2], report.most = efforts.back();
  report.median_seconds = times[times.size() / 2], report.longest_seconds = times.back();
  const auto late = times.end() - std::upper_bound(times.begin(), times.end(), seconds_);
  report.late = static_cast<double>(late) / static_cast<double>(times.size());
  report.iteration_error = error_, report.motion = motion_;
  return report;
}

namespace {

constexpr double kSafety = 0.8;   ///< of the longest stable step: room for a body that stiffens between two looks
constexpr int kWatchEvery = 100;  ///< steps
/// How many times the largest motion counts as the size against which the error of a step is: with an error of 1e-4 a
/// vibration gets 27 steps a period, and its frequency right to 0.5 %.
constexpr double kMotions = 10;
constexpr double kLeastMotion = 1e-5;  ///< of the size: below it a body is at rest, but for rounding

double size_of(const Body& body) {
  const auto [low, high] = outline_of_whole(body);
  return (high - low).norm();
}

}  // namespace

StepControl::StepControl(Model& model, const State& start, const TimeOptions& options, const StepperMethod& method,
                         const StaticOptions& newton)
    : options_(options), size_(size_of(model.body())) {
  stepper_ = make_stepper({method, options.parameters, newton});
  order_ = method->order;
  if (options.budget > 0) paced_.emplace(*stepper_, method, options, newton);
  const bool automatic = options.choice == StepChoice::automatic;
  by_error_ = options.choice == StepChoice::by_error || (automatic && !method->is_explicit);
  watched_ = method->is_explicit && options.choice != StepChoice::fixed;
  memory.wanted = options.choice == StepChoice::fixed ? options.step : options.time_of(1);
  memory.stable = std::numeric_limits<double>::infinity();
  if (method->is_explicit) {
    const StableStep found = explained_stable_step(model, start);
    memory.critical = found.step;
    memory.frequency = found.frequency;
    if (auto* shared = dynamic_cast<SharedStep*>(stepper_.get()))
      shared->set_own(found.frequency * found.frequency, found.damping_rate);
    if (watched_) {
      memory.stable = kSafety * found.step;
      memory.first_bound = found.bound;
    }
  }
  if (by_error_) memory.wanted = std::min(options.largest, memory.wanted / 8);
  if (by_error_) start_ = start.positions;
  longest_ = std::numeric_limits<double>::infinity();
  if (options.choice == StepChoice::fixed || options.choice == StepChoice::per_frame) options_.follows.clear();
  for (const TimeFunction& function : options_.follows) longest_ = std::min(longest_, function.longest_step());
}

/// A body that stiffens as it moves takes shorter steps; the row sums say by how much, in one pass.
void StepControl::watch(Model& model, const State& state) {
  if (!watched_ || memory.steps % kWatchEvery != 0 || memory.steps == 0) return;
  const double bound = frequency_bound(model, state);
  if (std::isfinite(memory.critical) && bound > 0)
    memory.stable = std::min(memory.stable, kSafety * memory.critical * std::min(1., memory.first_bound / bound));
}

/// Of the body's size, or where all motion is small of that: what swings then has the same frequency whatever its
/// amplitude. [m]
double StepControl::error_limit(double motion) const {
  if (!options_.resolves_motion) return options_.error * size_;
  return options_.error * std::clamp(kMotions * motion, kLeastMotion * size_, size_);
}

StepResult StepControl::one_step(Model& model, State& state, double until) {
  watch(model, state);
  double end = until;
  for (const TimeFunction& function : options_.follows) end = std::min(end, function.next_corner(state.time));
  while (true) {
    const double left = end - state.time;
    double step = std::min({memory.wanted, memory.stable, longest_});
    if (by_error_) step = std::max(step, options_.smallest);
    // The rest of the frame's time in equal steps; a step that rounding alone makes is left out.
    const double count = std::max(1., std::ceil(left / step * (1 - 1e-9)));
    const double dt = left / count;
    if (!(state.time + dt > state.time))
      return {Outcome::diverged, "the step has become too short for the clock", 0, 0, 1, 0};
    const State before = by_error_ ? state : State{};
    memory.last = dt;
    StepResult result = paced_ ? paced_->advance(model, state, dt) : stepper_->advance(model, state, dt);
    if (result.outcome != Outcome::converged) return result;
    if (by_error_) {
      const double farthest = std::sqrt((state.positions - start_).colwise().squaredNorm().maxCoeff());
      const double motion = std::max(memory.motion, largest_over(model.body(), farthest));
      const double ratio = result.error / error_limit(motion);
      const double change =
          ratio > 0 ? 0.9 * std::pow(ratio, -1 / (order_ + 1)) : std::numeric_limits<double>::infinity();
      const bool can_shorten = dt > options_.smallest * (1 + 1e-9) && result.substeps <= 1;
      // Up to what was wanted before at once: a frame or a corner may have cut this step alone.
      memory.wanted = std::min(options_.largest, dt * std::clamp(change, 0.2, std::max(2., memory.wanted / dt)));
      if (ratio > 1 && can_shorten) {
        state = before;
        if (model.drive) model.drive(state.time, model.supports);
        ++memory.rejected;
        continue;
      }
      memory.motion = motion;
    }
    if (count == 1) {
      state.time = end;
      if (model.drive) model.drive(end, model.supports);
    }
    ++memory.steps;
    memory.shortest = memory.shortest > 0 ? std::min(memory.shortest, dt) : dt;
    return result;
  }
}

namespace {

constexpr std::string_view kName = "elastin-restart-";
constexpr const char* kHead = "elastin-restart-10";  // another format, or another meaning of a number, counts on
constexpr std::string_view kEnd = "\nend\n";
constexpr const char* kFrame = "frame";    ///< what it calls the time of a frame [s]
constexpr std::string_view kHash = "#";    ///< begins what is too long to be shown
constexpr std::size_t kLongestShown = 80;  ///< characters

/// As one word that `from_word` reads.
std::string as_word(const std::string& text) {
  std::string word;
  for (const char c : text) {
    char escaped[8];
    std::snprintf(escaped, sizeof escaped, "%%%02x", static_cast<unsigned char>(c));
    word += std::isgraph(static_cast<unsigned char>(c)) && !std::strchr("%,=", c) ? std::string(1, c) : escaped;
  }
  return word;
}

std::string from_word(const std::string& word) {
  std::string text;
  for (std::size_t i = 0; i < word.size(); ++i) {
    const bool escaped = word[i] == '%' && i + 2 < word.size();
    text += escaped ? static_cast<char>(std::strtol(word.substr(i + 1, 2).c_str(), nullptr, 16)) : word[i];
    if (escaped) i += 2;
  }
  return text;
}

/// "name=value,…" as pairs, in order of name.
std::map<std::string, std::string> parts_of_identity(const std::string& identity) {
  std::map<std::string, std::string> parts;
  std::istringstream stream(identity);
  for (std::string part; std::getline(stream, part, ',');) {
    const std::size_t equals = std::min(part.find('='), part.size());
    parts[part.substr(0, equals)] += part.substr(std::min(equals + 1, part.size()));
  }
  return parts;
}

/// What of a restart file is not of the run that reads it.
std::string differences(const std::string& file, const std::string& run) {
  std::map<std::string, std::string> there = parts_of_identity(file), here = parts_of_identity(run);
  const auto value = [](const std::map<std::string, std::string>& parts, const std::string& name) {
    const auto found = parts.find(name);
    return found == parts.end() ? std::string("not there") : from_word(found->second);
  };
  std::map<std::string, std::string> all = there;
  all.insert(here.begin(), here.end());
  std::string text;
  for (const auto& [name, either] : all) {
    const std::string its = value(there, name), own = value(here, name);
    if (its == own) continue;
    text += text.empty() ? "" : "; ";
    if (name == kFrame)
      text += "it has a frame every " + number(std::atof(its.c_str()), 6) + " s, and this run every " +
              number(std::atof(own.c_str()), 6) + " s: change `time.frames` together with `time.duration`";
    else if (its.starts_with(kHash) || own.starts_with(kHash))
      text += "its " + name + " is another one";
    else
      text += "its " + name + " is " + its + ", here " + own;
  }
  return text.empty() ? "it is of " + file + ", here runs " + run : text;
}

std::string hex(std::uint64_t value) {
  char text[32];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(value));
  return text;
}

}  // namespace

template <class Archive>
void visit(Archive& archive, Measures& measures) {
  auto all = measures.all();
  visit(archive, all);
  if constexpr (Archive::reads)
    for (const auto& [name, value] : all) measures.set(name, value);
}

inline auto members(CurvePoint& row) {
  return std::tie(row.load_factor, row.residual, row.time, row.step, row.newton_iterations, row.linear_iterations,
                  row.steps, row.measures);
}
inline auto members(RestartPoint& point) {
  auto& m = point.memory;
  return std::tie(point.frame, m.steps, m.rejected, point.newton_iterations, point.linear_iterations, point.dissipated,
                  point.work, point.taken, point.jumps, m.wanted, m.first_bound, m.stable, m.critical, m.frequency,
                  m.shortest, m.last, m.motion, point.state, point.curve, point.history);
}

std::string restart_text(const RestartPoint& point, const std::string& identity) {
  TextWriter writer;
  RestartPoint copy = point;
  visit(writer, copy);
  const std::string& body = writer.text();
  return std::string(kHead) + " " + identity + " " + hex(checksum(body.data(), body.size())) + "\n" + body +
         std::string(kEnd);
}

RestartPoint parse_restart(const std::string& text, const std::string& identity, const std::string& path) {
  const std::string what = "the restart file";
  const std::size_t line = text.find('\n');
  std::string head, of, sum;
  TextReader first(text.substr(0, line), what, {path, 1, 1});
  if (!text.starts_with(kName)) first.fail("this is no restart file");
  first.word(head);
  if (head != kHead)
    first.fail("this restart file is of another version of the program ('" + head.substr(0, 40) + "', here '" + kHead +
               "'), whose numbers mean something else: run the scene from its start");
  first.word(of);
  if (of != identity)
    first.fail("this is the restart file of another run: " + differences(of, identity) +
               "; of the scene only how long it runs, and what is looked at, may be another");
  first.word(sum);
  if (line == std::string::npos || text.size() < line + 1 + kEnd.size() || !text.ends_with(kEnd)) {
    TextReader whole(text, what, {path, 1, 1});
    for (std::string word; true;) whole.word(word);  // fails at the end
  }
  const std::string body = text.substr(line + 1, text.size() - line - 1 - kEnd.size());
  if (hex(checksum(body.data(), body.size())) != sum) first.fail(what + " is damaged: its checksum does not hold");
  TextReader reader(body, what, {path, 2, 1});
  RestartPoint point;
  visit(reader, point);
  return point;
}

std::string restart_identity(const Body& body, const std::string& problem, const std::string& strategy,
                             const TimeOptions& options, const std::string& method) {
  std::uint64_t hash = checksum(nullptr, 0);
  const auto add = [&](const void* data, std::size_t size) { hash = checksum(data, size, hash); };
  add(body.rest.data(), sizeof(double) * static_cast<std::size_t>(body.rest.size()));
  add(body.mass.data(), sizeof(double) * static_cast<std::size_t>(body.mass.size()));
  add(body.connections.ends.data(), sizeof(int) * 2 * body.connections.ends.size());
  std::string identity = "strategy=" + as_word(strategy) + ",stepper=" + as_word(method) + "," + kFrame + "=" +
                         number(options.time_of(1), 12) + ",body=" + std::string(kHash) + hex(hash);
  if (options.first_frame > 0) identity += ",duration=" + number(options.duration, 12);
  // "small" or "large", then a line a key: see Scene::problem.
  std::istringstream lines(problem);
  std::string key = "displacements", content;
  const auto end_key = [&] {
    const bool is_long = content.size() > kLongestShown;
    identity += "," + as_word(key) + "=" +
                (is_long ? std::string(kHash) + hex(checksum(content.data(), content.size())) : as_word(content));
  };
  for (std::string line; std::getline(lines, line);) {
    const std::size_t colon = line.find(": ");
    const bool begins = !content.empty() && colon != std::string::npos &&
                        line.find_first_not_of("abcdefghijklmnopqrstuvwxyz_") == colon;
    if (begins) end_key(), key = line.substr(0, colon), content.clear();
    content += begins ? line.substr(colon + 2) : line;
  }
  end_key();
  return identity;
}

}  // namespace elastin::lab
