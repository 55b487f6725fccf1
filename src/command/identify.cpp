#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <optional>

#include "command/row.h"
#include "lab/identify/identify.h"
#include "lab/report/files.h"
#include "lab/report/screen.h"
#include "lab/run/config_names.h"
#include "lab/study/study.h"

namespace elastin::command {
using namespace lab;
namespace {

/// The path of an answer's files without their endings.
std::string path_of(const std::string& out, const Answer& answer) {
  return out + "/" + (answer.strategy.empty() ? file_name(answer.scene) : file_name(answer.scene, answer.strategy));
}

/// A file as a scene in this folder names it.
std::string file_from(const std::string& folder, const std::string& file) {
  namespace fs = std::filesystem;
  const fs::path from = fs::absolute(folder).lexically_normal(), to = fs::absolute(file).lexically_normal();
  return path_text((fs::path(file).is_absolute() ? to : to.lexically_relative(from)).generic_string());
}

/// The scene with --set and with what was found; files are named from its new folder.
void write_scene(const std::string& out, const std::vector<std::string>& overrides, const SceneSource& source,
                 const Answer& answer) {
  std::filesystem::create_directories(out);
  if (!answer.succeeded()) return;
  const std::string folder = std::filesystem::path(source.path()).parent_path().string();
  std::vector<std::pair<std::string, std::string>> values;
  for (const std::string& assignment : overrides)  // those of the material are in the one found
    if (const std::size_t equals = assignment.find('=');
        assignment.substr(0, assignment.find_first_of(".=")) != "material")
      values.emplace_back(assignment.substr(0, equals), assignment.substr(equals + 1));
  const std::string head = "material:";
  const std::size_t begin = answer.material.find(head) + head.size();
  values.emplace_back("material", answer.material.substr(begin, answer.material.size() - begin - 1));
  std::string scene;
  try {
    scene = with_values(source, values);
  } catch (const InputError& error) {
    say(fmt::format("{}: no scene with the numbers found is written: {}\n", source.path(), error.what()));
    return;
  }
  scene = moved_scene(scene, folder, out);
  for (const auto& [key, value] : answer.keys)
    scene = with_value(scene, key, key.ends_with(".file") ? file_from(out, value) : value);
  if (answer.field) {
    const std::string file = "{file: " + path_text(std::filesystem::path(path_of(out, answer)).filename().string()) +
                             "-field.vtu, data: stiffness, length_unit: m}";
    const std::string with = with_value(scene, "material.fields.stiffness", file);
    scene = with != scene ? with : with_value(scene, "material.fields", "{stiffness: " + file + "}");
  }
  write_whole(path_of(out, answer) + ".yaml", scene);
}

void write_files(const Output& output, const std::vector<Answer>& answers) {
  std::filesystem::create_directories(output.out);
  write_whole(output.out + "/identify.json", identify_json(answers));
  write_whole(output.out + "/report.html", identify_page(answers, output.command));
  for (const Answer& answer : answers) {
    const std::string name = path_of(output.out, answer);
    write_whole(name + "-points.csv", points_csv(answer));
    write_whole(name + "-fit.svg", svg_text(fit_plot(answer), 760, true));
    if (answer.field) write_whole(name + "-field.vtu", field_vtu(answer));
  }
}

/// Adds the files of "FOLDER" or "TEST=FOLDER" in order of their names, each as --data takes it; a file adds itself.
void add_files(const std::string& given, std::vector<std::string>& files) {
  const std::size_t equals = given.find('=');
  const std::string test = equals == std::string::npos ? "" : given.substr(0, equals + 1),
                    folder = given.substr(test.size());
  if (!std::filesystem::exists(folder)) throw InputError("--each " + given + ": there is no such folder or file");
  if (!std::filesystem::is_directory(folder)) return files.push_back(given);
  std::vector<std::string> found;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (entry.is_regular_file() && !entry.path().filename().string().starts_with("."))
      found.push_back(test + entry.path().string());
  if (found.empty()) throw InputError("--each " + given + ": there is no file in this folder");
  std::sort(found.begin(), found.end());
  files.insert(files.end(), found.begin(), found.end());
}

/// Of many curves: the table, JSON, and a page of the first ones.
void write_numbers(const Output& output, const std::vector<Answer>& answers) {
  constexpr std::size_t shown = 12;
  std::filesystem::create_directories(output.out);
  write_whole(output.out + "/identify.json", identify_json(answers));
  write_whole(output.out + "/numbers.csv", numbers_csv(answers));
  write_whole(output.out + "/report.html", identify_page(answers, output.command, shown));
}

/// Fits the material of each scene to its measured tests; prints tables, and with --out writes the page, JSON, every
/// point, and the scene with the numbers found.
struct IdentifyCommand {
  SceneOptions scene;
  Output output;
  IdentifyRequest request;
  std::string resumed;
  std::vector<std::string> each;

