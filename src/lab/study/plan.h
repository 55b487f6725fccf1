#pragma once
#include <memory>
#include <string>
#include <vector>

#include "lab/report/machine.h"
#include "lab/scene/scene.h"
#include "lab/study/request.h"

namespace elastin::lab {

/// All rows of one scene: its combinations × threads × strategies, each `repeats` times.
struct ScenePlan {
  SceneSource source;
  std::string content;           ///< key_of the scene's text and of the files that it names
  std::unique_ptr<Scene> scene;  ///< as it stands; released after its first runs where a study changes it
  std::vector<std::vector<std::pair<std::string, std::string>>> combinations;
  std::vector<int> threads;             ///< 0 = as the command says
  std::vector<std::string> strategies;  ///< labels, and the name of another program behind them
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

}  // namespace elastin::lab
