#pragma once
#include "experiment/run.h"

namespace elastin {

/// Solves load step after load step of a model that the experiment holds, each started where the last two lead, and
/// adds curve, measures, cost and outcome to the run. A step that fails ends it; what was measured before stays.
/// `places`: where the solver starts; none = at rest.
void solve_load_curve(Model& model, Experiment& experiment, const Material& material, const RunOptions& options,
                      Run& run, const std::optional<Positions>& places = {});

}  // namespace elastin
