#include <fmt/format.h>
#include <unistd.h>

#include "command/row.h"
#include "elastin/lab/experiment/experiment_catalog.h"
#include "lab/scene/scene.h"
#include "lab/study/request.h"
#include "lab/study/study.h"

namespace elastin::command {
namespace {

struct ListCommand {
  bool keys = false;

  void add_to(Options& options) { options.flag("--keys", keys, "List every key of a scene instead, as Markdown"); }

  int run(const Call& call) {
    const lab::ExperimentCatalog experiments = lab::built_in_experiments();
    fmt::print("{}", keys ? lab::key_reference(call.catalog, experiments)
                          : lab::catalog_text(call.catalog, experiments, lab::colours_on(STDOUT_FILENO)));
    return 0;
  }
};

}  // namespace

const CommandRow kList{"list", "List strategies, their parameters, and measures",
                       R"(list                                                  strategies and their parameters
)",
                       &declare<ListCommand>};

}  // namespace elastin::command
