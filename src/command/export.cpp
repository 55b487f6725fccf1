#include <fmt/format.h>

#include <filesystem>

#include "command/row.h"
#include "core/base/named.h"
#include "elastin/core/base/error.h"
#include "lab/export/formats.h"
#include "lab/report/files.h"

namespace elastin::command {
namespace {

struct ExportCommand {
  SceneOptions scene;
  std::string format, strategy, out;

  void add_to(Options& options) {
    scene.add_to(options, false);
    const std::string formats = joined(
        lab::export_formats(), [](const auto& row) { return row->name + ": " + row->summary; }, "; ");
    options.add("--to", "FORMAT", into(format), formats).required = true;
    options.add("--strategy", "NAME", into(strategy),
                "The strategy whose constants are written, as in --strategies; without it the scene's own");
    options.add("--out", "PATH", into(out), "The file, - for standard output; of an engine the folder").required = true;
  }

  int run(const Call& call) {
    const auto row = lab::export_formats().find(format);
    const auto exported = lab::load_scene(scene.open().front(), call.catalog, scene.overrides);
    if (!strategy.empty()) exported->stiffness = lab::choose_strategy(*exported, call.catalog, strategy);
    if (row->files) return write_folder(*row, lab::exported_body(*exported, exported->stiffness));
    std::vector<std::string> notes;
    const std::string text = row->text(*exported, notes);
    if (out == "-") {
      fmt::print("{}", text);
      return 0;
    }
    if (!out.ends_with(row->ending))
      throw InputError("--out " + out + ": files of " + row->name + " end in " + row->ending);
    lab::write_whole(out, text);
    say(fmt::format("{}: {}, {:.3g} MB", out, row->summary, 1e-6 * static_cast<double>(text.size())), notes);
    return 0;
  }

  int write_folder(const lab::ExportFormat& row, const lab::ExportedBody& body) {
    const auto files = lab::engine_files(row, body);
    std::error_code error;
    if (out == "-" || (std::filesystem::create_directories(out, error), error))
      throw InputError("--out " + out + ": a folder is needed for the files of " + row.name +
                       (error ? ": " + error.message() : ""));
    for (const auto& [name, text] : files) lab::write_whole(out + "/" + name, text);
    say(fmt::format("{}: {}", out, joined(files, &lab::ExportedFile::name)), body.notes);
    return 0;
  }

  void say(const std::string& written, const std::vector<std::string>& notes) const {
    if (scene.quiet) return;
    fmt::print("{}\n", written);
    for (const std::string& note : notes) fmt::print("  {}\n", note);
  }
};

}  // namespace

const CommandRow kExport{
    "export", "Write a scene's body or whole problem as a file of another program",
    R"(export scenes/tension/dogbone.yaml --to vtu --out bone.vtu    the body, or the whole problem, for another program
export scenes/tension/cube-1000.yaml --to jolt --strategy lattice --out cube    the constants, as an engine takes them
)",
    &declare<ExportCommand>};

}  // namespace elastin::command
