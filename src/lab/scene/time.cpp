#include <Eigen/Geometry>
#include <algorithm>
#include <random>

#include "core/forces/floor.h"
#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"
#include "elastin/core/model/parts.h"
#include "lab/scene/parts.h"

namespace elastin::lab {
namespace {

/// Fails where a key is a parameter of other steppers than the one chosen.
void refuse_others(Reader& reader, const elastin::Table<StepperKind>& steppers, const StepperKind& chosen) {
  const auto has = [](const StepperKind& stepper, const std::string& key) {
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

/// Of a map: by number, or by error.
const Forms<TimeOptions>& step_forms() {
  using T = TimeOptions;
  static const Forms<T> forms{
      {key::whole("per_frame", &T::steps_per_frame, 1, 1000000,
                  "instead of the keys below: number of equal steps in each frame, longer where frames are")
           .otherwise("none")
           .then([](const Reader&, T& options) { options.choice = StepChoice::per_frame; })},
      {key::quantity("error", &T::error, dimension::none,
                     "error of a step in position, over the body's size or over ten times the largest displacement so "
                     "far, the smaller of the two",
                     kPositive),
       key::quantity("smallest", &T::smallest, dimension::time, "shortest step by error", kPositive),
       key::quantity("largest", &T::largest, dimension::time, "longest step by error, not below `smallest`", kPositive)
           .otherwise("none")}};
  return forms;
}

void read_step(const Reader& reader, TimeOptions& options) {
  if (reader.is_map()) {
    options.choice = StepChoice::by_error;
    options = step_forms().read(reader, {}, options);
    if (options.largest < options.smallest) reader.fail("the largest step must not be below the smallest");
  } else if (reader.text() != "automatic") {
    options.choice = StepChoice::fixed;
    options.step = reader.quantity(dimension::time, kPositive);
  }
}

/// Uniform in −1 … 1: the same on every machine.
double uniform(std::mt19937_64& generator) { return 2 * static_cast<double>(generator() >> 11) * 0x1p-53 - 1; }

void check_budget(const Reader& reader, const elastin::Table<StepperKind>& steppers, const TimeOptions& options) {
  if (!options.stepper || (*options.stepper)->effort.empty()) {
    std::string able;
    for (const auto& stepper : steppers)
      if (!stepper->effort.empty()) able += (able.empty() ? "" : ", ") + stepper->name;
    reader.fail("chooses how many sweeps or iterations a step gets: write `stepper:` with one of " + able);
  }
  if (options.choice != StepChoice::fixed) reader.fail("needs steps of one length: write `step: 1 ms` or another");
  if (options.checkpoint) reader.fail("the clock decides: a run that goes on from a checkpoint would take other steps");
}

/// Some molecules, and their velocity or displacement.
struct SomeMolecules {
  std::vector<int> molecules;
  Vector3 by = Vector3::Zero();
};

struct Scatter {
  double amount = 0;  ///< [m], at most, in each direction
  int seed = 1;
};

struct InitialSetup {
  Vector3 velocity = Vector3::Zero(), spin = Vector3::Zero();
  std::vector<SomeMolecules> thrown;
  Matrix3 stretch = Matrix3::Identity(), turn = Matrix3::Identity();
  Scatter scatter;
  SomeMolecules move;
  std::optional<Positions> positions;
};

const Keys<InitialSetup>& initial_setup_keys() {
  using S = InitialSetup;
  const auto some = [](const char* molecules, const char* by, const Dimension& unit, const char* text) {
    return Keys<SomeMolecules>{molecules_key("molecules", &SomeMolecules::molecules, molecules).needed(),
                               key::vector(by, &SomeMolecules::by, unit, text).needed()};
  };
  static const Keys<S> keys{
      key::vector("velocity", &S::velocity, dimension::velocity, "velocity of the body"),
      key::vector("spin", &S::spin, {0, 0, -1}, "rotation of the body about its middle"),
      key::maps("throw", &S::thrown, some("which molecules", "velocity", dimension::velocity, "their velocity"),
                "velocities of some molecules"),
      Key<S>({"stretch", "vector", "", "", "1",
              "factors along x, y, z about the middle; 0 flattens, negative values mirror"},
             [](const Reader& value, S& setup, const Frame& frame) {
               setup.stretch = frame.rotation * value.vector(dimension::none).asDiagonal() * frame.rotation.transpose();
             }),
      key::rotation("turn", &S::turn, "rotation about the middle"),
      key::map("scatter", &S::scatter,
               Keys<Scatter>{key::quantity("amount", &Scatter::amount, dimension::length,
                                           "random displacement of each molecule in each direction", kPositive)
                                 .needed(),
                             key::whole("seed", &Scatter::seed, 0, "seed of the random numbers")}),
      Key<S>(
          "positions",
          key::rows_below("positions", "map", "where the molecules begin, in place of where the body is at rest",
                          Keys<MeshFile>{mesh_file_key("mesh of as many points in the same order"), length_unit_key()}),
          [](const Reader& value, S& setup, const Frame& frame) {
            setup.positions = Keys<MeshFile>{mesh_file_key(""), length_unit_key()}.read(value).load().points;
            if (setup.positions->cols() != frame.body->size())
              value.fail("the file has " + counted(setup.positions->cols(), "point") +
                         "; needed: " + std::to_string(frame.body->size()) + ", one a molecule");
            *setup.positions = (frame.rotation * *setup.positions).eval();
          }),
      key::map("move", &S::move, some("which molecules are displaced", "by", dimension::length, "their displacement"))};
  return keys;
}

/// {method: NAME, PARAMETER: VALUE, …}
Keys<TimeOptions> stepper_keys(const elastin::Table<StepperKind>& steppers) {
  using T = TimeOptions;
  return {key::row("method", &T::stepper, steppers, "name of the stepper").needed("needed in the map"),
          parameter_keys(steppers, &T::parameters,
                         [](const T& options) { return options.stepper ? &**options.stepper : nullptr; })};
}

Keys<TimeOptions> time_options_keys(const elastin::Table<StepperKind>& steppers) {
  using T = TimeOptions;
  SceneKey stepper{"stepper",
                   "word, or map",
                   "",
                   "",
                   "`velocity_verlet` for springs, `newmark` for cells; of creep and relaxation `backward_euler`",
                   words_text(steppers.names())};
  return {key::quantity("duration", &T::duration, dimension::time, "time that the run covers", kPositive).needed(),
          Key<T>("stepper", key::rows_below(stepper, stepper_keys(steppers)),
                 [&steppers](const Reader& value, T& options) { read_stepper(value, steppers, options); }),
          Key<T>("step",
                 key::rows_below(
                     {"step", "quantity, `automatic`, or map", "s", "> 0", "`automatic`",
                      "explicit: 0.8 of the longest stable step, checked as the body stiffens; implicit: by error, "
                      "of creep and relaxation at most a hundredth of the duration; either ends where a function of "
                      "time jumps or has a kink, and takes at most a fortieth of its period"},
                     step_forms()),
                 read_step),
          key::whole("frames", &T::frames, 1, 1000000, "points of the time history and snapshots, at equal times"),
          key::quantity("first_frame", &T::first_frame, dimension::time,
                        "end of the first frame; the ends of the others are a geometric sequence up to the duration: "
                        "decades of time",
                        kPositive)
              .refused_for([](const T& options) {
                return options.first_frame > 0 && (options.first_frame >= options.duration || options.frames < 2)
                           ? "must be shorter than the duration, and there must be at least 2 frames"
                           : "";
              }),
          key::quantity("frame_rate", &T::frame_rate, {0, 0, -1}, "most frames a second with `--live`", kPositive),
          key::whole("checkpoint", &T::checkpoint, 1, 1000000, "frames between restart files; Ctrl-C leaves one too"),
          key::quantity("budget", &T::budget, dimension::time,
                        "computing time of a step of fixed length: a stepper with sweeps or iterations gets as many "
                        "as there is time for; what is left of the error is measured at the frames. Not with "
                        "`checkpoint`",
                        kPositive)
              .then([&steppers](const Reader& value, const T& options) { check_budget(value, steppers, options); })};
}

}  // namespace

void read_stepper(const Reader& reader, const elastin::Table<StepperKind>& steppers, TimeOptions& options) {
  if (reader.is_text()) {
    options.stepper = reader.located([&] { return steppers.find(reader.text()); });
    return;
  }
  const Keys<TimeOptions> keys = stepper_keys(steppers);
  Reader map = reader;
  if (const auto method = map.find("method"))
    refuse_others(map, steppers, *method->located([&] { return steppers.find(method->text()); }));
  options = keys.read(map, {}, options);
}

TimeOptions read_time(const Reader& reader, const elastin::Table<StepperKind>& steppers) {
  return time_options_keys(steppers).read(reader);
}

namespace {

/// They stay where they are, or go where the experiment moves them.
void refuse_velocities_of_rigid_parts(Reader reader, const Body& body, const InitialSetup& setup) {
  const auto is_rigid = [](const Part& part) { return part.rigid; };
  for (const char* key : {"velocity", "spin"})
    if (!body.parts.empty() && std::all_of(body.parts.begin(), body.parts.end(), is_rigid) && reader.has(key))
      reader.at(key).fail(
          "a rigid body stays where it is unless the experiment moves it, and all bodies are rigid: give "
          "one a stiff material in place of `rigid`");
  for (const Part& part : body.parts) {
    if (!part.rigid) continue;
    const std::vector<int> held = molecules_of(part);
    for (std::size_t i = 0; i < setup.thrown.size(); ++i)
      for (const int molecule : setup.thrown[i].molecules)
        if (std::find(held.begin(), held.end(), molecule) != held.end())
          reader.at("throw").items()[i].fail("the rigid body '" + part.name +
                                             "' stays where it is unless the experiment moves it: give it a stiff "
                                             "material in place of `rigid`, or throw molecules of other bodies");
  }
}

}  // namespace

std::function<void(State&)> read_initial(const Reader& reader, const Body& body, const Matrix3& rotation, bool timed) {
  const InitialSetup setup = initial_setup_keys().read(reader, {rotation, &body});
  if (!timed && (setup.velocity.norm() > 0 || setup.spin.norm() > 0 || !setup.thrown.empty()))
    reader.fail("an experiment at rest has no velocities");
  refuse_velocities_of_rigid_parts(reader, body, setup);
  return [setup](State& state) {
    if (setup.positions) state.positions = *setup.positions;
    const Vector3 middle = state.positions.rowwise().mean();
    state.positions = (setup.turn * setup.stretch * (state.positions.colwise() - middle)).colwise() + middle;
    std::mt19937_64 generator(static_cast<std::uint64_t>(setup.scatter.seed));
    if (setup.scatter.amount > 0)
      for (double& coordinate : state.positions.reshaped()) coordinate += setup.scatter.amount * uniform(generator);
    for (const int molecule : setup.move.molecules) state.positions.col(molecule) += setup.move.by;
    for (Eigen::Index i = 0; i < state.positions.cols(); ++i)
      state.velocities.col(i) += setup.velocity + setup.spin.cross(Vector3(state.positions.col(i) - middle));
    for (const auto& [molecules, velocity] : setup.thrown)
      for (const int molecule : molecules) state.velocities.col(molecule) += velocity;
  };
}

std::vector<KeySection> time_keys(const Catalog& catalog) {
  return {{"time", "Time", "", time_options_keys(catalog.steppers).rows()}};
}

std::vector<KeySection> initial_keys() {
  return {{"initial", "Initial state",
           "Velocities are of experiments in time only, and of molecules that nothing holds.",
           initial_setup_keys().rows()}};
}

}  // namespace elastin::lab
