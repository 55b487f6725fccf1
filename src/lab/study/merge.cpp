#include "lab/study/study.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"
#include "lab/report/comparison.h"
#include "lab/report/files.h"
#include "lab/report/records.h"
#include "lab/report/screen.h"
#include "lab/study/journal.h"
#include "lab/study/plan.h"
#include "lab/study/reference.h"

namespace elastin::lab {
namespace {

namespace fs = std::filesystem;

/// Of a long list the first ones are named.
constexpr std::size_t kMostNamed = 5;

/// "a; b and 3 more"
std::string some_of(const std::vector<std::string>& names) {
  const std::size_t named = std::min(names.size(), kMostNamed);
  std::string text = fmt::format("{}", fmt::join(names.begin(), names.begin() + static_cast<long>(named), "; "));
  return named < names.size() ? fmt::format("{} and {} more", text, names.size() - named) : text;
}

/// A run, and the folder that has it.
struct Found {
  std::size_t folder;
  JournalEntry entry;
};

class Merge {
 public:
  Merge(const std::vector<std::string>& folders, const Output& output);
  bool run();

 private:
  RunSource source_of(const ScenePlan& plan) const { return {plan.name, plan.content, study().overrides}; }
  const StudyFile& study() const { return studies_.front(); }
  void check_same_study(std::size_t folder) const;
  void find_runs(std::size_t folder);
  void tell_missing(const PlannedRow& row, std::size_t number);
  void unite_references(std::size_t folder, const PlannedRow& row, Record& record);
  void write_journal() const;
  std::vector<std::string> views() const;
  void copy_files(const Found& found) const;
  std::string machines() const;
  void say(const std::string& line) const { lab::say("  " + line + "\n"); }

