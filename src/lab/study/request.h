#pragma once
#include <functional>
#include <string>
#include <vector>

#include "lab/export/engine_run.h"
#include "lab/report/page.h"
#include "lab/report/records.h"
#include "lab/run/config_names.h"

namespace elastin::lab {

/// A share of the rows of a comparison.
struct Shard {
  int number = 1, of = 1;  ///< 1 ≤ number ≤ of
};

/// Where the results of runs go, and how much of them is printed.
struct Output {
  std::string out;           ///< folder of all files; empty: none
  std::string json;          ///< file, or "-" for standard output; empty: none
  std::string pieces;        ///< folder of states of which another process writes the tables; empty: none
  std::string peers;         ///< CSV file of other programs' runs, for the page
  std::string baseline;      ///< folder of an earlier comparison
  std::string image;         ///< file of the last state as an image (see write_image); empty: none
  double image_spacing = 0;  ///< [m]; 0: of the image that the body was made of
  std::string command;       ///< as it was typed, for the page
  bool quiet = false, summary = false;
  bool verbose = false;  ///< every run in full as it is finished, with every point of its curve
  bool to_screen() const { return !quiet && json != "-"; }
};

/// A run of scenes with their own strategies, or a comparison.
struct Request : Output {
  std::vector<SceneSource> scenes;
  std::vector<std::string> overrides, vary;
  std::vector<std::string> gradient;  ///< keys of numbers by which measures are differentiated
  std::string strategies, steppers, restart;
  std::string against;  ///< "calculix": one of the engines, which must be installed; empty: none
  std::vector<std::string> engine_commands = {};  ///< the user's own engines, in addition to those of each scene
  std::string reference;                          ///< "computed" or "none" for all scenes; empty: as each scene says
  Shard shard = {};                               ///< of the runs of a comparison: what is run here
  int repeats = 0;                                ///< 0 = as the scene says
  bool compare = false, resume = false, live = false;
  std::function<bool()> interrupted = {};  ///< called after each run
};

/// Writes runs.csv and runs.json, or the file of --json, of all runs so far; a pipe or device gets those of the whole
/// comparison alone.
void write_tables(const Output& output, const std::vector<Record>& records, bool whole = true);
/// Curve and states of one run, if there are any; releases the states.
void write_run(const Output& output, const Scene& scene, Record& record);

/// Writes the page and its plots, with the requested peers.
void write_report(const Output& output, PageMatter matter);

/// Whether text has colours: on a terminal, unless NO_COLOR is set, and wherever CLICOLOR_FORCE is (tools/picture).
bool colours_on(int stream);

}  // namespace elastin::lab
