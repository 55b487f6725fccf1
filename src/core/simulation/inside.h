#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/simulation/holds.h"
#include "elastin/core/simulation/simulation.h"
#include "elastin/core/solve/stable_step.h"

namespace elastin {

/// As messages write it.
std::string number(double value);

struct Simulation::Inside {
  Inside(Body a_body, SimulationOptions some_options);

  StepResult step(double dt);
  StepResult parts_of_step(double dt, int parts);
  double longest_part();
  std::string odd_input() const;
  void check_molecule(int molecule) const;
  Grip* find(GripId id);
  void make_room_for_host_forces();
  void make_room_for_grips();

  Body body;
  SimulationOptions options;
  Model model{body};
  std::unique_ptr<Integrator> integrator;
  Holds holds{model};
  State shown;  // what the host sees: its arrays stay where they are
  State work;   // the same, between steps; integrators give it other arrays as they go
  Positions host_forces;
  std::vector<Grip> grips;
  bool has_host_forces = false, has_grips = false;
  GripId next_grip = 1;
  std::optional<StableStep> stable;  // of the body at rest, nothing held or gripped
  // Read off the state shown when the host asks.
  Scratch scratch;
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
