#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "command/options.h"
#include "elastin/core/simulation/catalog.h"
#include "lab/study/request.h"

namespace elastin::command {

/// How the program was called.
struct Call {
  const Catalog& catalog;
  std::string line;  ///< as it was typed, for pages
};

/// Does what a command is for, with the options that were read; gives the exit code. Throws InputError.
using Action = std::function<int(const Call& call)>;

/// One command of the program.
struct CommandRow {
  const char *name, *summary;
  const char* examples;                 ///< lines without the program's name
  Action (*declare)(Options& options);  ///< names what the command takes
};

/// A command of one class: `add_to(options)` names its options, which are its members; `run(call)` does the work.
template <class Command>
Action declare(Options& options) {
  const auto command = std::make_shared<Command>();
  command->add_to(options);
  return [command](const Call& call) { return command->run(call); };
}

extern const CommandRow kRun, kCompare, kMerge, kVerify, kCheck, kIdentify, kList, kPlot, kLab, kExport, kNew;

/// Adds KEY.PATH=VALUE; refuses one that replaces an earlier one.
Take keys_into(std::vector<std::string>& overrides);

/// Options of all commands that read scenes.
struct SceneOptions {
  std::vector<std::string> scenes, overrides;
  int threads = 0;
  bool quiet = false;
  bool takes_folders = false;  ///< which commands of several scenes do
  bool identifies = false;     ///< of folders it takes the scenes with `identify`, others take those with a body

  void add_to(Options& options, bool several = true);
  /// Sets the number of threads. Every file is read once, even if several scenes name it; of a folder all scenes below.
  std::vector<lab::SceneSource> open() const;
  /// Puts these and how the program was called into a request.
  void fill(lab::Request& request, const Call& call) const;
};

/// --out, --json and --verbose, which prints `more`.
void add_output_options(Options& options, lab::Output& output, const std::string& more);
void add_baseline_option(Options& options, lab::Output& output);
/// --summary and --peers.
void add_table_options(Options& options, lab::Output& output);
/// Options of `run` and `compare`: those of the output, --restart, --live, --strategies and --reference.
void add_run_options(Options& options, lab::Request& request, const std::string& more);

/// --resume FOLDER is --out FOLDER with the results that it already has; gives whether it was requested. Throws
/// InputError where --out names another folder.
bool continue_in(const std::string& folder, std::string& out);

/// From now on the first interrupt (SIGINT, SIGTERM) ends a run after its step, in time or of the load, and a
/// comparison or a search after its run, with all files complete. The second one ends the program, and so does the
/// first where no signal has arrived within a second.
void stop_on_interrupt();
/// Whether there was one. The caller then ends what it does.
bool interrupted();

}  // namespace elastin::command