  Request request_;  // of all rows together
  const std::vector<std::string>& folders_;
  std::vector<StudyFile> studies_;
  std::vector<PlannedRow> rows_;
  std::vector<int> shards_;  ///< of the rows, in the first folder's study
  std::unordered_map<std::string, Found> runs_;
  std::map<int, std::vector<std::string>> missing_;                      ///< names of rows by shard
  std::map<std::string, std::pair<Reference, std::size_t>> references_;  ///< with their folder; by scene and measure
  std::size_t missing_runs_ = 0;
  bool agree_ = true;
};

Merge::Merge(const std::vector<std::string>& folders, const Output& output) : folders_(folders) {
  static_cast<Output&>(request_) = output;
  request_.compare = true;
  for (const std::string& folder : folders_) {
    std::error_code ignored;
    if (!output.out.empty() && fs::equivalent(folder, output.out, ignored))
      throw InputError("--out: " + output.out + " is one of the folders that are merged; choose another one");
    studies_.push_back(read_study(folder));
  }
  rows_ = rows_of(study().plans);
  shards_ = deal_rows(rows_.size(), study().shard.of);
  for (std::size_t folder = 0; folder < folders_.size(); ++folder) check_same_study(folder);
}

/// Rows have their keys of what they are made from: studies with the same keys are the same.
void Merge::check_same_study(std::size_t folder) const {
  const StudyFile& other = studies_[folder];
  const std::string refused = folders_[folder] + " cannot be merged with " + folders_.front() + ": ";
  std::vector<RunSource> wanted;
  for (const ScenePlan& plan : study().plans) wanted.push_back(source_of(plan));
  for (const ScenePlan& plan : other.plans)
    if (const std::string why = mismatch({plan.name, plan.content, other.overrides}, wanted, "the other"); !why.empty())
      throw InputError(refused + "it " + why);
  if (std::tie(other.machine.compiler, other.machine.flags) !=
      std::tie(study().machine.compiler, study().machine.flags))
    throw InputError(fmt::format(
        "{}another build of the program ran there ({}; {}), and its last digits may differ from "
        "those of {}; {}",
        refused, other.machine.compiler, other.machine.flags, study().machine.compiler, study().machine.flags));
  const std::vector<PlannedRow> rows = rows_of(other.plans);
  const auto same = [&](const PlannedRow& one, const PlannedRow& two) {
    return key_of(one, one.plan->repeats, study().overrides, study().machine) ==
           key_of(two, two.plan->repeats, other.overrides, other.machine);
  };
  if (!std::equal(rows.begin(), rows.end(), rows_.begin(), rows_.end(), same))
    throw InputError(
        fmt::format("{}it is of another study of the same scenes, with other strategies, values, threads or "
                    "repeats: {} there, {} here",
                    refused, counted(static_cast<std::ptrdiff_t>(rows.size()), "row"),
                    counted(static_cast<std::ptrdiff_t>(rows_.size()), "row")));
}

void Merge::find_runs(std::size_t folder) {
  for (JournalEntry& entry : journal_of(folders_[folder])) {
    const auto [there, first] = runs_.try_emplace(entry.key, Found{folder, entry});
    if (first) continue;
    if (there->second.folder == folder) {  // the later line counts, as with --resume
      there->second.entry = std::move(entry);
      continue;
    }
    const std::string difference = disagreement(there->second.entry.record, entry.record);
    if (difference.empty()) continue;
    agree_ = false;
    say(fmt::format("{}, {}: {} and {} have different numbers, {}", entry.record.scene, run_name(entry.record),
                    folders_[there->second.folder], folders_[folder], difference));
  }
}

void Merge::tell_missing(const PlannedRow& row, std::size_t number) {
  ++missing_runs_;
  std::vector<std::string>& names = missing_[shards_[number]];
  if (names.empty() || names.back() != row.name()) names.push_back(row.name());
}

/// Computed references of one row of parameters are equal in all shards, but where the time to compute them ran out.
/// The time that it took is that of one of the shards, so that each is listed once.
void Merge::unite_references(std::size_t folder, const PlannedRow& row, Record& record) {
  std::string where = row.plan->name;
  for (const auto& [key, value] : *row.combination) where += "\n" + key + "=" + value;
  for (Reference& reference : record.references) {
    if (!reference.computed) continue;
    const std::string measure(reference.measure);
    const auto [first, added] = references_.try_emplace(where + "\n" + measure, reference, folder);
    const auto& [known, known_folder] = first->second;
    if (known.value == reference.value && known.uncertainty == reference.uncertainty) {
      reference.seconds = known.seconds;
      continue;
    }
    agree_ = false;
    say(fmt::format("{}: the computed reference of {} is {:.10g} in {} and {:.10g} in {}", row.name(), measure,
                    known.value, folders_[known_folder], reference.value, folders_[folder]));
  }
}

void Merge::write_journal() const {
  Request whole = request_;
  whole.command = study().command;
  whole.overrides = study().overrides;
  write_study(whole, study().plans);
  LineFile lines(request_.out + "/runs.jsonl", false), shown(request_.out + "/views.jsonl", false);
  int passes = 0;
  for (const ScenePlan& plan : study().plans) passes = std::max(passes, plan.repeats);
  for (int repeat = 0; repeat < passes; ++repeat)
    for (const PlannedRow& row : rows_) {
      if (repeat >= row.plan->repeats) continue;
      const auto run = runs_.find(key_of(row, repeat, study().overrides, study().machine));
      if (run != runs_.end()) lines.add(run->second.entry.line);
    }
  for (const std::string& line : views()) shown.add(line);
  ReferenceStore store(request_.out);
  for (const std::string& folder : folders_) store.add(ReferenceStore(folder));
}

/// The bodies and states of the rows that count, in the order of the rows.
std::vector<std::string> Merge::views() const {
  std::map<std::string, std::map<std::string, std::string>> bodies, states;  // by scene; by variant, and strategy
  for (std::size_t folder = 0; folder < folders_.size(); ++folder) {
    std::map<std::pair<std::string, std::string>, std::string> own;
    for (std::string& line : lines_of(folders_[folder] + "/views.jsonl")) {
      const auto keep = [](int depth, nlohmann::json::parse_event_t, nlohmann::json&) { return depth < 2; };
      const nlohmann::json head = nlohmann::json::parse(line, keep, false);  // ends where the first array begins
      if (!head.is_object()) continue;
      const std::string scene = head.value("scene", ""), variant = head.value("variant", "");
      if (head.value("kind", "") == "body")
        bodies[scene].try_emplace(variant, std::move(line));
      else
        own.insert_or_assign({scene, variant + "\n" + head.value("strategy", "")}, std::move(line));
    }
    for (auto& [run, line] : own) states[run.first].try_emplace(run.second, std::move(line));
  }
  std::vector<std::string> lines;
  for (const PlannedRow& row : rows_) {
    const auto run = runs_.find(key_of(row, 0, study().overrides, study().machine));
    if (run == runs_.end()) continue;
    const Record& record = run->second.entry.record;
    const std::string variant = variant_text(record);
    if (auto body = bodies[record.scene].extract(variant)) lines.push_back(std::move(body.mapped()));
    if (auto state = states[record.scene].extract(variant + "\n" + record.run.strategy))
      lines.push_back(std::move(state.mapped()));
  }
  return lines;
}

/// Curves, states and restart files of a run.
void Merge::copy_files(const Found& found) const {
  const std::string name = file_name(found.entry.record.scene, found.entry.record.run.strategy);
  for (const auto& entry : fs::directory_iterator(folders_[found.folder])) {
    const std::string file = entry.path().filename().string();
    if (!entry.is_regular_file() || !file.starts_with(name) || file.size() == name.size()) continue;
    if (file[name.size()] != '-' && file[name.size()] != '.') continue;
    std::error_code problem;
    fs::copy_file(entry.path(), request_.out + "/" + file, fs::copy_options::overwrite_existing, problem);
    if (problem) throw InputError(request_.out + "/" + file + ": cannot be written: " + problem.message());
  }
}

/// Each kind of machine once, with the largest load of those.
std::string Merge::machines() const {
  std::vector<Machine> kinds;
  for (const StudyFile& study : studies_) {
    const auto same = [&](const Machine& kind) {
      return kind.processor == study.machine.processor && kind.cores == study.machine.cores;
    };
    const auto known = std::find_if(kinds.begin(), kinds.end(), same);
    if (known == kinds.end())
      kinds.push_back(study.machine);
    else
      known->load = std::max(known->load, study.machine.load);
  }
  std::vector<std::string> texts;
  for (const Machine& kind : kinds) texts.push_back(kind.text());
  return fmt::format("{}", fmt::join(texts, "; "));
}

bool Merge::run() {
  Results results(request_);
  for (std::size_t folder = 0; folder < folders_.size(); ++folder) find_runs(folder);
  bool good = true, suited = false;
  std::size_t wanted = 0;
  int passes = 0;
  for (const ScenePlan& plan : study().plans) passes = std::max(passes, plan.repeats);
  for (int repeat = 0; repeat < passes; ++repeat)
    for (std::size_t number = 0; number < rows_.size(); ++number) {
      const PlannedRow& row = rows_[number];
      if (repeat >= row.plan->repeats) continue;
      ++wanted;
      const auto run = runs_.find(key_of(row, repeat, study().overrides, study().machine));
      if (run == runs_.end()) {
        tell_missing(row, number);
        continue;
      }
      Record record = run->second.entry.record;
      unite_references(run->second.folder, row, record);
      good &= record.good();
      suited |= record.run.suited || record.stopped_as_expected();
      results.add(std::move(record), repeat);
    }
  if (!request_.out.empty()) {
    write_journal();
    for (const auto& [key, found] : runs_)
      if (found.entry.record.variant.empty()) copy_files(found);
  }
  for (const ScenePlan& plan : study().plans) results.print_scene(plan);
  std::string machine = machines();
  if (missing_runs_ > 0) machine += fmt::format("; {} of {} runs are missing", missing_runs_, wanted);
  results.finish(study().plans, false, !request_.out.empty(),
                 {std::move(machine), study().command + "; " + request_.command,
                  request_.out.empty() ? std::vector<std::string>{} : lines_of(request_.out + "/views.jsonl")});
  if (missing_runs_ > 0) say(fmt::format("{} of {} runs are missing:", missing_runs_, wanted));
  for (const auto& [shard, names] : missing_)
    say(study().shard.of > 1 ? fmt::format("  of shard {}/{}: {}", shard, study().shard.of, some_of(names))
                             : "  " + some_of(names));
  return good && suited && agree_ && missing_runs_ == 0;
}

}  // namespace

bool merge_studies(const std::vector<std::string>& folders, const Output& output) {
  return Merge(folders, output).run();
}

}  // namespace elastin::lab
