#include "lab/export/engine_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "elastin/core/base/text.h"
#include "lab/export/formats.h"
#include "lab/export/process.h"
#include "lab/report/page.h"

namespace elastin::lab {
namespace {

using Json = nlohmann::json;

/// An answer that is not one, in words.
struct Fault {
  std::string text;
};

std::string node_has(const char* package) {
  return fmt::format("node -e 'require(\"module\").createRequire(process.cwd() + \"/\").resolve(\"{}\")'", package);
}

/// What an engine printed: its last line that is a JSON object. Python writes numbers that JSON does not have.
Json answer_of(const std::string& path) {
  std::ifstream file(path);
  Json answer;
  for (std::string line; std::getline(file, line);) {
    if (line.find_first_not_of(" \t\r") == std::string::npos || line[line.find_first_not_of(" \t\r")] != '{') continue;
    for (const std::string_view word : {"-Infinity", "Infinity", "NaN"})
      for (std::size_t at = 0; (at = line.find(word, at)) != std::string::npos;) line.replace(at, word.size(), "null");
    Json read = Json::parse(line, nullptr, false);
    if (read.is_object()) answer = std::move(read);
  }
  if (answer.is_null()) throw Fault{"it printed no line with a JSON object"};
  return answer;
}

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

OtherSolution solution_of(const Json& answer, const ExportedBody& body, Run& run) {
  if (answer.contains("error")) {
    run.suited = false;
    throw Fault{answer["error"].is_string() ? answer["error"].get<std::string>() : answer["error"].dump()};
  }
  if (!answer.contains("positions")) throw Fault{"its answer has neither 'positions' nor 'error'"};
  const Positions positions = vectors_of(answer, "positions", body.positions.cols());
  read_report(answer, *run.engine);
  if (answer.contains("at_rest") && answer["at_rest"] == false)
    throw Fault{
        fmt::format("not at rest after {}", counted(run.engine->steps, "step")) +
        (answer.contains("cause") && answer["cause"].is_string() ? ": " + answer["cause"].get<std::string>() : "")};
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

std::string request_text(const ExportedBody& body, const EngineSettings& settings, const std::string& folder) {
  std::string one_line = json_of_body(body);
  std::erase(one_line, '\n');
  return fmt::format(
      "{{\"elastin_request\": 1, \"dt\": {}, \"iterations\": {}, \"tolerance\": 1e-5, \"most_steps\": 20000, "
      "\"seconds\": {}, \"folder\": {}, \"body\": {}}}\n",
      settings.time_step, settings.iterations ? std::to_string(*settings.iterations) : "null", settings.seconds,
      Json(folder).dump(), one_line);
}

/// Hands the body over, waits for the answer and measures it.
void solve_once(const Engine& engine, const Scene& scene, const ExportedBody& body, const EngineSettings& settings,
                const std::function<bool()>& stop, Run& run) {
  const auto begin = std::chrono::steady_clock::now();
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
      run_process(folder, "{ " + engine.command + "\n} < \"$0/request.json\" > \"$0/answer\" 2> \"$0/log\"", "", stop,
                  settings.seconds);
  run.solve_seconds += ended.seconds;
  if (ended.stopped) {
    run.outcome = Outcome::interrupted;
    throw Fault{"interrupted"};
  }
  if (ended.timed_out) throw Fault{fmt::format("no answer in {:.3g} s", settings.seconds)};
  if (!ended.well) throw Fault{"it ended with " + ended.text + ": " + complaint(folder.file("log"))};
  measure_other(scene, 1, solution_of(answer_of(folder.file("answer")), body, run), run);
}

/// How far the engine may stay from the modulus that its constants have, and how little it may gain by twice the
/// constants until it counts as saturated.
constexpr double kMet = 2e-3, kLeastGain = 0.02;

/// One factor on all constants, until the engine shows the modulus that Elastin finds with those given: secants of
/// log E over log factor. Where more stiffness changes nothing the run says how stiff the engine can be.
void calibrate_in(const Engine& engine, const Scene& scene, const ExportedBody& body, const EngineSettings& settings,
                  const std::function<bool()>& stop, Run& run) {
  constexpr int kMostRuns = 12;
  constexpr double kLargestFactor = 8;  // from run to run
  const std::string name = calibrated_measure(*scene.experiment->at_rest(), scene.specimen.material);
  const std::string measure =
      name.empty() ? scene.experiment->main_measures(scene.specimen.material, {}).front().name : name;
  RunOptions options;
  options.statics = scene.statics;
  options.stop = stop;
  const double target = run_strategy(scene.specimen, *scene.experiment, scene.stiffness, options).measures.get(measure);
  if (!(target > 0)) throw Fault{"Elastin itself finds no positive " + measure + " to calibrate to"};
  double factor = 1, last_factor = 0, last = 0, slope = 1;
  for (int trial = 0; trial < kMostRuns; ++trial) {
    ExportedBody scaled = body;
    for (auto& one : scaled.connections) one.stiffness *= factor;
    for (auto* cells : {&scaled.cells, &scaled.tetrahedra})
      for (auto& cell : *cells) cell.youngs_modulus *= factor;
    Run found;
    found.engine = run.engine;
    solve_once(engine, scene, scaled, settings, stop, found);
    const double shown = found.measures.get(measure);
    run.measures = found.measures;
    run.curve = found.curve;
    run.engine = found.engine;
    run.solve_seconds += found.solve_seconds;
    run.calibration_factor = factor;
    if (!(shown > 0)) throw Fault{"it shows no positive " + measure};
    if (std::abs(shown / target - 1) <= kMet) {
      run.warnings.push_back(
          fmt::format("its constants are {:.4g} times those of the strategy, so that it shows their "
                      "{}",
                      factor, measure));
      return;
    }
    if (last > 0) slope = std::log(shown / last) / std::log(factor / last_factor);
    if (last > 0 && shown < target && factor > last_factor && slope < std::log2(1 + kLeastGain)) {
      run.outcome = Outcome::limit_reached;
      const std::string iterations =
          run.engine->iterations > 0 ? counted(run.engine->iterations, "iteration") : "its iterations";
      throw Fault{
          fmt::format("saturated: with {} and steps of {:.4g} s it shows no more than {:.4g} of the {} of the "
                      "constants, however large they are; take shorter steps or more iterations",
                      iterations, settings.time_step, shown / target, measure)};
    }
    last = shown, last_factor = factor;
    factor *= std::clamp(std::pow(target / shown, 1 / std::max(slope, 0.1)), 1 / kLargestFactor, kLargestFactor);
  }
  throw Fault{fmt::format("{} runs have not found a factor of its constants that shows their {}", kMostRuns, measure)};
}

void solve_in(const Engine& engine, const Scene& scene, const EngineSettings& settings,
              const std::function<bool()>& stop, Run& run) {
  if (!scene.experiment->at_rest()) throw InputError("engines run experiments at rest");
  if (!scene.specimen.loads.empty())
    throw InputError("loads in addition to the experiment's are not measured separately");
  const ExportedBody body = exported_body(scene);
  run.warnings = body.notes;
  (settings.calibrate ? calibrate_in : solve_once)(engine, scene, body, settings, stop, run);
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
    const auto add = [&](const char* name, const char* summary, const std::string& test, const char* install,
                         const char* program, const char* driver) {
      rows.add({{name, summary, "scenes/README.md"},
                test,
                install,
                fmt::format("exec {} \"$0/{}\"", program, driver),
                driver});
    };
    add("jolt", "soft body of Jolt, in node", node_has("jolt-physics"), "npm install jolt-physics", "node", "jolt.mjs");
    add("rapier", "soft body of Rapier, in node", node_has("@dimforge/rapier3d-compat"),
        "npm install @dimforge/rapier3d-compat", "node", "rapier.mjs");
    add("mujoco", "tendons or a flex of MuJoCo, in node", node_has("@mujoco/mujoco"), "npm install @mujoco/mujoco",
        "node", "mujoco.mjs");
    add("lammps", "harmonic bonds of LAMMPS", "command -v lmp && command -v python3", "apt-get install lammps python3",
        "python3", "lammps_engine.py");
    return rows;
  }();
  return table;
}

std::vector<Engine> chosen_engines(const std::string& names, const std::vector<std::string>& commands,
                                   const Catalog& catalog) {
  std::vector<Engine> chosen;
  const auto add = [&](Engine engine, const std::string& option) {
    for (const Strategy& strategy : catalog.strategies())
      if (strategy.name == engine.name)
        throw InputError(option + ": '" + engine.name + "' is a strategy; give the engine another name");
    for (const Engine& other : chosen)
      if (other.name == engine.name) throw InputError(option + ": '" + engine.name + "' is there twice");
    chosen.push_back(std::move(engine));
  };
  std::istringstream list(names);
  for (std::string name; std::getline(list, name, ',');) {
    name.erase(0, name.find_first_not_of(' '));
    name.erase(name.find_last_not_of(' ') + 1);
    add(*engines().find(name), "--engines");
  }
  for (const std::string& command : commands) {
    std::istringstream words(command);
    std::string name;
    for (std::string word; words >> word;)
      if (word.front() != '-') name = std::filesystem::path(word).stem().string();
    if (name.empty() || !std::all_of(name.begin(), name.end(), [](unsigned char letter) {
          return std::isalnum(letter) || letter == '_' || letter == '-' || letter == '.';
        }))
      throw InputError("--engine: '" + command + "' does not end in the name of a program or script");
    add({{name, "command of the user", ""}, "", "", command}, "--engine");
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
  rig->set_load(load);
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
                    const std::vector<std::string>& overrides, const EngineSettings& settings,
                    const std::function<bool()>& stop) {
  OtherRun result;
  Run& run = result.run;
  if (const std::string why = missing(engine); !why.empty()) {
    run.suited = false;
    run.cause = why;
  } else if (engine.solve) {
    result = engine.solve(scene, catalog, overrides, stop);
  } else {
    run.engine = EngineReport{"", scene.stiffness.label, settings.time_step, settings.iterations.value_or(0)};
    try {
      prepare(scene.specimen, scene.stiffness.strategy);
      solve_in(engine, scene, settings, stop, run);
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
