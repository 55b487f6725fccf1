#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "elastin/config/scene_source.h"
#include "elastin/core/simulation/simulation.h"
#include "elastin/lab/experiment/experiment_catalog.h"

namespace elastin::lab {

struct Record;
struct Scene;
using config::HeldScene;
using config::SceneSource;

/// A number that an experiment has read off a body, SI units.
struct Measured {
  std::string name, unit;  ///< "effective_modulus", "Pa"; unit "" of a ratio
  double value = 0;
};

/// What a scene says that a measure is, and by what source.
struct Stated {
  std::string strategy;  ///< about which it is said; "" = any
  Measured measured;
  std::string source;
};

/// Result of one strategy on a scene.
struct LaboratoryResult {
  std::string strategy;
  Outcome outcome = Outcome::converged;
  bool suited = true;              ///< false: the strategy cannot run on this body
  std::string cause;               ///< why it did not converge or is unsuited; empty if it did
  bool good = true;                ///< as the command's exit code 0: no failure, and every `expect` of the scene holds
  std::vector<Measured> measures;  ///< of the last load step, or of the time history of a run
  std::vector<std::string> main;   ///< by which of them strategies are compared, the most telling first
  /// By measure, compared with the target of the material: relative, or the difference of a ratio.
  /// MEASURE_to_reference: relative to the scene's reference.
  std::vector<Measured> errors;
  /// One row a load step or frame: its load factor (time [s] of a run in time) and what was measured there.
  struct Row {
    double at = 0;
    std::vector<Measured> measures;
  };
  std::vector<Row> curve;
  Gradients gradients;  ///< of the measures, by RunWatch::derivatives_by and the scene's uncertain numbers
  /// Where the scene states an `uncertainty`: of each measure its "deviation", and each number's share in its square.
  Gradients spreads;
  std::optional<Eigen::Matrix<double, 6, 6>> stiffness;  ///< [Pa], xx yy zz yz xz xy; of the experiment `material`
  Positions positions;  ///< [m], 3 × n, of the last state; empty where none was reached
  VectorX tensions;     ///< [N], one a connection, pulling is positive; as positions
  /// Where the molecules were in each state that was kept, [m], 3 × n; see RunWatch::keep_states.
  struct Kept {
    double at = 0;  ///< load factor, or time [s]
    Positions positions;
  };
  std::vector<Kept> states;
  std::vector<std::string> warnings, notes;  ///< what makes it doubtful; what was done for the scene, in its order
  std::string solver;                        ///< "newton pcg"; of a run in time its stepper
  int newton_iterations = 0, linear_iterations = 0;
  double build_seconds = 0, solve_seconds = 0;
  /// What a page shows of it; null of one that was packed and unpacked.
  std::shared_ptr<const Record> record;
  std::shared_ptr<const Scene> scene;
  /// The measure of this name; NaN if it was not taken.
  double get(const std::string& name) const;
};

using LaboratoryResults = std::vector<const LaboratoryResult*>;
/// What a comparison recommends.
struct Advice {
  std::string strategy;  ///< "" where none comes near enough
  std::string text;      ///< that and its numbers, or why nothing is recommended
};
/// Of results on one scene, as `elastin compare` says it. Throws InputError where one of them was unpacked.
Advice advice_of(const LaboratoryResults& results);
/// Their page, as `elastin compare --out` writes it: HTML that needs no other file. Throws as advice_of.
std::string page_of(const LaboratoryResults& results);
/// The body with their states alone, to be turned in 3D.
std::string view_of(const LaboratoryResults& results);
/// The same of a simulation's present state.
std::string view_of(const Simulation& simulation);
std::string view_of(const Body& body);

/// What a program may do while a scene runs.
struct RunWatch {
  /// Called before each load step or frame. What it throws ends the run and comes out of it.
  std::function<void(const std::string& doing)> progress = {};
  /// Asked after each step in time and each load step; true ends the run as `interrupted`.
  std::function<bool()> stop = {};
  bool keep_states = false;  ///< at rest and after each load step or frame
  /// Keys of the scene's numbers by which the measures of an experiment at rest are differentiated.
  std::vector<std::string> derivatives_by = {};
};

/// A scene, of a file or in memory, read, checked and built: the laboratory for programs of their own. For one thread
/// at a time.
class Laboratory {
 public:
  /// `overrides` are "key.path=value", as the command's --set. A program that has laws or experiments of its own hands
  /// catalogs with them over. Throws InputError as the command says it: file:line:column.
  explicit Laboratory(const SceneSource& scene, const std::vector<std::string>& overrides = {},
                      Catalog catalog = built_in_catalog(),
                      const ExperimentCatalog& experiments = built_in_experiments());
  ~Laboratory();
  Laboratory(Laboratory&&) noexcept;
  Laboratory& operator=(Laboratory&&) noexcept;

