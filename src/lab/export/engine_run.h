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
  std::string tested = {};  ///< what the driver was written for, as it calls itself; empty: not said
  /// In place of `command`: gets the request, gives the answer.
  std::function<std::string(const std::string& request)> ask = {};
  std::shared_ptr<const StepperKind> stepper = {};  ///< in place of all: Elastin's own, run to rest as the drivers do
};

const elastin::Table<Engine>& engines();

/// The engine `against` unless it is empty, the engines and steppers that a scene names, and one for each command,
/// called by its script or program: "python3 my_engine.py" is my_engine. Throws InputError for unknown, equal and
/// strategies' names.
std::vector<Engine> chosen_engines(const EngineStudy& study, const std::vector<std::string>& commands,
                                   const std::string& against, const Catalog& catalog);

/// Why an engine cannot run here, with what to type to install it; "" if it can.
std::string missing(const Engine& engine);

/// What a program that solves a problem gives back.
struct OtherSolution {
  Positions displacements;             ///< [m]
  std::optional<Positions> reactions;  ///< with which supports act on the molecules [N]; zero on free ones
};

/// Reads the experiment's measures off it, under the part `load` of the whole load.
void measure_other(const Scene& scene, double load, const OtherSolution& solution, Run& run);

/// Runs the scene with the constants of its own strategy in the engine, as the scene's `engines` say. Whatever goes
/// wrong is an outcome of the run.
OtherRun run_engine(const Engine& engine, Scene& scene, const Catalog& catalog,
                    const std::vector<std::string>& overrides, const std::function<bool()>& stop);

}  // namespace elastin::lab
