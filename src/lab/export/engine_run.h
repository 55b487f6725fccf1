#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "elastin/core/base/table.h"
#include "lab/export/problem.h"
#include "lab/scene/scene.h"

namespace elastin::lab {

/// How engines that step in time run to rest.
struct EngineSettings {
  double time_step = 1. / 60;     ///< [s]
  std::optional<int> iterations;  ///< of a step; none: the engine's own number
  double seconds = 120;           ///< after which an engine that has not answered is ended
  bool calibrate = false;         ///< multiply the constants until the engine shows the modulus that they have
};

/// What another program made of a scene.
struct OtherRun {
  std::unique_ptr<Scene> scene;  ///< as it was given to the program, where that has another body
  Run run;                       ///< measured as a run of Elastin is, off the displacements and forces that it gave
};

/// Another program in a comparison: it solves each scene's problem itself, and is measured as a strategy is.
struct Engine : Descriptor {
  std::string test;     ///< of sh: succeeds where the program is installed; empty: not tested
  std::string install;  ///< what to type where it is not
  /// Of sh, in the present folder; $0 is the folder with the engine's files (see engine_files). It reads a request and
  /// prints an answer, as scenes/README.md describes. Empty: `solve` does it.
  std::string command = {};
  const char* driver = nullptr;  ///< a file among those built in, for the folder
  std::function<OtherRun(const Scene& scene, const Catalog& catalog, const std::vector<std::string>& overrides,
                         const std::function<bool()>& stop)>
      solve = {};
};

const elastin::Table<Engine>& engines();

/// The engines of a list of names, separated by commas, and one for each command, called by its script or program:
/// "python3 my_engine.py" is my_engine. Throws InputError for unknown, equal and strategies' names.
std::vector<Engine> chosen_engines(const std::string& names, const std::vector<std::string>& commands,
                                   const Catalog& catalog);

/// Why an engine cannot run here, with what to type to install it; "" if it can.
std::string missing(const Engine& engine);

/// What a program that solves a problem gives back.
struct OtherSolution {
  Positions displacements;             ///< [m]
  std::optional<Positions> reactions;  ///< with which supports act on the molecules [N]; zero on free ones
};

/// Reads the experiment's measures off it, under the part `load` of the whole load.
void measure_other(const Scene& scene, double load, const OtherSolution& solution, Run& run);

/// Runs the scene with the constants of its own strategy in the engine. Whatever goes wrong is an outcome of the run.
OtherRun run_engine(const Engine& engine, Scene& scene, const Catalog& catalog,
                    const std::vector<std::string>& overrides, const EngineSettings& settings,
                    const std::function<bool()>& stop);

}  // namespace elastin::lab
