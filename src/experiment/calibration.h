#pragma once
#include <memory>
#include <optional>

#include "experiment/specimen.h"

namespace elastin {

/// The measure to which a rule is calibrated: the first that the material prescribes a value for. Null if there is
/// none.
std::optional<MainMeasure> calibrated_measure(const Experiment& experiment, const Material& material);

/// The springs of a run with a volume term of this modulus [Pa], if the strategy has one.
std::unique_ptr<Elasticity> springs_of(const Specimen& specimen, const StrategyChoice& choice, const Run& run,
                                       double volume_modulus);

/// Changes the run's spring constants, and its volume term if it has one, by linear solves of the experiment: so that
/// it measures the modulus that the material prescribes, and with a volume term Poisson's ratio too where the
/// experiment measures both. The run says if that fails.
void calibrate(const Specimen& specimen, Experiment& experiment, const StrategyChoice& choice,
               const StaticOptions& options, Run& run);

}  // namespace elastin
