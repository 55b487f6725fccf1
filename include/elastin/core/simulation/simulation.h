#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "elastin/core/forces/model.h"
#include "elastin/core/geometry/pose.h"
#include "elastin/core/model/material.h"
#include "elastin/core/model/topology.h"
#include "elastin/core/parallel/threads.h"
#include "elastin/core/simulation/catalog.h"
#include "elastin/core/simulation/prepare.h"
#include "elastin/core/solve/stepper.h"

namespace elastin {

class Sensitivity;  // elastin/core/solve/sensitivity.h

/// Names a virtual coupling (see Simulation::couple); never used again after decouple.
using CouplingId = int;
/// Names a load (see Simulation::add_load), from 1; never used again after remove_load.
using LoadId = int;
/// Names a tool (see Simulation::add_tool), from 1.
using ToolId = int;

struct SimulationOptions {
  StepperOptions stepper = {"symplectic_euler"};
  ParameterValues parameters = {};  ///< of the strategy
  /// Explicit steppers part a step so that each part is at most this share (0 … 1] of the longest stable step of the
  /// body at rest, with its grips unless the stepper takes them at the end of a step; see find_stable_step. The steps
  /// themselves show where the body has become stiffer, and those after it are shorter for good; so that 0.95 does for
  /// laws that stiffen slowly, as springs do.
  double safety = 0.8;
  /// A step that would take more parts ends as limit_reached and leaves the state as it was: real time has a limit.
  int max_substeps = 1000;
  /// By the clock, what a step may take [s]; 0: any. Of steppers that take a number of sweeps or iterations (their
  /// row's `effort`): each step gets as many as the pace of the steps before leaves time for; see Simulation::effort.
  double budget = 0;
  /// Who runs the loops over large bodies (some 50 000 connections on): the host's task system, which must outlive the
  /// simulation; or, where it is null, this number of threads of the common one (set_runner, use_openmp), 0 = as
  /// set_threads says. Bitwise identical with any.
  TaskRunner* runner = nullptr;
  int threads = 0;
  /// Makes Voronoi cells where the strategy or the material's fibres need them: mesh::voronoi_cells. Empty: the body
  /// has them, or such strategies are refused.
  MakeVoronoi make_voronoi = {};
};

/// A spring of length 0 and a damper between a molecule and a position.
struct Coupling {
  CouplingId id = 0;
  int molecule = 0;
  double stiffness = 0, damping = 0;   ///< [N/m], [N s/m]
  Vector3 position = Vector3::Zero();  ///< [m]
  Vector3 velocity = Vector3::Zero();
};

/// A rigid thing that the host moves, from one pose to the next at constant speed and spin.
struct Tool {
  Pose pose = {};                 ///< at the beginning of the next step
  std::optional<Pose> next = {};  ///< at its end; none: it stays
};

/// A simulation's body after its topology has changed, and what of it cannot be derived again.
struct Topology {
  Body body;
  VectorX constants;        ///< [N/m] of a spring rule, as they were before and shared out; empty of other strategies
  std::vector<int> origin;  ///< of each molecule: its number in the body that the simulation was made of
  double stiffness = 0;     ///< sum of the constants [N/m] of that body; 0 of other strategies
};

/// What a change of topology did.
struct TopologyReport {
  bool changed = false;
  int split_molecules = 0, removed_connections = 0, removed_cells = 0;
  /// Of each molecule and connection its number before. Molecules keep their numbers, unless one before them is gone;
  /// those that were split off come last.
  std::vector<int> molecule_from, connection_from;
  /// Keeps alive what views showed before: release it when nobody looks at them any more.
  std::shared_ptr<const void> before;
};

/// What sets the longest explicit step: frequencies [rad/s] and damping rates [1/s] of the body and, squared and
/// summed, of what was added to it since. All 0 before the first step.
struct StepBound {
  double frequency = 0, damping_rate = 0, added_square = 0, added_rate = 0;
  bool operator==(const StepBound&) const = default;
};

/// Everything that a simulation changes while it runs; restoring it goes on bitwise identically.
struct SimulationState {
  State state;
  std::vector<Support> supports;
  Positions host_forces;  ///< [N]; empty if nobody requested them
  std::vector<Coupling> couplings;
  /// Of Simulation::fix and move_to: the fixed molecule, and where it is to be at the end of the next step.
  struct HostSupport {
    int molecule = 0;
    std::optional<Vector3> next;  ///< as Support::displacement [m]
  };
  std::vector<HostSupport> host_supports;
  int others_supports = 0;  ///< number of supports that come from elsewhere; they stand first
  std::vector<Tool> tools;
  std::shared_ptr<const Topology> topology;  ///< null: the body is as the simulation was made with it
  int effort = 0;                            ///< of the last step; see Simulation::effort
  SeenFrequency seen = {};                   ///< in explicit steps; see SimulationOptions::safety
  StepBound bound = {};                      ///< of explicit steps
  Matrix3 rest_moments = Matrix3::Zero();    ///< of its body's positions at rest; 0: not known
};

/// A body that moves: what a simulator embeds. Any number may run in as many threads, each in one at a time.
///
///   Simulation tissue(body, catalog.find("lattice"), material);
///   tissue.add_load(*built_in_loads().find("gravity"), {.vectors = {{"acceleration", {0, 0, -9.81}}}});
///   const CouplingId tool = tissue.couple(17, position, 200);
///   while (…) { tissue.move_coupling(tool, position); tissue.step(1e-3); push(-tissue.coupling_force(tool)); }
///
/// The views (positions, velocities, forces, tensions), the body and the model keep their address as long as the
/// simulation lives and its topology stays. step(), the
/// views and the calls that are noexcept allocate nothing after the first step and the first call of each, throw
/// nothing, lock nothing and print nothing; what of that a step cannot promise is said at Stepper::advance.
/// Functions that throw InputError do so before they change anything. A moved-from Simulation may only
/// be assigned to or destroyed; its step() says that it is empty.
class Simulation {
 public:
  /// The strategy at work on the body, once it is prepared for it (see prepare), with what the material and the body
  /// bring besides: fibres, bending, cables, ties, bone. Throws InputError where it cannot run there, or a parameter or
  /// the material is out of range. A body of several materials wants a strategy made by in_parts.
  Simulation(Body body, const Strategy& strategy, const Material& material, SimulationOptions options = {});
  /// An elastic law that the host makes itself from the body, which stays where it is.
  using MakeElasticity = std::function<ElasticTerms(const Body&)>;
  Simulation(Body body, const MakeElasticity& make, SimulationOptions options = {});
  ~Simulation();
  Simulation(Simulation&&) noexcept;
  Simulation& operator=(Simulation&&) noexcept;

