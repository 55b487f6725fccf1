#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>

#include "elastin/core/base/error.h"
#include "elastin/core/forces/floor.h"
#include "lab/experiment/motion/motion.h"
#include "lab/scene/parts.h"
#include "lab/scene/pick.h"

namespace elastin::lab {
namespace {

/// Fails where a key is a parameter of other schemes than the one chosen.
void refuse_others(Reader& reader, const elastin::Table<Stepper>& steppers, const Stepper& chosen) {
  const auto has = [](const Stepper& stepper, const std::string& key) {
    return std::any_of(stepper.parameters.begin(), stepper.parameters.end(),
                       [&](const ParameterInfo& info) { return info.name == key; });
  };
  for (const std::string& key : reader.keys()) {
    if (has(chosen, key)) continue;
    std::string owners;
    int count = 0;
    for (const auto& stepper : steppers)
      if (has(*stepper, key)) owners += (count++ ? ", " : "") + stepper->name;
    if (count > 0) reader.at(key).fail("only " + owners + (count > 1 ? " have this" : " has this"));
  }
}

void read_step(Reader reader, TimeOptions& options) {
  if (reader.is_map()) {
    if (auto count = reader.find("per_frame")) {
      options.choice = StepChoice::per_frame;
      options.steps_per_frame = count->whole(1, 1000000);
      reader.finish();
      return;
    }
    options.choice = StepChoice::by_error;
    if (auto error = reader.find("error")) options.error = error->quantity(dimension::none, kPositive);
    if (auto smallest = reader.find("smallest")) options.smallest = smallest->quantity(dimension::time, kPositive);
    if (auto largest = reader.find("largest")) options.largest = largest->quantity(dimension::time, kPositive);
    reader.finish();
    if (options.largest < options.smallest) reader.fail("the largest step must not be below the smallest");
  } else if (reader.text() != "automatic") {
    options.choice = StepChoice::fixed;
    options.step = reader.quantity(dimension::time, kPositive);
  }
}

/// Uniform in −1 … 1: the same on every machine.
double uniform(std::mt19937_64& generator) { return 2 * static_cast<double>(generator() >> 11) * 0x1p-53 - 1; }

void read_budget(const Reader& reader, const elastin::Table<Stepper>& steppers, TimeOptions& options) {
  options.budget = reader.quantity(dimension::time, kPositive);
  if (!options.scheme || (*options.scheme)->effort.empty()) {
    std::string able;
    for (const auto& stepper : steppers)
      if (!stepper->effort.empty()) able += (able.empty() ? "" : ", ") + stepper->name;
    reader.fail("chooses how many sweeps or iterations a step gets: write `integrator:` with one of " + able);
  }
  if (options.choice != StepChoice::fixed) reader.fail("needs steps of one length: write `step: 1 ms` or another");
  if (options.checkpoint) reader.fail("the clock decides: a run that goes on from a checkpoint would take other steps");
}

}  // namespace

void read_integrator(Reader reader, const elastin::Table<Stepper>& steppers, TimeOptions& options) {
  const auto named = [&](const Reader& name) { return name.located([&] { return steppers.find(name.text()); }); };
  if (reader.is_text()) {
    options.scheme = named(reader);
    return;
  }
  const auto scheme = named(reader.at("scheme"));
  options.scheme = scheme;
  refuse_others(reader, steppers, *scheme);
  for (const ParameterInfo& info : scheme->parameters)
    if (auto value = reader.find(info.name)) options.parameters[info.name] = read_parameter(*value, info);
  reader.finish();
}

TimeOptions read_time(Reader reader, const elastin::Table<Stepper>& steppers) {
  TimeOptions options;
  options.duration = reader.at("duration").quantity(dimension::time, kPositive);
  if (auto integrator = reader.find("integrator")) read_integrator(*integrator, steppers, options);
  if (auto step = reader.find("step")) read_step(*step, options);
  if (auto frames = reader.find("frames")) options.frames = frames->whole(1, 1000000);
  if (auto first = reader.find("first_frame")) {
    options.first_frame = first->quantity(dimension::time, kPositive);
    if (!(options.first_frame < options.duration) || options.frames < 2)
      first->fail("must be shorter than the duration, and there must be at least 2 frames");
  }
  if (auto rate = reader.find("frame_rate")) options.frame_rate = rate->quantity({0, 0, -1}, kPositive);
  if (auto checkpoint = reader.find("checkpoint")) options.checkpoint = checkpoint->whole(1, 1000000);
  if (auto budget = reader.find("budget")) read_budget(*budget, steppers, options);
  reader.finish();
  return options;
}

std::function<void(State&)> read_initial(Reader reader, const Body& body, const Matrix3& rotation, bool timed) {
  Matrix3 stretch = Matrix3::Identity(), turn = stretch;
  Vector3 velocity = Vector3::Zero(), spin = velocity, move = velocity;
  double scatter = 0;
  int seed = 1;
  std::vector<int> molecules;
  std::vector<std::pair<int, Vector3>> thrown;
  if (auto value = reader.find("velocity")) velocity = rotation * value->vector(dimension::velocity);
  if (auto value = reader.find("throw"))
    for (Reader item : value->items()) {
      const Vector3 speed = rotation * item.at("velocity").vector(dimension::velocity);
      for (const int molecule : read_molecules(item.at("molecules"), body, rotation))
        thrown.emplace_back(molecule, speed);
      item.finish();
    }
  if (auto value = reader.find("spin")) spin = rotation * value->vector({0, 0, -1});
  if (!timed && (velocity.norm() > 0 || spin.norm() > 0 || !thrown.empty()))
    reader.fail("an experiment at rest has no velocities");
  if (auto value = reader.find("stretch"))
    stretch = rotation * value->vector(dimension::none).asDiagonal() * rotation.transpose();
  if (auto value = reader.find("turn")) turn = rotation * value->rotation() * rotation.transpose();
  if (auto value = reader.find("scatter")) {
    Reader map = *value;
    scatter = map.at("amount").quantity(dimension::length, kPositive);
    if (auto given = map.find("seed")) seed = given->whole(0);
    map.finish();
  }
  if (auto value = reader.find("move")) {
    Reader map = *value;
    molecules = read_molecules(map.at("molecules"), body, rotation);
    move = rotation * map.at("by").vector(dimension::length);
    map.finish();
  }
  reader.finish();
  return [=](State& state) {
    const Vector3 middle = state.positions.rowwise().mean();
    state.positions = (turn * stretch * (state.positions.colwise() - middle)).colwise() + middle;
    std::mt19937_64 generator(static_cast<std::uint64_t>(seed));
    if (scatter > 0)
      for (double& coordinate : state.positions.reshaped()) coordinate += scatter * uniform(generator);
    for (const int molecule : molecules) state.positions.col(molecule) += move;
    for (Eigen::Index i = 0; i < state.positions.cols(); ++i)
      state.velocities.col(i) += velocity + spin.cross(Vector3(state.positions.col(i) - middle));
    for (const auto& [molecule, speed] : thrown) state.velocities.col(molecule) += speed;
  };
}

std::vector<KeySection> time_keys(const Catalog& catalog) {
  std::vector<SceneKey> keys{
      {"duration", "quantity", "s", "> 0", "needed", "time that the run covers"},
      {"integrator", "word, or map", "", "", "`velocity_verlet` for springs, `newmark` for cells",
       words_text(catalog.steppers.names())},
      {"integrator.scheme", "word", "", "", "needed in the map", "name of the integrator"}};
  for (const auto& stepper : catalog.steppers)
    for (const ParameterInfo& info : stepper->parameters) {
      const std::string name = "integrator." + info.name, of = "of `" + stepper->name + "`";
      const auto same = std::find_if(keys.begin(), keys.end(), [&](const SceneKey& key) { return key.name == name; });
      if (same != keys.end()) {  // one parameter of several integrators
        same->text.insert(same->text.find(": "), ", `" + stepper->name + "`");
        continue;
      }
      keys.push_back(key_of(info, "integrator."));
      keys.back().text = of + ": " + info.text;
    }
  const std::vector<SceneKey> rest{
      {"step", "quantity, `automatic`, or map", "s", "> 0", "`automatic`",
       "explicit: 0.8 of the longest stable step, checked as the body stiffens; implicit: by error"},
      {"step.error", "number", "", "> 0", "1e-4", "error of a step in position, over the body's size"},
      {"step.smallest", "quantity", "s", "> 0", "none", "shortest step by error"},
      {"step.largest", "quantity", "s", "> 0", "none", "longest step by error, not below `smallest`"},
      {"step.per_frame", "whole", "", "1 … 1000000", "none",
       "instead of these: so many steps of equal length in each frame, longer where frames are"},
      {"frames", "whole", "", "1 … 1000000", "100", "points of the time history and snapshots, at equal times"},
      {"first_frame", "quantity", "s", "> 0", "none",
       "end of the first frame; the ends of the others are a geometric sequence up to the duration: decades of time"},
      {"frame_rate", "quantity", "1/s", "> 0", "250", "most frames a second with `--live`"},
      {"checkpoint", "whole", "", "1 … 1000000", "none", "frames between restart files; Ctrl-C leaves one too"},
      {"budget", "quantity", "s", "> 0", "none",
       "by the clock, for a step of fixed length: an integrator with sweeps or iterations gets as many as there is "
       "time "
       "for; what so few leave is measured at the frames. Not with `checkpoint`"}};
  keys.insert(keys.end(), rest.begin(), rest.end());
  return {{"time", "Time", "", std::move(keys)}};
}

std::vector<KeySection> initial_keys() {
  return {
      {"initial",
       "Initial state",
       "Velocities are of experiments in time only.",
       {{"velocity", "vector", "m/s", "", "0", "velocity of the body"},
        {"spin", "vector", "1/s", "", "0", "rotation of the body about its middle"},
        {"throw", "list of maps", "", "", "none", "velocities of some molecules"},
        {"throw.molecules", "list of molecules, or [pick](#picked-molecules)", "", "0 … last molecule", "needed",
         "which molecules"},
        {"throw.velocity", "vector", "m/s", "", "needed", "their velocity"},
        {"stretch", "vector", "", "", "1",
         "factors along x, y, z about the middle; 0 flattens, negative values mirror"},
        {"turn", "rotation", "", "", "none", "rotation about the middle"},
        {"scatter.amount", "quantity", "m", "> 0", "needed", "random displacement of each molecule in each direction"},
        {"scatter.seed", "whole", "", "≥ 0", "1", "seed of the random numbers"},
        {"move.molecules", "list of molecules, or [pick](#picked-molecules)", "", "0 … last molecule", "needed",
         "which molecules are displaced"},
        {"move.by", "vector", "m", "", "needed", "their displacement"}}}};
}

}  // namespace elastin::lab
