#include "command/processes.h"

#include <algorithm>
#include <thread>

#include "elastin/core/base/error.h"

namespace elastin::command {
namespace {

/// Whether an argument is one of these options, with its value behind = or not.
bool is_option(const std::string& argument, const std::string& option) {
  return argument == option || argument.starts_with(option + "=");
}

}  // namespace

std::vector<std::string> shared_arguments(std::vector<std::string> arguments, int rank, int count) {
  const auto given = [&](const std::string& option) {
    return std::any_of(arguments.begin(), arguments.end(), [&](const auto& word) { return is_option(word, option); });
  };
  const std::string engine = "solver.engine=";
  if (arguments.size() < 2 || arguments[1] != "run")
    throw InputError("several processes (mpiexec) can only `run` scenes together");
  for (const std::string& word : arguments) {
    const auto at = word.find(engine);
    if (at == 0 || word.starts_with("--set=" + engine)) {
      const std::string name = word.substr(at + engine.size());
      if (name == "threads")
        throw InputError("solver.engine=threads leaves all but one of the " + std::to_string(count) +
                         " processes without work; write solver.engine=petsc, or start one process");
    }
  }
  const bool named = std::any_of(arguments.begin(), arguments.end(),
                                 [&](const auto& word) { return word.find(engine) != std::string::npos; });
  if (!named) arguments.insert(arguments.end(), {"--set", engine + "petsc"});
  if (!given("--threads")) {
    const int cores = static_cast<int>(std::thread::hardware_concurrency());
    arguments.insert(arguments.end(), {"--threads", std::to_string(std::max(1, cores / count))});
  }
  if (rank == 0) return arguments;
  for (std::string& word : arguments)
    if (is_option(word, "--out")) word.replace(0, 5, "--pieces");
  for (auto at = arguments.begin(); at != arguments.end();)
    if (is_option(*at, "--json"))
      at = arguments.erase(at, std::min(arguments.end(), at + (*at == "--json" ? 2 : 1)));
    else
      ++at;
  if (!given("--quiet")) arguments.push_back("--quiet");
  return arguments;
}

}  // namespace elastin::command