  const Body& body() const noexcept;
  /// What acts on the body. What is added to it directly cannot follow a change of topology: see add.
  Model& model() noexcept;
  const Model& model() const noexcept;

  /// Adds what acts on the body, now and again after each change of its topology: `add` puts it on a model, whose body
  /// it must request what it needs. At any time between steps; what it throws leaves the simulation as it was.
  void add(std::function<void(Model&)> add);
  /// Adds a load, or damping, out of a table, as add; the strategy's material stands behind defaults.
  /// Throws InputError as checked_values.
  LoadId add_load(const LoadKind& load, const LoadValues& values = {});
  /// From the next step on it acts with these values instead, or not at all; a history that it has begins again or
  /// ends. Throws InputError as add_load, and where there is no such load (any more), before anything changes.
  void set_load(LoadId load, const LoadValues& values);
  void remove_load(LoadId load);
  /// Its row. Throws InputError as remove_load.
  const LoadKind& load_kind(LoadId load) const;
  /// Brings the body forward by dt > 0 [s]; numerical trouble is an outcome, and the state then stays as it was.
  StepResult step(double dt) noexcept;
  double time() const noexcept;  ///< [s]
  /// Solves for the equilibrium of all that acts at this time, and leaves the body there, at rest: a start. Couplings
  /// rest, too: their dampers have no part in it, and their velocities are 0 until move_coupling gives others. By
  /// default one that is no minimum is left, and StaticResult::unstable says where that did not succeed. Allocates.
  /// std::bad_alloc leaves the state as it was.
  StaticResult settle(const StaticOptions& options = {.probe = true});
  /// Derivatives about the equilibrium that settle() has found. Throws InputError where what is left unbalanced is more
  /// than 1e-6 of all forces. Of use until the next step, cut or change.
  Sensitivity sensitivity();

