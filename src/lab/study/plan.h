#pragma once
#include <memory>
#include <string>
#include <vector>

#include "lab/report/machine.h"
#include "lab/report/page.h"
#include "lab/scene/scene.h"
#include "lab/study/request.h"

namespace elastin::lab {

/// All rows of one scene: its combinations × threads × strategies, each `repeats` times.
struct ScenePlan {
  SceneSource source;
  std::string content;           ///< key_of the scene's text and the files that it names; with --out
  std::unique_ptr<Scene> scene;  ///< as it stands; released after its first runs where a study changes it
  std::vector<std::vector<std::pair<std::string, std::string>>> combinations;
  std::vector<int> threads;             ///< 0 = as the command says
  std::vector<std::string> strategies;  ///< labels, and the name of another program behind them
  std::vector<Engine> engines;          ///< those other programs
  int repeats = 1;
  std::string name, title, own_reference;
  std::vector<std::string> warnings;  ///< of the scene as it stands
  std::size_t runs() const { return combinations.size() * threads.size() * strategies.size(); }
  bool varied() const { return combinations.size() > 1 || threads.size() > 1; }
};

/// Reads all scenes before anything runs: an error in the last must not waste the others' run time.
std::vector<ScenePlan> plan_of(const Request& request, const Catalog& catalog);

/// A row of a plan; points into it.
struct PlannedRow {
  const ScenePlan* plan;
  const std::vector<std::pair<std::string, std::string>>* combination;
  int threads;  ///< 0 = as the command says
  std::string strategy;
  /// "cube, lattice, [5, 5, 5], 2 threads"
  std::string name() const;
};

/// Every row, in the order in which one command runs them: scenes, combinations, threads, strategies.
std::vector<PlannedRow> rows_of(const std::vector<ScenePlan>& plans);

/// What a run is made from: another scene, change, strategy, number of threads or repeat gives another key, and so do
/// another build of the program and another form of the record. `overrides` are the command's --set.
std::string key_of(const PlannedRow& row, int repeat, const std::vector<std::string>& overrides,
                   const Machine& machine);

/// The strategies to run on a scene, with the scene's parameters of those that it names.
std::vector<StrategyChoice> chosen_strategies(const Request& request, const Catalog& catalog, const Scene& scene);

/// "KEY.PATH=VALUE" of the command line, then those of a combination.
std::vector<std::string> overrides_of(const std::vector<std::string>& overrides,
                                      const std::vector<std::pair<std::string, std::string>>& combination);

/// "3/16", the third of sixteen. Throws InputError.
Shard read_shard(const std::string& text);

/// For each row of a plan the number, from 1, of the shard that runs it. Rows are shuffled, always alike, and dealt out
/// in turn: every shard has as many, give or take one, and none has all those of one strategy or of the largest bodies.
std::vector<int> deal_rows(std::size_t rows, int shards);

/// What a folder of a comparison says of the study that its rows belong to: its whole plan, so that rows of other
/// folders are put next to them without the scenes.
struct StudyFile {
  Shard shard;
  std::string command;  ///< as it was typed
  Machine machine;
  std::vector<std::string> overrides;  ///< the command's --set
  std::vector<ScenePlan> plans;        ///< without their scenes
};

/// Writes FOLDER/study.json. Throws InputError naming the path.
void write_study(const Request& request, const std::vector<ScenePlan>& plans);

/// Reads it. Throws InputError naming the path.
StudyFile read_study(const std::string& folder);

/// The rows of a comparison in the order of its plan, and all that is reported of them: tables on the screen, files,
/// page.
class Results {
 public:
  /// Reads the peers and the baseline that the request names, which must outlive this. Throws InputError.
  explicit Results(const Request& request);
  /// A row, or of a later repeat (> 0) one more time of the row that is there.
  void add(Record record, int repeat);
  const std::vector<Record>& records() const { return records_; }
  bool has_body(const Record& record) const;  ///< whether some row has the scene and the variant of this one

  /// The table of one scene of a comparison, as soon as its rows are there: with its warnings, but of a study.
  void print_scene(const ScenePlan& plan) const;
  /// What a page shows in addition to its rows.
  struct Origin {
    std::string machine, command;
    std::vector<std::string> views;  ///< lines of body_view and states_view
  };
  /// When all rows are there: the tables of studies, the summary, runs.csv, runs.json, and with `page` the page and its
  /// plots. `stopped`: some rows are not there.
  void finish(const std::vector<ScenePlan>& plans, bool stopped, bool page, Origin origin);

 private:
  std::vector<Record> records_of(const std::string& scene) const;
  void print_table(const ScenePlan& plan) const;
  void refer_to_own_values(const std::vector<ScenePlan>& plans);
  void complete_failed_rows();

  const Request& request_;
  std::vector<Record> records_, baseline_;
  std::vector<Peer> peers_;
};

}  // namespace elastin::lab
