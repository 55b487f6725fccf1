#include "lab/export/engine_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/solve/newton.h"
#include "elastin/core/base/text.h"
#include "elastin/core/solve/stepper.h"
#include "lab/export/formats.h"
#include "lab/export/process.h"
#include "lab/report/page.h"
#include "lab/run/load_path.h"

namespace elastin::lab {
namespace {

using Json = nlohmann::json;

/// At rest is who moves less than this part of the largest displacement in 50 steps, three times; steps until an engine
/// gives up.
constexpr double kAtRest = 1e-5;
constexpr int kMostSteps = 20000;

/// An answer that is not one, in words.
struct Fault {
  std::string text;
};

/// The engine found no equilibrium of the body: with softer constants or smaller steps it may.
struct NoRest : Fault {};

std::string node_has(const char* package) {
  return fmt::format("node -e 'require(\"module\").createRequire(process.cwd() + \"/\").resolve(\"{}\")'", package);
}

/// What an engine printed: its last line that is a JSON object. Python writes numbers that JSON does not have.
class Answer {
 public:
  void read(std::string&& line) {
    for (const std::string_view word : {"-Infinity", "Infinity", "NaN"})
      for (std::size_t at = 0; (at = line.find(word, at)) != std::string::npos;) line.replace(at, word.size(), "null");
    Json read = Json::parse(line, nullptr, false);
    if (read.is_object()) json_ = std::move(read);
  }
  const Json& json() const {
    if (json_.is_null()) throw Fault{"it printed no line with a JSON object"};
    return json_;
  }

