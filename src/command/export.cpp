#include <fmt/format.h>

#include "command/row.h"
#include "elastin/core/base/error.h"
#include "lab/export/formats.h"
#include "lab/report/files.h"

namespace elastin::command {
namespace {

struct ExportCommand {
  SceneOptions scene;
  std::string format, out;

  void add_to(Options& options) {
    scene.add_to(options, false);
    std::string formats;
    for (const auto& row : lab::export_formats())
      formats += fmt::format("{}{}: {}", formats.empty() ? "" : "; ", row->name, row->summary);
    options.add("--to", "FORMAT", into(format), formats).required = true;
    options.add("--out", "FILE", into(out), "The file; - for standard output").required = true;
  }

  int run(const Call& call) {
    const auto row = lab::export_formats().find(format);
    const auto exported = lab::load_scene(scene.open().front(), call.catalog, scene.overrides);
    std::vector<std::string> notes;
    const std::string text = row->text(*exported, notes);
    if (out == "-") {
      fmt::print("{}", text);
      return 0;
    }
    if (!out.ends_with(row->ending))
      throw InputError("--out " + out + ": files of " + row->name + " end in " + row->ending);
    lab::write_whole(out, text);
    if (scene.quiet) return 0;
    fmt::print("{}: {}, {:.3g} MB\n", out, row->summary, 1e-6 * static_cast<double>(text.size()));
    for (const std::string& note : notes) fmt::print("  {}\n", note);
    return 0;
  }
};

}  // namespace

const CommandRow kExport{
    "export", "Write a scene's body or whole problem as a file of another program",
    R"(export scenes/tension/dogbone.yaml --to vtu --out bone.vtu    the body, or the whole problem, for another program
)",
    &declare<ExportCommand>};

}  // namespace elastin::command
