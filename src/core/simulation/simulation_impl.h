#pragma once
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/simulation/budget.h"
#include "core/simulation/host_supports.h"
#include "core/simulation/tools.h"
#include "core/solve/stable_step.h"
#include "elastin/core/simulation/simulation.h"

namespace elastin {

class FrequencyWatch;

struct Simulation::Impl {
  Impl(Body a_body, SimulationOptions some_options);

  StepResult step(double dt);
  StepResult timed_substeps(double dt, int substeps);
  StepResult substeps_of(double dt, int substeps);
  double longest_substep();
  void find_bound();
  StepBound bound() const;
  void make_own_stepper();
  void begin_step(double start, double end);
  void go_back();
  void set_effort(int number);
  std::string odd_size() const;
  void check_host_forces() const;  ///< throws InputError where the host has made them another size
  std::string odd_input(double end) const;
  /// Throws InputError where a load or law that a step calls wants to change what the step works on.
  void check_idle(const char* call) const;
  void check_molecule(int molecule) const;
  Coupling& find(CouplingId id);  ///< throws InputError for an unknown one
  void ensure_host_forces();
  void ensure_couplings();
  void order_loads();
  void restore(const SimulationState& saved);

  /// What was added to the model by a function, and what it put there.
  struct Added {
    std::function<void(Model&)> add;            // empty: removed, or nothing is left that it acts on
    std::shared_ptr<const LoadKind> kind = {};  // null: no load out of a table
    LoadValues values = {}, given = {};         // of such a load: on this body, and on that which it was given on
    std::vector<int> given_on = {};             // the origins of that body's molecules
    std::vector<const Load*> loads = {};
    std::vector<const Viscosity*> viscosity = {};
    double frequency = 0, damping_rate = 0;  // bounds of its own, of what came after `stable` was found
  };
  void put(Added added, std::size_t place);
  void take_away(Added& added);
  void perform(Added& added);
  void bound_step(Added& added) const;
  void keep_history();
  Added& load(LoadId id);  ///< throws InputError for an unknown one
  void set_values(Added& load, const LoadValues& values) const;
  Added load_of(std::shared_ptr<const LoadKind> kind, const LoadValues& values);
  const std::vector<int>& origin_of_molecules();
  /// How its model is made again on another body.
  struct Recipe {
    std::function<void(Impl&)> add_laws;
    /// Spring constants [N/m] that are carried over to it; empty: the laws are made of the body.
    std::function<VectorX(const Impl&)> constants;
    std::vector<Added> added;
    std::string fixed;  ///< why the strategy cannot follow a change of topology, or ""
  };
  /// Its laws and what was added, on its own body.
  void make_model();
  std::size_t terms() const { return model.elasticity().size() + model.viscosity().size() + model.loads().size(); }
  /// The same simulation on another body, with its state at rest; `moved` gives the values of a load there.
  std::unique_ptr<Impl> on(Topology topology, const std::function<LoadValues(const Added&)>& moved) const;
  /// Throws InputError where what acts here cannot follow a change of topology.
  void check_follows() const;
  std::shared_ptr<const Topology> shared_topology() const;
  Matrix3 rest_moments() const;    ///< see SimulationState
  double first_stiffness() const;  ///< of the body that the simulation was made of; see Topology
  /// Throws InputError where the state is another body's.
  void check_own(const SimulationState& saved) const;

  Body body;
  Recipe recipe;
  VectorX constants;                                 // carried over; empty as long as the topology is the first
  double carried_stiffness = 0;                      // the same, first_stiffness()
  std::vector<int> origin;                           // of each molecule
  std::size_t known = 0;                             // terms that the recipe has made, or host forces and couplings are
  std::shared_ptr<const Topology> original;          // null as long as the topology is the first
  mutable std::shared_ptr<const Topology> topology;  // as original; made when it is requested
  std::optional<Material> material;                  // of the strategy, where there is one
  std::shared_ptr<const Strategy> strategy;          // null: the host's own law
  SimulationOptions options;
  Model model{body};
  std::unique_ptr<Stepper> stepper;
  HostSupports host_supports{model};
  std::shared_ptr<Tools> tools = std::make_shared<Tools>();
  Budget budget;
  int effort = 0;                       // of a stepper that takes a number of sweeps or iterations
  bool effort_is_given = false;         // by the host, whatever the budget says
  int timed_steps = 0, late_steps = 0;  // with a budget: all, and those that took longer with an effort of 1
  State shown;                          // what the host sees: its arrays stay where they are
  State work;                           // the same, between steps; steppers give it other arrays as they go
  Positions host_forces;
  std::vector<Coupling> couplings;
  bool has_host_forces = false, has_couplings = false;
  CouplingId next_coupling = 1;
  std::optional<StableStep> stable;  // of the body at rest, nothing fixed or coupled
  StepBound restored;                // of another simulation's steps, which may have been shorter
  FrequencyWatch* watch = nullptr;   // of a stepper that has one
  // Read off the state shown when the host asks.
  Workspace workspace;
  Positions forces;
  VectorX tensions;
  bool forces_known = false, tensions_known = false;
  struct Observer {
    int every, waited;
    std::function<void(const Simulation&)> see;
  };
  std::deque<Observer> observers;  // which may add others: those that are there stay where they are
  bool observed = false;           // an observer is at work
  bool in_use = false;             // the model and the states, by a step or a solve
};

}  // namespace elastin
