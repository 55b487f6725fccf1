#pragma once
#include "lab/run/run.h"

namespace elastin::lab {

/// Solves load step after load step of a model that the experiment holds, each started where the last two lead, and
/// adds curve, measures, cost and outcome to the run. A step that fails ends it; what was measured before stays.
/// @param begin changes the state in which the search for the first equilibrium starts; may be empty.
void solve_load_curve(Model& model, const StaticExperiment& experiment, StaticRig& rig, const Material& material,
                      const RunOptions& options, Run& run, const std::function<void(State&)>& begin = {});

}  // namespace elastin::lab
