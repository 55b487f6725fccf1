#pragma once
#include <memory>
#include <string>
#include <vector>

#include "lab/scene/scene.h"
#include "lab/study/request.h"

namespace elastin::lab {

/// All rows of one scene: its combinations × threads × strategies, each `repeats` times.
struct ScenePlan {
  std::string path, text;        ///< the scene's file
  std::unique_ptr<Scene> scene;  ///< as it stands; released after its first runs where a study changes it
  std::vector<std::vector<std::pair<std::string, std::string>>> combinations;
  std::vector<int> threads;  ///< 0 = as the command says
  std::vector<std::string> strategies;
  int repeats = 1;
  std::string name, title, own_reference;
  std::size_t runs() const { return combinations.size() * threads.size() * strategies.size(); }
  bool varied() const { return combinations.size() > 1 || threads.size() > 1; }
};

/// Reads all scenes before anything runs: a slip in the last one must not cost the others' time.
std::vector<ScenePlan> plan_of(const Request& request, const Catalog& catalog);

/// The strategies to run on a scene, with the scene's parameters of those that it names.
std::vector<StrategyChoice> chosen_strategies(const Request& request, const Catalog& catalog, const Scene& scene);

/// "KEY.PATH=VALUE" of the command line, then those of a combination.
std::vector<std::string> overrides_of(const Request& request,
                                      const std::vector<std::pair<std::string, std::string>>& combination);

}  // namespace elastin::lab