  void add_to(Options& options) {
    scene.add_to(options);
    scene.identifies = true;
    options
        .add("--data", "FILE", into(request.data),
             "CSV file instead of the scene's own: FILE, or TEST=FILE. May be repeated")
        .repeated = true;
    options
        .add(
            "--each", "FOLDER", [this](const std::string& given) { add_files(given, each); },
            "One answer, a row of a table, for each file of a folder in the place of the scene's own: FOLDER, or "
            "TEST=FOLDER; or a file. May be repeated")
        .repeated = true;
    options
        .add("--tests", "NAMES", each_of(into(request.tests)),
             "Tests that count, separated by commas; the others are predicted alone")
        .repeated = true;
    options.add("--laws", "NAMES", into(request.laws),
                "Laws that are compared, separated by commas (yeoh/2: with two terms); all: every law");
    options.add("--strategies", "NAMES", into(request.strategies),
                "Strategies of the specimens instead of their scenes' own, separated by commas: each is fitted");
    options.add("--json", "FILE", into(output.json), "JSON file; - for standard output, and nothing else there");
    options.add("--out", "FOLDER", into(output.out),
                "Folder for the page, JSON, every point, and the scene with its numbers");
    options.add("--resume", "FOLDER", into(resumed),
                "Continue in a folder of --out: searches that ended there are not repeated");
  }

  /// The first interrupt ends the search under way with the best that it has.
  int run(const Call& call) {
    const std::vector<SceneSource> sources = scene.open();
    const bool resume = continue_in(resumed, output.out);
    output.quiet = scene.quiet, output.command = call.line;
    Progress progress(progress_of(output));
    request.overrides = scene.overrides;
    request.progress = [&](const std::string& doing) { progress.set(doing); };
    request.stop = interrupted;
    stop_on_interrupt();
    std::optional<FitJournal> journal;
    if (!output.out.empty()) request.journal = &journal.emplace(output.out, resume);
    std::vector<Answer> all;
    for (const SceneSource& source : sources) {
      if (interrupted()) break;
      if (!each.empty()) {
        for (const std::string& file : each) {
          if (interrupted()) break;
          progress.set(file);
          add_curve(source, call.catalog, file, all);
        }
        continue;
      }
      std::vector<Answer> answers = identify(source, call.catalog, request);
      progress.pause();
      print(answers);
      if (!output.out.empty())
        for (const Answer& answer : answers) write_scene(output.out, scene.overrides, source, answer);
      std::move(answers.begin(), answers.end(), std::back_inserter(all));
      if (!output.out.empty()) write_files(output, all);
    }
    progress.pause();
    if (!each.empty()) {
      if (output.to_screen()) fmt::print("{}", answers_text(all, colours_on(STDOUT_FILENO)));
      if (!output.out.empty()) write_numbers(output, all);
    }
    if (output.json == "-")
      fmt::print("{}", identify_json(all));
    else if (!output.json.empty())
      write_whole(output.json, identify_json(all));
    const auto succeeded = [](const Answer& answer) { return answer.succeeded(); };
    return !interrupted() && std::all_of(all.begin(), all.end(), succeeded) ? 0 : 1;
  }

  /// A curve that cannot be read is an answer, too.
  void add_curve(const SceneSource& source, const Catalog& catalog, const std::string& file, std::vector<Answer>& all) {
    IdentifyRequest own = request;
    own.data = {file};
    std::vector<Answer> answers;
    try {
      answers = identify(source, catalog, own);
    } catch (const InputError& error) {
      answers.emplace_back().cause = error.what();
    }
    for (Answer& answer : answers)
      answer.scene = std::filesystem::path(file.substr(file.find('=') + 1)).stem().string();
    std::move(answers.begin(), answers.end(), std::back_inserter(all));
  }

  void print(const std::vector<Answer>& answers) const {
    if (!output.to_screen()) return;
    const bool colours = colours_on(STDOUT_FILENO);
    for (const Answer& answer : answers) fmt::print("{}", answer_text(answer, colours));
    if (answers.size() > 1) fmt::print("{}", answers_text(answers, colours));
  }
};

}  // namespace

const CommandRow kIdentify{
    "identify", "Fit a scene's material to measured tests; print how certain it is",
    R"(identify scenes/identify/treloar-ogden.yaml           the material of a measured curve, and how certain its numbers are
)",
    &declare<IdentifyCommand>};

}  // namespace elastin::command
