#include "lab/study/plan.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <sstream>
#include <utility>

#include "elastin/core/base/error.h"
#include "lab/export/formats.h"
#include "lab/report/files.h"
#include "lab/report/records.h"
#include "lab/run/config_names.h"
#include "lab/study/journal.h"

namespace elastin::lab {
namespace {

std::string trimmed(const std::string& text) {
  const std::size_t from = text.find_first_not_of(' '), to = text.find_last_not_of(' ');
  return from == std::string::npos ? "" : text.substr(from, to - from + 1);
}

/// Throws InputError where an axis is a key that says which runs there are, not what one of them is.
void check_axes(const Study& study) {
  for (const StudyAxis& axis : study.axes)
    for (const auto& [key, value] : axis.values.front()) {
      const std::string first = key.substr(0, key.find('.'));
      if (key == "stiffness" || first == "strategies")
        throw InputError("a study does not vary '" + key + "': it runs each of the scene's strategies; name them by " +
                         "`strategies` or --strategies");
      if (first == "study")
        throw InputError("a study does not vary '" + key +
                         "', which says what the study is; write it in the scene or " + "with --set");
    }
}

/// Throws InputError where the scene cannot be read with some value of the study, whatever the others are: an error in
/// the last is found before the first run. Values that do not go together are rows that fail.
void read_each_value(const ScenePlan& plan, const Request& request, const Catalog& catalog) {
  std::set<std::pair<std::string, std::string>> read;
  std::map<std::pair<std::string, std::string>, std::string> faults;
  for (const auto& combination : plan.combinations) {
    const auto is_read = [&](const auto& value) { return read.contains(value); };
    if (std::ranges::all_of(combination, is_read)) continue;
    try {
      load_scene(plan.source, catalog, overrides_of(request.overrides, combination));
      read.insert(combination.begin(), combination.end());
    } catch (const InputError& error) {
      for (const auto& value : combination) faults.try_emplace(value, error.what());
    }
  }
  for (const auto& [value, what] : faults) {
    if (read.contains(value)) continue;
    const std::string set = "--set: ", by = request.vary.empty() ? "study: " : "--vary: ";
    throw InputError(what.starts_with(set) ? by + what.substr(set.size()) : what);
  }
}

ScenePlan plan_scene(const Request& request, const Catalog& catalog, const SceneSource& source) {
  ScenePlan plan;
  plan.source = source;
  plan.scene = load_scene(source, catalog, request.overrides);
  if (!request.out.empty()) {
    const std::string with = scene_format_of(source.path()) ? "" : open_scene(source, {}, kMostMolecules).content();
    plan.content = key_of(std::vector{source.text(), with});
  }
  plan.warnings = plan.scene->warnings;
  plan.name = plan.scene->name;
  plan.title = plan.scene->title;
  Study study = request.compare ? plan.scene->study : Study{};
  for (const std::string& axis : request.vary) study.axes.push_back(read_axis(axis));
  check_axes(study);
  plan.combinations = combinations(study.axes, request.overrides);
  plan.threads = study.threads.empty() ? std::vector{0} : study.threads;
  plan.repeats = request.repeats > 0 ? request.repeats : study.repeats;
  for (const StrategyChoice& choice : chosen_strategies(request, catalog, *plan.scene))
    plan.strategies.push_back(choice.label);
  if (request.compare)
    plan.engines = chosen_engines(plan.scene->engines, request.engine_commands, request.against, catalog);
  for (const Engine& engine : plan.engines) plan.strategies.push_back(engine.name);
  plan.own_reference = study.own_reference;
  if (!study.axes.empty() && !plan.scene->expectations.empty())
    plan.warnings.emplace_back("`expect` is not judged: it speaks of the scene as it is, and the study varies it");
  if (!study.axes.empty()) read_each_value(plan, request, catalog);
  return plan;
}

/// Throws InputError where files of two runs would have one name.
void check_file_names(const std::vector<ScenePlan>& plans) {
  std::map<std::string, std::string> runs;  // by the names of their files
  for (const ScenePlan& plan : plans)
    for (const std::string& strategy : plan.strategies) {
      const std::string run = plan.source.path() + " with " + strategy;
      const auto [known, added] = runs.try_emplace(file_name(plan.name, strategy), run);
      if (!added)
        throw InputError("--out: files of " + known->second + " and of " + run + " would have the same name, " +
                         known->first);
    }
}

}  // namespace

std::string PlannedRow::name() const {
  std::string text = plan->name + ", " + strategy;
  for (const auto& [key, value] : *combination) text += ", " + value;
  return threads > 0 ? text + ", " + std::to_string(threads) + (threads == 1 ? " thread" : " threads") : text;
}

std::vector<PlannedRow> rows_of(const std::vector<ScenePlan>& plans) {
  std::vector<PlannedRow> rows;
  for (const ScenePlan& plan : plans)
    for (const auto& combination : plan.combinations)
      for (const int threads : plan.threads)
        for (const std::string& strategy : plan.strategies) rows.push_back({&plan, &combination, threads, strategy});
  return rows;
}

std::string key_of(const PlannedRow& row, int repeat, const std::vector<std::string>& overrides,
                   const Machine& machine) {
  std::vector<std::string> parts{
      std::to_string(kRecordVersion), row.plan->name,         row.plan->content, row.strategy,
      std::to_string(row.threads),    std::to_string(repeat), machine.compiler,  machine.flags};
  for (const std::string& override : overrides_of(overrides, *row.combination)) parts.push_back(override);
  return key_of(parts);
}

std::vector<std::string> overrides_of(const std::vector<std::string>& overrides,
                                      const std::vector<std::pair<std::string, std::string>>& combination) {
  std::vector<std::string> all = overrides;
  for (const auto& [key, value] : combination) all.push_back(key + "=" + value);
  return all;
}

std::vector<StrategyChoice> chosen_strategies(const Request& request, const Catalog& catalog, const Scene& scene) {
  if (request.strategies.empty()) return request.compare ? scene.strategies : std::vector{scene.stiffness};
  std::vector<StrategyChoice> choices;
  std::istringstream names(request.strategies);
  for (std::string label; std::getline(names, label, ',');) {
    label = trimmed(label);
    if (label == "all")
      for (StrategyChoice& choice : all_strategies(catalog, scene.specimen))
        if (!find_strategy(choices, choice.label)) choices.push_back(std::move(choice));
    if (label == "all" || find_strategy(choices, label)) continue;
    try {
      choices.push_back(choose_strategy(scene, catalog, label));
    } catch (const InputError& error) {
      throw InputError(std::string("--strategies: ") + error.what());
    }
  }
  return choices;
}

std::filesystem::path path_of(const SceneSource& source) {
  return std::filesystem::absolute(source.path()).lexically_normal();
}

/// Scenes of one name in several folders are named with as many of these as tell them apart; texts by their numbers.
void tell_apart(std::vector<ScenePlan>& plans) {
  std::map<std::string, std::vector<ScenePlan*>> of_name;
  for (ScenePlan& plan : plans) of_name[plan.name].push_back(&plan);
  for (auto& [name, alike] : of_name) {
    std::vector<std::filesystem::path> folders;
    for (const ScenePlan* plan : alike) folders.push_back(path_of(plan->source).parent_path());
    std::set<std::string> names{name};
    while (names.size() < alike.size()) {
      names.clear();
      for (std::size_t i = 0; i < alike.size(); ++i) {
        const std::string folder = folders[i].filename().string();
        alike[i]->name = (folder.empty() ? std::to_string(i + 1) : folder) + "/" + alike[i]->name;
        names.insert(alike[i]->name);
        folders[i] = folders[i].parent_path();
      }
    }
    for (ScenePlan* plan : alike) plan->scene->name = plan->name;
  }
}

std::vector<ScenePlan> plan_of(const Request& request, const Catalog& catalog) {
  if (!request.against.empty()) check_calculix();
  std::vector<ScenePlan> plans;
  std::set<std::pair<std::filesystem::path, std::string>> known;
  for (const SceneSource& source : request.scenes)
    if (known.insert({path_of(source), source.text()}).second) plans.push_back(plan_scene(request, catalog, source));
  tell_apart(plans);
  if (!request.out.empty()) check_file_names(plans);
  if (std::all_of(plans.begin(), plans.end(), [](const ScenePlan& plan) { return plan.engines.empty(); }))
    for (const std::string& override : request.overrides)
      if (request.compare && override.starts_with("engines."))
        throw InputError("'" + override + "' is for engines, and none is to run: name them by --engines or --engine");
  return plans;
}

namespace {

using Json = nlohmann::ordered_json;

constexpr int kMostShards = 1000000;

Json json_of(const ScenePlan& plan) {
  return {{"name", plan.name},
          {"title", plan.title},
          {"path", plan.source.path()},
          {"content", plan.content},
          {"strategies", plan.strategies},
          {"threads", plan.threads},
          {"repeats", plan.repeats},
          {"own_reference", plan.own_reference},
          {"warnings", plan.warnings},
          {"combinations", plan.combinations}};
}

ScenePlan plan_of_json(const Json& json) {
  ScenePlan plan;
  json.at("name").get_to(plan.name);
  json.at("title").get_to(plan.title);
  plan.source = json.at("path").get<std::string>();
  json.at("content").get_to(plan.content);
  json.at("strategies").get_to(plan.strategies);
  json.at("threads").get_to(plan.threads);
  json.at("repeats").get_to(plan.repeats);
  json.at("own_reference").get_to(plan.own_reference);
  json.at("warnings").get_to(plan.warnings);
  json.at("combinations").get_to(plan.combinations);
  if (plan.strategies.empty() || plan.threads.empty() || plan.combinations.empty() || plan.repeats < 1)
    throw InputError("a scene without rows");
  return plan;
}

StudyFile study_of_json(const Json& json) {
  if (json.at("record_version") != kRecordVersion) throw InputError("another version of Elastin wrote it");
  StudyFile study;
  study.shard = read_shard(json.at("shard"));
  json.at("command").get_to(study.command);
  json.at("overrides").get_to(study.overrides);
  const Json& machine = json.at("machine");
  study.machine = {machine.at("processor"), machine.at("cores"),
                   machine.at("load").is_number() ? machine["load"].get<double>() : 0, machine.at("compiler"),
                   machine.at("flags")};
  for (const Json& scene : json.at("scenes")) study.plans.push_back(plan_of_json(scene));
  if (study.plans.empty()) throw InputError("a study without scenes");
  return study;
}

}  // namespace

Shard read_shard(const std::string& text) {
  Shard shard;
  const char* const end = text.data() + text.size();
  const auto number = std::from_chars(text.data(), end, shard.number);
  const bool slash = number.ec == std::errc() && number.ptr != end && *number.ptr == '/';
  const auto of = slash ? std::from_chars(number.ptr + 1, end, shard.of) : number;
  if (!slash || of.ec != std::errc() || of.ptr != end || shard.number < 1 || shard.number > shard.of ||
      shard.of > kMostShards)
    throw InputError("--shard: '" + text + "' is not N/M with 1 ≤ N ≤ M ≤ " + std::to_string(kMostShards) +
                     ", such as 3/16 for the third of sixteen shards");
  return shard;
}

std::vector<int> deal_rows(std::size_t rows, int shards) {
  std::vector<std::size_t> order(rows);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::mt19937_64 random(1);
  for (std::size_t left = rows; left > 1; --left) std::swap(order[left - 1], order[random() % left]);
  std::vector<int> shard(rows);
  for (std::size_t turn = 0; turn < rows; ++turn)
    shard[order[turn]] = static_cast<int>(turn % static_cast<std::size_t>(shards)) + 1;
  return shard;
}

void write_study(const Request& request, const std::vector<ScenePlan>& plans) {
  const Machine machine = this_machine();
  Json scenes = Json::array();
  for (const ScenePlan& plan : plans) scenes.push_back(json_of(plan));
  const Json json{{"record_version", kRecordVersion},
                  {"shard", std::to_string(request.shard.number) + "/" + std::to_string(request.shard.of)},
                  {"command", request.command},
                  {"overrides", request.overrides},
                  {"machine",
                   {{"processor", machine.processor},
                    {"cores", machine.cores},
                    {"load", machine.load},
                    {"compiler", machine.compiler},
                    {"flags", machine.flags}}},
                  {"scenes", scenes}};
  write_whole(request.out + "/study.json", json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
}

StudyFile read_study(const std::string& folder) {
  const std::string path = folder + "/study.json";
  std::ifstream stream(path, std::ios::binary);
  if (!stream)
    throw InputError(path + ": cannot be read; a folder that `elastin compare --shard N/M --out` wrote has it");
  try {
    return study_of_json(Json::parse(std::string(std::istreambuf_iterator<char>(stream), {})));
  } catch (const std::exception& error) {
    throw InputError(path + ": is not the plan of a study: " + error.what());
  }
}

}  // namespace elastin::lab