  const Positions& positions() const noexcept;  ///< [m], 3 × n
  /// Puts the molecules there [m], 3 × n, between steps: a body may begin elsewhere than at rest. Velocities stay, and
  /// supports where they are. Throws InputError on another number of molecules, or positions that are not finite.
  void set_positions(const Positions& positions);
  /// Gives the molecules these velocities [m/s], 3 × n, between steps. Throws InputError as set_positions.
  void set_velocities(const Positions& velocities);
  const Positions& velocities() const noexcept;  ///< [m/s], 3 × n
  /// All that moves, as what reads a state wants it: energies, contact reports.
  const State& state() const noexcept;
  /// All forces of the state reached [N], 3 × n; the reaction of a fixed molecule is minus its components in the fixed
  /// directions. One pass over the body at the first call after a step; none without a call.
  const Positions& forces() const noexcept;
  /// Force of each connection with its damping [N], pulling is positive; as forces.
  const VectorX& tensions() const noexcept;

  /// The host's own forces [N], 3 × n: act from the next step on until they are changed. The first call allocates. With
  /// another number of columns no step is taken.
  Positions& host_forces() noexcept;

  /// Fixes a molecule at its present position in all directions, or in those that `free` (a projector) leaves; again:
  /// with the new ones. Throws InputError on a number that is no molecule, or a matrix that is no projector.
  void fix(int molecule, const Matrix3& free = Matrix3::Zero());
  /// Releases a molecule, whatever fixed it; nothing happens to one that is free. Throws InputError as fix.
  void release(int molecule);
  /// Prescribes the position [m] of a fixed molecule at the end of the next step, in its fixed directions: it goes
  /// there at constant speed, and stays. Throws InputError if it is not fixed or the position is not finite.
  void move_to(int molecule, const Vector3& position);
  /// Force by which the support of a fixed molecule acts on it [N], without what its own inertia takes; zero where
  /// nothing fixes it. As forces.
  Vector3 reaction(int molecule) const noexcept;

  /// A spring of length 0 and a damper between a molecule and a position [m]: a tool, a mouse. stiffness > 0 [N/m],
  /// damping ≥ 0 [N s/m]. Throws InputError.
  CouplingId couple(int molecule, const Vector3& position, double stiffness, double damping = 0);
  /// From the next step on. Throws InputError where there is no such coupling (any more), as the two below.
  void move_coupling(CouplingId coupling, const Vector3& position, const Vector3& velocity = Vector3::Zero());
  /// Force of the coupling on its molecule [N] in the state reached; a haptic device gets its opposite. Under `newmark`
  /// and `energy_momentum` that of a stiff coupling swings about its mean from one step to the next, where the step is
  /// long for the coupling's own vibration: take backward_euler or generalized_alpha there.
  Vector3 coupling_force(CouplingId coupling) const;
  void decouple(CouplingId coupling);

