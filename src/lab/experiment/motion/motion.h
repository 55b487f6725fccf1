#pragma once
#include <optional>
#include <string>

#include "elastin/contact/contact.h"
#include "elastin/core/forces/time_function.h"
#include "elastin/lab/run/experiment.h"

namespace elastin::lab {

enum class MotionKind {
  motion,      ///< nothing but the rows
  release,     ///< loaded, then let go: free vibration; or the load put on at once, with `applied`
  creep,       ///< a load that is held
  relaxation,  ///< a displacement that grows and is held
  cyclic,      ///< a displacement that oscillates
};

/// A body held and loaded as an experiment at rest says, whose load changes in time.
struct MotionSetup {
  std::string name = "motion";  ///< of the experiment
  MotionKind kind = MotionKind::motion;
  std::unique_ptr<const StaticExperiment> fixture;  ///< null: the body is free; only `motion` allows that
  TimeFunction load;                                ///< what the experiment's load is multiplied with
  bool applied = false;  ///< of a release: the load is put on at time 0, and not gone from then on
  double ramp = 0;       ///< [s] after which a relaxation begins
  double frequency = 0;  ///< [Hz] of what is cyclic
};

/// Starts in the equilibrium of the scene's own loads (a free body: at rest). Throws InputError if the inner experiment
/// has not what the kind needs.
std::unique_ptr<TimedExperiment> make_motion(const Body& body, MotionSetup setup);

/// A body clamped at one end, which is moved to and fro.
struct ShakeSetup {
  Vector3 axis = Vector3::UnitX();       ///< from the clamped end to the far one
  Vector3 direction = Vector3::UnitX();  ///< of the shaking
  double amplitude = 0;                  ///< [m]
  double frequency = 0;                  ///< [Hz]
  double grip_depth = 0;
};
std::unique_ptr<TimedExperiment> make_shake(const Body& body, const ShakeSetup& setup);

/// A free body that falls on a floor, or on the obstacles of its scene.
struct DropSetup {
  Vector3 direction = -Vector3::UnitZ();  ///< down
  double gravity = 0;                     ///< [m/s²]; 0: none
  double height = 0;                      ///< [m] of the lowest sphere above the floor at time 0
  double speed = 0;                       ///< [m/s] down at time 0
  double stiffness = 0, damping = 0;      ///< of its own floor, a molecule [N/m], [N s/m]
  /// None: it falls on a floor of its own.
  std::optional<contact::ContactOptions> contact = {};
};
std::unique_ptr<TimedExperiment> make_drop(const Body& body, const DropSetup& setup);

/// A canopy with a load on cables that falls through air: how it opens. The air is a load of the scene.
struct ParachuteSetup {
  Vector3 direction = -Vector3::UnitZ();  ///< down
  double gravity = 9.81;                  ///< [m/s²], ≥ 0
  double speed = 0;                       ///< [m/s] down at time 0
};
/// Throws InputError for a body without cables.
std::unique_ptr<TimedExperiment> make_parachute(const Body& body, const ParachuteSetup& setup);

/// Natural frequencies of a body held as an experiment at rest says, or free, about its equilibrium under the scene's
/// own loads and, if `loaded`, the fixture's. At rest: it takes no time.
std::unique_ptr<StaticExperiment> make_vibration(const Body& body, std::unique_ptr<const StaticExperiment> fixture,
                                                 int count, bool loaded = false);

const MeasureList& vibration_measures();

const MeasureList& shake_measures();

const MeasureList& drop_measures();

const MeasureList& parachute_measures();

const MeasureList& motion_measures();

}  // namespace elastin::lab
