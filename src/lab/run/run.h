#pragma once
#include <array>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "elastin/contact/contact.h"
#include "elastin/core/forces/load_table.h"
#include "elastin/core/model/body.h"
#include "elastin/core/model/material.h"
#include "elastin/lab/run/experiment.h"
#include "lab/run/time_options.h"

namespace elastin {
class Catalog;
}
namespace elastin::lab {

struct BodyImage;
struct StrategyChoice;
class Derivatives;

/// The material that an identification found.
struct Identified {
  std::vector<double> polynomial;       ///< c₀, c₁ … [Pa]
  std::vector<double> standard_errors;  ///< of E at no strain, at up_to/2 and at up_to [Pa], from the misfit's scatter
  double up_to = 0;                     ///< strain
  double misfit = 0;                    ///< root of the mean of (shown/measured − 1)²
  int evaluations = 0;                  ///< load curves that were solved for it
  double modulus(double strain) const;  ///< E(|ε|) [Pa]
};

/// Outcome of a run whose strategy cannot run on its body; in addition to the names of the outcomes.
inline constexpr const char* kUnsuited = "unsuited";

/// Beyond this relative uncertainty a reference ranks nothing.
inline constexpr double kMostUncertain = 0.05;

/// A value of the same boundary-value problem to measure errors against: from elsewhere, or the limit of the solid
/// itself under refinement.
struct Reference {
  std::string measure;
  double value = 0;
  std::string source;
  double uncertainty = 0;  ///< relative; 0 = not stated
  bool computed = false;   ///< the solid itself, refined and extrapolated
  double seconds = 0;      ///< that computing it took, when it was
  bool read_back = false;  ///< from the file of an earlier comparison
  double scatter = 0;      ///< standard deviation of the measured specimens, over the value; 0 = not stated
  std::string along = {};  ///< measure, "time" or "load" over which `points` stand; empty without
  std::vector<std::array<double, 3>> points = {};  ///< of a measured curve: where, value, standard deviation
  bool certain() const { return uncertainty <= kMostUncertain; }
  bool operator==(const Reference&) const = default;
};

/// Adds one load, or damping, to a model of the body.
struct SpecimenLoad {
  std::function<void(Model&)> add;
  /// Its row in the core's table of loads and its values, for adding it again; empty if it depends on other data or
  /// changes in time.
  std::optional<std::pair<std::string, LoadValues>> row = {};
};

/// What the shape is in which a body is described.
enum class GivenShape {
  at_rest,
  loaded,   ///< under its loads: each run finds the unloaded one first
  in_place  ///< in equilibrium by its prestrain, Body::unstressed: each run finds the rest that keeps it there first
};

/// What does not change from strategy to strategy.
struct Specimen {
  Body body;
  Material material;  ///< what experiments compare with
  std::vector<SpecimenLoad> loads;
  std::function<void(State&)> start = {};  ///< changes the state in which a run begins; may be empty
  GivenShape given = GivenShape::at_rest;
  std::vector<Material> materials = {};                 ///< of the body's parts, by Part::material; empty without parts
  std::shared_ptr<const Catalog> laws = {};             ///< that parts may state; null without parts
  std::shared_ptr<const BodyImage> image = {};          ///< of which the body was made; null: of none
  std::optional<contact::ContactOptions> contact = {};  ///< none: no contact object is built
  std::shared_ptr<const StrategyChoice> law = {};  ///< that the material states by constants or a curve; null: none
  /// In which spring rules are calibrated; null: in the scene's own experiment.
  std::shared_ptr<const StaticExperiment> calibration = {};
  std::vector<Reference> references = {};  ///< computed ones: what the solid itself measures on this body
};

/// A state to be looked at.
struct Snapshot {
  double at = 0;                               ///< load factor; time [s] of a run in time
  Positions positions;                         ///< [m]
  VectorX force_densities;                     ///< force density of each connection [N/m]
  int number = 0;                              ///< of the load step or frame
  Positions contact_forces = {};               ///< [N]; empty without contact
  VectorX contact_pressure = {};               ///< [Pa]
  std::vector<contact::Pose> obstacles = {};   ///< where they were
  std::vector<CellState> states_of_laws = {};  ///< of all cells as CellNodes has them; empty: no law has any
  VectorX other_force_densities = {};          ///< [N/m]; where there are such states, those that are in none of them
  Positions elastic_forces = {};               ///< [N]; where some are found at the nodes of cells
  /// The same states of a snapshot that is kept with others, in their place: strain and stress, 00 11 22 01 02 12 each.
  std::vector<std::array<float, 12>> kept_states = {};
  double frequency =
      std::numeric_limits<double>::quiet_NaN();  ///< [Hz] of a vibration whose shape this is; NaN: of none
};

/// What another program says of a run that it made.
struct EngineReport {
  std::string version;          ///< in its own words
  std::string constants;        ///< the strategy whose constants it was given; empty: none
  double time_step = 0;         ///< [s]; 0: it has none
  int iterations = 0;           ///< of a step; 0: its own number, which it did not say
  int steps = 0;                ///< to rest
  double seconds_per_step = 0;  ///< by its own clock
  std::string name = {};
};

/// Result of one strategy on one specimen. Everything in SI units.
struct Run {
  std::string strategy;
  int order = 0;  ///< of the strategy, see StrategyChoice::order
  std::string solver;
  std::string solver_reason;  ///< why that one; empty where there was no choice
  Outcome outcome = Outcome::converged;
  std::string cause;
  Measures measures;                ///< of the last converged load step
  std::vector<CurvePoint> curve;    ///< one point a converged load step
  Gradients gradients;              ///< of `measures`, where they are requested
  std::vector<Snapshot> snapshots;  ///< of the start and of each point, or the last of them, if requested
  /// Of natural vibrations, to be shown in place of the snapshots: the state about which the body moves, then each
  /// mode, whose largest displacement from there is a tenth of the body's size.
  std::vector<Snapshot> modes;
  std::vector<contact::Obstacle> obstacles;  ///< of the snapshots
  const std::vector<Snapshot>& shown() const { return modes.empty() ? snapshots : modes; }
  VectorX constants;                     ///< spring constants [N/m]; empty for laws without
  double calibration_factor = 1;         ///< what calibration has multiplied the rule's constants with
  bool calibrated_to_reference = false;  ///< not to the material: it meets the computed reference by construction
  double volume_modulus = 0;             ///< κ of the springs' volume term [Pa]; 0 without
  std::optional<Identified> identified;  ///< the material that the experiment was there to find
  double build_seconds = 0, solve_seconds = 0;
  int newton_iterations = 0, linear_iterations = 0;
  int cut_steps = 0;            ///< Newton steps that were shortened because they would have inverted a cell
  int bisected_load_steps = 0;  ///< load steps that were bisected to avoid inverting a cell
  double residual = 0;
  int zero_energy_modes = 0;
  std::vector<std::string> warnings;
  std::string remark;                  ///< of the experiment on what its measures mean here; empty = nothing to say
  bool restarted_from_rest = false;    ///< the start led nowhere: measured from the equilibrium that there is from rest
  bool unstable = false;               ///< an equilibrium was found that is no minimum
  bool relaxes = false;                ///< the strategy is `prony:`
  bool wrinkles = false;               ///< the strategy is a membrane law that bears no compression
  bool uses_cells = false;             ///< the strategy could not run without the body's triangles or tetrahedra
  bool suited = true;                  ///< false: the strategy cannot run on this body; cause says why
  std::optional<TimeReport> time;      ///< of a run in time
  std::optional<EngineReport> engine;  ///< of a run by another program, which `strategy` names too
  std::shared_ptr<const Body> found;   ///< with the rest that was found; null where none was to be found
  Measures law;                        ///< what the law itself shows in this test, see measure_law; may be empty
  double law_strain = 0;               ///< at which it does
  std::optional<contact::ContactReport> contact;  ///< of the last state, where there is contact
  Positions end;                                  ///< of the last state [m], until findings_at_end has looked at it
};

/// "converged", "unsuited" …
inline const char* outcome_name(const Run& run) { return run.suited ? name_of(run.outcome) : kUnsuited; }

struct RunOptions {
  StaticOptions statics;
  bool keep_snapshots = false;
  bool last_snapshot = false;                                   ///< of them only that of the last state
  std::function<void(const std::string& doing)> progress = {};  ///< called before each load step; may be empty
  std::optional<TimeOptions> time = {};                         ///< what a timed experiment needs
  bool live = false;                                            ///< frames of a run in time no faster than its cap
  std::string problem = {};       ///< of the scene (Scene::problem): a run goes on with that of another one only
  std::string restart = {};       ///< text that `checkpoint` got: a run in time goes on from there
  std::string restart_path = {};  ///< where that text stands, for messages; may be empty
  std::function<void(const std::string& text)> checkpoint = {};  ///< called after frames that are to be kept
  /// Asked after each step in time and before each load step and iteration of Newton's method; true ends the run.
  std::function<bool()> stop = {};
  std::shared_ptr<Derivatives> derivatives = {};  ///< of the measures, to be taken too; null: none
};

/// Why a strategy cannot be used to identify a material, or "".
std::string identification_unsuited(const StrategyChoice& choice);

/// Puts the curve found into the specimen's material and what was found into the run. Least squares of shown/measured −
/// 1 over c₀, c₁ up_to, c₂ up_to² … [Levenberg & Marquardt, MINPACK's lmdif as in Eigen], each evaluation one load
/// curve, started from the last one's equilibria. False if even the guess cannot be solved, or there are fewer values
/// than coefficients: the run says why.
bool identify_material(const Identification& wanted, Specimen& specimen, const StaticExperiment& experiment,
                       const StrategyChoice& choice, const RunOptions& options, Run& run);

}  // namespace elastin::lab
