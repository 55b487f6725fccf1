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

/// The experiment at rest that says how a timed one fixes and loads its body.
std::unique_ptr<const StaticExperiment> read_fixture(const Reader& reader, const ExperimentContext& context) {
  std::unique_ptr<const Experiment> fixture = read_experiment(reader, context);
  const StaticExperiment* at_rest = fixture->at_rest();
  if (!at_rest) reader.fail("must be an experiment at rest; " + fixture->name() + " runs through time itself");
  fixture.release();
  return std::unique_ptr<const StaticExperiment>(at_rest);
}

std::unique_ptr<Experiment> read_motion(Reader reader, MotionKind kind, const ExperimentContext& context) {
  MotionSetup setup;
  reader.set_section("experiment");  // the key that the table of experiments was asked by
  setup.name = reader.at("kind").text();
  reader.set_section("experiment." + setup.name);
  setup.kind = kind;
  const bool free = kind == MotionKind::motion;
  const auto fixture = free ? reader.find("fixture") : std::optional(reader.at("fixture"));
  if (fixture) setup.fixture = read_fixture(*fixture, context);
  if (free)
    if (auto in_time = reader.find("in_time")) {
      if (!fixture) in_time->fail("there is no load to change: key 'fixture' is missing");
      setup.load = read_time_function(*in_time);
    }
  if (kind == MotionKind::release) {
    const auto load = reader.find("load");
    setup.released = !load || load->choice<bool>({{"removed", true}, {"applied", false}});
  }
  if (kind == MotionKind::relaxation) {
    setup.ramp = reader.at("ramp").quantity(dimension::time, kPositive);
    setup.load = TimeFunction::ramp(setup.ramp);
  }
  if (kind == MotionKind::cyclic) {
    setup.frequency = reader.at("frequency").quantity({0, 0, -1}, kPositive);
    setup.load = TimeFunction::sine(setup.frequency);
  }
  reader.finish();
  return reader.located([&] { return make_motion(context.body, std::move(setup)); });
}

std::unique_ptr<Experiment> read_shake(Reader reader, const ExperimentContext& context) {
  ShakeSetup setup;
  if (auto axis = reader.find("axis")) setup.axis = read_direction(*axis);
  setup.direction = context.rotation * (reader.has("direction") ? read_direction(reader.at("direction")) : setup.axis);
  setup.axis = context.rotation * setup.axis;
  const auto amplitude = read_travel(reader, "amplitude", context.body, setup.axis);
  setup.amplitude = amplitude ? *amplitude : reader.at("amplitude").quantity(dimension::length, kPositive);
  setup.frequency = reader.at("frequency").quantity({0, 0, -1}, kPositive);
  if (auto depth = reader.find("grip_depth")) setup.grip_depth = depth->quantity(dimension::length, kPositive);
  reader.finish();
  return reader.located([&] { return make_shake(context.body, setup); });
}

std::unique_ptr<Experiment> read_drop(Reader reader, const ExperimentContext& context) {
  DropSetup setup;
  setup.direction = context.rotation *
                    (reader.has("direction") ? read_direction(reader.at("direction")) : Vector3(-Vector3::UnitZ()));
  const auto gravity = reader.find("gravity"), height = reader.find("height"), speed = reader.find("speed"),
             stiffness = reader.find("stiffness"), damping = reader.find("damping");
  if (gravity) setup.gravity = gravity->quantity(dimension::acceleration, kNotNegative);
  if (height) setup.height = height->quantity(dimension::length, kNotNegative);
  if (speed) setup.speed = speed->quantity(dimension::velocity, kNotNegative);
  if (context.contact) {
    for (const auto& own : {height, stiffness, damping})
      if (own) own->fail("belongs to the floor of `drop`; this scene has contact and obstacles of its own");
    setup.contact = *context.contact;
  }
  setup.stiffness = stiffness ? stiffness->quantity(dimension::stiffness, kPositive)
                              : default_floor_stiffness(context.body, context.material);
  if (damping) setup.damping = damping->quantity(dimension::damping, kNotNegative);
  reader.finish();
  if (!(setup.speed > 0 || (setup.gravity > 0 && (setup.height > 0 || setup.contact))))
    reader.fail("nothing falls: give a speed, or gravity and a height");
  return reader.located([&] { return make_drop(context.body, setup); });
}

std::unique_ptr<Experiment> read_parachute(Reader reader, const ExperimentContext& context) {
  ParachuteSetup setup;
  if (auto direction = reader.find("direction")) setup.direction = read_direction(*direction);
  setup.direction = context.rotation * setup.direction;
  if (auto gravity = reader.find("gravity")) setup.gravity = gravity->quantity(dimension::acceleration, kNotNegative);
  if (auto speed = reader.find("speed")) setup.speed = speed->quantity(dimension::velocity, kNotNegative);
  reader.finish();
  return reader.located([&] { return make_parachute(context.body, setup); });
}