  /// A rigid thing that the host moves, an instrument: contact takes tool_motion as the motion of an obstacle. Throws
  /// InputError on a pose that is not finite or a turn that is no rotation.
  ToolId add_tool(const Pose& pose);
  /// Where the tool is to be at the end of the next step [m]: it goes there at constant speed and spin, and stays.
  /// Without a turn it keeps its own. Throws InputError as add_tool, and where there is no such tool.
  void move_tool(ToolId tool, const Vector3& position, const std::optional<Matrix3>& turn = {});
  /// Where it is now; throws InputError where there is no such tool.
  Pose tool_pose(ToolId tool) const;
  /// Its pose by time [s], to be asked within steps; outlives the simulation. Throws InputError as tool_pose.
  std::function<Pose(double time)> tool_motion(ToolId tool) const;

  /// Parts the body where the surface goes through it in its present positions; see elastin::cut. What is left goes on
  /// with the same positions, velocities, masses and stiffness; supports of a molecule that is split hold
  /// all that comes of it, host forces are shared out as its mass, couplings stay with what keeps its number. Of loads
  /// out of the table faces are those of all that comes of their molecules, a force on each molecule stays with what
  /// keeps its number, and what has nothing left that it acts on does nothing until set_load or restore. Contact,
  /// colours, hierarchies and matrices are made again, so the next step takes longer; points of contact forget where
  /// they stuck. Throws InputError as elastin::cut, and changes nothing, where something cannot follow: a law or load
  /// with a history, springs with fibres, sheets with bending stiffness, calibrated:RULE+volume, supports that
  /// Model::drive moves, and what was added to model() directly.
  TopologyReport cut(const CutSurface& surface);
  /// Parts it where it is strained above `strain` > 0; see elastin::tear. As cut.
  TopologyReport tear(double strain);
  /// Removes connections and cells by number; see elastin::without. As cut. What fixed or pulled a molecule that is
  /// gone is gone, too.
  TopologyReport remove(const std::vector<int>& connections, const std::vector<int>& cells);
  /// Of each molecule its number in the body that the simulation was made of: a host's own data goes by
  /// these.
  const std::vector<int>& origin() const noexcept;

  /// Sweeps or iterations of the last step, of a stepper that takes a number of them; else 0. With a budget it differs
  /// from step to step and from machine to machine: record it and pass it to set_effort to reproduce the run.
  int effort() const noexcept;
  /// Sets the number (≥ 1) from now on, whatever the budget says. Throws InputError where the stepper takes none.
  void set_effort(int effort);
  /// What its few sweeps or iterations would do to a next step by dt > 0 [s], which is tried and taken back: the
  /// largest distance of a molecule from where backward Euler's balance to the end has it, and the largest distance
  /// that it goes there [m]. NaN where one of the two fails. Throws InputError where the stepper takes no number of
  /// them.
  std::pair<double, double> iteration_error(double dt);

  /// What makes its results doubtful, a sentence each: pieces, cells given twice, negative spring constants,
  /// mechanisms, cells that lock, a missing thickness, a budget that is not kept. Looks at the whole body: not for
  /// every step.
  /// @param mechanisms whether spring constants are looked at and zero-energy modes counted, which takes longest
  std::vector<std::string> warnings(bool mechanisms = true) const;

  /// Calls `see` after every `every` (≥ 1) steps that converged. A step that it takes ends as limit_reached, with the
  /// reason; what it throws ends in std::terminate.
  void observe(int every, std::function<void(const Simulation&)> see);

  /// The state to go on from; with the same model the steps after it are bitwise identical.
  SimulationState save() const;
  /// Throws InputError where it is another body's, or as cut where the topology has changed since. Another body's is
  /// one of another number of molecules or of other positions at rest, and after a cut one whose spring constants had
  /// another sum; other materials, connections and cells are not noticed. Gives back what keeps alive what views showed
  /// before, as TopologyReport::before, if it had to change the topology; else null.
  std::shared_ptr<const void> restore(const SimulationState& saved);

 private:
  struct Impl;
  TopologyReport change(ChangedBody changed);
  std::unique_ptr<Impl> impl_;
};

}  // namespace elastin
