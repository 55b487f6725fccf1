#include "command/row.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <string_view>

#include "config/scene_tree.h"
#include "elastin/core/base/error.h"
#include "elastin/core/parallel/threads.h"

namespace elastin::command {

using namespace lab;
namespace fs = std::filesystem;

Take keys_into(std::vector<std::string>& overrides) {
  return [&overrides](const std::string& text) {
    overrides.push_back(text);
    config::check_overrides(overrides);
  };
}

void SceneOptions::add_to(Options& options, bool several) {
  takes_folders = several;
  options.argument("SCENE", into(scenes), several ? "Scene files (YAML), or folders of them" : "Scene file (YAML)",
                   true, several);
  options
      .add("--set", "KEY=VALUE", keys_into(overrides),
           "Set a key of the scene: KEY.PATH=VALUE; a plain number is SI. May be repeated")
      .repeated = true;
  options.add("--threads", "NUMBER", into(threads, 0, kMostThreads),
              "Threads for large bodies, at most 4096; 0: one for each core. Results are bitwise identical for any "
              "number");
  options.flag("--quiet", quiet, "Print nothing but errors");
}

namespace {

/// Whether a scene of a folder is for the other commands: without `identify` for it, with that and no body for the
/// rest. What cannot be read is for all, so that it is told why.
bool is_for_others(const SceneSource& source, bool identifies) {
  try {
    config::Reader scene = config::open_scene(source, {}, 1);
    return identifies ? !scene.has("identify") : scene.has("identify") && !scene.has("body") && !scene.has("bodies");
  } catch (const InputError&) {
    return false;
  }
}

}  // namespace

std::vector<SceneSource> SceneOptions::open() const {
  set_threads(threads);
  const SceneSource none;
  std::vector<SceneSource> sources;
  for (const std::string& path : scenes) {
    if (!takes_folders || !fs::is_directory(path)) {
      sources.push_back(none.other(path));
      continue;
    }
    std::vector<std::string> below;
    for (const auto& entry : fs::recursive_directory_iterator(path))
      if (entry.path().extension() == ".yaml") below.push_back(entry.path().string());
    if (below.empty()) throw InputError(path + ": this folder has no scene (.yaml)");
    std::sort(below.begin(), below.end());
    std::size_t left_out = 0;
    for (const std::string& scene : below) {
      SceneSource source = none.other(scene);
      if (is_for_others(source, identifies))
        ++left_out;
      else
        sources.push_back(std::move(source));
    }
    const std::string others = identifies ? "without `identify`" : "for `elastin identify`";
    if (left_out == below.size()) throw InputError(path + ": this folder has no scene but those " + others);
    if (left_out > 0 && !quiet)
      fmt::print(stderr, "  {}: {} {} left out\n", path, counted(left_out, "scene"),
                 others + (left_out > 1 ? " are" : " is"));
  }
  return sources;
}

void SceneOptions::fill(Request& request, const Call& call) const {
  request.scenes = open();
  request.overrides = overrides;
  request.quiet = quiet;
  request.command = call.line;
  request.interrupted = interrupted;
}

void add_output_options(Options& options, Output& output, const std::string& more) {
  options.add("--out", "FOLDER", into(output.out), "Folder for CSV, JSON, curves and ParaView files");
  options.add("--json", "FILE", into(output.json), "JSON file; - for standard output, and nothing else there");
  options.flag("--verbose", output.verbose, more);
}

void add_baseline_option(Options& options, Output& output) {
  options.add("--baseline", "FOLDER", into(output.baseline),
              "Folder of an earlier --out: report what changed since, run by run");
}

void add_table_options(Options& options, Output& output) {
  options.flag("--summary", output.summary, "Print only the summary over all scenes: by strategy, by body");
  options.add("--peers", "FILE", into(output.peers),
              "CSV of other programs' runs for the page: method, minimum_s, error, scene");
}

void add_run_options(Options& options, Request& request, const std::string& more) {
  add_output_options(options, request, more);
  options.add("--pieces", "FOLDER", into(request.pieces), "").hidden = true;  // for processes.h
  options.add("--restart", "FILE", into(request.restart),
              "Continue a run in time from a .restart file that --out wrote");
  options.flag("--live", request.live, "Show at most time.frame_rate frames a second");
  options.add("--strategies", "NAMES", into(request.strategies),
              "Strategies instead of the scene's own, separated by commas; all: every strategy");
  options
      .add("--gradient", "KEY,KEY", each_of(into(request.gradient)),
           "Derivatives of every measure by numbers of the scene, named as of --set; SI")
      .repeated = true;
  options.add("--reference", "computed|none", one_of({"computed", "none"}, into(request.reference)),
              "computed: compute the references of every scene that has a domain; none: of no scene");
}

bool continue_in(const std::string& folder, std::string& out) {
  if (folder.empty()) return false;
  if (!out.empty() && out != folder) throw InputError("--resume continues in its own folder; leave out --out");
  out = folder;
  return true;
}

namespace {

volatile std::sig_atomic_t noted = 0;  // the signal

/// No signal for a second: what is done now (a factorisation, a packing) has no end at which to stop.
void give_up(int) {
  constexpr std::string_view message = "  stopped in the middle: this run is not complete\n";
  if (write(STDERR_FILENO, message.data(), message.size()) >= 0 || noted) std::raise(noted);
}

void note_interrupt(int signal) {
  constexpr std::string_view message = "\n  stopping after this run or step; Ctrl-C again stops at once\n";
  noted = signal;
  if (write(STDERR_FILENO, message.data(), message.size()) < 0) noted = signal;  // no terminal is left
  for (const int each : {SIGINT, SIGTERM}) std::signal(each, SIG_DFL);
  std::signal(SIGALRM, give_up);
  alarm(1);
}

}  // namespace

void stop_on_interrupt() {
  for (const int each : {SIGINT, SIGTERM}) std::signal(each, note_interrupt);
}
bool interrupted() {
  if (noted) alarm(0);
  return noted != 0;
}

}  // namespace elastin::command
