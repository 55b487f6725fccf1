#pragma once
#include <functional>
#include <string>
#include <vector>

#include "report/records.h"

namespace elastin {

/// What the command line asks of `run`, `compare` and `verify`.
struct Request {
  std::vector<std::string> scenes, overrides, vary;
  std::string strategies, out, json, restart, peers;
  std::string command;  ///< as it was typed, for the page
  int repeats = 0;      ///< 0 = as the scene says
  bool compare = false, resume = false, quiet = false, summary = false, live = false;
  std::function<bool()> interrupted = {};  ///< asked after each row
  bool to_screen() const { return !quiet && json != "-"; }
};

/// Runs every chosen strategy on every scene, in every combination that a study asks for. Of `compare` prints one table
/// a scene and, of several, a summary; of `run` one page a run. With `out` each row is on disk as soon as it is
/// finished, and a page, plots and tables in the end. Returns whether nothing failed. Throws InputError.
bool run_scenes(const Request& request, const Catalog& catalog);

/// Writes runs.csv and runs.json, or the file asked for, of what there is.
void write_tables(const Request& request, const std::vector<Record>& records);
/// Curve and states of one run, if there are; lets go of the states.
void write_run(const Request& request, const Scene& scene, Record& record);

/// Colours on a terminal only, but for who insists (CLICOLOR_FORCE; tools/picture does) or declines (NO_COLOR).
bool colours_on(int stream);

}  // namespace elastin
