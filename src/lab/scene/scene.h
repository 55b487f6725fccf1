#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "elastin/core/base/table.h"
#include "elastin/core/simulation/catalog.h"
#include "elastin/lab/experiment/experiment_catalog.h"
#include "lab/run/config_names.h"
#include "lab/run/specimen.h"
#include "lab/scene/parts.h"

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

/// Whether the converged solution of the scene's own problem is computed as its reference, and how.
struct ComputedReference {
  enum class When {
    by_default,  ///< where no strategy should show the material's values, and the scene states no reference
    always,
    never
  };
  When when = When::by_default;
  double uncertainty = 1e-3;  ///< relative: it is refined until the main measures are known to this
  int most_cells = 1000000;   ///< no body of more cells is solved
  double seconds = 120;       ///< no body is solved that would probably take longer; one that does is given up
  std::string strategy;       ///< the law; empty = the material's own
};

/// A number of a scene that is known to a standard deviation.
struct UncertainNumber {
  std::string key;
  double deviation = 0;  ///< > 0, SI
};

/// One scene file, read, checked and built.
struct Scene {
  SceneSource source;
  std::string name, title;
  Specimen specimen;
  std::unique_ptr<const Experiment> experiment;
  std::shared_ptr<const MeasureList> measures;  ///< of the experiment's runs
  Matrix3 rotation = Matrix3::Identity();       ///< of the whole scene
  StrategyChoice stiffness;                     ///< what `run` uses
  std::vector<StrategyChoice> strategies;       ///< what `compare` uses
  StaticOptions statics;
  std::optional<TimeOptions> time;  ///< of a timed experiment, and only of one
  std::vector<Expectation> expectations;
  std::vector<Reference> references;  ///< stated ones
  ComputedReference computed;
  std::string no_computed_reference;  ///< why it was not computed where it should have been; empty else
  std::string problem;                ///< all but the body and the strategies, as text: equal ones are the same problem
  bool bare_graph = false;            ///< the body is a list of molecules without cells: nothing says what it fills
  Study study;                        ///< what `compare` changes from run to run; empty where the scene has none
  std::optional<StepperStudy> steppers;    ///< where `compare` compares steppers and not strategies
  EngineStudy engines;                     ///< what `compare` runs in addition to strategies
  std::vector<UncertainNumber> uncertain;  ///< what gives every measure its standard deviation
  MatrixX correlation;                     ///< of these with each other, 1 on its diagonal
  std::vector<std::string> warnings;       ///< of the scene as a whole
  std::string whole_body = {};             ///< why each of several processes has the whole body; "" where shares of it
  std::vector<std::string> notes;          ///< what was made of it that its author may want to know
  double build_seconds = 0;                ///< body and experiment
};

/// More molecules than this are an error of the scene.
inline constexpr double kMostMolecules = 5e7;

/// The one with this label, or nullptr.
const StrategyChoice* find_strategy(const std::vector<StrategyChoice>& choices, const std::string& label);

/// The one that a label names in a scene: a strategy that the scene names keeps the scene's parameters. Throws
/// InputError with the nearest name.
StrategyChoice choose_strategy(const Scene& scene, const Catalog& catalog, const std::string& label);

/// Why no run of the scene can be ranked by the material's own values, or "".
std::string no_reference(const Scene& scene);

/// Reads a scene and builds its body and experiment. `overrides` are key.path=value. Throws InputError, of a body with
/// more molecules than these too.
std::unique_ptr<Scene> load_scene(const SceneSource& source, const Catalog& catalog,
                                  const std::vector<std::string>& overrides = {},
                                  double most_molecules = kMostMolecules,
                                  const ExperimentCatalog& experiments = built_in_experiments());

/// The same scene on another body: `change` gets the one that the scene describes, before the scene is turned, with its
/// material.
std::unique_ptr<Scene> load_scene_on(const SceneSource& source, const Catalog& catalog,
                                     const std::vector<std::string>& overrides,
                                     const std::function<void(Body&, const Material&)>& change);

/// Files of another program, each of which is a whole scene: its name ("febio") and, as summary, what one of them is
/// ("model of FEBio").
struct SceneFormat : Descriptor {
  std::string ending;  ///< of its files, ".feb"
  /// Specimen, stiffness, experiment, warnings and notes of a file; a title if it has one. Throws InputError.
  std::unique_ptr<Scene> (*read)(const SceneSource& source) = nullptr;
};

/// The formats that load_scene reads in addition to Elastin's own. A program adds its rows before it reads scenes: see
/// febio::add_scene_format.
elastin::Table<SceneFormat>& scene_formats();

/// The row of a file by its ending; null: the file is a scene in YAML.
const SceneFormat* scene_format_of(const std::string& path);

/// All tables in the order of the reference.
std::vector<KeySection> key_sections(const Catalog& catalog, const ExperimentCatalog& experiments);

/// The key reference, Markdown, as it stands in scenes/README.md.
std::string key_reference(const Catalog& catalog, const ExperimentCatalog& experiments);

}  // namespace elastin::lab
