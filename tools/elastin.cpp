// The command: elastin run|compare|verify|check|list.

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string_view>

#include "base/waiting_threads.h"
#include "elastin/base/error.h"
#include "elastin/base/threads.h"
#include "elastin/contact/overlaps.h"
#include "report/check.h"
#include "report/files.h"
#include "report/progress.h"
#include "report/summary.h"
#include "report/table.h"
#include "report/verdicts.h"
#include "scene/scene.h"

namespace {

using namespace elastin;

constexpr const char* kExamples = R"(
Examples:
  elastin compare scenes/tension/cube-1000.yaml                 every stiffness strategy of the scene, side by side
  elastin compare scenes/tension/*.yaml --strategies all        all that the catalog has, on every scene
  elastin compare scenes/zoo/*.yaml --summary                   what each strategy is worth over all bodies
  elastin run scenes/tension/dogbone.yaml --out out             one strategy, all measures; files for ParaView in out/
  elastin run scenes/tension/cube-27-face.yaml --set stiffness=lattice --set material.youngs_modulus='10 kPa'
  elastin run scenes/tension/cube-1000.yaml --json - | jq .runs[0].measures
  elastin check scenes/tension/table1-b.yaml                    what the body is, and its zero-energy modes
  elastin verify scenes/hard/*.yaml --choices                   hard cases against their known answers: a verdict each
  elastin list                                                  strategies and their parameters

Exit codes: 0 all expectations hold; 1 an expectation or a run failed; 2 wrong use or input.
)";

struct Options {
  std::vector<std::string> scenes, overrides;
  std::string strategies, out, json, restart;
  int threads = 0;
  bool quiet = false, summary = false, others = false, markdown = false, live = false;
};

volatile std::sig_atomic_t interrupted = 0;

/// The first interrupt ends a run in time after its frame, with everything written; the second ends the command.
void note_interrupt(int) {
  interrupted = 1;
  std::signal(SIGINT, SIG_DFL);
}

/// Colours on a terminal only, but for who insists (CLICOLOR_FORCE; tools/picture does) or declines (NO_COLOR).
bool colours(int stream) { return std::getenv("CLICOLOR_FORCE") || (isatty(stream) && !std::getenv("NO_COLOR")); }

/// Names of a run's files: of scene and strategy, without letters that mean something in a path or in XML.
std::string file_name(const std::string& scene, const std::string& strategy) {
  std::string name = scene + "-" + strategy;
  for (char& c : name)
    if (std::string_view(":/\\ \"'<>&").find(c) != std::string_view::npos) c = '-';
  return name;
}

std::string restart_text_of(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  if (!stream || std::filesystem::is_directory(path)) throw InputError("--restart: " + path + ": cannot be read");
  return {std::istreambuf_iterator<char>(stream), {}};
}

RunOptions run_options_of(const Options& options, const Scene& scene, const StrategyChoice& choice,
                          Progress& progress) {
  RunOptions result;
  result.statics = scene.statics;
  result.time = scene.time;
  result.live = options.live;
  result.keep_snapshots = !options.out.empty();
  result.progress = [&progress, name = scene.name + ", " + choice.label + ": "](const std::string& doing) {
    progress.set(name + doing);
  };
  result.stop = [] { return interrupted != 0; };
  if (!options.restart.empty()) result.restart = restart_text_of(options.restart);
  if (!options.out.empty())
    result.checkpoint = [path = options.out + "/" + file_name(scene.name, choice.label) +
                                ".restart"](const std::string& text) { write_whole(path, text); };
  return result;
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
  std::vector<StrategyChoice> choices;
  for (std::string label : CLI::detail::split(options.strategies, ',')) {
    CLI::detail::trim(label);
    if (label == "all")
      for (StrategyChoice& choice : all_strategies(catalog))
        if (!find_strategy(choices, choice.label)) choices.push_back(std::move(choice));
    if (label == "all" || find_strategy(choices, label)) continue;
    // A strategy that the scene names keeps the scene's parameters.
    const StrategyChoice* known = find_strategy(scene.strategies, label);
    if (scene.stiffness.label == label && (!known || known->values.empty())) known = &scene.stiffness;
    try {
      choices.push_back(known ? *known : choose_strategy(catalog, label));
    } catch (const InputError& error) {
      throw InputError(std::string("--strategies: ") + error.what());
    }
  }
  return choices;
}

/// Reads all scenes before anything runs: a slip in the last one must not cost the others' time.
std::vector<std::unique_ptr<Scene>> load_scenes(const Options& options, const Catalog& catalog, Progress& progress) {
  std::vector<std::unique_ptr<Scene>> scenes;
  for (const std::string& path : options.scenes) {
    progress.set("reading " + path);
    scenes.push_back(load_scene(path, catalog, options.overrides));
    for (std::size_t i = 0; i + 1 < scenes.size() && !options.out.empty(); ++i)
      if (scenes[i]->name == scenes.back()->name)
        throw InputError("--out: " + scenes[i]->path + " and " + path + " have one name: so would their files");
  }
  return scenes;
}

/// Curve and states of one run.
void write_run(const Options& options, const Scene& scene, Record& record) {
  if (options.out.empty() || record.run.curve.empty()) return;
  const std::string name = file_name(record.scene, record.run.strategy);
  write_whole(options.out + "/" + name + "-curve.csv", curve_csv_text(record));
  const auto& contact = scene.specimen.contact;
  write_states(options.out, name, scene.specimen.body, record.run,
               contact ? contact->obstacles : std::vector<Obstacle>{});
  record.run.snapshots.clear();
}

/// Runs every chosen strategy on every scene; `compare` prints one table a scene and, of several, a summary; `run` one
/// page a run.
int run_scenes(const Options& options, const Catalog& catalog, bool compare) {
  const bool to_screen = !options.quiet && options.json != "-";
  Progress progress(to_screen && isatty(STDERR_FILENO));
  std::vector<std::unique_ptr<Scene>> scenes = load_scenes(options, catalog, progress);
  progress.pause();
  std::vector<std::vector<StrategyChoice>> choices;
  for (const auto& scene : scenes) choices.push_back(chosen_strategies(options, catalog, *scene, compare));
  if (!options.restart.empty() && (scenes.size() != 1 || choices[0].size() != 1 || !scenes[0]->time))
    throw InputError("--restart: goes on with one strategy of one scene that runs in time");
  if (std::any_of(scenes.begin(), scenes.end(), [](const auto& scene) { return scene->time.has_value(); }))
    std::signal(SIGINT, note_interrupt);
  write_files(options, {});  // a folder that cannot be written to is said before the work
  std::vector<Record> all;
  bool good = true;
  const bool tables = to_screen && compare && !options.summary;
  const std::size_t count = scenes.size();
  for (std::size_t i = 0; i < count; ++i) {
    Scene& scene = *scenes[i];
    std::vector<Record> records;
    for (const StrategyChoice& choice : choices[i]) {
      const auto start = std::chrono::steady_clock::now();
      prepare(scene.specimen.body, choice.strategy, scene.specimen.material);
      const std::chrono::duration<double> prepared = std::chrono::steady_clock::now() - start;
      Run run =
          run_strategy(scene.specimen, *scene.experiment, choice, run_options_of(options, scene, choice, progress));
      run.build_seconds += prepared.count();  // once a body: the first strategy that needs it pays
      Record record = make_record(scene, std::move(run));
      progress.pause();
      // `run` names its one strategy: that it cannot run is a failure; in a comparison it is a row.
      good &= record.good() && (compare || record.run.suited || record.stopped_as_expected());
      write_run(options, scene, record);
      if (to_screen && !compare) fmt::print("{}", run_text(record, colours(STDOUT_FILENO)));
      records.push_back(record);
      all.push_back(std::move(record));
      write_files(options, all);
      if (interrupted) break;
    }
    if (tables) fmt::print("{}", comparison_text(records, colours(STDOUT_FILENO)));
    if (to_screen && !options.summary)
      for (const std::string& warning : scene.warnings) fmt::print("  warning: {}\n", warning);
    std::fflush(stdout);
    scenes[i].reset();
    if (interrupted) break;
  }
  if (to_screen && compare && (options.summary || count > 1))
    fmt::print("{}", summary_text(all, colours(STDOUT_FILENO)));
  if (options.json == "-") fmt::print("{}", json_text(all));
  if (to_screen && !options.out.empty())
    fmt::print("  files in {}/: runs.csv, runs.json, curves, and .pvd for ParaView\n", options.out);
  return good ? 0 : 1;
}

/// Holds every scene against what it says must come of it.
int verify_scenes(const Options& options, const Catalog& catalog) {
  const bool to_screen = !options.quiet && options.json != "-";
  Progress progress(to_screen && isatty(STDERR_FILENO));
  load_scenes(options, catalog, progress);
  write_files(options, {});
  VerifyOptions verify{options.overrides, options.others, !options.out.empty()};
  verify.progress = [&](const std::string& doing) { progress.set(doing); };
  verify.finished = [&](const Scene& scene, Record& record) { write_run(options, scene, record); };
  std::vector<Case> cases;
  std::vector<Record> records;
  for (const std::string& path : options.scenes)
    for (Case& a_case : verify_scene(path, catalog, verify)) {
      records.push_back(a_case.own);
      cases.push_back(std::move(a_case));
      write_files(options, records);
    }
  progress.pause();
  if (to_screen) fmt::print("{}", verdicts_text(cases, colours(STDOUT_FILENO), options.markdown));
  if (options.json == "-") fmt::print("{}", json_text(records));
  return std::all_of(cases.begin(), cases.end(), passed) ? 0 : 1;
}

int check_scenes(const Options& options, const Catalog& catalog) {
  bool sound = true;
  for (const std::string& path : options.scenes) {
    const auto scene = load_scene(path, catalog, options.overrides);
    const Body& body = scene->specimen.body;
    const CheckReport report = check_scene(*scene, catalog, find_overlaps(body, body.rest));
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
      ->take_all()
      ->allow_extra_args(false);
  command
      .add_option("--threads", options.threads, "Threads for large bodies; 0 = one a core. Same bits for any number")
      ->check(CLI::Range(0, 4096));
  command.add_flag("--quiet", options.quiet, "Print nothing but errors");
}

void add_file_options(CLI::App& command, Options& options) {
  command.add_option("--out", options.out, "Folder for CSV, JSON, curves and ParaView files");
  command.add_option("--restart", options.restart,
                     "Go on with a run in time from a .restart file that --out has got from it");
  command.add_flag("--live", options.live, "No more frames a second than time.frame_rate says");
  command.add_option("--json", options.json, "JSON file; - for standard output, and nothing else there");
}

void add_run_options(CLI::App& command, Options& options) {
  add_scene_options(command, options);
  add_file_options(command, options);
  command.add_option("--strategies", options.strategies,
                     "Comma-separated names, all among them; instead of the scene's own");
}

/// "unknown option '--thread'; did you mean …", of the first command or option that there is not; "" if there are all.
std::string unknown_word(const CLI::App& app, int argc, char** argv) {
  std::vector<std::string> commands, options;
  for (const CLI::App* command : app.get_subcommands({})) {
    commands.push_back(command->get_name());
    for (const CLI::Option* option : command->get_options())
      for (const std::string& name : option->get_lnames())
        if (std::find(options.begin(), options.end(), "--" + name) == options.end()) options.push_back("--" + name);
  }
  for (int i = 1; i < argc; ++i) {
    const std::string word = std::string(argv[i]).substr(0, std::string_view(argv[i]).find('='));
    const bool option = word.starts_with("--");
    const std::vector<std::string>& known = option ? options : commands;
    if ((option || i == 1) && std::find(known.begin(), known.end(), word) == known.end())
      return std::string("unknown ") + (option ? "option '" : "command '") + word + "'" + suggestion(word, known);
  }
  return "";
}

}  // namespace

int main(int argc, char** argv) {
  let_threads_sleep(argv);
  CLI::App app{"Elastin: soft tissue as molecules and connections, and the modulus it really has.", "elastin"};
  app.footer(kExamples);
  app.require_subcommand(1);
  Options options;
  CLI::App* run = app.add_subcommand("run", "Run a scene with its own stiffness strategy; print every measure");
  CLI::App* compare =
      app.add_subcommand("compare", "Run a scene with many strategies; print measured modulus, error and cost");
  CLI::App* verify = app.add_subcommand("verify", "Hold scenes against the answers that they state; print verdicts");
  CLI::App* check = app.add_subcommand("check", "Say what a scene's body is: counts, loose parts, zero-energy modes");
  CLI::App* list = app.add_subcommand("list", "List strategies, their parameters, and measures");
  add_run_options(*run, options);
  add_run_options(*compare, options);
  compare->add_flag("--summary", options.summary, "Print only the summary over all scenes: by strategy, by body");
  add_scene_options(*verify, options);
  add_file_options(*verify, options);
  verify->add_flag("--choices", options.others,
                   "Also what explicit and implicit steps, small displacements and plain springs make of each case");
  verify->add_flag("--markdown", options.markdown, "The table as Markdown, with titles");
  add_scene_options(*check, options);
  for (CLI::App* command : {run, compare, verify, check, list}) command->footer(kExamples);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const std::string unknown = unknown_word(app, argc, argv);
    if (error.get_exit_code() == 0 || unknown.empty()) return app.exit(error) == 0 ? 0 : 2;
    fmt::print(stderr, "elastin: {}\n", unknown);
    return 2;
  }
  try {
    set_threads(options.threads);
    const Catalog catalog = built_in_catalog();
    if (*list) return list_catalog(catalog);
    if (*verify) return verify_scenes(options, catalog);
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
