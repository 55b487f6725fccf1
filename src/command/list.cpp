#include <fmt/format.h>
#include <unistd.h>

#include "command/row.h"
#include "core/base/named.h"
#include "elastin/core/base/error.h"
#include "elastin/lab/experiment/experiment_catalog.h"
#include "lab/scene/scene.h"
#include "lab/study/request.h"
#include "lab/study/study.h"

namespace elastin::command {
namespace {

struct ListCommand {
  bool keys = false;
  std::string word;

  void add_to(Options& options) {
    options.argument("WORD", into(word), "Only what has this word in it: a name, or one of its description", false,
                     false);
    options.flag("--keys", keys, "List every key of a scene instead, as Markdown");
  }

  int run(const Call& call) {
    const lab::ExperimentCatalog& experiments = lab::built_in_experiments();
    if (keys && !word.empty()) throw InputError("list: --keys lists all keys; leave out " + word);
    const std::string text = keys ? lab::key_reference(call.catalog, experiments)
                                  : lab::catalog_text(call.catalog, experiments, lab::colours_on(STDOUT_FILENO), word);
    if (text.empty()) {
      std::vector<std::string> names{"strategies", "steppers",    "solvers", "engines",
                                     "loads",      "experiments", "measures"};
      const auto add = [&](const std::vector<std::string>& more) {
        names.insert(names.end(), more.begin(), more.end());
      };
      add(names_of(call.catalog.strategies()));
      add(call.catalog.steppers.names()), add(call.catalog.linear_solvers.names()), add(call.catalog.loads.names());
      add(names_of(experiments.experiments()));
      for (const lab::KeySection& section : lab::key_sections(call.catalog, experiments))
        for (const lab::SceneKey& key : section.keys) names.push_back(key.name);
      const std::string near = nearest_name(word, names);
      throw InputError("list: no strategy, stepper, solver, load, experiment, key or measure has '" + word +
                       "' in it; " + (near.empty() ? "" : "did you mean '" + near + "'? ") + "elastin list prints all");
    }
    fmt::print("{}", text);
    return 0;
  }
};

}  // namespace

const CommandRow kList{"list", "List strategies, their parameters, and measures",
                       R"(list                                                  strategies and their parameters
list tension                                          what has this word in its name or description
)",
                       &declare<ListCommand>};

}  // namespace elastin::command
