#pragma once
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "contact/overlaps.h"
#include "elastin/core/laws/material_law.h"
#include "lab/report/directions.h"
#include "lab/report/plot.h"
#include "lab/report/records.h"
#include "lab/report/screen.h"
#include "lab/report/stepper_report.h"
#include "lab/scene/scene.h"
#include "lab/study/request.h"

/// What the commands do with scenes.
namespace elastin::lab {

/// The output of `elastin check` for a scene.
struct CheckReport {
  std::string text;
  bool sound = true;  ///< false: isolated molecules, several pieces, connections without length, flat cells
};

/// Counts, neighbours, pieces, faults by number, zero-energy modes by name, what the scene builds, and which strategies
/// can run on the body. `overlaps` are those of the body at rest.
CheckReport check_scene(Scene& scene, const Catalog& catalog, const std::vector<contact::Overlap>& overlaps);

/// The output of `elastin list`.
std::string catalog_text(const Catalog& catalog, const ExperimentCatalog& experiments, bool colours,
                         const std::string& word = "");

/// How progress is shown: not at all with --quiet, otherwise as standard error can show it.
Progress::Show progress_of(const Output& output);

/// Derivatives by numbers of a scene, which may be read again with others, and by its uncertain ones; null by none.
/// Throws InputError: a key where the scene states no number, with the nearest one.
std::shared_ptr<Derivatives> derivatives_by(const std::vector<std::string>& keys, const Scene& scene,
                                            const StrategyChoice& choice, const Catalog& catalog,
                                            const std::vector<std::string>& overrides,
                                            const ExperimentCatalog& experiments = built_in_experiments());
/// As Derivatives::check_deviations, by the scene's uncertain numbers.
void check_deviations(const Scene& scene, const RunOptions& options, Run& run);

/// Runs every chosen strategy on every scene, in every combination of a study. Of `compare` prints one table
/// a scene and, of several, a summary; of `run` one page a run. With `out` each row is on disk as soon as it is
/// finished, and a page, plots and tables in the end. Returns whether nothing failed. Throws InputError.
bool run_scenes(const Request& request, const Catalog& catalog);

/// Puts the rows of one study together that lie in several folders of `compare --out`, and reports them as the one
/// command would have that runs them all: tables, page, files, with times as they were measured. The merged folder is
/// one of `compare --out` itself: `--resume` continues in it. Says on standard error which rows are missing, and which
/// are there twice with different numbers; of these the first folder's count.
/// @param output `out` may be empty
/// @return whether every row is there, none contradicts another, and nothing failed. Throws InputError: a folder that
/// has no study or another one than the first.
bool merge_studies(const std::vector<std::string>& folders, const Output& output);

/// Whether the command, or one of its scenes, compares steppers instead of strategies. Throws InputError where some
/// scenes do and others do not.
bool compares_steppers(const Request& request);

/// Runs every stepper on every scene and reports. Returns whether all rows that could run did.
bool compare_steppers(const Request& request, const Catalog& catalog);

/// The steppers of `study` on a scene's own strategy, held by its experiment at rest (of one in time: its fixture):
///   * loaded at once, under mass damping that is critical for the loaded shape, until it rests: measures at rest;
///   * released from the loaded equilibrium for one period without that damping: errors, energy and time of a step.
/// Throws InputError where there is no such experiment, or no equilibrium.
/// @param progress gets what is being done; @param stop ends the comparison after a row.
StepperComparison measure_steppers(Scene& scene, const StepperStudy& study,
                                   const std::function<void(const std::string&)>& progress = {},
                                   const std::function<bool()>& stop = {});

/// A scene to begin with.
struct NewScene {
  std::string specimen;            ///< of new_specimens()
  std::string size;                ///< "40 x 10 x 4 mm": of a block, along x, y, z
  std::string mesh;                ///< file of a mesh or a surface
  std::string length_unit = "";    ///< of the file's coordinates; empty: what an image states, else mm
  std::string modulus = "10 kPa";  ///< E
  double poissons_ratio = 0.45;    ///< from 0 to below 0.5
  std::string voxel_size = "";     ///< "1 x 1 x 2 mm", of an image that does not state it
};

struct NewSpecimen {
  const char *name, *summary;
  const char* file;  ///< what `mesh` names: "image"; empty: it has a `size`
  bool from_file() const { return *file != 0; }
};

/// What scenes can be begun with.
const std::vector<NewSpecimen>& new_specimens();

/// A whole scene with comments that say what each part is and what else it may be; its file will stand in `folder`, to
/// which the path of the mesh is relative. Cells are as small as lets all strategies run in seconds: some thousands.
/// Throws InputError: an unknown specimen, a size or a modulus that cannot be read, a mesh that cannot be loaded.
std::string new_scene_text(const NewScene& wanted, const std::string& folder);

/// Two columns of a CSV file that Elastin wrote against each other, named with or without their unit. Empty names
/// choose:
///   * rows of benchmarks: error over minimum_s, a series a method;
///   * runs.csv: the first error over the time to solve, a series a strategy (and scene, where there are several);
///   * curves and time histories: what the page draws of them, one series.
/// Benchmarks stand on logarithmic axes, and so do times and errors of runs, errors by their size. Throws InputError:
/// file:line, with the nearest column.
Plot csv_plot(const std::string& path, std::string x, std::string y);

/// Nominal stress over nominal strain, or amount of shear, of a material with a law: in uniaxial, planar and
/// equibiaxial tension and compression and in simple shear. Dashed where the law is unstable [Drucker]; curves end
/// where there is no equilibrium.
/// Axis 1 is along the law's own direction, if it has one.
/// @param stretch the largest one, > 1; the largest shear is stretch − 1. Compression goes to its inverse, or to where
/// the stress is as large as that of tension.
Plot material_plot(const std::string& title, const MaterialLaw& law, const Material& material, double stretch);

/// No larger body is measured in every direction: that takes six linear solves a strategy.
inline constexpr int kMostMeasuredMolecules = 20000;

/// Measures a strategy, calibrated as in the scene's own experiment, by six small strains of the body's surface at rest
/// (see make_homogenisation), without the scene's loads; where that is the scene's experiment, `run` has measured it.
/// The scene's body must be prepared for it. Says why where that has no meaning: no solid, or no one isotropic
/// material.
DirectionErrors measure_directions(const Scene& scene, const StrategyChoice& choice, const RunOptions& options,
                                   const Run& run);

/// A case that a strategy or a solver may fail on: one scene with one strategy, compared with what the scene expects;
/// and the same with other choices.
struct Case {
  Record own;
  std::string trouble;  ///< another fault: a resumed run that differs; empty = none
  /// Other choices by name, and their verdicts in words; empty = not requested.
  std::vector<std::pair<std::string, std::string>> others;
};

struct VerifyOptions {
  std::vector<std::string> overrides;  ///< KEY.PATH=VALUE, of every scene
  bool others = false;    ///< also run explicit steps, implicit steps, small displacements and plain springs
  bool steppers = false;  ///< also run cases in time with every stepper
  bool keep_snapshots = false;
  std::function<void(const std::string& doing)> progress = {};
  /// Called after each run of a case's own; may write files of it.
  std::function<void(const Scene&, Record&)> finished = {};
};

/// Runs a scene with its own strategy and with each that an expectation names. Throws InputError on wrong input.
std::vector<Case> verify_scene(const SceneSource& source, const Catalog& catalog, const VerifyOptions& options);

/// What a case is worth. Not judged: the run converged, and the scene has no expectation of it that is judged.
enum class CaseResult { passed, failed, not_judged };
CaseResult result_of(const Case& a_case);
inline bool passed(const Case& a_case) { return result_of(a_case) == CaseResult::passed; }

/// One line for each case: verdict, error against the known result, time; then how many passed. `markdown`: the table
/// alone, for a page.
std::string verdicts_text(const std::vector<Case>& cases, bool colours, bool markdown);

}  // namespace elastin::lab
