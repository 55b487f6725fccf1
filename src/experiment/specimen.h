#pragma once
#include "experiment/choice.h"
#include "experiment/run.h"

namespace elastin {

/// Builds the strategy on the specimen, solves every load step and measures. Numerical trouble is an outcome in the
/// result; wrong parameters throw InputError.
Run run_strategy(const Specimen& specimen, Experiment& experiment, const StrategyChoice& choice,
                 const RunOptions& options);

}  // namespace elastin
