#include "command/identify.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <optional>

#include "lab/identify/report.h"
#include "lab/report/files.h"
#include "lab/report/progress.h"
#include "lab/report/screen.h"
#include "lab/run/config_names.h"
#include "lab/study/compare.h"

namespace elastin::command {
using namespace lab;
namespace {

std::string path_of(const Request& request, const Answer& answer) {
  return request.out + "/" + (answer.strategy.empty() ? answer.scene : file_name(answer.scene, answer.strategy));
}

/// A file as a scene in this folder names it.
std::string file_from(const std::string& folder, const std::string& file) {
  namespace fs = std::filesystem;
  const fs::path from = fs::absolute(folder).lexically_normal(), to = fs::absolute(file).lexically_normal();
  return path_text((fs::path(file).is_absolute() ? to : to.lexically_relative(from)).generic_string());
}

/// The scene with --set, what was found, and the files that it names from its new folder.
void write_scene(const Request& request, const std::string& path, const Answer& answer) {
  std::filesystem::create_directories(request.out);
  if (!answer.succeeded()) return;
  const std::string folder = std::filesystem::path(path).parent_path().string();
  std::vector<std::pair<std::string, std::string>> values;
  for (const std::string& assignment : request.overrides)  // those of the material are in the one found
    if (const std::size_t equals = assignment.find('=');
        assignment.substr(0, assignment.find_first_of(".=")) != "material")
      values.emplace_back(assignment.substr(0, equals), assignment.substr(equals + 1));
  const std::string head = "material:";
  values.emplace_back("material", answer.material.substr(head.size(), answer.material.size() - head.size() - 1));
  std::string scene;
  try {
    scene = with_values(text_of_scene(path), folder, values);
  } catch (const InputError& error) {
    say(fmt::format("{}: no scene with the numbers put in is written: {}\n", path, error.what()));
    return;
  }
  scene = moved_scene(scene, folder, request.out);
  for (const auto& [key, value] : answer.keys)
    scene = with_value(scene, key, key.ends_with(".file") ? file_from(request.out, value) : value);
  write_whole(path_of(request, answer) + ".yaml", scene);
}

void write_files(const Request& request, const std::vector<Answer>& answers) {
  std::filesystem::create_directories(request.out);
  write_whole(request.out + "/identify.json", identify_json(answers));
  write_whole(request.out + "/report.html", identify_page(answers, request.command));
  for (const Answer& answer : answers) {
    const std::string name = path_of(request, answer);
    write_whole(name + "-points.csv", points_csv(answer));
    write_whole(name + "-fit.svg", svg_text(fit_plot(answer), 760, true));
  }
}

}  // namespace

bool identify_scenes(const Request& request, IdentifyRequest wanted, const Catalog& catalog) {
  Progress progress(progress_of(request));
  wanted.overrides = request.overrides, wanted.strategies = request.strategies;
  wanted.progress = [&](const std::string& doing) { progress.set(doing); };
  wanted.stop = request.interrupted;
  std::optional<FitJournal> journal;
  if (!request.out.empty()) wanted.journal = &journal.emplace(request.out, request.resume);
  std::vector<Answer> all;
  for (const std::string& path : request.scenes) {
    if (wanted.stop && wanted.stop()) break;
    std::vector<Answer> answers = identify(path, catalog, wanted);
    progress.pause();
    for (const Answer& answer : answers) {
      if (request.to_screen()) fmt::print("{}", answer_text(answer, colours_on(STDOUT_FILENO)));
      if (!request.out.empty()) write_scene(request, path, answer);
    }
    if (request.to_screen()) fmt::print("{}", strategies_text(answers, colours_on(STDOUT_FILENO)));
    std::move(answers.begin(), answers.end(), std::back_inserter(all));
    if (!request.out.empty()) write_files(request, all);
  }
  progress.pause();
  if (request.json == "-")
    fmt::print("{}", identify_json(all));
  else if (!request.json.empty())
    write_whole(request.json, identify_json(all));
  return !(wanted.stop && wanted.stop()) &&
         std::all_of(all.begin(), all.end(), [](const Answer& answer) { return answer.succeeded(); });
}

}  // namespace elastin::command
