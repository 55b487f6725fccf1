#pragma once
#include <memory>
#include <string>
#include <vector>

#include "elastin/lab/scene/experiment_catalog.h"
#include "lab/scene/reader.h"

namespace elastin::lab {

/// Keys that many experiments have.
inline const ExperimentKey kDepthKey{"grip_depth", "m",
                                     "molecules this close to an end belong to it; without it those in the end plane"};
inline const ExperimentKey kStepsKey{"load_steps", "number", "equal steps in which the load grows; 1 without it"};

/// Rows of the table, each list beside the functions that read them.
std::vector<ExperimentInfo> static_experiments();
std::vector<ExperimentInfo> bubble_experiments();
std::vector<ExperimentInfo> contact_experiments();
std::vector<ExperimentInfo> timed_experiments();

/// {kind: NAME, …}, of the context's catalog. Throws InputError with source location and key.
std::unique_ptr<Protocol> read_experiment(Reader reader, const ExperimentContext& context);

/// "motion, release and creep": those that run through time.
std::string timed_experiment_names(const ExperimentCatalog& catalog);

}  // namespace elastin::lab
