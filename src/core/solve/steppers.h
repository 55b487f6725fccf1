#pragma once
#include "core/solve/trial.h"
#include "elastin/core/solve/stepper.h"

namespace elastin {

/// A stepper that takes a number of sweeps or iterations, which may change from step to step.
class HasEffort {
 public:
  virtual ~HasEffort() = default;
  virtual void set_effort(int effort) = 0;
};

/// A stepper that sees in its own steps how fast the body vibrates, where that has an elastic energy: two passes
/// over the molecules every few steps.
class FrequencyWatch {
 public:
  virtual ~FrequencyWatch() = default;
  /// Begins to watch, or goes on from there.
  virtual void watch(const SeenFrequency& before) = 0;
  virtual const SeenFrequency& seen() const = 0;
};

/// A stepper that goes in substeps where a stiffness sets in: as short as the body's own allows for in addition.
class SharedStep {
 public:
  virtual ~SharedStep() = default;
  /// Of what does not set in: the square of the fastest vibration's frequency [1/s²], and the damping rate [1/s].
  virtual void set_own(double square_frequency, double damping_rate) = 0;
};

/// "cell 3 is flat or inverted", or the same without a number where no single cell is.
std::string inverted_text(const Body& body, const Positions& positions);
/// The same where any of the processes that share the body finds it; they call it together.
std::string inverted_anywhere(const Model& model, const Positions& positions);

/// Gives supported molecules the velocities of their supports in the fixed directions.
void move_with_supports(const std::vector<Support>& supports, Positions& velocities);

/// Velocities that go with the positions; those of supports are their own.
void set_velocities(const Model& model, const Kinematics& kinematics, State& state);
/// And accelerations.
void follow(const Model& model, const Kinematics& kinematics, State& state);

/// Whether all elastic laws of a model are sums over elements, see Elasticity::local.
bool has_local_terms(const Model& model);

}  // namespace elastin
