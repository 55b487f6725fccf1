#pragma once
#include <optional>
#include <string>
#include <vector>

#include "elastin/lab/scene/experiment_catalog.h"
#include "lab/experiment/specimen.h"
#include "lab/scene/keys.h"
#include "lab/scene/study.h"

namespace elastin::lab {

/// The value of a measure from a published or independent source, or how a run must stop.
struct Expectation {
  std::string strategy;  ///< the strategy it is about; empty = every one
  std::string measure;   ///< empty where an outcome is expected
  std::string outcome;   ///< "inverted" …: the run must stop so, with `cause` in its cause; empty = it converges
  std::string cause;
  double value = 0;                   ///< SI
  double relative = 0, absolute = 0;  ///< tolerance: |difference| ≤ absolute + relative |value|
  std::string source;
  std::string not_reproduced;  ///< why it is printed but not judged; empty = judged
};

/// A value of the same boundary-value problem from elsewhere, to measure errors against.
struct Reference {
  std::string measure;
  double value = 0;
  std::string source;
  double uncertainty = 0;  ///< relative; 0 = not stated
};

/// One scene file, read, checked and built.
struct Scene {
  std::string path, name, title;
  Specimen specimen;
  std::unique_ptr<const Protocol> experiment;
  StrategyChoice stiffness;                ///< what `run` uses
  std::vector<StrategyChoice> strategies;  ///< what `compare` uses
  StaticOptions statics;
  std::optional<TimeOptions> time;  ///< of a timed experiment, and only of one
  std::vector<Expectation> expectations;
  std::vector<Reference> references;
  Study study;                        ///< what `compare` changes from run to run; empty where the scene has none
  std::vector<std::string> warnings;  ///< of the scene as a whole
  std::vector<std::string> notes;     ///< what was made of it that its author may want to know
  double build_seconds = 0;           ///< body and experiment
};

/// More molecules than this are an error of the scene.
inline constexpr double kMostMolecules = 5e7;

/// The one with this label, or nullptr.
const StrategyChoice* find_strategy(const std::vector<StrategyChoice>& choices, const std::string& label);

/// The one that a label names in a scene: a strategy that the scene names keeps the scene's parameters. Throws
/// InputError with the nearest name.
StrategyChoice choose_strategy(const Scene& scene, const Catalog& catalog, const std::string& label);

/// Reads a scene and builds its body and experiment. `overrides` are key.path=value. Throws InputError, of a body with
/// more molecules than these too. `uses`, if given, gets every key that its readers ask for.
std::unique_ptr<Scene> load_scene(const std::string& path, const Catalog& catalog,
                                  const std::vector<std::string>& overrides = {},
                                  double most_molecules = kMostMolecules,
                                  const ExperimentCatalog& experiments = built_in_experiments(),
                                  KeyUses* uses = nullptr);

}  // namespace elastin::lab
