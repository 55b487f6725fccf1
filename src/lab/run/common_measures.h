#pragma once
#include "elastin/lab/run/experiment.h"

namespace elastin::lab {

/// The measures of every run of an experiment: the experiment's own, then those that its kind of run adds: preload,
/// energy, contact, the history of a run in time, the identified material.
MeasureList measures_of(const Experiment& experiment);

/// Those that runs add to the experiments' own, of any kind.
const MeasureList& common_measures();

}  // namespace elastin::lab
