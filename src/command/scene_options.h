#pragma once
#include <string>
#include <vector>

#include "command/row.h"
#include "lab/study/request.h"

namespace elastin::command {

/// Options of all commands that read scenes.
struct SceneOptions {
  std::vector<std::string> scenes, overrides;
  int threads = 0;
  bool quiet = false;

  void add_to(Options& options, bool several = true);
  /// Sets the number of threads. Every file is read once, even if several scenes name it.
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

}  // namespace elastin::command
