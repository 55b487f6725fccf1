#include <fmt/format.h>

#include <filesystem>

#include "command/row.h"
#include "lab/live/live.h"
#include "lab/report/files.h"
#include "lab/scene/scene.h"

namespace elastin::command {
namespace {

/// Where tools/setup --web puts the module next to this program, or where an installed one has it.
std::string usual_module_folder() {
  std::error_code problem;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", problem);
  const std::filesystem::path root = program.parent_path().parent_path();
  const std::filesystem::path installed = root / "share" / "elastin" / "web";
  return (std::filesystem::exists(installed) ? installed : root / "web" / "bin").string();
}

struct LabCommand {
  SceneOptions scene;
  std::string out, module;

  void add_to(Options& options) {
    scene.add_to(options, false);
    options.add("--out", "FILE", into(out), "The HTML file; - for standard output").required = true;
    options.add("--module", "FOLDER", into(module),
                "Folder of elastin.js and elastin.wasm, as tools/setup --web builds them");
  }

  int run(const Call& call) {
    const auto shown = lab::load_scene(scene.open().front(), call.catalog, scene.overrides);
    const auto web = lab::load_web_module(module.empty() ? usual_module_folder() : module);
    const lab::Parcel parcel = lab::make_parcel(*shown, call.catalog);
    for (const std::string& part : parcel.left_out) fmt::print(stderr, "warning: the page leaves out {}\n", part);
    const std::string page = lab::live_page(*shown, call.catalog, parcel, web);
    if (out == "-") {
      fmt::print("{}", page);
      return 0;
    }
    lab::write_whole(out, page);
    if (!scene.quiet) fmt::print("{}: {:.2f} MB, opens in any browser\n", out, 1e-6 * static_cast<double>(page.size()));
    return 0;
  }
};

}  // namespace

const CommandRow kLab{
    "lab", "Write a page on which a scene's body moves under a hand in a browser",
    R"(lab scenes/tension/cube-1000.yaml --out lab.html      the body in a browser: drag it, change its strategy, test it
)",
    &declare<LabCommand>};

}  // namespace elastin::command
