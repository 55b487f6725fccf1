#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/simulation/host_supports.h"
#include "elastin/core/simulation/simulation.h"
#include "elastin/core/solve/stable_step.h"

namespace elastin {

struct Simulation::Impl {
  Impl(Body a_body, SimulationOptions some_options);

  StepResult step(double dt);
  StepResult substeps_of(double dt, int substeps);
  double longest_substep();
  std::string odd_input() const;
  void check_molecule(int molecule) const;
  Coupling* find(CouplingId id);
  void ensure_host_forces();
  void ensure_couplings();

  Body body;
  std::optional<Material> material;  // of the strategy, where there is one
  SimulationOptions options;
  Model model{body};
  std::unique_ptr<Integrator> integrator;
  HostSupports host_supports{model};
  State shown;  // what the host sees: its arrays stay where they are
  State work;   // the same, between steps; integrators give it other arrays as they go
  Positions host_forces;
  std::vector<Coupling> couplings;
  bool has_host_forces = false, has_couplings = false;
  CouplingId next_coupling = 1;
  std::optional<StableStep> stable;  // of the body at rest, nothing held or gripped
  // Read off the state shown when the host asks.
  Workspace workspace;
  Positions forces;
  VectorX tensions;
  bool forces_known = false, tensions_known = false;
  struct Observer {
    int every, waited;
    std::function<void(const Simulation&)> see;
  };
  std::vector<Observer> observers;
};

}  // namespace elastin
