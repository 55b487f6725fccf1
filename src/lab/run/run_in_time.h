#pragma once
#include "lab/run/run.h"

namespace elastin::lab {

/// Takes a held model through time, frame after frame, and adds rows, measures, cost and outcome to the run. A step
/// that fails ends it: the frames before stay. Throws InputError where options or a restart text do not fit.
void run_in_time(Model& model, const TimedExperiment& experiment, TimedRig& rig, const Specimen& specimen,
                 const RunOptions& options, Run& run);

/// The scheme that a run takes, and why if the scene leaves it open.
std::pair<Scheme, std::string> chosen_scheme(const TimeOptions& options, bool uses_cells);

}  // namespace elastin::lab
