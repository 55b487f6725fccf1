#pragma once
#include <functional>
#include <string>
#include <vector>

#include "lab/report/page.h"
#include "lab/report/records.h"

namespace elastin::lab {

/// A share of the rows of a comparison.
struct Shard {
  int number = 1, of = 1;  ///< 1 ≤ number ≤ of
};

/// What the command line asks of `run`, `compare` and `verify`.
struct Request {
  std::vector<std::string> scenes, overrides, vary;
  std::string strategies, steppers, out, json, restart, peers;
  std::string baseline;   ///< folder of an earlier comparison
  std::string against;    ///< another program whose row stands in each table, "calculix"; empty: none
  std::string reference;  ///< "computed" or "none" for all scenes; empty: as each scene says
  std::string pieces;     ///< folder of states of which another process writes the tables; empty: none
  std::string command;    ///< as it was typed, for the page
  Shard shard = {};       ///< of the rows of a comparison: what is run here
  int repeats = 0;        ///< 0 = as the scene says
  bool compare = false, resume = false, quiet = false, summary = false, live = false;
  bool verbose = false;                    ///< every run in full as it is finished, with every point of its curve
  std::function<bool()> interrupted = {};  ///< called after each run
  bool to_screen() const { return !quiet && json != "-"; }
};

/// Writes runs.csv and runs.json, or the file of --json, of all runs so far.
void write_tables(const Request& request, const std::vector<Record>& records);
/// Curve and states of one run, if there are any; releases the states.
void write_run(const Request& request, const Scene& scene, Record& record);

/// Writes the page and its plots, with the peers that were asked for.
void write_report(const Request& request, PageMatter matter);

/// Names of a run's files: of scene and strategy, without letters that mean something in a path or in XML.
std::string file_name(const std::string& scene, const std::string& strategy);

/// Colours on a terminal only, but for who insists (CLICOLOR_FORCE; tools/picture does) or declines (NO_COLOR).
bool colours_on(int stream);

}  // namespace elastin::lab
