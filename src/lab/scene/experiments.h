#pragma once
#include <memory>
#include <string>
#include <vector>

#include "elastin/lab/scene/experiment_catalog.h"
#include "lab/scene/reader.h"

namespace elastin::lab {

/// Keys that many experiments have.
inline const SceneKey kDepthKey{"grip_depth", "quantity",      "m",
                                "> 0",        "the end plane", "molecules that are so near to an end belong to it"};
inline const SceneKey kStepsKey{"load_steps", "whole", "", "1 … 100000", "1", "equal steps in which the load grows"};
inline const SceneKey kSymmetryKey{
    "symmetry", "list of directions",
    "",         "",
    "none",     "normals of planes through the origin that cut the body, each perpendicular to the others"};

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
