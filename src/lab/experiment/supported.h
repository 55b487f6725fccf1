#pragma once
#include <vector>

#include "elastin/lab/run/experiment.h"

namespace elastin::lab {

/// An experiment at rest on a body with further supports: planes of symmetry, a clamped rim. What a molecule is held
/// along by either stays held; the supports' own displacements are 0. A release frees what the experiment held alone.
std::unique_ptr<StaticExperiment> with_supports(std::unique_ptr<const StaticExperiment> experiment,
                                                std::vector<Support> supports);

/// The experiment that with_supports was given, or itself.
const Experiment& without_supports(const Experiment& experiment);

}  // namespace elastin::lab
