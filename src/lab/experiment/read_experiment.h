#pragma once
#include <memory>
#include <string>

#include "elastin/lab/experiment/experiment_catalog.h"
#include "lab/run/config_names.h"

namespace elastin::lab {

/// {kind: NAME, …}, of the context's catalog. Throws InputError with source location and key.
std::unique_ptr<Experiment> read_experiment(Reader reader, const ExperimentContext& context);

/// "motion, release and creep": those that run through time.
std::string timed_experiment_names(const ExperimentCatalog& catalog);

}  // namespace elastin::lab
