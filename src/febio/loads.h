#pragma once
#include <array>
#include <memory>
#include <vector>

#include "core/forces/surface_load.h"
#include "elastin/core/forces/loads.h"
#include "febio/load_controller.h"

namespace elastin::febio {

/// A dead force on each molecule [N], 3 × n, times a number over time.
struct DeadLoad {
  Positions forces;
  Value factor;
};

struct SurfaceLoad : elastin::SurfaceLoad {
  Value factor;  ///< [Pa] of a pressure
};

struct LinearSpring {
  std::array<int, 2> ends;
  Value stiffness;  ///< [N/m]
};

/// A load whose time is that of the step.
class TimedLoad : public Load {
 public:
  virtual void set_time(double time) = 0;
  /// Which step leads there.
  virtual void set_step(int /*step*/) {}
  /// No force until the next set_time: the analysis begins at rest, whatever its loads are then.
  virtual void remove() {}
  bool feels_velocity() const override { return false; }
};

std::unique_ptr<TimedLoad> make_dead_loads(const Body& body, std::vector<DeadLoad> loads);
std::unique_ptr<TimedLoad> make_surface_load(const Body& body, SurfaceLoad load);
/// Tension k (l − l₀).
std::unique_ptr<TimedLoad> make_linear_springs(const Body& body, std::vector<LinearSpring> springs);

/// How a step integrates: M (α_m a₁ + (1 − α_m) a₀) + f(α_f x₁ + (1 − α_f) x₀) = 0 with Newmark's β and γ; loads are
/// those at its end, as FEBio has them.                                      [Newmark 1959; Chung & Hulbert 1993]
struct Integration {
  double beta = 0.25, gamma = 0.5, alpha_mass = 1, alpha_force = 1;
};

/// Σ over the cells of ρ ∫ N_a N_b dV [kg], by pairs of molecules.
struct MassPair {
  int a, b;
  double mass;
};

/// Inertia as a load of the static steps that an implicit stepper solves: the energy whose forces are −M a. The
/// mass matrix is consistent. Velocity and acceleration are history.
class Inertia : public TimedLoad {
 public:
  /// Of the step that leads to the time set; null: it is one at rest, without inertia. Must outlive it.
  virtual void set_integration(const Integration* integration) = 0;
};
std::unique_ptr<Inertia> make_inertia(const Body& body, const std::vector<MassPair>& mass,
                                      const Positions& accelerations);

}  // namespace elastin::febio
