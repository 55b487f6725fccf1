#include "lab/study/shards.h"

#include <charconv>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <numeric>
#include <random>
#include <utility>

#include "elastin/core/base/error.h"
#include "lab/report/files.h"
#include "lab/report/json.h"

namespace elastin::lab {
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
