// The command: elastin run|compare|check|list.

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>

#include "elastin/base/error.h"
#include "elastin/base/threads.h"
#include "report/check.h"
#include "report/files.h"
#include "report/progress.h"
#include "report/table.h"
#include "scene/scene.h"

namespace {

using namespace elastin;

constexpr const char* kExamples = R"(
Examples:
  elastin compare scenes/tension/cube-1000.yaml                 every stiffness strategy of the scene, side by side
  elastin compare scenes/tension/*.yaml --strategies all        all that the catalog has, on every scene
  elastin run scenes/tension/dogbone.yaml --out out             one strategy, all measures; files for ParaView in out/
  elastin run scenes/tension/cube-27-face.yaml --set stiffness=lattice --set material.youngs_modulus='10 kPa'
  elastin run scenes/tension/cube-1000.yaml --json - | jq .runs[0].measures
  elastin check scenes/tension/table1-b.yaml                    what the body is, and its zero-energy modes
  elastin list                                                  strategies and their parameters

Exit codes: 0 all expectations hold; 1 an expectation or a run failed; 2 wrong use or input.
)";

struct Options {
  std::vector<std::string> scenes, overrides;
  std::string strategies, out, json;
  int threads = 0;
  bool quiet = false;
};

bool colours(int stream) { return isatty(stream) && !std::getenv("NO_COLOR"); }

std::string file_name(const Record& record) {
  std::string name = record.scene + "-" + record.run.strategy;
  for (char& c : name)
    if (c == ':' || c == '/') c = '-';
  return name;
}

/// Writes everything there is so far: an interrupted command leaves whole files of all finished runs.
void write_files(const Options& options, const std::vector<Record>& records) {
  if (!options.out.empty()) {
    write_whole(options.out + "/runs.csv", csv_text(records));
    write_whole(options.out + "/runs.json", json_text(records));
  }
  if (!options.json.empty() && options.json != "-") write_whole(options.json, json_text(records));
}

std::vector<StrategyChoice> chosen_strategies(const Options& options, const Catalog& catalog, const Scene& scene,
                                              bool compare) {
  if (options.strategies.empty()) return compare ? scene.strategies : std::vector{scene.stiffness};
  if (options.strategies == "all") return all_strategies(catalog);
  std::vector<StrategyChoice> choices;
  for (const std::string& label : CLI::detail::split(options.strategies, ',')) {
    // A strategy that the scene names keeps the scene's parameters.
    StrategyChoice choice = choose_strategy(catalog, label);
    for (const StrategyChoice& known : scene.strategies)
      if (known.label == label) choice = known;
    if (scene.stiffness.label == label && !scene.stiffness.values.empty()) choice = scene.stiffness;
    choices.push_back(choice);
  }
  return choices;
}

/// Runs every chosen strategy on every scene; `compare` prints one table a scene, `run` one page a run.
int run_scenes(const Options& options, const Catalog& catalog, bool compare) {
  const bool to_screen = !options.quiet && options.json != "-";
  // All scenes are read before anything runs: a slip in the last one must not cost the others' time.
  std::vector<std::unique_ptr<Scene>> scenes;
  std::vector<std::vector<StrategyChoice>> choices;
  for (const std::string& path : options.scenes) {
    scenes.push_back(load_scene(path, catalog, options.overrides));
    choices.push_back(chosen_strategies(options, catalog, *scenes.back(), compare));
  }
  Progress progress(to_screen && isatty(STDERR_FILENO));
  std::vector<Record> all;
  bool good = true;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    Scene& scene = *scenes[i];
    std::vector<Record> records;
    for (const StrategyChoice& choice : choices[i]) {
      RunOptions run_options;
      run_options.statics = scene.statics;
      run_options.keep_states = !options.out.empty();
      run_options.progress = [&](const std::string& doing) {
        progress.set(scene.name + ", " + choice.label + ": " + doing);
      };
      Record record = make_record(scene, run_strategy(scene.specimen, *scene.experiment, choice, run_options));
      progress.pause();
      // `run` names its one strategy: that it cannot run is a failure; in a comparison it is a row.
      good &= record.good() && (compare || record.run.suited);
      if (!options.out.empty() && !record.run.curve.empty()) {
        write_whole(options.out + "/" + file_name(record) + "-curve.csv", curve_csv_text(record));
        write_states(options.out, file_name(record), scene.specimen.body, record.run);
        record.run.states.clear();
      }
      if (to_screen && !compare) fmt::print("{}", run_text(record, colours(STDOUT_FILENO)));
      records.push_back(record);
      all.push_back(std::move(record));
      write_files(options, all);
    }
    if (to_screen && compare) fmt::print("{}", comparison_text(records, colours(STDOUT_FILENO)));
    if (to_screen)
      for (const std::string& warning : scene.warnings) fmt::print("  warning: {}\n", warning);
    std::fflush(stdout);
    scenes[i].reset();
  }
  if (options.json == "-") fmt::print("{}", json_text(all));
  if (to_screen && !options.out.empty())
    fmt::print("  files in {}/: runs.csv, runs.json, curves, and .pvd for ParaView\n", options.out);
  return good ? 0 : 1;
}

int check_scenes(const Options& options, const Catalog& catalog) {
  bool sound = true;
  for (const std::string& path : options.scenes) {
    const auto scene = load_scene(path, catalog, options.overrides);
    const CheckReport report = check_scene(*scene, catalog);
    if (!options.quiet) fmt::print("{}\n", report.text);
    sound &= report.sound;
  }
  return sound ? 0 : 1;
}

int list_catalog(const Catalog& catalog) {
  fmt::print("{}", catalog_text(catalog, colours(STDOUT_FILENO)));
  return 0;
}

void add_scene_options(CLI::App& command, Options& options) {
  command.add_option("scenes", options.scenes, "Scene files (YAML)")->required();
  command
      .add_option("--set", options.overrides,
                  "Set a key of the scene: KEY.PATH=VALUE; a plain number is SI. May be repeated")
      ->take_all();
  command
      .add_option("--threads", options.threads, "Threads for large bodies; 0 = one a core. Same bits for any number")
      ->check(CLI::Range(0, 4096));
  command.add_flag("--quiet", options.quiet, "Print nothing but errors");
}

void add_run_options(CLI::App& command, Options& options) {
  add_scene_options(command, options);
  command.add_option("--strategies", options.strategies, "Comma-separated names, or all; instead of the scene's own");
  command.add_option("--out", options.out, "Folder for CSV, JSON, curves and ParaView files");
  command.add_option("--json", options.json, "JSON file; - for standard output, and nothing else there");
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Elastin: soft tissue as molecules and connections, and the modulus it really has."};
  app.footer(kExamples);
  app.require_subcommand(1);
  Options options;
  CLI::App* run = app.add_subcommand("run", "Run a scene with its own stiffness strategy; print every measure");
  CLI::App* compare =
      app.add_subcommand("compare", "Run a scene with many strategies; print measured modulus, error and cost");
  CLI::App* check =
      app.add_subcommand("check", "Say what a scene's body is: counts, loose parts, overlaps, zero-energy modes");
  CLI::App* list = app.add_subcommand("list", "List strategies, their parameters, and measures");
  add_run_options(*run, options);
  add_run_options(*compare, options);
  add_scene_options(*check, options);
  for (CLI::App* command : {run, compare, check, list}) command->footer(kExamples);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  try {
    set_threads(options.threads);
    const Catalog catalog = built_in_catalog();
    if (*list) return list_catalog(catalog);
    if (*check) return check_scenes(options, catalog);
    return run_scenes(options, catalog, static_cast<bool>(*compare));
  } catch (const InputError& error) {
    fmt::print(stderr, "elastin: {}\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "elastin: internal error: {}\n", error.what());
    return 1;
  }
}
