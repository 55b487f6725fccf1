#include "elastin/command/command.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <new>
#include <sstream>
#include <string_view>
#include <system_error>

#include "command/identify.h"
#include "elastin/contact/overlaps.h"
#include "elastin/core/base/error.h"
#include "elastin/core/parallel/threads.h"
#include "elastin/openmp/openmp.h"
#include "lab/export/calculix_run.h"
#include "lab/export/formats.h"
#include "lab/live/live.h"
#include "lab/report/files.h"
#include "lab/report/json.h"
#include "lab/report/progress.h"
#include "lab/report/screen.h"
#include "lab/report/table.h"
#include "lab/scene/key_reference.h"
#include "lab/scene/scene.h"
#include "lab/study/check.h"
#include "lab/study/compare.h"
#include "lab/study/csv_plot.h"
#include "lab/study/material_plot.h"
#include "lab/study/merge.h"
#include "lab/study/new_scene.h"
#include "lab/study/shards.h"
#include "lab/study/steppers.h"
#include "lab/study/verdicts.h"

namespace elastin::command {
using namespace lab;
namespace {

constexpr const char* kExamples =
    R"(  {0} compare scenes/tension/cube-1000.yaml                 every stiffness strategy of the scene, side by side
  {0} compare scenes/tension/*.yaml --strategies all        every strategy of the catalog, on every scene
  {0} compare scenes/zoo/*.yaml --summary                   what each strategy is worth over all bodies
  {0} compare scenes/material/cantilever.yaml --out out     also a page: error against time, the body in 3D, tables
  {0} compare scenes/tension/cube-1000.yaml --vary 'solver.linear_solver=[pcg, direct]' --repeats 5
  {0} compare scenes/study/cantilever.yaml --shard 3/16 --resume study/3    the third of 16 jobs that share the rows
  {0} merge study/* --out out                               the table and page of all the jobs' rows
  {0} compare scenes/steppers/cube-1000.yaml --out out      modulus, error and milliseconds of each time-stepping scheme
  {0} run scenes/tension/dogbone.yaml --out out             one strategy, all measures; files for ParaView in out/
  {0} run scenes/tension/cube-27-face.yaml --set stiffness=lattice --set material.youngs_modulus='10 kPa'
  {0} run scenes/tension/cube-1000.yaml --json - | jq .runs[0].measures
  {0} check scenes/tension/table1-b.yaml                    counts of the body, and its zero-energy modes
  {0} verify scenes/hard/*.yaml --choices                   hard cases compared with their known results
  {0} identify scenes/identify/treloar-ogden.yaml           the material of a measured curve, and how sure its numbers are
  {0} lab scenes/tension/cube-1000.yaml --out lab.html      the body in a browser: drag it, change its strategy, test it
  {0} export scenes/tension/dogbone.yaml --to vtu --out bone.vtu    the body, or all of the problem, for another program
  {0} compare scenes/study/clamped-block.yaml --against calculix    a row by CalculiX beside them
  {0} list                                                  strategies and their parameters
  {0} plot out/cube-1000-lattice-curve.csv > curve.svg      stress over strain, or any two columns of a CSV file
  {0} new strip --size '40 x 10 x 4 mm' --modulus '20 kPa'  a commented scene to begin with; without options it asks
)";
constexpr const char* kExitCodes =
    "Exit codes: 0 all expectations hold; 1 an expectation or a run failed; 2 wrong use or input.\n";

/// The lines of kExamples that are of a command, or all of them.
std::string examples_of(const std::string& name, const std::string& command) {
  std::istringstream lines(fmt::format(kExamples, name));
  std::string out;
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with("  " + name + " " + command)) out += line + "\n";
  return out;
}

struct Options : Request {
  std::string resume_from, shard_text, x_column, y_column, page, module, format;
  IdentifyRequest identify;
  int threads = 0;
  double stretch = 1.5;
  bool others = false, each_stepper = false, markdown = false, keys = false;
  NewScene scene;
};

volatile std::sig_atomic_t interrupted = 0;

/// The first interrupt ends a run after its step, in time or of the load, and a comparison after its run, with
/// everything written; the second ends the command.
void note_interrupt(int) {
  constexpr std::string_view said = "\n  stopping after this run or step; Ctrl-C again stops at once\n";
  if (write(STDERR_FILENO, said.data(), said.size()) < 0) interrupted = 1;  // nobody to tell
  interrupted = 1;
  std::signal(SIGINT, SIG_DFL);
}

/// Compares what comes of every scene with what it expects.
int verify_scenes(const Options& options, const Catalog& catalog) {
  Progress progress(progress_of(options));
  for (const std::string& path : options.scenes)
    load_scene(path, catalog, options.overrides);  // errors in scenes come before the first run
  write_tables(options, {});
  VerifyOptions verify{options.overrides, options.others, options.each_stepper, !options.out.empty()};
  verify.progress = [&](const std::string& doing) { progress.set(doing); };
  verify.finished = [&](const Scene& scene, Record& record) {
    write_run(options, scene, record);
    if (!options.verbose || !options.to_screen()) return;
    progress.pause();
    fmt::print("{}", run_text(record, colours_on(STDOUT_FILENO), true));
  };
  std::vector<Case> cases;
  std::vector<Record> records;
  for (const std::string& path : options.scenes)
    for (Case& a_case : verify_scene(path, catalog, verify)) {
      records.push_back(a_case.own);
      cases.push_back(std::move(a_case));
      write_tables(options, records);
    }
  progress.pause();
  if (options.to_screen()) fmt::print("{}", verdicts_text(cases, colours_on(STDOUT_FILENO), options.markdown));
  if (options.json == "-") fmt::print("{}", json_text(records));
  const auto failed = [](const Case& a_case) { return result_of(a_case) == CaseResult::failed; };
  return std::any_of(cases.begin(), cases.end(), failed) ? 1 : 0;
}

/// --resume DIR is --out DIR with what is there already.
void continue_in_folder(Options& options) {
  if (options.resume_from.empty()) return;
  if (!options.out.empty() && options.out != options.resume_from)
    throw InputError("--resume continues in its own folder; leave out --out");
  options.out = options.resume_from;
  options.resume = true;
}

/// `compare` and `run`. The first interrupt ends the run under way and leaves whole files; see note_interrupt.
int run_all(Options& options, const Catalog& catalog, bool compare) {
  options.compare = compare;
  options.interrupted = [] { return interrupted != 0; };
  continue_in_folder(options);
  if (!options.shard_text.empty()) {
    options.shard = read_shard(options.shard_text);
    if (options.out.empty())
      throw InputError(
          "--shard needs a folder of its own for its rows, which `merge` reads: --out DIR or --resume DIR");
    if (!options.peers.empty() || !options.baseline.empty())
      throw InputError("--shard has no table to show them in: give --peers and --baseline to `merge`");
    if (compares_steppers(options, catalog))
      throw InputError("--shard divides the runs of strategies; a comparison of steppers is not divided");
  }
  std::signal(SIGINT, note_interrupt);
  if (compare && compares_steppers(options, catalog)) return compare_steppers(options, catalog) ? 0 : 1;
  return run_scenes(options, catalog) ? 0 : 1;
}

/// `merge`: its scenes are folders.
int merge_folders(Options& options) {
  options.compare = true;
  return merge_studies(options) ? 0 : 1;
}

/// The curves of each material of these scenes that has a law.
int plot_materials(const Options& options, const Catalog& catalog) {
  for (std::size_t i = 1; i < options.scenes.size(); ++i) {
    const auto scene = load_scene(options.scenes[i], catalog, options.overrides);
    std::vector<Material> materials = scene->specimen.materials;
    if (materials.empty()) materials.push_back(scene->specimen.material);
    bool any = false;
    for (const Material& material : materials) {
      if (!material.law) continue;
      any = true;
      const std::string title =
          fmt::format("{}: {}, E = {} and nu = {:.4g} at rest", scene->name, material.law->law,
                      readable(material.youngs_modulus, dimension::pressure), material.poissons_ratio);
      const auto law = catalog.material_laws.find(material.law->law);
      fmt::print("{}", svg_text(material_plot(title, *law, material, options.stretch), 760, true));
    }
    if (!any)
      throw InputError(options.scenes[i] + ": no material has a `law`; its curve is its E, or what it states itself");
  }
  if (options.scenes.size() < 2) throw InputError("plot material: name a scene");
  return 0;
}

int plot_columns(const Options& options) {
  for (const std::string& path : options.scenes)
    fmt::print("{}", svg_text(csv_plot(path, options.x_column, options.y_column), 760, true));
  return 0;
}

int check_scenes(const Options& options, const Catalog& catalog) {
  bool sound = true;
  for (const std::string& path : options.scenes) {
    const auto scene = load_scene(path, catalog, options.overrides);
    const Body& body = scene->specimen.body;
    const CheckReport report = check_scene(*scene, catalog, contact::find_overlaps(body, body.rest));
    if (!options.quiet) fmt::print("{}\n", report.text);
    sound &= report.sound;
  }
  return sound ? 0 : 1;
}

/// The first interrupt ends the search under way with the best that it has.
int identify_all(Options& options, const Catalog& catalog) {
  options.interrupted = [] { return interrupted != 0; };
  std::signal(SIGINT, note_interrupt);
  continue_in_folder(options);
  return identify_scenes(options, options.identify, catalog) ? 0 : 1;
}

/// Where tools/setup --web puts the module beside this program, or where an installed one has it.
std::string module_folder(const Options& options) {
  if (!options.module.empty()) return options.module;
  std::error_code problem;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", problem);
  const std::filesystem::path root = program.parent_path().parent_path();
  const std::filesystem::path installed = root / "share" / "elastin" / "web";
  return (std::filesystem::exists(installed) ? installed : root / "web" / "bin").string();
}

/// The scene as a page that runs it in a browser.
int write_lab(const Options& options, const Catalog& catalog) {
  if (options.scenes.size() != 1) throw InputError("lab: name one scene");
  const auto scene = load_scene(options.scenes.front(), catalog, options.overrides);
  const std::string page = live_page(*scene, catalog, load_web_module(module_folder(options)));
  if (options.page == "-") {
    fmt::print("{}", page);
    return 0;
  }
  write_whole(options.page, page);
  if (!options.quiet)
    fmt::print("{}: {:.2f} MB, opens in any browser\n", options.page, 1e-6 * static_cast<double>(page.size()));
  return 0;
}

/// The scene with its own strategy as a file of another program.
int export_scene(const Options& options, const Catalog& catalog) {
  if (options.scenes.size() != 1) throw InputError("export: name one scene");
  const auto format = export_formats().find(options.format);
  const auto scene = load_scene(options.scenes.front(), catalog, options.overrides);
  std::vector<std::string> notes;
  const std::string text = format->text(*scene, notes);
  if (options.page == "-") {
    fmt::print("{}", text);
    return 0;
  }
  if (!options.page.ends_with(format->ending))
    throw InputError("--out " + options.page + ": files of " + format->name + " end in " + format->ending);
  write_whole(options.page, text);
  if (options.quiet) return 0;
  fmt::print("{}: {}, {:.3g} MB\n", options.page, format->summary, 1e-6 * static_cast<double>(text.size()));
  for (const std::string& note : notes) fmt::print("  {}\n", note);
  return 0;
}

int list_catalog(const Options& options, const Catalog& catalog) {
  if (options.keys)
    fmt::print("{}", key_reference(catalog, built_in_experiments()));
  else
    fmt::print("{}", catalog_text(catalog, built_in_experiments(), colours_on(STDOUT_FILENO)));
  return 0;
}

/// The answer to a question on the terminal; "" at the end of input.
std::string answer_to(const std::string& question, const std::string& otherwise) {
  say(fmt::format("{}{}: ", question, otherwise.empty() ? "" : " [" + otherwise + "]"));
  std::string line;
  std::getline(std::cin, line);
  return line.empty() ? otherwise : line;
}

/// What the options leave open is asked for, on a terminal only.
void ask_for_rest(NewScene& scene, bool modulus_given) {
  const bool can_ask = isatty(STDIN_FILENO) && isatty(STDERR_FILENO);
  if (scene.specimen.empty()) {
    std::string names;
    for (const NewSpecimen& row : new_specimens()) {
      if (can_ask) say(fmt::format("  {:12} {}\n", row.name, row.summary));
      names += std::string(names.empty() ? "" : ", ") + row.name;
    }
    if (!can_ask) throw InputError("new: name a specimen: " + names);
    scene.specimen = answer_to("specimen", "strip");
  }
  for (const NewSpecimen& row : new_specimens()) {
    if (scene.specimen != row.name) continue;
    std::string& missing = row.from_file ? scene.mesh : scene.size;
    if (!missing.empty()) continue;
    if (!can_ask)
      throw InputError(std::string("new ") + row.name +
                       (row.from_file ? ": give --mesh FILE" : ": give --size, such as '40 x 10 x 4 mm'"));
    missing = answer_to(row.from_file ? "file of the mesh or surface" : "size along x, y, z",
                        row.from_file ? "" : "40 x 10 x 4 mm");
    if (!modulus_given) scene.modulus = answer_to("Young's modulus", scene.modulus);
  }
}

/// Writes a scene to begin with, reads it as any scene is read, and says how to go on.
int write_new_scene(Options& options, const Catalog& catalog, bool modulus_given) {
  ask_for_rest(options.scene, modulus_given);
  const std::string path = options.out.empty() ? options.scene.specimen + ".yaml" : options.out;
  if (std::filesystem::exists(path)) throw InputError(path + ": is there already; choose another name with --out");
  write_whole(path, new_scene_text(options.scene, std::filesystem::path(path).parent_path().string()));
  const auto scene = load_scene(path, catalog, {});
  if (!options.quiet)
    fmt::print("  {}: {} molecules, {} cells\n  elastin compare {} --out out    runs it and writes out/report.html\n",
               path, scene->specimen.body.size(), count_cells(scene->specimen.body), path);
  return 0;
}

void add_new_options(CLI::App& command, Options& options) {
  std::string names;
  for (const NewSpecimen& row : new_specimens())
    names += fmt::format("{}{}: {}", names.empty() ? "" : "; ", row.name, row.summary);
  command.add_option("specimen", options.scene.specimen, names);
  command.add_option("--size", options.scene.size, "Lengths of a block along x, y, z: '40 x 10 x 4 mm'");
  command.add_option("--mesh", options.scene.mesh, "File of the mesh (dogbone) or of the closed surface (organ)");
  command.add_option("--length-unit", options.scene.length_unit, "Unit of the file's coordinates")
      ->capture_default_str();
  command.add_option("--modulus", options.scene.modulus, "Young's modulus")->capture_default_str();
  command.add_option("--poissons-ratio", options.scene.poissons_ratio, "Poisson's ratio")->capture_default_str();
  command.add_option("--out", options.out, "File to write; default: SPECIMEN.yaml");
  command.add_flag("--quiet", options.quiet, "Print nothing but errors");
}

void add_scene_options(CLI::App& command, Options& options) {
  command.add_option("SCENE", options.scenes, "Scene files (YAML)")->required();
  command
      .add_option("--set", options.overrides,
                  "Set a key of the scene: KEY.PATH=VALUE; a plain number is SI. May be repeated")
      ->take_all()
      ->allow_extra_args(false);
  command
      .add_option("--threads", options.threads,
                  "Threads for large bodies; 0 = one for each core. Results are bitwise identical for any number")
      ->check(CLI::Range(0, 4096));
  command.add_flag("--quiet", options.quiet, "Print nothing but errors");
}

void add_file_options(CLI::App& command, Options& options) {
  command.add_option("--out", options.out, "Folder for CSV, JSON, curves and ParaView files");
  command.add_option("--pieces", options.pieces)->group("");  // of a process that is not the first, see processes.h
  command.add_option("--restart", options.restart, "Continue a run in time from a .restart file that --out wrote");
  command.add_flag("--live", options.live, "Show at most time.frame_rate frames a second");
  command.add_option("--baseline", options.baseline, "Folder of an earlier --out: tell what changed since, run by run");
  command.add_option("--json", options.json, "JSON file; - for standard output, and nothing else there");
  command.add_flag("--verbose", options.verbose,
                   command.get_name() == "run"
                       ? "Print every point of the response curve, with all its measures"
                       : "Print every run in full as it is finished, before the tables, with every point of its curve");
}

/// Of tables and pages of many runs.
void add_page_options(CLI::App& command, Options& options) {
  command.add_flag("--summary", options.summary, "Print only the summary over all scenes: by strategy, by body");
  command.add_option("--peers", options.peers,
                     "CSV of other programs' runs for the page: method, minimum_s, error, scene");
}

void add_study_options(CLI::App& command, Options& options) {
  command
      .add_option("--vary", options.vary,
                  "Change a key from run to run: KEY.PATH=[VALUE, …], or {KEY: […], KEY: […]} for keys that change "
                  "together. May be repeated: every combination runs")
      ->take_all()
      ->allow_extra_args(false);
  command.add_option("--steppers", options.steppers,
                     "Compare time-stepping schemes on the scene's own strategy: names separated by commas, or all");
  command
      .add_option("--against", options.against,
                  "calculix: a row by CalculiX too, with its error and seconds, where ccx is installed")
      ->check(CLI::IsMember({kCalculix}));
  command.add_option("--repeats", options.repeats, "Run everything this often, in turn; the fastest run counts")
      ->check(CLI::Range(1, 1000));
  command.add_option("--resume", options.resume_from, "Continue in a folder of --out: finished runs are not repeated");
  command.add_option("--shard", options.shard_text,
                     "N/M: run the N-th of M shares of the rows, in a folder of its own; `merge` puts them together");
  add_page_options(command, options);
}

void add_merge_options(CLI::App& command, Options& options) {
  command.add_option("folders", options.scenes, "Folders of `compare --shard N/M --out DIR`, of one study")->required();
  command.add_option("--out", options.out, "Folder for the page, CSV, JSON, curves and ParaView files of all rows");
  command.add_option("--baseline", options.baseline, "Folder of an earlier --out: tell what changed since, run by run");
  command.add_option("--json", options.json, "JSON file; - for standard output, and nothing else there");
  command.add_flag("--quiet", options.quiet, "Print nothing but errors and missing rows");
  add_page_options(command, options);
}

void add_identify_options(CLI::App& command, Options& options) {
  add_scene_options(command, options);
  command
      .add_option("--data", options.identify.data,
                  "CSV file instead of the scene's own: FILE, or TEST=FILE. May be repeated")
      ->take_all()
      ->allow_extra_args(false);
  command
      .add_option("--tests", options.identify.tests,
                  "Tests that count, separated by commas; the others are predicted alone")
      ->delimiter(',');
  command.add_option("--laws", options.identify.laws,
                     "Laws that are compared, separated by commas (yeoh/2: with two terms); all stands for every one");
  command.add_option("--strategies", options.strategies,
                     "Strategies of the specimens instead of their scenes' own, separated by commas: each is fitted");
  command.add_option("--json", options.json, "JSON file; - for standard output, and nothing else there");
  command.add_option("--out", options.out, "Folder for the page, JSON, every point, and the scene with its numbers");
  command.add_option("--resume", options.resume_from,
                     "Continue in a folder of --out: searches that ended there are not repeated");
}

void add_run_options(CLI::App& command, Options& options) {
  add_scene_options(command, options);
  add_file_options(command, options);
  command.add_option("--strategies", options.strategies,
                     "Strategies instead of the scene's own, separated by commas; all stands for every one");
  command
      .add_option("--reference", options.reference,
                  "computed: compute the references of every scene that has a domain; none: of no scene")
      ->check(CLI::IsMember({"computed", "none"}));
}

/// "unknown option '--thread'; did you mean …", of the first command or option that there is not; "" if there are all.
std::string unknown_word(const CLI::App& app, int argc, const char* const* argv) {
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

/// The commands of the command line; what they are given goes to `options`.
struct Commands {
  CLI::App app;
  CLI::App *run, *compare, *merge, *verify, *check, *identify, *list, *plot, *lab, *other, *create;

  Commands(const std::string& name, Options& options)
      : app("Elastin: soft tissue as molecules and connections, and the modulus it really has.", name),
        run(app.add_subcommand("run", "Run a scene with its own stiffness strategy; print every measure")),
        compare(
            app.add_subcommand("compare", "Run a scene with many strategies; print measured modulus, error and cost")),
        merge(app.add_subcommand("merge", "Put the rows of a study together that several `compare --shard` have run")),
        verify(app.add_subcommand("verify", "Compare scenes with the results that they expect; print verdicts")),
        check(app.add_subcommand("check", "Print counts, pieces and zero-energy modes of a scene's body")),
        identify(app.add_subcommand("identify", "Fit a scene's material to measured tests; print how sure it is")),
        list(app.add_subcommand("list", "List strategies, their parameters, and measures")),
        plot(app.add_subcommand("plot", "Draw two columns of a CSV file, or the curves of a scene's material: SVG")),
        lab(app.add_subcommand("lab", "Write a scene's body as a page that moves it under a hand in a browser")),
        other(app.add_subcommand("export", "Write a scene's body or whole problem as a file of another program")),
        create(app.add_subcommand("new", "Write a commented scene for a specimen, from options or three questions")) {
    app.set_version_flag("--version", std::string("elastin ") + ELASTIN_VERSION);
    app.require_subcommand(1);
    add_run_options(*run, options);
    add_run_options(*compare, options);
    add_study_options(*compare, options);
    add_merge_options(*merge, options);
    add_scene_options(*verify, options);
    add_file_options(*verify, options);
    verify->add_flag("--choices", options.others,
                     "Also run each case with explicit steps, implicit steps, small displacements, plain springs");
    verify->add_flag("--steppers", options.each_stepper, "Also run each case in time with every stepper");
    verify->add_flag("--markdown", options.markdown, "Print the table as Markdown, with titles");
    add_scene_options(*check, options);
    add_identify_options(*identify, options);
    list->add_flag("--keys", options.keys, "List every key of a scene instead, as Markdown");
    plot->add_option("FILE", options.scenes,
                     "CSV files: curves, time histories, runs, rows of benchmarks; or the word material, and scenes")
        ->required();
    plot->add_option("--x", options.x_column,
                     "Column of the horizontal axis, for example strain; default: the main one of the file");
    plot->add_option("--y", options.y_column,
                     "Column of the vertical axis, for example stress; default: the main one of the file");
    plot->add_option("--stretch", options.stretch, "plot material: the largest stretch; the least is its inverse")
        ->check(CLI::Range(1.001, 100.))
        ->capture_default_str();
    plot->add_option("--set", options.overrides, "plot material: key=value, another value in the scenes");
    add_scene_options(*lab, options);
    lab->add_option("--out", options.page, "The HTML file; - for standard output")->required();
    lab->add_option("--module", options.module,
                    "Folder of elastin.js and elastin.wasm, as tools/setup --web builds them");
    add_scene_options(*other, options);
    std::string formats;
    for (const auto& format : export_formats())
      formats += fmt::format("{}{}: {}", formats.empty() ? "" : "; ", format->name, format->summary);
    other->add_option("--to", options.format, formats)->required();
    other->add_option("--out", options.page, "The file; - for standard output")->required();
    add_new_options(*create, options);
    app.footer(fmt::format("\nExamples:\n{}\n{}", examples_of(name, ""), kExitCodes));
    for (CLI::App* command : {run, compare, merge, verify, check, identify, list, plot, lab, other, create})
      command->footer(fmt::format("\nExamples:\n{}\n{}", examples_of(name, command->get_name()), kExitCodes));
  }
};

int run_chosen(const Commands& commands, Options& options, const Catalog& catalog) {
  openmp::use_openmp();
  set_screen_width(terminal_width(STDOUT_FILENO));
  set_threads(options.threads);
  if (*commands.list) return list_catalog(options, catalog);
  if (*commands.create) return write_new_scene(options, catalog, commands.create->get_option("--modulus")->count() > 0);
  if (*commands.merge) return merge_folders(options);
  if (*commands.verify) return verify_scenes(options, catalog);
  if (*commands.check) return check_scenes(options, catalog);
  if (*commands.identify) return identify_all(options, catalog);
  if (*commands.lab) return write_lab(options, catalog);
  if (*commands.other) return export_scene(options, catalog);
  if (*commands.plot)
    return options.scenes.front() == "material" ? plot_materials(options, catalog) : plot_columns(options);
  return run_all(options, catalog, static_cast<bool>(*commands.compare));
}

/// A standard stream that the caller has closed stays one that cannot be used: no file that the command opens may take
/// its number, and be written to in its place.
void keep_standard_streams() {
  while (true) {
    const int next = open("/dev/null", O_RDONLY);
    if (next > STDERR_FILENO) close(next);
    if (next < 0 || next > STDERR_FILENO) return;
  }
}

}  // namespace

int run_command(int argc, const char* const* argv, const Catalog& catalog) {
  keep_standard_streams();
  const std::string name = argc > 0 ? std::filesystem::path(argv[0]).filename().string() : "elastin";
  try {
    Options options;
    options.command = name;
    for (int i = 1; i < argc; ++i) options.command += " " + std::string(argv[i]);
    Commands commands(name, options);
    try {
      commands.app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
      const std::string unknown = unknown_word(commands.app, argc, argv);
      if (error.get_exit_code() == 0 || unknown.empty()) return commands.app.exit(error) == 0 ? 0 : 2;
      say(fmt::format("{}: {}\n", name, unknown));
      return 2;
    }
    const int code = run_chosen(commands, options, catalog);
    if (std::fflush(stdout) == 0 && !std::ferror(stdout)) return code;
    say(fmt::format("{}: standard output could not be written: {}\n", name, std::strerror(errno)));
    return 2;
  } catch (const std::system_error& error) {  // of a print
    say(fmt::format("{}: standard output could not be written: {}\n", name, error.code().message()));
    return 2;
  } catch (const std::bad_alloc&) {
    say(fmt::format("{}: there is not enough memory for this body\n", name));
    return 2;
  } catch (const InputError& error) {
    say(fmt::format("{}: {}\n", name, error.what()));
    return 2;
  } catch (const std::exception& error) {
    say(fmt::format("{}: internal error: {}\n", name, error.what()));
    return 1;
  }
}

}  // namespace elastin::command