 private:
  Json json_;
};

/// Three numbers for each molecule.
Positions vectors_of(const Json& answer, const char* key, Eigen::Index molecules) {
  const Json& rows = answer.at(key);
  if (!rows.is_array() || static_cast<Eigen::Index>(rows.size()) != molecules)
    throw Fault{fmt::format("its '{}' are {} of {} molecules", key, rows.size(), molecules)};
  Positions result(3, molecules);
  for (Eigen::Index i = 0; i < molecules; ++i) {
    const Json& row = rows[static_cast<std::size_t>(i)];
    if (!row.is_array() || row.size() != 3)
      throw Fault{fmt::format("its '{}' of molecule {} are no three numbers", key, i)};
    for (int axis = 0; axis < 3; ++axis) {
      const Json& value = row[static_cast<std::size_t>(axis)];
      if (!value.is_number()) throw Fault{fmt::format("its '{}' of molecule {} are not finite", key, i)};
      result(axis, i) = value.get<double>();
    }
  }
  if (!result.allFinite()) throw Fault{fmt::format("its '{}' are not finite", key)};
  return result;
}

/// What the answer says of itself.
void read_report(const Json& answer, EngineReport& report) {
  const auto number = [&](const char* key, double other) {
    return answer.contains(key) && answer[key].is_number() ? answer[key].get<double>() : other;
  };
  if (answer.contains("engine") && answer["engine"].is_string()) report.version = answer["engine"].get<std::string>();
  report.steps = static_cast<int>(number("steps", 0));
  report.seconds_per_step = number("seconds_per_step", 0);
  if (report.iterations == 0) report.iterations = static_cast<int>(number("iterations", 0));
}

/// Single precision shows itself: every number is one.
void warn_of_precision(const Positions& positions, const Positions& displacements, Run& run) {
  if (positions.cast<float>().cast<double>() != positions) return;
  const double share = 0x1p-24 * positions.cwiseAbs().maxCoeff() / displacements.cwiseAbs().maxCoeff();
  if (share > 1e-3)
    run.warnings.push_back(
        fmt::format("its positions have single precision, so that the largest displacement is known "
                    "to {:.1g} %: load the body more",
                    100 * share));
}

/// An equilibrium in which cells are inverted is another one than that of the test, or the load is far too large.
std::string inversion(const ExportedBody& body, const Positions& positions) {
  const auto volume = [](const ExportedBody::Cell& cell, const Positions& at) {
    const Vector3 first = at.col(cell.nodes[0]);
    return (at.col(cell.nodes[1]) - first).cross(at.col(cell.nodes[2]) - first).dot(at.col(cell.nodes[3]) - first);
  };
  const auto inverted = std::count_if(body.tetrahedra.begin(), body.tetrahedra.end(), [&](const auto& cell) {
    return !(volume(cell, positions) * volume(cell, body.positions) > 0);
  });
  return inverted == 0 ? ""
                       : fmt::format(
                             "its positions invert {} of {} tetrahedra: take smaller time steps, or load the "
                             "body less",
                             inverted, body.tetrahedra.size());
}

OtherSolution solution_of(const Engine& engine, const Json& answer, const ExportedBody& body, bool calibrating,
                          Run& run) {
  if (answer.contains("error")) {
    run.suited = false;
    throw Fault{(answer["error"].is_string() ? answer["error"].get<std::string>() : answer["error"].dump()) +
                (engine.tested.empty() ? "" : " (its driver is written for " + engine.tested + ")")};
  }
  if (!answer.contains("positions")) throw Fault{"its answer has neither 'positions' nor 'error'"};
  const Positions positions = vectors_of(answer, "positions", body.positions.cols());
  read_report(answer, *run.engine);
  if (!engine.tested.empty() && run.engine->version != engine.tested)
    run.warnings.push_back("this is " + run.engine->version + "; its driver is written for " + engine.tested);
  if (answer.contains("at_rest") && answer["at_rest"] == false) {
    const Json cause = answer.value("cause", Json(""));
    throw NoRest{{fmt::format("not at rest after {}", counted(run.engine->steps, "step")) +
                  (cause.is_string() && cause != "" ? ": " + cause.get<std::string>() : "")}};
  }
  if (const std::string why = inversion(body, positions); !why.empty()) {
    if (calibrating) throw NoRest{{why}};
    run.warnings.push_back(why);
  }
  OtherSolution solution{positions - body.positions, std::nullopt};
  warn_of_precision(positions, solution.displacements, run);
  if (answer.contains("reactions")) solution.reactions = vectors_of(answer, "reactions", body.positions.cols());
  const bool driven = std::any_of(body.supports.begin(), body.supports.end(),
                                  [](const Support& support) { return !support.displacement.isZero(0); });
  if (driven && !solution.reactions) {
    run.suited = false;
    throw Fault{"it gives no reactions, and the experiment prescribes displacements: load the body by a force"};
  }
  return solution;
}

std::string request_text(const ExportedBody& body, const EngineStudy& settings, const std::string& folder) {
  std::string one_line = json_of_body(body);
  std::erase(one_line, '\n');
  return fmt::format(
      "{{\"elastin_request\": 1, \"dt\": {}, \"iterations\": {}, \"tolerance\": {}, \"most_steps\": {}, "
      "\"seconds\": {}, \"folder\": {}, \"body\": {}}}\n",
      settings.time_step, settings.iterations ? std::to_string(*settings.iterations) : "null", kAtRest, kMostSteps,
      settings.seconds, Json(folder).dump(), one_line);
}

/// Hands the body over, waits for the answer and measures it.
void solve_once(const Engine& engine, const Scene& scene, const ExportedBody& body, const EngineStudy& settings,
                const std::function<bool()>& stop, Run& run) {
  const auto begin = std::chrono::steady_clock::now();
  Answer answer;
  const auto read_answer = [&](std::string&& line) { answer.read(std::move(line)); };
  if (engine.ask) {
    KeptLines lines(read_answer);
    lines.add(engine.ask(request_text(body, settings, "")));
    lines.finish();
    run.solve_seconds += seconds_since(begin);
    return measure_other(scene, body.load, solution_of(engine, answer.json(), body, settings.calibrate, run), run);
  }
  const JobFolder folder(engine.name);
  const auto write = [&](const std::string& name, const std::string& text) {
    std::ofstream file(folder.file(name));
    file << text;
    if (!file.flush()) throw InputError(folder.file(name) + ": cannot be written");
  };
  for (const auto& format : export_formats())
    if (format->name == engine.name && format->files)
      for (const auto& [name, text] : engine_files(*format, body)) write(name, text);
  if (engine.driver) write(engine.driver, page_part(engine.driver));
  write("request.json", request_text(body, settings, folder.path()));
  run.build_seconds += seconds_since(begin);
  const Ended ended =
      run_process(folder, "{ " + engine.command + "\n} < \"$0/request.json\"", "", stop, settings.seconds, read_answer);
  run.solve_seconds += ended.seconds;
  if (ended.stopped) {
    run.outcome = Outcome::interrupted;
    throw Fault{"interrupted"};
  }
  if (ended.timed_out) throw Fault{fmt::format("no answer in {:.3g} s", settings.seconds)};
  if (!ended.well) throw Fault{"it ended with " + ended.text + ": " + ended.complaint};
  measure_other(scene, body.load, solution_of(engine, answer.json(), body, settings.calibrate, run), run);
}

/// How far the engine may stay from the modulus that its constants have, and how little it may gain by twice the
/// constants until it counts as saturated.
constexpr double kMet = 2e-3, kLeastGain = 0.02;

/// What would do where an engine is saturated: that many iterations, or steps that short, with the constants that it
/// had. "" if neither does within 64 times.
std::string remedy(const std::function<double(const EngineStudy&)>& shown, double target, const EngineStudy& settings,
                   int iterations) {
  constexpr int kDoublings = 6;
  std::string text;
  const auto search = [&](const auto& change) {
    EngineStudy changed = settings;
    for (int i = 0; i < kDoublings; ++i) {
      change(changed);
      try {
        if (!(shown(changed) >= (1 - kMet) * target)) continue;
      } catch (const NoRest&) {
        continue;
      }
      text += text.empty() ? "; with " : " or ";
      return true;
    }
    return false;
  };
  EngineStudy last;
  if (iterations > 0 && search([&](EngineStudy& one) {
        one.iterations = 2 * one.iterations.value_or(iterations);
        last = one;
      }))
    text += counted(*last.iterations, "iteration");
  if (search([&](EngineStudy& one) {
        one.time_step /= 2;
        last = one;
      }))
    text += fmt::format("steps of {:.4g} s", last.time_step);
  return text.empty() ? "" : text + " it reaches that";
}

/// One factor on all constants, until the engine shows the modulus that Elastin finds with those given: secants of
/// log E over log factor. Where more stiffness changes nothing, or finds no rest, the run says how stiff the engine can
/// be.
void calibrate_in(const Engine& engine, const Scene& scene, const ExportedBody& body, const EngineStudy& settings,
                  const std::function<bool()>& stop, Run& run) {
  constexpr int kMostRuns = 12;
  constexpr double kLargestFactor = 8;  // from run to run
  constexpr double kNear = 1.5;         // of a factor that finds rest to one that does not
  const std::string name = calibrated_measure(*scene.experiment->at_rest(), scene.specimen.material);
  const std::string measure =
      name.empty() ? scene.experiment->main_measures(scene.specimen.material, {}).front().name : name;
  RunOptions options;
  options.statics = scene.statics;
  options.stop = stop;
  const double target = run_strategy(scene.specimen, *scene.experiment, scene.stiffness, options).measures.get(measure);
  if (!(target > 0)) throw Fault{"Elastin itself finds no positive " + measure + " to calibrate to"};
  double factor = 1, last_factor = 0, last = 0, slope = 1;
  double restless = std::numeric_limits<double>::infinity();  // the least factor without rest
  std::string why;
  const EngineReport before = *run.engine;
  const auto with_factor = [&](const EngineStudy& changed) {
    ExportedBody scaled = body;
    for (auto& one : scaled.connections) one.stiffness *= factor;
    for (auto* cells : {&scaled.cells, &scaled.tetrahedra})
      for (auto& cell : *cells) cell.youngs_modulus *= factor;
    if (std::isfinite(restless) && factor < 1) {  // or what has become so soft bears no load
      scaled.load = factor;
      scaled.forces *= factor;
      for (Support& support : scaled.supports) support.displacement *= factor;
    }
    Run found;
    found.engine = before;
    solve_once(engine, scene, scaled, changed, stop, found);
    run.solve_seconds += found.solve_seconds;
    return found;
  };
  const auto saturated = [&](const std::string& beyond) {
    run.outcome = Outcome::limit_reached;
    const std::string iterations =
        run.engine->iterations > 0 ? counted(run.engine->iterations, "iteration") : "its iterations";
    return Fault{
        fmt::format("saturated: with {} and steps of {:.4g} s it shows no more than {:.4g} of the {} of the "
                    "constants, {}{}",
                    iterations, settings.time_step, last / target, measure, beyond,
                    remedy([&](const EngineStudy& one) { return with_factor(one).measures.get(measure); }, target,
                           settings, run.engine->iterations))};
  };
  for (int trial = 0; trial < kMostRuns; ++trial) {
    double next = factor;
    try {
      const Run found = with_factor(settings);
      const double shown = found.measures.get(measure);
      run.measures = found.measures;
      run.curve = found.curve;
      run.engine = found.engine;
      run.calibration_factor = factor;
      if (!(shown > 0)) throw Fault{"it shows no positive " + measure};
      if (std::abs(shown / target - 1) <= kMet) {
        run.warnings.insert(run.warnings.end(), found.warnings.begin(), found.warnings.end());
        run.warnings.push_back(
            fmt::format("its constants are {:.4g} times those of the strategy, so that it shows their "
                        "{}",
                        factor, measure));
        return;
      }
      if (last > 0) slope = std::log(shown / last) / std::log(factor / last_factor);
      const bool gained = !(last > 0 && shown < target && factor > last_factor && slope < std::log2(1 + kLeastGain));
      last = shown, last_factor = factor;
      if (!gained) throw saturated("however large");
      next *= std::clamp(std::pow(target / shown, 1 / std::max(slope, 0.1)), 1 / kLargestFactor, kLargestFactor);
    } catch (const NoRest& fault) {
      restless = factor;
      why = fault.text;
      next /= kLargestFactor;
    }
    if (last > 0 && last < target && last_factor < restless && std::isfinite(restless)) {
      if (restless <= kNear * last_factor) {
        factor = restless > 1 ? last_factor : 1;
        throw saturated(fmt::format("however large (with {:.3g} times them: {})", restless, why));
      }
      next = std::min(next, std::sqrt(last_factor * restless));
    }
    factor = next;
  }
  throw Fault{why.empty() ? fmt::format("{} runs have not found a factor of its constants that shows their {}",
                                        kMostRuns, measure)
                          : why};
}

/// Elastin's own stepper from rest under the whole load, as the drivers of engines do it: all that moves is stopped
/// where the kinetic energy has passed a largest value. Position-based ones go once over all constraints, in the body's
/// order, in each of `iterations` substeps, as engines do.
void step_to_rest(const StepperMethod& method, const Scene& scene, const std::function<bool()>& stop, Run& run) {
  RunOptions options;
  options.statics = scene.statics;
  if (const std::string why = unsuited(scene.specimen, *scene.experiment, scene.stiffness); !why.empty())
    throw InputError(why);
  const auto held = make_model(scene.specimen, *scene.experiment, scene.stiffness, options, run);
  if (!held) throw InputError(run.cause);
  Model& model = *held->model;
  if (const std::string why = unsuited_for(*method, model); !why.empty()) throw InputError(why);
  ParameterValues values;
  int substeps = 1;
  for (const ParameterInfo& info : method->parameters) {
    if (info.name == "substeps") {
      substeps = scene.engines.iterations.value_or(static_cast<int>(info.fallback));
      values = {{"substeps", 1}, {"iterations", 1}, {"in_order", 1}};
    } else if (info.name == method->effort && values.empty() && scene.engines.iterations) {
      values[info.name] = *scene.engines.iterations;
    }
  }
  const auto stepper = make_stepper({method, values, scene.statics});
  StaticRig& rig = *held->rig->at_rest();
  set_load(model, rig, 1);
  State state = state_at_rest(model.body());
  const Start start{state.positions, Positions::Zero(3, static_cast<Eigen::Index>(model.supports.size()))};
  for (const Support& support : model.supports)
    state.positions.col(support.molecule) += (Matrix3::Identity() - support.free) * support.displacement;
  model.declare_history(state);
  Positions before = state.positions;
  const auto begin = std::chrono::steady_clock::now();
  int& steps = run.engine->steps;
  double energy = 0;
  for (int quiet = 0; quiet < 3;) {
    if (steps >= kMostSteps) throw Fault{fmt::format("not at rest after {}", counted(steps, "step"))};
    for (int i = 0; i < 50; ++i, ++steps)
      for (int substep = 0; substep < substeps; ++substep) {
        const StepResult result = stepper->advance(model, state, scene.engines.time_step / substeps);
        if (result.outcome != Outcome::converged) {
          run.outcome = result.outcome;
          throw Fault{result.cause};
        }
        const double now = state.velocities.colwise().squaredNorm().dot(model.body().mass.transpose());
        if (now < energy) state.velocities.setZero();
        energy = now < energy ? 0 : now;
      }
    if (stop && stop()) {
      run.outcome = Outcome::interrupted;
      throw Fault{"interrupted"};
    }
    if (seconds_since(begin) > scene.engines.seconds)
      throw Fault{fmt::format("not at rest in {:.3g} s", scene.engines.seconds)};
    const double moved = (state.positions - before).cwiseAbs().maxCoeff();
    quiet = moved <= kAtRest * (state.positions - start.positions).cwiseAbs().maxCoeff() ? quiet + 1 : 0;
    before = state.positions;
  }
  run.engine->iterations = substeps > 1 ? substeps : scene.engines.iterations.value_or(0);
  run.solve_seconds = seconds_since(begin);
  run.engine->seconds_per_step = run.solve_seconds / steps;
  Positions forces;
  model.set_forces(state, forces);
  StaticResult solved;
  solved.reactions = -fixed_components(model.supports, forces);
  solved.scale = solved.reactions.norm();
  run.measures = rig.measure(start, state, scene.statics, solved);
  run.curve.push_back({1, run.measures, 0, 0, 0});
}

void solve_in(const Engine& engine, const Scene& scene, const std::function<bool()>& stop, Run& run) {
  if (!scene.experiment->at_rest()) throw InputError("engines run experiments at rest");
  if (scene.specimen.given != GivenShape::at_rest)
    throw InputError("the rest is to be found first: `elastin run --out` writes an unloaded shape as a mesh");
  if (!scene.specimen.loads.empty())
    throw InputError("loads in addition to the experiment's are not measured separately");
  if (engine.stepper) {
    if (scene.engines.calibrate)
      run.warnings.emplace_back("not calibrated: that is for other engines; a stepper needs more iterations alone");
    return step_to_rest(engine.stepper, scene, stop, run);
  }
  const ExportedBody body = exported_body(scene, scene.stiffness);
  if (body.askew > 0)
    throw InputError(
        "engines have no supports that slide in directions askew to x, y and z: leave out `rotate`, or "
        "write `fixed_grip: clamped` and `loaded_grip: clamped`");
  run.warnings = body.notes;
  (scene.engines.calibrate ? calibrate_in : solve_once)(engine, scene, body, scene.engines, stop, run);
}

}  // namespace

const elastin::Table<Engine>& engines() {
  static const auto table = [] {
    elastin::Table<Engine> rows("engine");
    rows.add({{"calculix", "finite elements of CalculiX, on the scene's cells", "CalculiX CrunchiX User's Manual"},
              "command -v ccx",
              "apt-get install calculix-ccx",
              "",
              nullptr,
              run_calculix});
    const auto add = [&](const char* name, const char* summary, const std::string& test, const std::string& install,
                         const char* program, const char* driver, const std::string& tested) {
      Engine row{{name, summary, "scenes/README.md"},
                 test,
                 install,
                 fmt::format("exec {} \"$0/{}\"", program, driver),
                 driver};
      row.tested = tested;
      rows.add(std::move(row));
    };
    const auto add_package = [&](const char* name, const char* summary, const char* package, const char* version,
                                 const char* driver) {
      add(name, summary, node_has(package), fmt::format("npm install {}@{}", package, version), "node", driver,
          fmt::format("{} {}", package, version));
    };
    add_package("jolt", "soft body of Jolt, in node", "jolt-physics", "1.1.0", "jolt.mjs");
    add_package("rapier", "soft body of Rapier, in node", "@dimforge/rapier3d-compat", "0.21.0", "rapier.mjs");
    add_package("mujoco", "tendons or a flex of MuJoCo, in node", "@mujoco/mujoco", "3.14.0", "mujoco.mjs");
    add("bullet", "soft body of Bullet, compiled by its driver", "pkg-config --exists bullet && command -v c++ python3",
        "apt-get install libbullet-dev pkg-config g++ python3", "python3", "bullet_engine.py", "Bullet 3.24");
    add("lammps", "harmonic bonds of LAMMPS", "command -v lmp && command -v python3", "apt-get install lammps python3",
        "python3", "lammps_engine.py", "LAMMPS 29 Sep 2021 - Update 2");
    return rows;
  }();
  return table;
}

std::vector<Engine> chosen_engines(const EngineStudy& study, const std::vector<std::string>& commands,
                                   const std::string& against, const Catalog& catalog) {
  std::vector<Engine> chosen;
  if (!against.empty()) chosen.push_back(*engines().find(against));
  const auto add = [&](Engine engine, const std::string& option) {
    for (const Strategy& strategy : catalog.strategies())
      if (strategy.name == engine.name)
        throw InputError(option + "'" + engine.name + "' is a strategy; give the engine another name");
    for (const Engine& other : chosen)
      if (other.name == engine.name) throw InputError(option + "'" + engine.name + "' is there twice");
    chosen.push_back(std::move(engine));
  };
  for (const Reader& reader : study.names)
    reader.located([&] {
      const std::string name = reader.text();
      for (const auto& stepper : catalog.steppers)
        if (stepper->name == name) {
          Engine engine{{name, stepper->summary, stepper->source}, "", "", ""};
          engine.stepper = stepper;
          return add(std::move(engine), "");
        }
      std::vector<std::string> known = engines().names();
      for (const std::string& stepper : catalog.steppers.names()) known.push_back(stepper);
      if (std::find(known.begin(), known.end(), name) == known.end())
        throw InputError("engine '" + name + "' is not known here" + suggestion(name, known));
      add(*engines().find(name), "");
    });
  for (const std::string& command : commands) {
    std::istringstream words(command);
    std::string name;
    for (std::string word; words >> word;)
      if (word.front() != '-') name = std::filesystem::path(word).stem().string();
    if (name.empty() || !std::all_of(name.begin(), name.end(), [](unsigned char letter) {
          return std::isalnum(letter) || letter == '_' || letter == '-' || letter == '.';
        }))
      throw InputError("--engine: '" + command + "' does not end in the name of a program or script");
    add({{name, "command of the user", ""}, "", "", command}, "--engine: ");
  }
  return chosen;
}

std::string missing(const Engine& engine) {
  if (engine.test.empty() || std::system(("{ " + engine.test + "; } > /dev/null 2>&1").c_str()) == 0) return "";
  return engine.name + " is not installed here: " + engine.install;
}

void measure_other(const Scene& scene, double load, const OtherSolution& solution, Run& run) {
  const Specimen& specimen = scene.specimen;
  Model model(specimen.body);
  RunOptions options;
  options.statics = scene.statics;
  Run ignored;
  if (auto terms = make_elasticity(specimen, *scene.experiment, scene.stiffness, options, ignored))
    model.add(std::move(*terms));
  const auto rig = scene.experiment->at_rest()->static_rig(model);
  State state = state_at_rest(specimen.body);
  const Start start{state.positions, Positions::Zero(3, static_cast<Eigen::Index>(model.supports.size()))};
  set_load(model, *rig, load);
  state.positions += solution.displacements;
  StaticResult solved;
  solved.linear = scene.statics.linear;
  solved.reactions = start.reactions;
  if (solution.reactions)
    for (std::size_t i = 0; i < model.supports.size(); ++i) {
      const Support& support = model.supports[i];
      solved.reactions.col(static_cast<Eigen::Index>(i)) =
          (Matrix3::Identity() - support.free) * solution.reactions->col(support.molecule);
    }
  solved.scale = solved.reactions.norm();
  run.measures = rig->measure(start, state, scene.statics, solved);
  run.curve.push_back({load, run.measures, 0, 0, 0});
}

OtherRun run_engine(const Engine& engine, Scene& scene, const Catalog& catalog,
                    const std::vector<std::string>& overrides, const std::function<bool()>& stop) {
  OtherRun result;
  Run& run = result.run;
  const EngineReport report{"", scene.stiffness.label, scene.engines.time_step, scene.engines.iterations.value_or(0)};
  if (const std::string why = missing(engine); !why.empty()) {
    if (!engine.solve) run.engine = report;
    run.suited = false;
    run.cause = why;
  } else if (engine.solve) {
    result = engine.solve(scene, catalog, overrides, stop);
  } else {
    run.engine = report;
    try {
      prepare(scene.specimen, scene.stiffness.strategy);
      solve_in(engine, scene, stop, run);
    } catch (const InputError& error) {
      run.suited = false;
      run.cause = error.what();
    } catch (const Fault& fault) {
      if (run.suited && run.outcome == Outcome::converged) run.outcome = Outcome::diverged;
      run.cause = engine.name + ": " + fault.text;
    }
    run.solver = fmt::format("{}, constants of {}", run.engine->version.empty() ? engine.name : run.engine->version,
                             scene.stiffness.label);
    run.warnings.push_back("computed by " + engine.name + " with the constants of '" + scene.stiffness.label +
                           "': shown with the others, never recommended");
  }
  if (!run.engine) run.engine.emplace();
  run.engine->name = run.strategy = engine.name;
  return result;
}

}  // namespace elastin::lab
