#pragma once
#include <string>
#include <vector>

#include "lab/report/machine.h"
#include "lab/study/plan.h"
#include "lab/study/request.h"

namespace elastin::lab {

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