std::unique_ptr<Experiment> read_vibration(Reader reader, const ExperimentContext& context) {
  std::unique_ptr<const StaticExperiment> fixture;
  if (auto value = reader.find("fixture")) fixture = read_fixture(*value, context);
  const int count = reader.has("count") ? reader.at("count").whole(1, 10) : 6;
  const auto load = reader.find("load");
  const bool loaded = load && load->choice<bool>({{"removed", false}, {"applied", true}});
  reader.finish();
  if (loaded && !fixture) load->fail("there is no load: key 'fixture' is missing");
  return reader.located([&] { return make_vibration(context.body, std::move(fixture), count, loaded); });
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

std::vector<ExperimentInfo> timed_experiments() {
  const auto motion = [](MotionKind kind) {
    return [kind](Reader& reader, const ExperimentContext& context) { return read_motion(reader, kind, context); };
  };
  const auto fixture = [](const char* fallback, const char* text) {
    return SceneKey{"fixture", "experiment at rest", "", "", fallback, text};
  };
  const SceneKey down{"direction", "direction", "", "", "`-z`", "direction of the fall"};
  const SceneKey speed{"speed", "quantity", "m/s", "≥ 0", "0", "speed along `direction` at time 0"};
  return {
      {.name = "motion",
       .summary = "a body, free or fixed and loaded by a fixture, is observed as it moves",
       .source = "",
       .in_time = true,
       .of_shares = true,
       .keys = {fixture("free body", "how the body is fixed and loaded"),
                {"in_time", "time function", "", "", "constant", "factor of the fixture's load"}},
       .read = motion(MotionKind::motion)},
      {.name = "release",
       .summary = "a loaded body is released, or loaded at once: free vibration, its frequency and damping",
       .source = "",
       .in_time = true,
       .of_shares = true,
       .keys = {fixture("needed", "how the body is fixed, and loaded before it is released"),
                {"load", "`removed`, `applied`", "", "", "`removed`",
                 "whether the load is taken away at time 0, or put on at once"}},
       .read = motion(MotionKind::release)},
      {.name = "creep",
       .summary = "a force is applied and stays: displacement over time, retardation time",
       .source = "",
       .in_time = true,
       .of_shares = true,
       .keys = {fixture("needed", "how the body is fixed, with the force that stays")},
       .read = motion(MotionKind::creep)},
      {.name = "relaxation",
       .summary = "a displacement grows and stays: force over time, relaxation time",
       .source = "",
       .in_time = true,
       .of_shares = true,
       .keys = {fixture("needed", "how the body is fixed, with the displacement that stays"),
                {"ramp", "quantity", "s", "> 0", "needed", "time in which the displacement grows"}},
       .read = motion(MotionKind::relaxation)},
      {.name = "cyclic",
       .summary = "a displacement oscillates: storage and loss modulus over the last period",
       .source = "",
       .in_time = true,
       .of_shares = true,
       .keys = {fixture("needed", "how the body is fixed, with the displacement that is the amplitude"),
                {"frequency", "quantity", "1/s", "> 0", "needed", "frequency of the oscillation"}},
       .read = motion(MotionKind::cyclic)},
      {.name = "shake",
       .summary = "the clamped end of a body oscillates: amplitude ratio and phase of the far end",
       .source = "",
       .in_time = true,
       .of_shares = true,
       .keys = {{"axis", "direction", "", "", "`x`", "from the clamped end to the far one"},
                {"direction", "direction", "", "", "`axis`", "direction of the oscillation"},
                {"amplitude", "quantity", "m", "> 0", "this, or `strain`", "amplitude of the clamped end"},
                travel_strain_key("amplitude", "this, or `amplitude`"),
                {"frequency", "quantity", "1/s", "> 0", "needed", "frequency of the oscillation"},
                kDepthKey},
       .read = read_shake},
      {.name = "drop",
       .summary = "a free body falls on a floor, or on the scene's obstacles: restitution, duration of contact",
       .source = "",
       .in_time = true,
       .of_shares = true,
       .keys = {down,
                {"gravity", "quantity", "m/s^2", "≥ 0", "0", "acceleration of the fall"},
                {"height", "quantity", "m", "≥ 0", "0",
                 "height of the lowest sphere above the floor; not with `contact`"},
                speed,
                {"stiffness", "quantity", "N/m", "> 0", "E × mean diameter",
                 "stiffness of the floor for each molecule; not with `contact`"},
                {"damping", "quantity", "N s/m", "≥ 0", "0", "damping of the floor; not with `contact`"}},
       .read = read_drop},
      {.name = "parachute",
       .summary = "a canopy with a load on `lines` falls through air: how it opens, largest force in a line",
       .source = "",
       .in_time = true,
       .keys = {down, {"gravity", "quantity", "m/s^2", "≥ 0", "9.81", "acceleration of the fall"}, speed},
       .read = read_parachute},
      {.name = "vibration",
       .summary = "natural frequencies of a body, free or fixed by a fixture; at rest",
       .source = "",
       .keys = {fixture("free body", "how the body is fixed"),
                {"load", "`removed`, `applied`", "", "", "`removed`",
                 "whether the body vibrates about rest, or about its equilibrium under the fixture's load"},
                {"count", "whole", "", "1 … 10", "6", "number of frequencies"}},
       .read = read_vibration},
  };
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
  if (auto value = reader.find("turn")) turn = rotation * read_rotation(*value) * rotation.transpose();
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
