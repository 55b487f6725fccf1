#include "lab/study/plan.h"

#include <algorithm>
#include <map>
#include <sstream>

#include "elastin/core/base/error.h"
#include "lab/export/calculix_run.h"
#include "lab/report/json.h"
#include "lab/run/config_names.h"
#include "lab/scene/scene_formats.h"
#include "lab/study/journal.h"
#include "lab/study/request.h"

namespace elastin::lab {
namespace {

std::string trimmed(const std::string& text) {
  const std::size_t from = text.find_first_not_of(' '), to = text.find_last_not_of(' ');
  return from == std::string::npos ? "" : text.substr(from, to - from + 1);
}

ScenePlan plan_scene(const Request& request, const Catalog& catalog, const SceneSource& source) {
  ScenePlan plan;
  plan.source = source;
  plan.scene = load_scene(source, catalog, request.overrides);
  const std::string with = scene_format_of(source.path()) ? "" : open_scene(source, {}, kMostMolecules).content();
  plan.content = key_of(std::vector{source.text(), with});
  plan.warnings = plan.scene->warnings;
  plan.name = plan.scene->name;
  plan.title = plan.scene->title;
  Study study = request.compare ? plan.scene->study : Study{};
  for (const std::string& axis : request.vary) study.axes.push_back(read_axis(axis));
  plan.combinations = combinations(study.axes);
  plan.threads = study.threads.empty() ? std::vector{0} : study.threads;
  plan.repeats = request.repeats > 0 ? request.repeats : study.repeats;
  for (const StrategyChoice& choice : chosen_strategies(request, catalog, *plan.scene))
    plan.strategies.push_back(choice.label);
  if (!request.against.empty()) plan.strategies.push_back(request.against);
  plan.own_reference = study.own_reference;
  if (!study.axes.empty()) load_scene(source, catalog, overrides_of(request.overrides, plan.combinations.front()));
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

std::vector<ScenePlan> plan_of(const Request& request, const Catalog& catalog) {
  if (!request.against.empty()) check_calculix();
  std::vector<ScenePlan> plans;
  for (const SceneSource& source : request.scenes) {
    plans.push_back(plan_scene(request, catalog, source));
    for (std::size_t i = 0; i + 1 < plans.size() && !request.out.empty(); ++i)
      if (plans[i].name == plans.back().name)
        throw InputError("--out: " + plans[i].source.path() + " and " + source.path() +
                         " have the same name, and so would their files");
  }
  if (!request.out.empty()) check_file_names(plans);
  return plans;
}

}  // namespace elastin::lab
