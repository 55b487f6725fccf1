#include "lab/study/study.h"

#include <fmt/format.h>

#include "command/row.h"
#include "contact/overlaps.h"
#include "lab/scene/scene.h"

namespace elastin::command {
namespace {

struct CheckCommand {
  SceneOptions scene;

  void add_to(Options& options) { scene.add_to(options); }

  int run(const Call& call) {
    bool sound = true;
    for (const lab::SceneSource& source : scene.open()) {
      const auto checked = lab::load_scene(source, call.catalog, scene.overrides);
      const Body& body = checked->specimen.body;
      const lab::CheckReport report = lab::check_scene(*checked, call.catalog, contact::find_overlaps(body, body.rest));
      if (!scene.quiet) fmt::print("{}\n", report.text);
      sound &= report.sound;
    }
    return sound ? 0 : 1;
  }
};

}  // namespace

const CommandRow kCheck{
    "check", "Print counts, pieces and zero-energy modes of a scene's body",
    R"(check scenes/tension/table1-b.yaml                    counts of the body, and its zero-energy modes
)",
    &declare<CheckCommand>};

}  // namespace elastin::command