  const std::string& name() const;
  const std::string& title() const;
  const Body& body() const;
  const Material& material() const;
  std::string strategy() const;                 ///< the scene's own: what run takes
  std::vector<std::string> strategies() const;  ///< those that the scene compares
  std::vector<Stated> references() const;       ///< of the same problem from elsewhere
  std::vector<Stated> expectations() const;     ///< values that the scene says must come out
  const std::vector<std::string>& warnings() const;

  /// Computes the reference of the scene, what its own problem comes to on finer and finer cells, as `elastin compare`
  /// does: as the scene says ("" here), or always ("computed"), or never ("none"). Runs after it have errors to it, and
  /// calibrate to it. One of the warnings says why a reference is missing where there should be one.
  void compute_reference(const std::string& option = "", const RunWatch& watch = {});

  /// Runs the experiment with a strategy by name ("calibrated:angles", "lattice+volume"); "" takes the scene's own. A
  /// strategy that the scene names keeps the scene's parameters. Equal to the command's numbers to the last bit. Throws
  /// InputError; numerical trouble is an outcome.
  LaboratoryResult run(const std::string& strategy = "", const RunWatch& watch = {});
  /// The body with the constants of a strategy ("": the scene's own) as JSON, see `elastin export --to json` in
  /// scenes/README.md. Throws InputError where the strategy does not suit.
  std::string exported(const std::string& strategy = "");
  /// The files of `elastin export --to FORMAT` by name; of a format that is one file that under "". Throws InputError
  /// for what the format cannot say. What a user must know of them is added to `notes`.
  std::vector<std::pair<std::string, std::string>> exported(const std::string& format, const std::string& strategy,
                                                            std::vector<std::string>& notes);
  /// Runs the experiment in a solver of the program's own with the constants of the scene's strategy, at the time step
  /// and iterations of its `engines`: `solve` gets a request and gives an answer, JSON as scenes/README.md describes
  /// it, and is measured as a strategy is. Numerical trouble is an outcome; what `solve` throws comes out.
  LaboratoryResult measure(const std::function<std::string(const std::string& request)>& solve);
  /// The scene's body at rest (of a scene in time: as it is at time 0), its strategy, its loads, damping and contact,
  /// held by its experiment and loaded in full at once, to be stepped. Independent of the laboratory from then on.
  /// Throws InputError where the strategy does not suit, and where that state cannot be found.
  Simulation simulation(const std::string& strategy = "", SimulationOptions options = {});

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// A body as scenes describe one under `body:`, in YAML: "lattice: {kind: cubic, molecules: [5, 5, 5], spacing: 1 mm}".
/// Files are named from the working directory. What makes its results doubtful is added to `warnings`, and how it
/// was read to `notes`. Throws InputError: body:line:column.
Body make_body(const std::string& yaml, const Material& material, std::vector<std::string>& warnings,
               std::vector<std::string>& notes);
/// The same with bodies and materials of the program. Throws InputError: scene:line:column.
Body make_body(const HeldScene& held, const Material& material, std::vector<std::string>& warnings,
               std::vector<std::string>& notes);

/// A material as scenes describe one under `material:`, in YAML: "{law: yeoh, terms: [1 kPa], bulk_modulus: 1 MPa}".
/// Files are named from the working directory. Throws InputError: material:line:column.
Material make_material(const std::string& yaml);
/// The same with materials of the program. Throws InputError: scene:line:column.
Material make_material(const HeldScene& held, const Catalog& catalog = built_in_catalog());

}  // namespace elastin::lab
